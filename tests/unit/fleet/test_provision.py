"""A batch: what is READY gets the name, what is not is set aside with its reason; no name outlives a conversation."""

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from app.fleet.batch import OPEN, SET_ASIDE, BatchRun, ModuleBatch, await_gone, batch_of, counted_names
from app.modules.names import remembered
from app.preflight.checks import Person
from app.preflight.evidence import Evidence
from app.procedures.write import WriteContext
from app.store.fact_store import Store
from app.text.messages import UserError
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame, refuse
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.stored import open_store
from tests.support.thorough import some

PROFILE = 'name = "Survey"\n[settings]\nfreefall_time_s = 1.2\nlight_threshold_v = 2.0\n'


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path / "store")) as one:
        yield one


@pytest.fixture
def batch(tmp_path: Path) -> ModuleBatch:
    path = tmp_path / "survey.toml"
    path.write_text(PROFILE, encoding="utf-8")
    names = counted_names("M-001..M-003")
    assert names is not None
    return batch_of(path, names)


def run_of(batch: ModuleBatch, store: Store) -> BatchRun:
    person = Person(who="Li Wei", are_records_reviewed=True, is_named_by_option=True)
    return BatchRun(batch, store, person, is_enabling=True, are_all_new=False, accepted=frozenset(batch.changes))


def turn(run: BatchRun, store: Store, name: str, rig: Rig) -> str:
    """The turn of one module; why it was set aside, or "" where it got the name."""
    evidence, done = Evidence(port="sim"), None
    job = rig.job(run.provision(evidence, WriteContext(journal=FakeJournal())))
    rig.step_until(lambda: job.has_ended)
    if job.error is None:
        done = job.outcome()
    else:
        assert isinstance(job.error, UserError)
    why = store.write(lambda facts: run.keep(facts, name, evidence, done, "usb")).result()
    return "" if why is None else why.in_english()


def test_a_setting_that_the_module_refuses_sets_it_aside_and_is_named(batch: ModuleBatch, store: Store) -> None:
    run, rig = run_of(batch, store), settled_rig()
    refuse(rig.bench)
    why = turn(run, store, "M-001", rig)
    assert why.startswith(("Free-fall time: ", "Light threshold: "))
    rows = store.read(run.rows)
    assert (rows[-1].name, rows[-1].result) == ("", SET_ASIDE)


ENDS: dict[EndReason, Callable[[Rig], object]] = {
    EndReason.SILENT: lambda rig: rig.bench.change(mute=True),
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
}


@pytest.mark.parametrize("reason", ENDS, ids=lambda reason: reason.name)
def test_the_next_one_is_waited_for_until_this_one_has_gone(reason: EndReason) -> None:
    rig = settled_rig()
    job = rig.job(await_gone())
    rig.step_for(5.0)
    assert not job.has_ended
    ENDS[reason](rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=3.0)
    assert job.error is None


@pytest.mark.parametrize("frame", some(range(1, 170, 5), one_in=4))
@pytest.mark.promise("i")
def test_a_turn_that_broke_off_says_why_and_nobody_gets_the_name(batch: ModuleBatch, store: Store, frame: int) -> None:
    """Another module may answer from then on."""
    run, rig = run_of(batch, store), settled_rig()
    at_frame(rig.bench, frame, rig.bench.restart)
    assert turn(run, store, "M-001", rig) == "The module restarted."
    assert store.read(lambda facts: remembered(facts, "M-001")) is None
    assert {row.result for row in store.read(run.rows)} == {OPEN, SET_ASIDE}
