"""A check is filed by the store's own thread, while the window goes on; with it what a person said is kept."""

import threading
import time
from pathlib import Path

from PySide6.QtWidgets import QApplication, QComboBox
from pytestqt.qtbot import QtBot

from app.store.store import Store
from app.trigger_records.history import Judgement
from tests.support.window.preflight_window import kept, name_module, on_bench
from ui.pages.preflight.controller import Standing, Statement
from ui.pages.triggers.model import Column

LIMIT_S = 60.0


def test_the_window_does_not_wait_while_a_check_is_filed(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    release = threading.Event()
    with on_bench(qtbot, qapp, tmp_path, "filing") as bench:
        page, store = bench.preflight, bench.assembly.storage.store
        assert isinstance(store, Store)
        name_module(bench, "M-07")
        try:
            bench.click(page.buttons.run)
            qtbot.waitUntil(lambda: page.work._job.is_running)
            store.queue.submit(lambda: release.wait(LIMIT_S))
            qtbot.waitUntil(lambda: page.work._filing.is_running)
            assert page.work.standing is Standing.CHECKING
            began = time.monotonic()
            for _ in range(20):
                QApplication.processEvents()
                assert page.work.standing is Standing.CHECKING  # nothing is said before the record is kept
            assert time.monotonic() - began < LIMIT_S / 2
            assert kept(bench, "M-07") == []
            assert not page.work.can_check
        finally:
            release.set()
        qtbot.waitUntil(lambda: page.work.standing is not Standing.CHECKING)
        assert page.work.trouble is None
        assert len(kept(bench, "M-07")) == 1


def test_records_that_a_person_passed_in_a_check_are_reviewed(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "word", history=2) as bench:
        name_module(bench, "M-07")
        bench.read_triggers()
        bench.triggers.table.selectRow(0)
        bench.click(bench.triggers.detail.buttons[Judgement.FALSE])
        assert bench.check() is Standing.NO_GO
        bench.preflight.work.check(Statement(is_enabling=True, are_records_reviewed=True))
        bench.wait_standing(Standing.READY)
        bench.read_triggers()
        assert [str(bench.triggers.table.filter.index(row, Column.JUDGED).data()) for row in range(2)] == [
            "false trigger",
            "reviewed",
        ]
        show = bench.find(QComboBox, "triggers_show")
        show.setCurrentIndex(show.findText("Not reviewed"))
        assert bench.triggers.table.filter.rowCount() == 0
