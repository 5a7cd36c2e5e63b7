"""The store is copied by itself, and restored from the newest good copy when it is damaged, emptied or gone."""

import sqlite3
import time
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from app.store import copies
from app.store.copies import FOLDER, copies_of, copy_store, restore, to_drop
from app.store.database import FILE_NAME, _check_copy
from app.store.store import Store, open_store
from tests.support.patience import PATIENCE_S

START = datetime(2026, 1, 2, 12, 0, tzinfo=UTC)


class Clock:
    def __init__(self) -> None:
        self.now = START

    def __call__(self) -> datetime:
        return self.now


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


@pytest.fixture
def clock() -> Clock:
    return Clock()


def names(store: Store) -> set[str]:
    return {one.name for one in store.modules()}


def filled(folder: Path, clock: Clock, *modules: str) -> Path:
    """A store with these modules and a copy of it, closed."""
    with closing(open_store(folder, clock=clock)) as store:
        for one in modules:
            store.register_module(one)
        copy = copy_store(folder / FILE_NAME, clock(), is_good=_check_copy)
        assert copy is not None
        return copy


@pytest.mark.parametrize("damage", ["middle", "head", "emptied", "gone"])
def test_a_damaged_store_is_restored_from_the_newest_good_copy_and_that_is_said(
    folder: Path, clock: Clock, damage: str
) -> None:
    copy = filled(folder, clock, "M-07")
    before = copy.read_bytes()
    path = folder / FILE_NAME
    with closing(open_store(folder, clock=clock)) as store:
        store.register_module("after the copy")
    data = bytearray(path.read_bytes())
    match damage:
        case "middle":
            data[4096 : 3 * 4096] = b"\xa5" * (2 * 4096)
            path.write_bytes(data)
        case "head":
            path.write_bytes(b"\x00" * 64 + data[64:])
        case "emptied":
            path.write_bytes(b"")
        case "gone":
            path.unlink()
    spoilt = path.read_bytes() if path.exists() else b""
    clock.now += timedelta(hours=5)
    with closing(open_store(folder, clock=clock)) as store:
        assert names(store) == {"M-07"}
        assert store.notice is not None
        when = f"{START.astimezone():%Y-%m-%d %H:%M}"
        assert f"restored from the copy of {when}; later ones are missing" in store.notice.in_english()
        store.register_module("goes on")
    assert copy.read_bytes() == before
    if damage in ("middle", "head"):
        kept = [one for one in folder.iterdir() if "20260102-170000" in one.name and one.suffix == ".sqlite"]
        assert [one.read_bytes() for one in kept] == [spoilt]
        assert str(kept[0]) in store.notice.in_english()
    with closing(open_store(folder, clock=clock)) as store:
        assert store.notice is None
        assert names(store) == {"M-07", "goes on"}


def test_a_copy_that_is_damaged_itself_is_passed_over(folder: Path, clock: Clock) -> None:
    filled(folder, clock, "M-07")
    clock.now += timedelta(hours=2)
    newest = filled(folder, clock, "M-08")
    newest.write_bytes(newest.read_bytes()[:5000])
    (folder / FILE_NAME).write_bytes(b"nothing")
    with closing(open_store(folder, clock=clock)) as store:
        assert names(store) == {"M-07"}


def test_a_damaged_store_is_never_copied_over_a_good_copy(folder: Path, clock: Clock) -> None:
    filled(folder, clock, "M-07")
    path = folder / FILE_NAME
    data = bytearray(path.read_bytes())
    data[4096 : 3 * 4096] = b"\xa5" * (2 * 4096)
    path.write_bytes(data)
    with pytest.raises(sqlite3.Error):
        copy_store(path, START + timedelta(hours=1), is_good=_check_copy)
    assert len(copies_of(path)) == 1
    assert [one.suffix for one in (folder / FOLDER).iterdir()] == [".sqlite"]


def test_an_empty_store_is_no_copy_to_come_back_to(folder: Path) -> None:
    (folder / FOLDER).mkdir(parents=True)
    sqlite3.connect(folder / FOLDER / "dps-s.20260102-120000.sqlite").close()
    assert restore(folder / FILE_NAME, is_good=_check_copy) is None
    assert not (folder / FILE_NAME).exists()


def test_four_copies_and_one_a_day_for_a_week_are_kept() -> None:
    hours = [START - timedelta(hours=one) for one in range(24 * 30)]
    made = [Path(f"dps-s.{one:%Y%m%d-%H%M%S}.sqlite") for one in hours]
    dropped = set(to_drop(made))
    kept = [one for one in made if one not in dropped]
    assert kept[:4] == made[:4]
    assert len(kept) == 4 + 6
    assert len({one.name[6:14] for one in kept}) == 7
    assert to_drop([Path("dps-s.mine.sqlite")] * 20) == []


def test_the_copies_are_made_beside_while_the_store_is_written(folder: Path, clock: Clock) -> None:
    with closing(open_store(folder, clock=clock)) as store:
        store.register_module("M-07")
        assert not copies_of(folder / FILE_NAME)
        for days in range(1, 4):
            clock.now = START + timedelta(days=1.1 * days)
            deadline = time.monotonic() + PATIENCE_S
            while len(copies_of(folder / FILE_NAME)) < days:
                assert time.monotonic() < deadline
                store.database.copy_if_due()  # as the window's timer does: the thread of the last copy may still end
                store.register_module("M-07")
            clock.now += timedelta(hours=2)
            for _ in range(3):
                store.database.copy_if_due()  # nothing is due
        assert len(copies_of(folder / FILE_NAME)) == 3


def test_a_store_that_is_written_all_the_time_is_copied_as_it_was_at_the_beginning(
    folder: Path, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(copies, "PAGES_AT_ONCE", 4)
    with closing(open_store(folder, clock=clock)) as store:
        store.register_module("M-0")
        lots = 0

        def write_between_lots() -> bool:
            nonlocal lots
            lots += 1
            store.register_module(f"M-{lots}")
            return lots < 500

        copy = copy_store(folder / FILE_NAME, clock(), is_good=_check_copy, is_wanted=write_between_lots)
        assert copy is not None
        assert lots > 2
        with closing(sqlite3.connect(copy)) as copied:
            assert copied.execute("SELECT module FROM facts").fetchall() == [("M-0",)]
        assert len(names(store)) == 1 + lots


def test_a_store_that_was_there_is_copied_at_the_opening_where_the_last_copy_is_old(folder: Path, clock: Clock) -> None:
    filled(folder, clock, "M-07")
    path = folder / FILE_NAME
    for hours, count in ((0, 1), (1.5, 2)):
        clock.now = START + timedelta(hours=hours)
        with closing(open_store(folder, clock=clock)):
            deadline = time.monotonic() + (PATIENCE_S if count == 2 else 0.2)
            while len(copies_of(path)) < 2 and time.monotonic() < deadline:
                time.sleep(0.01)
        assert len(copies_of(path)) == count


def test_a_command_that_opens_the_store_for_a_moment_lets_the_copy_end(
    folder: Path, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a user of the command line never gets one, and every command begins one."""
    filled(folder, clock, "M-07")
    monkeypatch.setattr(copies, "CLOSING_LIMIT_S", PATIENCE_S)
    clock.now += timedelta(hours=2)
    open_store(folder, clock=clock).close()
    assert len(copies_of(folder / FILE_NAME)) == 2


def test_closing_breaks_a_copy_off(folder: Path, clock: Clock) -> None:
    filled(folder, clock, "M-07")
    path = folder / FILE_NAME
    assert copy_store(path, START + timedelta(hours=1), is_good=_check_copy, is_wanted=lambda: False) is None
    assert len(list((folder / FOLDER).iterdir())) == 1
