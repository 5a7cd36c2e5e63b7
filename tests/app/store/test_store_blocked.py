"""A store that another program holds for seconds: the window goes on, and what was to be kept is kept afterwards."""

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.identity import IdentityEvidence
from app.records.check_store import CheckStore
from app.store.store import Store, open_store
from app.trigger_records.history import Judgement
from tests.support.journals import begin_baud
from tests.support.patience import MACHINE_S
from tests.support.window.fakes_ui import TRAFFIC_ALONE, simulated, window
from tests.support.window.preflight_window import OnBench, on_bench
from tests.support.window.steps import await_child, find, settle
from tests.ui.pages.triggers.test_triggers_page import fire, name_kept, said, texts
from ui.pages.diagnosis.traffic import TrafficPage
from ui.pages.triggers.model import Column
from ui.services.storage import Storage
from ui.widgets.notice_bar import NoticeBar

PATIENCE_S = 20.0
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
    store.database._connection.execute(f"PRAGMA busy_timeout = {PATIENCE_S * 1000:.0f}")
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
        again = page.strip.button("judge_again")
        assert again is not None
        bench.click(again)
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


def test_the_window_goes_on_while_a_broken_off_baud_change_is_forgotten(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    storage = Storage()
    assert isinstance(storage.store, Store)
    begin_baud(storage.store)
    storage.close()
    with simulated("crashed"), window(qapp, tmp_path) as assembly:
        bar = find(assembly.window, NoticeBar, "notice_bar")
        qtbot.waitUntil(lambda: bar.button("forget_baud") is not None)
        button, store = bar.button("forget_baud"), assembly.storage.store
        assert button is not None
        assert isinstance(store, Store)
        settle(button)
        with held_by_another(qtbot, store) as release:
            button.click()
            assert store.pending_bauds()
            release()
        qtbot.waitUntil(lambda: not store.pending_bauds())


def test_the_store_is_opened_beside_the_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened_in: list[threading.Thread] = []
    may_open = threading.Event()

    def open_slowly(folder: Path | None) -> Store:
        opened_in.append(threading.current_thread())
        may_open.wait(PATIENCE_S)
        return open_store(folder)

    monkeypatch.setattr("ui.services.storage.open_store", open_slowly)
    monkeypatch.setattr("ui.main.PAGES", TRAFFIC_ALONE)
    monkeypatch.setattr("ui.main._load_pages", bool)
    with window(qapp, tmp_path) as assembly:
        try:
            qtbot.waitUntil(lambda: bool(opened_in))
            turns = Turns()
            qtbot.wait(300)
            assert turns.longest_s < MACHINE_S
        finally:
            may_open.set()
        await_child(qtbot, assembly.window, TrafficPage)
        assert isinstance(assembly.storage.store, Store)
    assert opened_in == [opened_in[0]]
    assert opened_in[0] is not threading.main_thread()
