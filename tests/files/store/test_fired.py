"""A deploy that left, and a TRIGGERED that was seen, end every earlier verdict, in store, archive and check."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from app.archive.report import module_history, report
from app.preflight.checks import CheckResult, Person
from app.preflight.verdict import Verdict
from app.records.filing import Filed, file_check
from app.safety.journal import REQUESTS, Act, Outcome
from app.settings.profiles import NO_PROFILE
from app.store.acts import claim_fired, note_triggered
from app.store.fact_store import Store
from app.store.rows import MayHaveFired, Serviced, ServiceKind
from tests.support.records.preflight_rig import check
from tests.support.records.stored import begin, checks_of, open_store, settle

PORT, ADAPTER = "/dev/ttyUSB0", "0403:6001 A1"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    # A check has the computer's own time: what is noted comes after it, each a second later.
    now = datetime.now(UTC) + timedelta(seconds=2)

    def tick() -> datetime:
        nonlocal now
        now += timedelta(seconds=1)
        return now

    with closing(open_store(tmp_path, clock=tick)) as opened:
        yield opened


def file(store: Store, name: str | None = "M-07") -> Filed:
    evidence = check().assessment.case.evidence
    evidence.port = PORT
    person = Person(module=name, are_records_reviewed=True, is_same_module=True)
    return file_check(evidence, NO_PROFILE, person, store=store, adapter=ADAPTER)


def deploy(store: Store, outcome: Outcome | None, name: str = "M-07", port: str = PORT) -> None:
    """None: the program ended before it knew what came of it."""
    frame = REQUESTS[Act.DEPLOY].encode()
    intent = begin(store, Act.DEPLOY, frame, {}, port=port, adapter=ADAPTER, name=name, run="run")
    if outcome is not None:
        settle(store, intent, outcome)


def trigger(store: Store, name: str = "M-07") -> None:
    store.write(lambda facts: note_triggered(facts, name, port=PORT, adapter=ADAPTER)).result()


def repack(store: Store, *, is_later: bool) -> None:
    done = Serviced(service=ServiceKind.REPACK, on=datetime.now().astimezone().date(), due=None, who="Li Wei")
    at = datetime.now(UTC) + timedelta(minutes=5) if is_later else None
    store.write(lambda facts: facts.add(done, "M-07", at=at)).result()


def claimed(store: Store, name: str, port: str = PORT, adapter: str = ADAPTER) -> int:
    """How often it may have fired by now, after a person said its name at that port."""
    store.write(lambda facts: claim_fired(facts, name, port=port, adapter=adapter)).result()
    return len(store.read(lambda facts: facts.of_module(MayHaveFired, name)))


def due(store: Store) -> str:
    (state,) = report(store, datetime.now(UTC))
    return " ".join(one.in_english() for one in state.due)


@pytest.mark.parametrize("what", [Outcome.CONFIRMED, Outcome.REFUSED, Outcome.UNKNOWN, None, "TRIGGERED"])
@pytest.mark.promise("f")
def test_a_deploy_that_left_or_a_triggered_that_was_seen_ends_the_verdict(store: Store, what: Any) -> None:
    assert file(store).assessment.verdict is Verdict.READY
    assert due(store) == ""
    if what == "TRIGGERED":
        trigger(store)
    else:
        deploy(store, what)
    assert "No valid check" in due(store)
    assert "no repack" in due(store)
    (line,) = checks_of(store, "M-07")
    assert not line.holds
    told = [event.text.in_english() for event in module_history(store, "M-07")]
    assert any("READY (void" in text for text in told)


@pytest.mark.parametrize(("outcome", "port"), [(Outcome.NOT_SENT, PORT), (Outcome.CONFIRMED, "sim://M-07")])
def test_a_deploy_that_never_left_or_of_a_simulated_module_ends_nothing(
    store: Store, outcome: Outcome, port: str
) -> None:
    file(store)
    deploy(store, outcome, port=port)
    assert due(store) == ""


@pytest.mark.promise("f")
def test_after_it_fired_no_check_passes_until_it_was_repacked(store: Store) -> None:
    """Also where it restarted meanwhile and reports nothing of it."""
    file(store)
    repack(store, is_later=False)  # on this day, and before it fired
    deploy(store, Outcome.UNKNOWN)
    again = file(store)
    assert again.assessment.result("service") is CheckResult.FAIL
    assert again.assessment.verdict is Verdict.NO_GO
    repack(store, is_later=True)
    assert file(store).assessment.verdict is Verdict.READY
    assert "repack" not in due(store)


@pytest.mark.parametrize("is_deployed", [True, False])
@pytest.mark.promise("f")
def test_what_fired_without_a_name_is_of_the_next_name_said_at_that_port(store: Store, is_deployed: bool) -> None:
    file(store)
    if is_deployed:
        deploy(store, Outcome.UNKNOWN, name="")
    else:
        trigger(store, "")
    assert not claimed(store, "M-07", "/dev/ttyUSB5", "another")
    assert file(store, None).assessment.result("service") is CheckResult.FAIL, "it may be this one, restarted"
    assert due(store) == ""
    assert file(store).assessment.result("service") is CheckResult.FAIL  # it says the name
    assert "no repack" in due(store)
    assert not claimed(store, "M-08")
    assert file(store, None).assessment.result("service") is CheckResult.PASS


def test_an_unnamed_deploy_that_never_left_is_of_nobody(store: Store) -> None:
    deploy(store, Outcome.NOT_SENT, name="")
    assert not claimed(store, "M-07")
    trigger(store, "")
    deploy(store, Outcome.NOT_SENT, name="")
    assert claimed(store, "M-07"), "what was seen before stays"


def test_it_is_the_adapter_that_fired_whatever_its_port_is_called_now(store: Store) -> None:
    trigger(store, "")
    assert not claimed(store, "M-08", PORT, "another")
    assert claimed(store, "M-07", "/dev/ttyUSB5")
    assert not claimed(store, "M-09")


def test_a_check_after_it_fired_is_not_void_where_the_name_was_said_later(tmp_path: Path) -> None:
    past = datetime.now(UTC) - timedelta(minutes=10)
    with closing(open_store(tmp_path, clock=lambda: past)) as store:
        trigger(store, "")
        file(store)
        (line,) = checks_of(store, "M-07")
        assert (line.verdict, line.is_fired_since) == ("NO-GO", False)
