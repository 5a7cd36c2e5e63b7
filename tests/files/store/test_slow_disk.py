"""A store that is locked by another program or slow to commit: LOCK and the line go on, acts wait."""

import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from app.modules.names import modules, remember
from app.procedures.act import perform
from app.procedures.lock import Locked, lock
from app.safety.journal import Act, Outcome
from app.safety.permit import Interlock
from app.store.acts import StoreJournal
from app.store.fact_store import Facts, Store
from app.store.opening import FILE_NAME
from protocol.catalogue import Hazard
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import audit, audit_in, journal_in, open_store, register


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path)) as opened:
        yield opened


@contextmanager
def held(store: Store) -> Iterator[threading.Event]:
    """Block the writing thread until the event is set."""
    release = threading.Event()
    store.write(lambda _facts: release.wait(PATIENCE_S))
    try:
        yield release
    finally:
        release.set()


def locked_by(rig: Rig, journal: StoreJournal) -> Locked:
    return rig.end(rig.job(lock(journal), is_urgent=True, outlives=True))


@pytest.mark.promise("j")
def test_lock_is_sent_reported_and_done_before_anything_is_written(store: Store) -> None:
    rig, journal = settled_rig(active=True), journal_in(store, port="p")
    with held(store):
        locked = locked_by(rig, journal)
        assert locked.is_locked
        assert not rig.bench.module.state.is_active
        assert store.read(audit_in) == ()
    store.write(lambda _facts: None).result(PATIENCE_S)
    (entry,) = audit(store)
    assert (entry.act, entry.outcome) == (Act.LOCK, Outcome.CONFIRMED)


@pytest.mark.promise("j")
def test_lock_overtakes_and_cancels_an_act_that_waits_for_the_disk(store: Store) -> None:
    rig, journal = settled_rig(), journal_in(store, port="p")
    with held(store):
        acting = rig.job(perform(Act.ACTIVATE, journal, permit=rig.permit(Act.ACTIVATE)))
        rig.step_for(0.5)
        assert not acting.has_ended
        assert locked_by(rig, journal).is_locked
    store.write(lambda _facts: None).result(PATIENCE_S)
    assert rig.end(acting).refusals
    assert not [request for request in rig.line.requests if request.hazard is Hazard.DANGEROUS]
    assert (Act.LOCK, Outcome.CONFIRMED) in [(entry.act, entry.outcome) for entry in audit(store)]


@pytest.mark.promise("h")
def test_a_locked_store_refuses_acts_but_not_lock(store: Store, tmp_path: Path) -> None:
    rig, journal = settled_rig(active=True), journal_in(store, port="p")
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


@pytest.mark.promise("j")
def test_reading_does_not_wait_for_a_commit(store: Store) -> None:
    register(store, "M-07")
    inside, release = threading.Event(), threading.Event()

    def write_slowly(facts: Facts) -> None:
        remember(facts, "M-08")
        inside.set()
        release.wait(PATIENCE_S)

    writing = store.write(write_slowly)
    assert inside.wait(PATIENCE_S)
    assert [module.name for module in store.read(modules)] == ["M-07"]
    assert not writing.done()
    release.set()
    writing.result(PATIENCE_S)
    assert {module.name for module in store.read(modules)} == {"M-07", "M-08"}


def test_closing_has_a_limit_and_says_whether_all_was_written(tmp_path: Path) -> None:
    store = open_store(tmp_path)
    journal = journal_in(store, port="p")
    with held(store):
        journal.settle(journal.begin(Act.ZERO, b"", {}), Outcome.CONFIRMED, {})
        assert not store.close(0.01)
        late = journal.begin(Act.ZERO, b"", {})
        assert late.cancelled()
    assert store.close(PATIENCE_S)  # what was left behind was written after all
    with closing(open_store(tmp_path)) as again:
        assert [one.outcome for one in audit(again)] == [Outcome.CONFIRMED]
