"""The list of shortcuts and the About box."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QMenu, QMessageBox, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import ListedPorts, window
from tests.support.window.steps import find
from ui.help.windows import keys_of
from ui.main import PAGES
from ui.widgets.controls import Shortcut


@pytest.mark.qt_log_ignore("does not support", extend=True)
def test_the_list_names_every_key_and_no_window_is_modal(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, listed=ListedPorts(), entries=PAGES) as assembly:
        main = assembly.window
        with qtbot.waitSignal(main.pages_made):
            main.activateWindow()
        listed = keys_of(main)
        assert all(does for _, _, does in listed)
        named = {key for _, keys, _ in listed for key in keys.split(", ")}
        native = [
            (action.objectName(), key.toString(key.SequenceFormat.NativeText))
            for action in main.findChildren(QAction)
            if not isinstance(action.parent(), QMenu)
            for key in action.shortcuts()
        ]
        native += [
            (shortcut.objectName(), key.toString(key.SequenceFormat.NativeText))
            for shortcut in main.findChildren(Shortcut)
            for key in list(shortcut.keys())
        ]
        assert len(native) > 30
        assert [name for name, key in native if key and key not in named] == []
        main.menus["keys"].trigger()
        view = find(main, QWidget, "keys_view")
        assert not view.isModal()  # LOCK stays in reach
        assert "Ctrl+L" in view.findChild(QWidget, "keys_view_text").toPlainText()  # type: ignore[union-attr]
        view.close()
        main.menus["about"].trigger()
        box = find(main, QMessageBox, "about_box")
        assert box.windowModality() == Qt.WindowModality.NonModal
        box.close()
