"""A store that another program holds, or that does not open: the window goes on, and everything is kept afterwards."""

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

from app.engine.target import Target
from app.modules.names import modules
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.fact_store import Store
from app.store.opening import Opened, open_file
from app.store.trouble import StoreTrouble
from app.trigger_records.history import Judgement
from app.trigger_records.kept import KeptTriggers
from tests.support.patience import MACHINE_S
from tests.support.records.stored import audit, records_of, remembered_in
from tests.support.window.fakes_ui import simulated, window
from tests.support.window.fakes_ui import store_of as window_store
from tests.support.window.preflight_window import OnBench, name_module, on_bench
from tests.ui.pages.triggers.test_triggers_page import fire, name_kept, said, texts
from ui.pages.triggers.model import Column

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
    store.write(lambda facts: facts.connection.execute(f"PRAGMA busy_timeout = {WAITS_S * 1000:.0f}")).result()
    with closing(sqlite3.connect(store.path, isolation_level=None)) as other:
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


@pytest.mark.promise("j")
def test_the_window_goes_on_while_trigger_records_and_judgements_are_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "blocked", "triggers") as bench:
        fire(bench)
        page, store = bench.triggers, store_of(bench)
        name_kept(bench, "M-07")
        bench.beside_s = 0.05  # as in the program, where nobody waits for the disk
        with held_by_another(qtbot, store) as release:
            bench.click(page.read)
            bench.until(lambda: page.work.reading is not None)
            assert [row.is_stored for row in page.work.rows] == [False]
            page.table.selectRow(0)
            assert page.detail.seen.text() == "Saving…"
            assert store.read(lambda facts: KeptTriggers(facts).records("M-07")) == ()
            release()
        bench.until(lambda: not page.work.is_busy)
        assert [row.is_stored for row in page.work.rows] == [True]
        page.table.selectRow(0)
        (module,) = store.read(modules)
        with held_by_another(qtbot, store) as release:
            bench.click(page.detail.buttons[Judgement.BENCH_TEST])
            assert texts(bench, 0)[Column.JUDGED] == "bench test"
            page.refresh()
            assert texts(bench, 0)[Column.JUDGED] == "bench test"
            assert store.read(lambda facts: KeptTriggers(facts).records(module.name))[0].judgement is None
            release()
        bench.until(lambda: not page.work._judging)
        assert records_of(store, module.name)[0].judgement is Judgement.BENCH_TEST


@pytest.mark.promise("j")
def test_a_judgement_that_could_not_be_kept_is_said_and_tried_again(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "again", "triggers") as bench:
        fire(bench)
        page, store = bench.triggers, store_of(bench)
        name_kept(bench, "M-07")
        bench.read_triggers()
        page.table.selectRow(0)
        store.write(lambda facts: facts.connection.execute("PRAGMA busy_timeout = 50")).result()
        with closing(sqlite3.connect(store.path, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            page.detail.note.setText("tipped on the table")
            bench.click(page.detail.buttons[Judgement.BENCH_TEST])
            bench.until(lambda: "Not kept." in said(bench))
            assert texts(bench, 0)[Column.JUDGED] == "—"
            other.execute("ROLLBACK")
        bench.click(page.strip.button("judge_again"))
        bench.until(lambda: not page.work._judging)
        (module,) = store.read(modules)
        (record,) = records_of(store, module.name)
        assert (record.judgement, record.note) == (Judgement.BENCH_TEST, "tipped on the table")
        assert said(bench) == ""


@pytest.mark.promise("j")
def test_the_window_goes_on_while_the_module_and_what_was_read_of_it_are_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "met", "triggers") as bench:
        store = store_of(bench)
        bench.beside_s = 0.05  # as in the program, where nobody waits for the disk
        bench.until(lambda: bench.assembly.ports.module.is_read)
        with held_by_another(qtbot, store) as release:
            name_module(bench, "M-07", "triggers")
            assert bench.assembly.ports.module.name == "M-07"
            assert store.read(modules) == ()
            release()
        bench.until(lambda: bool(store.read(modules)))
        module, view = remembered_in(store, "M-07"), bench.assembly.ports.module.view
        assert module is not None
        assert module.boot_count == view.boot_count
        assert module.settings["freefall_time_s"] == view.values["freefall_time_s"].value


def test_the_window_connects_and_locks_though_the_store_does_not_open(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    may_open = threading.Event()

    def open_slowly(path: Path) -> Opened:
        may_open.wait(WAITS_S)
        return open_file(path)

    monkeypatch.setattr("app.store.fact_store.open_file", open_slowly)
    monkeypatch.setattr("tests.support.window.fakes_ui.Storage.open_store", lambda _storage: None)
    with simulated("beside", active=True), window(qapp, tmp_path) as assembly:
        port = assembly.ports.current
        try:
            turns = Turns()
            assembly.window.connect_to(Target("sim://beside", 115200))
            qtbot.waitUntil(lambda: port.module.view.reported != (None, None))
            assert isinstance(assembly.storage.store, StoreTrouble)
            port.lock.press()
            qtbot.waitUntil(lambda: port.lock.confirmed is not None)
            assert turns.longest_s < MACHINE_S
        finally:
            may_open.set()
        monkeypatch.undo()
        store = window_store(assembly.storage)
        qtbot.waitUntil(lambda: [entry.outcome for entry in audit(store, Act.LOCK)] == [Outcome.CONFIRMED])
