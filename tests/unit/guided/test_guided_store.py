"""Results of guided tests: only ever added, simulated ones apart, on the report and in the next pre-flight check."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, keep_test, last_tests
from app.preflight.checks import CheckResult, Person
from app.records.filing import file_check
from app.records.record import read_document
from app.records.report import report_html
from app.records.verification import RecordState, StationNames, verify
from app.settings.profiles import Profile
from app.store.fact_store import Store
from app.text.messages import message
from tests.support.records.preflight_rig import check
from tests.support.records.stored import open_store

NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)
PASSED, FAILED, UNCLEAR = GuidedVerdict.PASSED, GuidedVerdict.FAILED, GuidedVerdict.UNCLEAR


def result(kind: GuidedKind, verdict: GuidedVerdict = PASSED) -> GuidedResult:
    shown, tolerance = message("{angle:.0f}°", angle=61), message("{angle:.0f}°", angle=60)
    return GuidedResult(kind, (MeasuredValue(message("Fires"), shown, tolerance, verdict),))


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path, clock=lambda: NOW)) as one:
        yield one


def add(
    store: Store, kind: GuidedKind, verdict: GuidedVerdict = PASSED, *, module: str = "M-07", sim: bool = False
) -> None:
    store.write(
        lambda facts: keep_test(
            facts,
            result(kind, verdict),
            module=module or None,
            who="Li",
            is_simulated=sim,
        )
    ).result()


def last(store: Store, *, sim: bool = False) -> dict[GuidedKind, GuidedVerdict]:
    found = store.read(lambda facts: last_tests(facts, "M-07", counts_simulated=sim))
    return {kind: one.verdict for kind, one in found.items()}


def test_the_newest_result_of_each_test_counts(store: Store) -> None:
    add(store, GuidedKind.TILT)
    add(store, GuidedKind.TILT, FAILED)
    add(store, GuidedKind.BAY, UNCLEAR)
    add(store, GuidedKind.FREE_FALL, module="M-08")
    add(store, GuidedKind.LINK, module="")
    assert last(store) == {GuidedKind.TILT: FAILED, GuidedKind.BAY: UNCLEAR}


@pytest.mark.promise("f")
def test_a_simulated_run_never_counts_for_a_real_module(store: Store) -> None:
    add(store, GuidedKind.TILT, FAILED)
    add(store, GuidedKind.TILT, PASSED, sim=True)
    assert last(store) == {GuidedKind.TILT: FAILED}
    assert last(store, sim=True) == {GuidedKind.TILT: PASSED}


# The pre-flight check


@pytest.mark.parametrize(
    ("port", "is_simulated", "expected"),
    [
        ("/dev/ttyUSB0", False, CheckResult.PASS),
        ("/dev/ttyUSB0", True, CheckResult.FAIL),
        ("sim://x", True, CheckResult.PASS),
    ],
)
def test_the_filed_check_knows_the_tests_and_prints_them(
    store: Store, port: str, is_simulated: bool, expected: CheckResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.records.filing.local_now", lambda: NOW + timedelta(days=3))
    add(store, GuidedKind.TILT, sim=is_simulated)
    evidence = check().assessment.case.evidence
    evidence.port = port
    profile = Profile(name="H6", tests_within_days={GuidedKind.TILT: 10})
    filed = file_check(
        evidence, profile, Person(who="Li", module="M-07", aircraft="A"), store=store,
    )  # fmt: skip
    assert filed.assessment.result("guided_tests") is expected
    tests = filed.record.tests
    assert len(tests) == (expected is CheckResult.PASS)
    text = report_html(filed.exported)
    if tests:
        assert tests[0].who == "Li"
        assert "Attitude trigger" in text
        assert "Fires: 61° (60°)" in text
        assert ("simulated" in text.lower()) is is_simulated
    else:
        assert "Attitude trigger: not tested" in text
        assert "Fires: " not in text
    document = read_document(filed.exported.text.encode())
    assert verify(document, StationNames(None)).state is not RecordState.ALTERED
