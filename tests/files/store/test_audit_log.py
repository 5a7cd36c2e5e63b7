"""The audit log: intents, what came of them, what they leave behind, and a disk that is slow or held by others."""

import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import pytest

from app.procedures.act import perform
from app.procedures.lock import Locked, lock
from app.safety.journal import Act, Outcome
from app.safety.left_active import all_left
from app.safety.permit import Interlock
from app.store.acts import StoreJournal, Where, note_report, note_said_safe
from app.store.fact_store import FILE_NAME, Store
from app.store.rows import ActIntended
from protocol.catalogue import Hazard
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import audit, begin, open_store, settle

FRAME = bytes.fromhex("42 61 25 01 00 26")
PORT = "/dev/ttyUSB0"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path)) as opened:
        yield opened


def test_an_intent_without_an_outcome_reads_as_unknown(tmp_path: Path) -> None:
    noon = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)
    with closing(open_store(tmp_path, clock=lambda: noon)) as store:
        first = begin(store, Act.ZERO, FRAME, {"tilt_deg": 3}, port="sim://", origin="command line")
        second = begin(store, Act.LOCK, FRAME, {}, port="sim://")
        settle(store, second, Outcome.CONFIRMED, {"active": False})
    with closing(open_store(tmp_path)) as store:
        newest, oldest = audit(store)
    assert (oldest.id, oldest.outcome, oldest.origin) == (first.id, Outcome.UNKNOWN, "command line")
    assert (oldest.act, oldest.frame, oldest.detail) == (Act.ZERO, FRAME, {"tilt_deg": 3})
    assert oldest.at.startswith("2026-01-02T12:00:00.")
    assert (newest.outcome, newest.result) == (Outcome.CONFIRMED, {"active": False})


@pytest.mark.parametrize(
    ("acts", "left"),
    [
        ([(Act.ACTIVATE, Outcome.CONFIRMED)], [False]),
        ([(Act.ACTIVATE, None)], [False]),
        ([(Act.ACTIVATE, Outcome.NOT_SENT)], []),
        ([(Act.ACTIVATE, Outcome.REFUSED)], []),
        ([(Act.ACTIVATE, None), (Act.LOCK, Outcome.CONFIRMED)], []),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.LOCK, Outcome.UNKNOWN)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.LOCK, None)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.ACTIVATE, Outcome.NOT_SENT)], [False]),
        ([(Act.LOCK, Outcome.REFUSED)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.SHUTDOWN, Outcome.CONFIRMED)], []),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.SHUTDOWN, Outcome.UNKNOWN)], [False]),
        ([(Act.ZERO, None), (Act.LOCK, Outcome.CONFIRMED)], []),
    ],
)
@pytest.mark.promise("l")
def test_what_is_left_active(acts: list[tuple[Act, Outcome | None]], left: list[bool], tmp_path: Path) -> None:
    for port in PORT, "sim://M-07":
        for act, outcome in acts:
            with closing(open_store(tmp_path)) as store:  # also after `kill -9`
                entry = begin(store, act, FRAME, {}, port=port, name="M-07", run=port)
                if outcome is not None:
                    settle(store, entry, outcome)
    with closing(open_store(tmp_path)) as store:
        found = store.read(all_left)
    assert [(one.port, one.is_lock_unconfirmed) for one in found] == [(PORT, is_lock) for is_lock in left]


@pytest.mark.promise("l")
def test_what_the_module_reports_and_a_person_says(store: Store) -> None:
    here = Where(PORT, "window", "usb 1", "M-07", "run")
    for is_active, count in ((False, 0), (True, 1), (True, 1), (False, 0), (True, 1)):
        store.write(partial(note_report, where=here._replace(port="sim://"), is_active=True))
        store.write(partial(note_report, where=here, is_active=is_active))
        assert len(store.write(all_left).result()) == count
    (left,) = store.write(all_left).result()
    assert (left.module, left.run, left.port, left.adapter) == ("M-07", "run", PORT, "usb 1")
    for name, run in (("M-07", "another"), ("", "unnamed")):
        store.write(partial(note_report, where=here._replace(name=name, run=run), is_active=True))
    store.write(lambda facts: note_said_safe(facts, left, "window"))
    (unnamed,) = store.write(all_left).result()
    assert unnamed.run == "unnamed", "a person's word ends all of that name, and no other"
    (said,) = audit(store)
    assert (said.act, said.outcome, said.frame) == (Act.LOCK, Outcome.CONFIRMED, b"")
    assert said.detail == {"reported_by": "person"}
    store.write(lambda facts: note_said_safe(facts, unnamed, "window"))
    assert store.write(all_left).result() == ()


def test_an_entry_that_could_not_be_written_has_no_outcome_and_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.write_text("in the way", encoding="utf-8")
    troubles: list[object] = []
    with closing(Store(folder)) as store:
        journal = StoreJournal(store, lambda: Where(PORT, "window"), on_trouble=troubles.append)
        entry = journal.begin(Act.LOCK, FRAME, {})
        journal.settle(entry, Outcome.CONFIRMED, {})
    assert entry.exception() is not None
    assert troubles


# A store that is locked by another program or slow to commit: LOCK and the line go on, acts wait


@contextmanager
def held(store: Store) -> Iterator[None]:
    """Its thread does nothing else meanwhile."""
    release = threading.Event()
    store.write(lambda _facts: release.wait(PATIENCE_S))
    try:
        yield
    finally:
        release.set()
    store.write(lambda _facts: None).result(PATIENCE_S)


def locked_by(rig: Rig, journal: StoreJournal) -> Locked:
    return rig.end(rig.job(lock(journal), is_urgent=True, outlives=True))


@pytest.mark.promise("j")
def test_lock_is_sent_reported_and_done_before_anything_is_written(store: Store) -> None:
    rig, journal = settled_rig(active=True), StoreJournal(store, lambda: Where("p", "window"))
    with held(store):
        assert locked_by(rig, journal).is_locked
        assert not rig.bench.module.state.is_active
        assert store.read(lambda facts: facts.of_kind(ActIntended)) == [], (
            "reading does not wait for the store's thread either"
        )
    (entry,) = audit(store)
    assert (entry.act, entry.outcome) == (Act.LOCK, Outcome.CONFIRMED)


@pytest.mark.promise("j")
def test_lock_overtakes_and_cancels_an_act_that_waits_for_the_disk(store: Store) -> None:
    rig, journal = settled_rig(), StoreJournal(store, lambda: Where("p", "window"))
    with held(store):
        acting = rig.job(perform(Act.ACTIVATE, journal, permit=rig.permit(Act.ACTIVATE)))
        rig.step_for(0.5)
        assert not acting.has_ended
        assert locked_by(rig, journal).is_locked
    assert rig.end(acting).refusals
    assert not [request for request in rig.line.requests if request.hazard is Hazard.DANGEROUS]
    assert (Act.LOCK, Outcome.CONFIRMED) in [(entry.act, entry.outcome) for entry in audit(store)]


@pytest.mark.promise("h")
def test_a_locked_store_refuses_acts_but_not_lock(store: Store, tmp_path: Path) -> None:
    rig, journal = settled_rig(active=True), StoreJournal(store, lambda: Where("p", "window"))
    with closing(sqlite3.connect(tmp_path / FILE_NAME)) as other:
        other.execute("BEGIN EXCLUSIVE")
        assert locked_by(rig, journal).is_locked
        acting = rig.job(perform(Act.ACTIVATE, journal, permit=rig.permit(Act.ACTIVATE)))
        rig.step_for(5.0)
        assert acting.has_ended
        assert [refusal.condition for refusal in acting.outcome().refusals] == [Interlock.INTENT_DURABLE]
        other.execute("ROLLBACK")
    journal.begin(Act.ZERO, b"", {}).result(PATIENCE_S)
    assert Act.ACTIVATE not in [entry.act for entry in audit(store)]
