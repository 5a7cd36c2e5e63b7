"""A store that another program holds keeps everything afterwards; it is copied by itself, and restored when damaged."""

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.identity import IdentityEvidence
from app.records.check_store import CheckStore
from app.store import copies
from app.store.copies import FOLDER, copied_at, copies_of, copy_store, restore, to_drop
from app.store.database import FILE_NAME
from app.store.store import Store, open_store
from app.trigger_records.history import Judgement
from tests.support.patience import MACHINE_S, PATIENCE_S
from tests.support.window.fakes_ui import EMPTY_PAGE, window
from tests.support.window.preflight_window import OnBench, on_bench
from tests.support.window.steps import await_child
from tests.ui.pages.triggers.test_triggers_page import fire, name_kept, said, texts
from ui.pages.triggers.model import Column
from ui.services.page import Page

WAITS_S = 20.0
"""Of SQLite: so long a write waits for the program that holds the store."""
HELD_S = 0.3


class Turns:
    """The longest time between two turns of the window's event loop."""

    def __init__(self) -> None:
        self.longest_s, self._last = 0.0, time.monotonic()
        self._timer = QTimer()
        self._timer.setInterval(5)
        self._timer.timeout.connect(self._turn)
        self._timer.start()

    def _turn(self) -> None:
        now = time.monotonic()
        self.longest_s, self._last = max(self.longest_s, now - self._last), now


@contextmanager
def held_by_another(qtbot: QtBot, store: Store) -> Iterator[Callable[[], None]]:
    """Another connection is about to write; what is called lets it go, after `HELD_S` in which the window was alive."""
    store.database._connection.execute(f"PRAGMA busy_timeout = {WAITS_S * 1000:.0f}")
    with closing(sqlite3.connect(store.database.path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        turns = Turns()

        def release() -> None:
            qtbot.wait(int(HELD_S * 1000))
            other.execute("ROLLBACK")
            assert turns.longest_s < MACHINE_S, f"the window stood still for {turns.longest_s:.1f} s"

        yield release


def store_of(bench: OnBench) -> Store:
    store = bench.assembly.storage.store
    assert isinstance(store, Store)
    return store


def test_the_window_goes_on_while_trigger_records_and_judgements_are_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "blocked", "triggers") as bench:
        fire(bench)
        page, store = bench.triggers, store_of(bench)
        name_kept(bench, "M-07")
        with held_by_another(qtbot, store) as release:
            bench.click(page.read)
            bench.until(lambda: page.work.reading is not None)
            assert [row.is_stored for row in page.work.rows] == [False]
            page.table.selectRow(0)
            assert page.detail.seen.text() == "Saving…"
            assert store.modules() == ()
            release()
        bench.until(lambda: not page.work.is_busy)
        assert [row.is_stored for row in page.work.rows] == [True]
        page.table.selectRow(0)
        (module,) = store.modules()
        with held_by_another(qtbot, store) as release:
            bench.click(page.detail.buttons[Judgement.BENCH_TEST])
            assert texts(bench, 0)[Column.JUDGED] == "bench test"
            page.refresh()
            assert texts(bench, 0)[Column.JUDGED] == "bench test"
            assert CheckStore(store.database).records(module.name)[0].judgement is None
            release()
        bench.until(lambda: not page.work._judging)
        assert CheckStore(store.database).records(module.name)[0].judgement is Judgement.BENCH_TEST


def test_a_judgement_that_could_not_be_kept_is_said_and_tried_again(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "again", "triggers") as bench:
        fire(bench)
        page, store = bench.triggers, store_of(bench)
        name_kept(bench, "M-07")
        bench.read_triggers()
        page.table.selectRow(0)
        store.database._connection.execute("PRAGMA busy_timeout = 50")
        with closing(sqlite3.connect(store.database.path, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            page.detail.note.setText("tipped on the table")
            bench.click(page.detail.buttons[Judgement.BENCH_TEST])
            bench.until(lambda: "Not kept." in said(bench))
            assert texts(bench, 0)[Column.JUDGED] == "—"
            other.execute("ROLLBACK")
        bench.click(page.strip.button("judge_again"))
        bench.until(lambda: not page.work._judging)
        (module,) = store.modules()
        (record,) = CheckStore(store.database).records(module.name)
        assert (record.judgement, record.note) == (Judgement.BENCH_TEST, "tipped on the table")
        assert said(bench) == ""


def test_the_window_goes_on_while_the_module_and_what_was_read_of_it_are_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "met", "triggers") as bench:
        page, store = bench.triggers, store_of(bench)
        name_kept(bench, "M-07")
        naming = page._connector.current.module
        bench.until(lambda: "M-07" in naming._read)
        with held_by_another(qtbot, store) as release:
            naming.remember_adapter()
            assert store.modules() == ()
            release()
        bench.until(lambda: bool(store.modules()))
        (module,) = store.modules()
        assert (module.name, module.adapter) == ("M-07", naming.adapter)
        bench.until(lambda: store.evidence(module.name) != IdentityEvidence())
        assert store.evidence(module.name) == naming._read["M-07"]


def test_the_store_is_opened_beside_the_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened_in: list[threading.Thread] = []
    may_open = threading.Event()

    def open_slowly(folder: Path | None) -> Store:
        opened_in.append(threading.current_thread())
        may_open.wait(WAITS_S)
        return open_store(folder)

    monkeypatch.setattr("ui.services.storage.open_store", open_slowly)
    monkeypatch.setattr("ui.main.PAGES", EMPTY_PAGE)
    monkeypatch.setattr("ui.main._load_libraries", bool)
    with window(qapp, tmp_path) as assembly:
        try:
            qtbot.waitUntil(lambda: bool(opened_in))
            turns = Turns()
            qtbot.wait(300)
            assert turns.longest_s < MACHINE_S
        finally:
            may_open.set()
        await_child(qtbot, assembly.window, Page)
        assert isinstance(assembly.storage.store, Store)
    assert opened_in == [opened_in[0]]
    assert opened_in[0] is not threading.main_thread()


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
    return {module.name for module in store.modules()}


def filled(folder: Path, clock: Clock, *modules: str) -> Path:
    """A store with these modules and a copy of it, closed."""
    with closing(open_store(folder, clock=clock)) as store:
        copier = store.database._copies
        if copier is not None and copier._thread is not None:
            copier._thread.join()  # that of the opening, which has the same name and holds less
        for module in modules:
            store.register_module(module)
        copy = copy_store(folder / FILE_NAME, clock())
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
        assert store.database.notice is not None
        when = f"{START.astimezone():%Y-%m-%d %H:%M}"
        assert f"restored from the copy of {when}; later ones are missing" in store.database.notice.in_english()
        store.register_module("goes on")
    assert copy.read_bytes() == before
    if damage in ("middle", "head"):
        kept = [one for one in folder.iterdir() if "20260102-170000" in one.name and one.suffix == ".sqlite"]
        assert [one.read_bytes() for one in kept] == [spoilt]
        assert str(kept[0]) in store.database.notice.in_english()
    with closing(open_store(folder, clock=clock)) as store:
        assert store.database.notice is None
        assert names(store) == {"M-07", "goes on"}


def test_copies_of_a_clock_that_was_ahead_are_not_the_newest(folder: Path, clock: Clock) -> None:
    for days in range(9):
        clock.now = START + timedelta(days=400 + days)
        filled(folder, clock, f"M-{days}")
    clock.now = START
    filled(folder, clock, "after it was set back")
    clock.now += timedelta(minutes=1)
    with closing(open_store(folder, clock=clock)) as store:
        store.register_module("not copied yet")
    assert START in map(copied_at, copies_of(folder / FILE_NAME, clock()))
    (folder / FILE_NAME).write_bytes(b"nothing")
    with closing(open_store(folder, clock=clock)) as store:
        assert "after it was set back" in names(store)
        assert "not copied yet" not in names(store)


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
        copy_store(path, START + timedelta(hours=1))
    assert len(copies_of(path, START)) == 1
    assert [one.suffix for one in (folder / FOLDER).iterdir()] == [".sqlite"]


def test_an_empty_store_is_no_copy_to_come_back_to(folder: Path) -> None:
    (folder / FOLDER).mkdir(parents=True)
    sqlite3.connect(folder / FOLDER / "dps-s.20260102-120000.sqlite").close()
    assert restore(folder / FILE_NAME, START) is None
    assert not (folder / FILE_NAME).exists()


def test_four_copies_and_one_a_day_for_a_week_are_kept() -> None:
    hours = [START - timedelta(hours=one) for one in range(24 * 30)]
    made = [Path(f"dps-s.{hour:%Y%m%d-%H%M%S}.sqlite") for hour in hours]
    dropped = set(to_drop(made))
    kept = [one for one in made if one not in dropped]
    assert kept[:4] == made[:4]
    assert len(kept) == 4 + 6
    assert len({one.name[6:14] for one in kept}) == 7
    assert to_drop([Path("dps-s.mine.sqlite")] * 20) == []


def test_the_copies_are_made_beside_while_the_store_is_written(folder: Path, clock: Clock) -> None:
    with closing(open_store(folder, clock=clock)) as store:
        store.register_module("M-07")
        assert not copies_of(folder / FILE_NAME, clock())
        for days in range(1, 4):
            clock.now = START + timedelta(days=1.1 * days)
            deadline = time.monotonic() + PATIENCE_S
            while len(copies_of(folder / FILE_NAME, clock())) < days:
                assert time.monotonic() < deadline
                store.database.copy_if_due()  # as the window's timer does: the thread of the last copy may still end
                store.register_module("M-07")
            clock.now += timedelta(hours=2)
            for _ in range(3):
                store.database.copy_if_due()  # nothing is due
        assert len(copies_of(folder / FILE_NAME, clock())) == 3


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

        copy = copy_store(folder / FILE_NAME, clock(), is_wanted=write_between_lots)
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
            while len(copies_of(path, clock())) < 2 and time.monotonic() < deadline:
                time.sleep(0.01)
        assert len(copies_of(path, clock())) == count


def test_a_command_that_opens_the_store_for_a_moment_lets_the_copy_end(
    folder: Path, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a user of the command line never gets one, and every command begins one."""
    filled(folder, clock, "M-07")
    monkeypatch.setattr(copies, "CLOSING_LIMIT_S", PATIENCE_S)
    clock.now += timedelta(hours=2)
    open_store(folder, clock=clock).close()
    assert len(copies_of(folder / FILE_NAME, clock())) == 2


def test_closing_breaks_a_copy_off(folder: Path, clock: Clock) -> None:
    filled(folder, clock, "M-07")
    path = folder / FILE_NAME
    with pytest.raises(InterruptedError):
        copy_store(path, START + timedelta(hours=1), is_wanted=lambda: False)
    assert len(list((folder / FOLDER).iterdir())) == 1
