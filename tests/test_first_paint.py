"""The window is painted before it is filled: what takes long to load comes after the first paint."""

from pathlib import Path

import pytest
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.fakes_ui import WAIT_MS, window
from ui.main_window import MainWindow


def test_pages_are_made_after_the_first_paint(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    make = MainWindow.make_pages

    def painted(self: QWidget, _event: QPaintEvent) -> None:
        order.append("painted")

    def made(self: MainWindow) -> None:
        order.append("made")
        make(self)

    monkeypatch.setattr(MainWindow, "paintEvent", painted, raising=False)
    monkeypatch.setattr(MainWindow, "make_pages", made)
    with window(qapp, tmp_path):
        qtbot.waitUntil(lambda: "made" in order, timeout=WAIT_MS)
    assert order[0] == "painted"
    assert order.count("made") == 1


def test_a_window_that_is_never_painted_is_filled_all_the_same(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MainWindow, "show", lambda self: None)
    with window(qapp, tmp_path) as assembly:
        qtbot.waitUntil(lambda: assembly.window.findChild(QWidget, "traffic_page") is not None, timeout=WAIT_MS)
