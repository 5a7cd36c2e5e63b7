"""A batch: what is READY gets the name, what is not is set aside with its reason; no name outlives a conversation."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

import pytest

from app.engine.conversation import Interrupted
from app.fleet.batch import OPEN, READY, SET_ASIDE, BatchRun, ModuleBatch, batch_of, write_batch_labels
from app.fleet.batch_names import counted_names
from app.fleet.provision import await_gone
from app.modules.labels import PAPERS, Paper
from app.modules.names import remember, remembered
from app.preflight.evidence import Evidence
from app.preflight.findings import Person
from app.procedures.write import WriteContext
from app.store.fact_store import Store
from app.text.user_error import UserError
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.exchange import ExchangedRig
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.stored import checks_of, open_store
from tests.support.thorough import some


def _printed(bodies: Sequence[str], _paper: Paper, attached: bytes | None) -> bytes:
    assert attached is not None
    return b"%PDF- " + "".join(bodies).encode() + b"\nstream\n" + attached + b"\nendstream"


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


def states(run: BatchRun, store: Store) -> list[tuple[str, str]]:
    return [(row.name, row.result) for row in store.read(run.rows)]


@pytest.mark.promise("i")
def test_what_is_ready_gets_the_name_and_what_was_read_is_kept_under_it(batch: ModuleBatch, store: Store) -> None:
    run = run_of(batch, store)
    assert turn(run, store, "M-001", settled_rig()) == ""
    assert states(run, store) == [("M-001", READY), ("M-002", OPEN), ("M-003", OPEN)]
    known = store.read(lambda facts: remembered(facts, "M-001"))
    assert known is not None
    assert (known.boot_count, known.settings["freefall_time_s"], known.settings["light_threshold_v"]) == (37, 1.2, 2.0)
    assert [check.verdict for check in checks_of(store, "M-001")] == ["READY"]
    assert store.read(run_of(batch, store).left) == (["M-002", "M-003"], [])


def test_a_name_that_is_taken_is_left_out(batch: ModuleBatch, store: Store) -> None:
    store.write(lambda facts: remember(facts, "M-002")).result()
    run = run_of(batch, store)
    assert store.read(run.left) == (["M-001", "M-003"], ["M-002"])
    assert turn(run, store, "M-002", settled_rig()) == "M-002 is the name of another module: left out."
    assert states(run, store)[1] == ("M-002", OPEN)


@pytest.mark.promise("i")
def test_a_module_that_is_plugged_in_again_gets_no_second_name(batch: ModuleBatch, store: Store) -> None:
    run, rig = run_of(batch, store), settled_rig()
    assert turn(run, store, "M-001", rig) == ""
    rig.bench.restart()
    rig.step_for(3.0)
    sent = len(rig.acts)
    assert turn(run, store, "M-002", rig) == "It may be M-001: boot count and settings fit."
    assert len(rig.acts) == sent, "nothing was written"
    other = settled_rig(boots=3)
    assert turn(run, store, "M-002", other) == "", "it started less often than M-001, and holds other settings"


def test_nothing_is_written_to_an_active_module(batch: ModuleBatch, store: Store) -> None:
    rig = settled_rig(active=True)
    assert turn(run_of(batch, store), store, "M-001", rig) == "The module is ACTIVE: lock it first."
    assert rig.acts == []


def test_a_setting_that_the_module_refuses_sets_it_aside_and_is_named(batch: ModuleBatch, store: Store) -> None:
    run = run_of(batch, store)
    why = turn(run, store, "M-001", settled_rig(refuses=True))
    assert why.startswith(("Free-fall time: ", "Light threshold: "))
    rows = store.read(run.rows)
    assert (rows[-1].name, rows[-1].result) == ("", SET_ASIDE)


def test_what_stands_against_ready_sets_it_aside(batch: ModuleBatch, store: Store) -> None:
    run = run_of(batch, store)
    assert turn(run, store, "M-001", settled_rig(cell=3.4)) == "Cell voltage"
    assert checks_of(store, "M-001") == ()
    assert len(checks_of(store, None)) == 1, "the record is kept, without the name"


@pytest.mark.promise("i")
def test_another_module_in_its_place_gets_neither_settings_nor_the_name(batch: ModuleBatch, store: Store) -> None:
    run = run_of(batch, store)
    for frame in some(range(1, 170, 5), one_in=4):
        rig = ExchangedRig(frame, boots=37)
        why = turn(run, store, "M-001", rig)
        assert rig.is_exchanged
        assert rig.to_second == [], frame
        assert why == "The module was silent for a moment.", frame
    assert store.read(lambda facts: remembered(facts, "M-001")) is None
    assert {state for _name, state in states(run, store)} == {OPEN, SET_ASIDE}


ENDS: dict[EndReason, Callable[[Rig], object]] = {
    EndReason.SILENT: lambda rig: rig.bench.change(mute=True),
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
}


@pytest.mark.parametrize("reason", ENDS, ids=lambda reason: reason.value)
def test_the_next_one_is_waited_for_until_this_one_has_gone(reason: EndReason) -> None:
    rig = settled_rig()
    job = rig.job(await_gone())
    rig.step_for(5.0)
    assert not job.has_ended
    ENDS[reason](rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=3.0)
    assert job.error is None


def test_a_turn_that_broke_off_says_why(batch: ModuleBatch, store: Store) -> None:
    rig, evidence = settled_rig(), Evidence(port="sim")
    job = rig.job(run_of(batch, store).provision(evidence, WriteContext(journal=FakeJournal())))
    rig.step_for(0.1)
    rig.session.close(EndReason.PORT_LOST)
    assert isinstance(job.error, Interrupted)
    assert evidence.void is not None
    assert evidence.void.message.in_english() == "The port was lost."


def test_the_labels_of_what_is_given_are_ours_to_replace(batch: ModuleBatch, store: Store, tmp_path: Path) -> None:
    run, path = run_of(batch, store), tmp_path / "labels.pdf"
    assert turn(run, store, "M-001", settled_rig()) == ""
    for _ in range(2):
        write_batch_labels(path, store.read(run.rows), PAPERS["62"], _printed)
    assert b"M-001" in path.read_bytes()
    assert b"M-002" not in path.read_bytes()
    path.write_bytes(b"a thesis")
    with pytest.raises(UserError):
        write_batch_labels(path, store.read(run.rows), PAPERS["62"], _printed)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ("[settings]\nbaud_rate = 9600\n", "holds no settings"),
        ("[tests]\ntilt = 30\n[settings]\nfreefall_time_s = 1.2\n", "manual checks or guided tests"),
        ("", "holds no settings"),
    ],
)
def test_a_profile_with_which_no_module_can_be_ready_is_refused(tmp_path: Path, more: str, why: str) -> None:
    path = tmp_path / "profile.toml"
    path.write_text(f'name = "Survey"\n{more}', encoding="utf-8")
    with pytest.raises(UserError, match=why):
        batch_of(path, ("M-001",))
