"""A deploy that left, and a TRIGGERED that was seen, end every earlier verdict, in store, archive and check."""

from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import Archive
from app.archive.report import ModuleToday, module_history, report
from app.preflight.checks import CheckResult, Person
from app.preflight.verdict import Verdict
from app.records.filing import Filed, file_check
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.left_active import KnownAs
from app.settings.profiles import NO_PROFILE
from app.store.acts import claim_fired, note_triggered
from app.store.fact_store import Facts, Kept, Store
from app.store.rows import MayHaveFired, Serviced
from tests.support.records.preflight_rig import check
from tests.support.records.stored import checks_of, journal_in, open_store

PORT, ADAPTER = "/dev/ttyUSB0", "0403:6001 A1"


class Bench:
    """A store and its archive. Its clock is a minute later at each question."""

    def __init__(self, folder: Path) -> None:
        self.now = datetime.now(UTC) - timedelta(hours=2)
        self.store: Store = open_store(folder, clock=self.tick)

    def tick(self) -> datetime:
        self.now += timedelta(seconds=1)
        return self.now

    def file(self, name: str | None = "M-07", port: str = PORT) -> Filed:
        evidence = check().assessment.case.evidence
        evidence.port = port
        person = Person(module=name, are_records_reviewed=True, is_same_module=True)
        return file_check(evidence, NO_PROFILE, person, store=self.store, adapter=ADAPTER)

    def deploy(self, outcome: Outcome | None, name: str = "M-07", port: str = PORT) -> None:
        """As the window does it; None: the program ended before it knew what came of it."""
        known_as = KnownAs(name, "run")
        journal = journal_in(self.store, port=port, adapter=ADAPTER, known_as=known_as)
        entry = journal.begin(Act.DEPLOY, REQUESTS[Act.DEPLOY].encode(), {})
        entry.result(5.0)
        if outcome is not None:
            journal.settle(entry, outcome, {})
        self.store.write(lambda _facts: None).result(5.0)

    def today(self) -> ModuleToday:
        (state,) = report(Archive(self.store), datetime.now(UTC))
        return state

    def told(self) -> list[str]:
        history = module_history(Archive(self.store), "M-07")
        return [event.text.in_english() for event in history]

    def repack(self, at: str | None = "later") -> None:
        today = datetime.now().astimezone().date()
        done = Serviced(service="repack", on=today, due=None, who="Li Wei")
        when = datetime.now(UTC) + timedelta(minutes=5) if at else None
        self.store.write(lambda facts: facts.add(done, "M-07", at=when)).result(5.0)

    def do(self, work: Callable[[Facts], object]) -> None:
        self.store.write(work).result(5.0)

    def fired(self, name: str) -> list[Kept[MayHaveFired]]:
        return self.store.read(lambda facts: facts.of_module(MayHaveFired, name))


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    made.now = datetime.now(UTC) + timedelta(seconds=2)  # a check has the computer's own time
    yield made
    made.store.close()


def due_of(bench: Bench) -> str:
    return " ".join(due.in_english() for due in bench.today().due)


@pytest.mark.parametrize("what", [Outcome.CONFIRMED, Outcome.REFUSED, Outcome.UNKNOWN, None, "TRIGGERED"])
@pytest.mark.promise("f")
def test_a_deploy_that_left_or_a_triggered_that_was_seen_ends_the_verdict(bench: Bench, what: Any) -> None:
    assert bench.file().assessment.verdict is Verdict.READY
    assert "fired" not in due_of(bench)
    if what == "TRIGGERED":
        bench.do(lambda facts: note_triggered(facts, "M-07", port=PORT))
    else:
        bench.deploy(what)
    state = bench.today()
    assert state.last_check is not None
    assert not state.last_check.holds
    assert "READY" not in state.last_check.words.in_english().replace("READY (void", "")
    assert "no repack" in due_of(bench)
    (line,) = checks_of(bench.store, "M-07")
    assert not line.holds
    assert any("READY (void" in text for text in bench.told())


def test_a_deploy_that_never_left_ends_nothing(bench: Bench) -> None:
    bench.file()
    bench.deploy(Outcome.NOT_SENT)
    state = bench.today()
    assert state.last_check is not None
    assert state.last_check.holds
    assert "repack" not in due_of(bench)


@pytest.mark.promise("f")
def test_after_it_fired_no_check_passes_until_it_was_repacked(bench: Bench) -> None:
    """Also where it restarted meanwhile and reports nothing of it."""
    bench.file()
    bench.repack(at=None)  # on this day, and before it fired
    bench.deploy(Outcome.UNKNOWN)
    again = bench.file()
    assert again.assessment.result("service") is CheckResult.FAIL
    assert again.assessment.verdict is Verdict.NO_GO
    bench.repack()
    assert bench.file().assessment.verdict is Verdict.READY
    assert "repack" not in due_of(bench)


@pytest.mark.parametrize("is_deployed", [True, False])
@pytest.mark.promise("f")
def test_what_fired_without_a_name_is_of_the_next_name_said_at_that_port(bench: Bench, is_deployed: bool) -> None:
    bench.file()
    if is_deployed:
        bench.deploy(Outcome.UNKNOWN, name="")
    else:
        bench.do(lambda facts: note_triggered(facts, "", port=PORT, adapter=ADAPTER))
    assert "repack" not in due_of(bench)
    bench.do(lambda facts: claim_fired(facts, "M-07", port="/dev/ttyUSB5", adapter="another"))
    assert "repack" not in due_of(bench)
    assert bench.file().assessment.result("service") is CheckResult.FAIL  # it says the name
    assert "no repack" in due_of(bench)
    bench.do(lambda facts: claim_fired(facts, "M-08", port=PORT, adapter=ADAPTER))
    assert not bench.fired("M-08")


def test_a_check_after_it_fired_is_not_void_where_the_name_was_said_later(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.now = datetime.now(UTC) - timedelta(minutes=10)
    try:
        bench.do(lambda facts: note_triggered(facts, "", port=PORT, adapter=ADAPTER))
        bench.file()
        (line,) = checks_of(bench.store, "M-07")
        assert (line.verdict, line.is_fired_since) == ("NO-GO", False)
    finally:
        bench.store.close()


def test_a_module_without_a_name_does_not_pass_where_one_may_have_fired(bench: Bench) -> None:
    """It may be this one, restarted."""
    assert bench.file(None).assessment.result("service") is CheckResult.PASS
    bench.deploy(Outcome.UNKNOWN, name="")
    assert bench.file(None).assessment.result("service") is CheckResult.FAIL


def test_an_unnamed_deploy_that_never_left_is_of_nobody(bench: Bench) -> None:
    bench.deploy(Outcome.NOT_SENT, name="")
    bench.do(lambda facts: claim_fired(facts, "M-07", port=PORT, adapter=ADAPTER))
    assert not bench.fired("M-07")


def test_a_simulated_module_of_the_same_name_says_nothing_of_the_real_one(bench: Bench) -> None:
    bench.file()
    bench.deploy(Outcome.CONFIRMED, port="sim://M-07")
    state = bench.today()
    assert state.last_check is not None
    assert state.last_check.holds
    assert "repack" not in due_of(bench)
