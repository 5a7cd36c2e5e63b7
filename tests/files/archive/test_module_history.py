"""What happened to one module: its settings before and after, over a restart, and earlier ones to be written again."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import Archive
from app.archive.module_history import HistoryEvent, as_edits, module_history, settings_changed
from app.safety.journal import NOTE, Act, Outcome
from app.safety.left_active import KnownAs
from app.store.fact_store import Store
from app.store.rows import ModuleVisited, SettingsSeen
from tests.support.records.stored import journal_in, open_store

SETTINGS: dict[str, Any] = {"attitude_threshold_deg": 60, "freefall_time_s": 1.2}


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path)) as one:
        yield one


def read(store: Store, boot_count: int, **settings: Any) -> None:
    visit = ModuleVisited(
        port="P", boot_count=boot_count, slots=[], is_confirmed=True, known=0, settings=SETTINGS | settings
    )
    store.add(visit, "M-07").result()


def write(store: Store, outcome: Outcome, *, note: str = "", **detail: Any) -> None:
    journal = journal_in(store, port="P", known_as=KnownAs("M-07"))
    entry = journal.begin(Act.WRITE, b"\x20", detail | ({NOTE: note} if note else {}))
    journal.settle(entry, outcome, {})
    entry.result()


def history(store: Store) -> list[HistoryEvent]:
    return module_history(Archive(store), "M-07")


def told(store: Store) -> list[str]:
    return [event.text.in_english() for event in history(store)]


def test_a_write_is_told_with_the_value_before_and_why(store: Store) -> None:
    store.add(SettingsSeen(port="P", boot_count=4, settings=SETTINGS), "M-07").result()
    write(store, Outcome.CONFIRMED, note="Li Wei: heavier battery", attitude_threshold_deg=65)
    write(store, Outcome.REFUSED, attitude_threshold_deg=70)
    write(store, Outcome.UNKNOWN, attitude_threshold_deg=75)
    write(store, Outcome.CONFIRMED, attitude_threshold_deg=80)
    assert told(store)[1:] == [
        "Attitude threshold 60° → 65°: confirmed. “Li Wei: heavier battery”",
        "Attitude threshold 65° → 70°: refused.",
        "Attitude threshold 65° → 75°: may have been carried out.",
        "Attitude threshold 80°: confirmed.",
    ]
    assert [event.settings.get("attitude_threshold_deg") for event in history(store)] == [60, 65, 65, None, 80]


def test_over_a_restart_it_is_told_what_was_kept(store: Store) -> None:
    for boot_count, settings in ((255, {}), (0, {}), (0, {}), (1, {"freefall_time_s": 1.0}), (9, {})):
        read(store, boot_count, **settings)
    assert told(store) == [
        "Over the restart: settings kept.",
        "Over the restart: Free-fall time 1.20 s → 1.00 s.",
        "Read since: Free-fall time 1.00 s → 1.20 s.",
    ]


def test_two_are_compared_and_an_earlier_one_is_written_again(store: Store) -> None:
    store.add(SettingsSeen(port="P", boot_count=4, settings=SETTINGS), "M-07").result()
    write(store, Outcome.CONFIRMED, attitude_threshold_deg=65, attitude_trigger=True)
    first, last = history(store)
    assert [one.in_english() for one in settings_changed(first.settings, last.settings)] == [
        "Attitude threshold 60° → 65°"
    ]
    assert as_edits(first.settings) == SETTINGS
    assert as_edits({**last.settings, "freefall_time_s": 1e9, "unheard_of": 1}) == {"attitude_threshold_deg": 65}
