"""The "What's this?" texts of all controls, the list of shortcuts, the guide and the About box."""

from collections.abc import Iterator
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, QSize, Qt
from PySide6.QtGui import QAction, QHelpEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QHeaderView,
    QLineEdit,
    QMenu,
    QMessageBox,
    QScrollBar,
    QWhatsThis,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.settings.values import what_is
from protocol.catalogue import SETTINGS, Command
from tests.support.window.fakes_ui import ListedPorts, window
from tests.support.window.steps import find
from ui.help.help_actions import explain
from ui.help.windows import keys_of
from ui.main import PAGES, Assembly
from ui.services.context import PageEntry
from ui.widgets.readout import Readout, StateChip

CONTROLS = (QAbstractButton, QAbstractItemView, QAbstractSlider, QAbstractSpinBox, QComboBox, QLineEdit, Readout,
            StateChip)  # fmt: skip
OFFSCREEN = pytest.mark.qt_log_ignore("does not support", extend=True)
"""That platform has no windows to raise and no keyboard to take."""
NOT_OURS = ("qt_*", "about_*", "*_profile_none")


@contextmanager
def help_window(
    qtbot: QtBot, qapp: QApplication, folder: Path, *, entries: tuple[PageEntry, ...] = PAGES
) -> Iterator[Assembly]:
    with window(qapp, folder, listed=ListedPorts(), entries=entries) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(QSize(1024, 600))
        assembly.window.activateWindow()
        qtbot.waitUntil(assembly.window.isActiveWindow)
        yield assembly


def controls(root: QWidget) -> list[QWidget]:
    """What a person can use or read off; parts of a control that Qt made for itself are left out."""
    return [
        widget
        for widget in root.findChildren(QWidget)
        if isinstance(widget, CONTROLS)
        and widget.objectName()
        and not isinstance(widget, QScrollBar | QHeaderView)
        and not any(fnmatchcase(widget.objectName(), name) for name in NOT_OURS)
    ]


def text_of(widget: QWidget) -> str:
    """Its own text, or that of what it is part of, as Qt shows it."""
    around: QWidget | None = widget
    while around is not None and not around.whatsThis():
        around = around.parentWidget()
    return "" if around is None else around.whatsThis()


def test_every_control_says_what_it_is(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with help_window(qtbot, qapp, tmp_path) as assembly:
        assembly.window.menus["simulator"].setChecked(True)
        found = controls(assembly.window)
        assert len(found) > 150
        for widget in found:
            explain(widget)
        silent = [f"{type(one).__name__} {one.objectName()}" for one in found if not text_of(one)]
        assert not silent, "\n".join(silent)


@OFFSCREEN
def test_a_clicked_control_is_explained_at_once(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with help_window(qtbot, qapp, tmp_path, entries=()) as assembly:
        main = assembly.window
        menu = main.top_bar.menu
        main.menus["what"].trigger()
        assert QWhatsThis.inWhatsThisMode()
        qtbot.mouseClick(menu, Qt.MouseButton.LeftButton)
        assert menu.whatsThis() == menu.toolTip()
        QWhatsThis.leaveWhatsThisMode()
        QWhatsThis.hideText()
        menu.setWhatsThis("")
        QApplication.sendEvent(menu, QHelpEvent(QEvent.Type.QueryWhatsThis, QPoint(), QPoint()))
        assert menu.whatsThis() == ""  # nothing is looked at any more


@pytest.mark.parametrize("command", SETTINGS, ids=lambda command: command.name)
def test_a_setting_says_word_code_default_and_advice(command: Command) -> None:
    told = what_is(command)
    assert command.vendor_term in told
    assert f"{command.code:02X}" in told
    assert command.explanation in told
    assert command.advice is None or command.advice.text in told
    assert ("Default" in told) is (command.default is not None)


@OFFSCREEN
def test_help_windows_are_modeless(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with help_window(qtbot, qapp, tmp_path) as assembly:
        main = assembly.window
        main.menus["what"].trigger()
        assert QWhatsThis.inWhatsThisMode()
        QWhatsThis.leaveWhatsThisMode()
        # The overview names every key of the window
        listed = keys_of(main)
        assert all(does for _, _, does in listed)
        named = {key for _, keys, _ in listed for key in keys.split(", ")}
        native = [
            (action.objectName(), key.toString(key.SequenceFormat.NativeText))
            for action in main.findChildren(QAction)
            if not isinstance(action.parent(), QMenu)
            for key in action.shortcuts()
        ]
        assert len(native) > 30
        missing = [name for name, key in native if key and key not in named]
        assert not missing
        main.menus["keys"].trigger()
        view = find(main, QWidget, "keys_view")
        assert not view.isModal()  # LOCK stays in reach
        assert "Ctrl+L" in view.findChild(QWidget, "keys_view_text").toPlainText()  # type: ignore[union-attr]
        view.close()
        main.menus["about"].trigger()
        box = find(assembly.window, QMessageBox, "about_box")
        assert box.windowModality() == Qt.WindowModality.NonModal
        box.close()
