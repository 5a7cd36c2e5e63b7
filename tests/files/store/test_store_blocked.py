"""A store that another program holds, or that does not open: the window goes on, and everything is kept afterwards."""

import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.modules.names import modules
from app.safety.journal import Act, Outcome
from app.store.fact_store import Store, StoreError, open_file
from app.store.rows import Judgement
from app.trigger_records.history import KeptTriggers
from tests.support.records.stored import audit
from tests.support.window.desk import desk
from tests.support.window.fakes_ui import simulated, window
from tests.support.window.fakes_ui import store_of as window_store
from tests.support.window.rig import Rig
from tests.window.pages.triggers.test_triggers_page import JUDGED, fire, name_kept, said, texts

WAITS_S = 20.0
"""Of SQLite: so long a write waits for the program that holds the store."""


def store_of(bench: Rig) -> Store:
    store = bench.assembly.storage.store
    assert isinstance(store, Store)
    return store


@pytest.mark.promise("j")
def test_a_judgement_that_could_not_be_kept_is_said_and_tried_again(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, "triggers", name="again") as bench:
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
            assert texts(bench, 0)[JUDGED] == "—"
            other.execute("ROLLBACK")
        bench.click(page.strip.button("judge_again"))
        bench.until(lambda: not page.work._judging)
        (module,) = store.read(modules)
        (record,) = store.read(lambda facts: KeptTriggers(facts).records(module.name))
        assert (record.judgement, record.note) == (Judgement.BENCH_TEST, "tipped on the table")
        assert said(bench) == ""


def test_the_window_connects_and_locks_though_the_store_does_not_open(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    may_open = threading.Event()

    def open_slowly(path: Path) -> object:
        may_open.wait(WAITS_S)
        return open_file(path)

    monkeypatch.setattr("app.store.fact_store.open_file", open_slowly)
    monkeypatch.setattr("tests.support.window.fakes_ui.Storage.open_store", lambda _storage: None)
    with simulated("beside", active=True), window(qapp, tmp_path) as assembly:
        port = assembly.ports.current
        try:
            assembly.window.connect_to(Target("sim://beside", 115200))
            qtbot.waitUntil(lambda: port.module.view.reported != (None, None))
            assert isinstance(assembly.storage.store, StoreError)
            port.lock.press()
            qtbot.waitUntil(lambda: port.lock.confirmed is not None)
        finally:
            may_open.set()
        monkeypatch.undo()
        store = window_store(assembly.storage)
        qtbot.waitUntil(lambda: [entry.outcome for entry in audit(store, Act.LOCK)] == [Outcome.CONFIRMED])
