"""Records are kept, also by several processes and after a kill."""

import sys
import threading
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from app.modules.names import remember, remembered
from app.preflight.checks import CheckResult, Person
from app.preflight.verdict import Verdict
from app.procedures.history import History
from app.records.filing import Filed, aircraft_of, file_check, keep_check, weeks_since_charge
from app.records.record import read_document
from app.records.verification import RecordState, StationNames, verify
from app.settings.profiles import NO_PROFILE
from app.settings.values import DEFAULTS
from app.store.fact_store import Facts, Store, StoreError
from app.store.rows import Judgement, ModuleVisited, PreflightCheck
from app.store.station import KEY_FILE
from app.text.messages import UserError
from app.trigger_records.history import KeptTriggers, TriggersReading, Visit, file_triggers, record_of
from tests.support.patience import PATIENCE_S
from tests.support.processes import running
from tests.support.records.preflight_rig import FAULTS, Fault, check, loses
from tests.support.records.stored import checks_of, open_store

RECORD = record_of(bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"))
_FILER = """
import sys
from pathlib import Path
from app.safety.journal import Act
from tests.files.records.test_filing import file_one
from tests.support.records.stored import begin, open_store

store = open_store(Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
for _ in range(int(sys.argv[2])):
    begin(store, Act.LOCK, b"", {}, port="p", origin="test")
    print(file_one(store, "M-07").record.at.isoformat(), flush=True)
"""


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path)) as opened:
        yield opened


def file_one(store: Store, module: str | None = None, *faults: Fault, port: str = "sim", **person: Any) -> Filed:
    evidence = check(*faults).assessment.case.evidence
    evidence.port = port
    return file_check(evidence, NO_PROFILE, Person(module=module, **person), store=store)


def state_of(text: str) -> RecordState:
    return verify(read_document(text.encode()), StationNames()).state


def visits_of(store: Store, module: str) -> int:
    return len(store.read(lambda facts: facts.of_module(ModuleVisited, module)))


@pytest.mark.promise("f")
def test_two_programs_that_file_at_once_lose_nothing(tmp_path: Path) -> None:
    """One is killed: what it reported as kept is kept."""
    open_store(tmp_path).close()
    filer = sys.executable, "-c", _FILER, tmp_path
    with running(*filer, 6) as one, running(*filer, 1000) as other:
        for program in one, other:
            assert program.out.readline() == "ready\n"
        for program in one, other:
            program.told.write("\n")
            program.told.flush()
        told = [other.out.readline() for _ in range(3)]
        other.process.kill()
        told += [*other.out.readlines(), *one.out.readlines()]
        assert one.process.wait(60) == 0
    with closing(open_store(tmp_path)) as store:
        file_one(store, "M-07")
        kept = [check.content.document for check in store.read(lambda facts: facts.of_module(PreflightCheck, "M-07"))]
    assert set(map(state_of, kept)) == {RecordState.INTACT}
    assert len(kept) >= len([line for line in told if line.endswith("\n")]) >= 9


def test_what_waited_too_long_is_taken_back(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk answers again after the limit."""
    monkeypatch.setattr("app.store.fact_store.ANSWER_LIMIT_S", 0.1)
    goes_on = threading.Event()
    store.write(lambda _facts: goes_on.wait(PATIENCE_S))
    filed = file_one(store, "M-07")
    goes_on.set()
    assert filed.trouble is not None
    assert checks_of(store, "M-07") == ()


def test_what_is_just_being_written_is_waited_for_no_longer(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk hangs in the middle of it."""
    monkeypatch.setattr("app.store.fact_store.ANSWER_LIMIT_S", 0.5)
    goes_on = threading.Event()
    keep = keep_check

    def keep_slowly(facts: Facts, filed: Filed) -> None:
        keep(facts, filed)
        goes_on.wait(PATIENCE_S)

    monkeypatch.setattr("app.records.filing.keep_check", keep_slowly)
    filed = file_one(store, "M-07")
    assert filed.trouble is not None
    goes_on.set()
    assert len(checks_of(store, "M-07")) == 1


def test_a_record_that_could_not_be_kept_is_still_signed(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> int:
        raise StoreError("It cannot be used.")

    with monkeypatch.context() as patch:
        patch.setattr("app.store.fact_store.Facts.add", full)
        filed = file_one(store, "M-07")
    assert filed.trouble is not None
    assert state_of(filed.exported.text) is RecordState.INTACT
    assert checks_of(store, "M-07") == ()


@pytest.mark.parametrize("content", [b"", b"no key", b"-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n"])
def test_a_damaged_key_is_never_replaced_and_what_it_would_sign_is_not_kept(store: Store, content: bytes) -> None:
    (store.folder / KEY_FILE).write_bytes(content)
    filed = file_one(store, "M-07")
    assert filed.assessment.verdict is Verdict.READY
    assert filed.signed is None
    with pytest.raises(UserError, match="key of this station"):
        _ = filed.exported
    assert checks_of(store, "M-07") == ()
    assert (store.folder / KEY_FILE).read_bytes() == content


def test_what_may_be_another_module_becomes_no_part_of_this_ones_history(store: Store) -> None:
    store.write(lambda facts: remember(facts, "M-07", boot_count=50)).result()
    for is_same_module, result, boot_count, visits in (
        (False, CheckResult.FAIL, 50, 0),
        (True, CheckResult.PASS, 37, 1),
        (False, CheckResult.PASS, 37, 2),
    ):
        filed = file_one(store, "M-07", is_same_module=is_same_module)
        assert filed.assessment.result("boot_count") is result
        known = store.read(partial(remembered, name="M-07"))
        assert known is not None
        assert (known.boot_count, "freefall_time_s" in known.settings) == (boot_count, visits > 0)
        assert visits_of(store, "M-07") == visits


def test_records_of_a_simulated_module_are_kept_with_those_of_no_real_one(store: Store) -> None:
    reading = TriggersReading(History((RECORD,), is_confirmed=True, is_answered=True), 7, DEFAULTS)
    for name, first, other in (("M-07", "sim://", "/dev/ttyUSB0"), ("M-08", "/dev/ttyUSB0", "sim://x?seed=1")):
        file = partial(file_triggers, reading=reading, name=name)
        for port, is_kept in ((first, True), (other, False), (first, True)):
            filed = store.write(partial(file, port=port)).result()
            assert isinstance(filed, Visit) is is_kept
        file_one(store, name, port=other, is_same_module=True)
        assert visits_of(store, name) == 2


def test_settings_that_a_simulated_module_passed_with_are_approved_for_none_that_is_real(store: Store) -> None:
    for port in ("sim://", "/dev/ttyUSB0"):
        results = [file_one(store, "M-07", port=port).assessment.result("fingerprint") for _ in range(2)]
        assert results == [CheckResult.WARN, CheckResult.PASS]


def test_a_persons_word_for_the_records_is_kept_until_the_module_triggers(store: Store) -> None:
    for is_said in (True, False):
        filed = file_one(store, "M-07", FAULTS["new records"], are_records_reviewed=is_said)
        assert filed.assessment.result("trigger_records") is CheckResult.PASS
        records = store.read(lambda facts: KeptTriggers(facts).records("M-07"))
        assert {record.judgement for record in records} == {Judgement.REVIEWED}
    silent = Fault(arrange=loses(0x35))
    for faults, is_said, is_new in (((), True, True), ((), False, True), ((FAULTS["fired"],), False, False)):
        file_one(store, "M-08", silent, *faults, are_records_reviewed=is_said)
        assert store.read(lambda facts: KeptTriggers(facts).is_said_new("M-08")) is is_new


# Lists


def test_the_aircraft_of_a_module_is_that_of_its_last_check_that_names_one(store: Store) -> None:
    evidence = check().assessment.case.evidence
    for module, aircraft in ("A", "H6"), ("B", ""), ("A", "X8"), ("B", "H6"), (None, "Q4"), ("A", "X8"), ("B", ""):
        file_check(evidence, NO_PROFILE, Person(module=module, aircraft=aircraft), store=store)
    assert store.read(lambda facts: [aircraft_of(facts, module) for module in ("A", "B", "C")]) == ["X8", "H6", ""]


@pytest.mark.parametrize(
    ("measured", "weeks"),
    [
        ([], None),
        ([(0, 4.0), (30, 3.9)], None),  # it never rose
        ([(0, 3.8), (2, 4.16), (13, 4.1), (23, 3.9)], 3),
        ([(0, 3.8), (2, 4.16), (9, 4.1), (16, 4.12), (30, 4.1)], 4),  # a reading scatters
        ([(0, 3.8), (2, 4.16), (30, 4.1)], None),  # or in between
        ([(0, 3.8), (2, 4.16), (14, 4.0), (16, 4.16), (30, 4.0)], 2),  # the last charge
        ([(0, 3.8), (20, 4.16), (40, 4.0)], None),  # some day of three weeks
        ([(0, 3.8), (2, 4.16), (4, 4.1)], None),  # days, not weeks
    ],
)
def test_the_last_charge_is_told_only_where_the_checks_tell_it(
    measured: list[tuple[int, float]], weeks: int | None
) -> None:
    start = datetime(2026, 3, 1, tzinfo=UTC)
    assert weeks_since_charge([(start + timedelta(days=day), volts) for day, volts in measured]) == weeks
