"""The audit log: intents, what came of them, and what they leave behind."""

from contextlib import closing
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import pytest

from app.safety.journal import Act, Outcome
from app.safety.left_active import KnownAs
from app.store.acts import StoreJournal, Where, note_report, note_said_safe
from app.store.fact_store import Store
from tests.support.records.stored import audit, begin, left_in, open_store, settle

FRAME = bytes.fromhex("42 61 25 01 00 26")
PORT = "/dev/ttyUSB0"


def noon() -> datetime:
    return datetime(2026, 1, 2, 12, 0, tzinfo=UTC)


def test_an_intent_without_an_outcome_reads_as_unknown(tmp_path: Path) -> None:
    with closing(open_store(tmp_path, clock=noon)) as store:
        first = begin(store, Act.ZERO, FRAME, {"tilt_deg": 3}, port="sim://", origin="command line")
        second = begin(store, Act.LOCK, FRAME, {}, port="sim://")
        settle(store, second, Act.LOCK, Outcome.CONFIRMED, {"active": False}, port="sim://")
    with closing(open_store(tmp_path)) as store:
        newest, oldest = audit(store)
    assert (oldest.id, oldest.outcome, oldest.origin) == (first, Outcome.UNKNOWN, "command line")
    assert (oldest.act, oldest.frame, oldest.detail) == (Act.ZERO, FRAME, {"tilt_deg": 3})
    assert oldest.at.startswith("2026-01-02T12:00:00.")
    assert (newest.outcome, newest.result) == (Outcome.CONFIRMED, {"active": False})


@pytest.mark.parametrize(
    ("acts", "left"),
    [
        ([(Act.ACTIVATE, Outcome.CONFIRMED)], [False]),
        ([(Act.ACTIVATE, Outcome.UNKNOWN)], [False]),
        ([(Act.ACTIVATE, None)], [False]),
        ([(Act.ACTIVATE, Outcome.NOT_SENT)], []),
        ([(Act.ACTIVATE, Outcome.REFUSED)], []),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.LOCK, Outcome.CONFIRMED)], []),
        ([(Act.ACTIVATE, None), (Act.LOCK, Outcome.CONFIRMED)], []),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.LOCK, Outcome.UNKNOWN)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.LOCK, None)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.ACTIVATE, Outcome.NOT_SENT)], [False]),
        ([(Act.LOCK, Outcome.UNKNOWN)], [True]),
        ([(Act.LOCK, Outcome.REFUSED)], [True]),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.SHUTDOWN, Outcome.CONFIRMED)], []),
        ([(Act.ACTIVATE, Outcome.CONFIRMED), (Act.SHUTDOWN, Outcome.UNKNOWN)], [False]),
        ([(Act.ZERO, None), (Act.LOCK, Outcome.CONFIRMED)], []),
    ],
)
@pytest.mark.promise("l")
def test_what_is_left_active(acts: list[tuple[Act, Outcome | None]], left: list[bool], tmp_path: Path) -> None:
    known_as = KnownAs("M-07", "run")
    for act, outcome in acts:
        with closing(open_store(tmp_path)) as store:  # also after `kill -9`
            entry = begin(store, act, FRAME, {}, port=PORT, known_as=known_as)
            if outcome is not None:
                settle(store, entry, act, outcome, port=PORT, known_as=known_as)
    with closing(open_store(tmp_path)) as store:
        assert [one.is_lock_unconfirmed for one in left_in(store)] == left


def test_a_simulated_module_leaves_nothing_active(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        begin(store, Act.ACTIVATE, FRAME, {}, port="sim://M-07", known_as=KnownAs("M-07", "run"))
        store.write(lambda facts: note_report(facts, Where("sim://", "window"), is_active=True))
        assert left_in(store) == ()


@pytest.mark.promise("l")
def test_what_the_module_reports_and_a_person_says(tmp_path: Path) -> None:
    here = Where(PORT, "window", "usb 1", KnownAs("M-07", "run"))
    with closing(open_store(tmp_path)) as store:
        for is_active, count in ((False, 0), (True, 1), (True, 1), (False, 0)):
            store.write(partial(note_report, where=here, is_active=is_active))
            assert len(left_in(store)) == count
        store.write(partial(note_report, where=here, is_active=True))
        (left,) = left_in(store)
        assert (left.module, left.run, left.port, left.adapter) == (*here.known_as, PORT, "usb 1")
        store.write(lambda facts: note_said_safe(facts, left, "window"))
        assert left_in(store) == ()
        (said,) = audit(store)
        assert (said.act, said.outcome, said.frame) == (Act.LOCK, Outcome.CONFIRMED, b"")
        assert said.detail == {"reported_by": "person"}


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
