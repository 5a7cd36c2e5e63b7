"""Names, notes and texts of files are plain text wherever they are shown: no name is a big green "GO"."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QToolTip, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import connect, simulated, window
from tests.window.lock.test_lock_everywhere import DIALOGS, Bench
from ui.main import PAGES

NAME = '<h1 style="color:green">GO</h1><img src="/usr/share/pixmaps/a.png">'


@pytest.fixture
def bench(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Bench]:
    with simulated("plain") as module, window(qapp, tmp_path, entries=PAGES) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages)
        connect(qtbot, assembly, "sim://plain")
        qtbot.waitUntil(lambda: assembly.ports.module.is_read)
        assembly.ports.module.say_name(NAME)
        yield Bench(qtbot, assembly, module)
        for widget in QApplication.topLevelWidgets():
            if isinstance(widget, QDialog):
                widget.close()


def _tool_tip() -> QLabel | None:
    """The one in sight."""
    for widget in QApplication.topLevelWidgets():
        if isinstance(widget, QLabel) and widget.isVisible() and widget.windowType() == Qt.WindowType.ToolTip:
            return widget
    return None


def assert_plain(root: QWidget) -> int:
    """Every label in sight below `root`; how many they are."""
    labels = [label for label in root.findChildren(QLabel) if label.isVisible()]
    rich = [label.objectName() or label.text() for label in labels if label.textFormat() != Qt.TextFormat.PlainText]
    assert rich == []
    return len(labels)


@pytest.mark.promise("g")
def test_every_label_of_every_page_and_dialog_is_plain(bench: Bench) -> None:
    main, seen = bench.assembly.window, 0
    for entry in PAGES:
        main.go_to(entry.key)
        QApplication.processEvents()
        seen += assert_plain(main)
    assert seen > 300
    for show in DIALOGS.values():
        dialog = show(bench)
        bench.qtbot.waitUntil(dialog.isVisible)
        assert_plain(dialog)
        dialog.close()


@pytest.mark.promise("g")
def test_every_tool_tip_is_plain(bench: Bench) -> None:
    """Those that the program has, and one that looks like a verdict: as it would be shown for anything else."""
    main = bench.assembly.window
    for key in (entry.key for entry in PAGES):
        main.go_to(key)
        QApplication.processEvents()
    shown = 0
    for widget in main.findChildren(QWidget):
        if NAME in widget.toolTip():
            assert_shown_as_it_is(widget, widget.toolTip())
            shown += 1
    assert shown > 0
    assert_shown_as_it_is(main, NAME)
    assert_shown_as_it_is(main, "short")  # the same tip with another text
    assert_shown_as_it_is(main, NAME)


def assert_shown_as_it_is(widget: QWidget, text: str) -> None:
    QToolTip.hideText()
    QToolTip.showText(widget.mapToGlobal(QPoint(5, 5)), text, widget)
    tip = _tool_tip()
    assert tip is not None
    assert (tip.text(), tip.textFormat()) == (text, Qt.TextFormat.PlainText)
    assert tip.width() >= tip.minimumSizeHint().width()
    QToolTip.hideText()
    QTest.qWait(1)
