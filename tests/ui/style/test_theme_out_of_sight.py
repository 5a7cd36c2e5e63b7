"""What is out of sight follows a change of theme when it is shown, before it is painted."""

from pathlib import Path

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QImage, QPalette
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS, window
from tests.support.window.steps import find
from ui.main import PAGES
from ui.style.theme import DARK, LIGHT, Choice

_PLAIN = tuple(entry for entry in PAGES if entry.key in ("settings", "triggers", "commands"))
_INK = QPalette.ColorRole.ButtonText


class _Paints(QObject):
    """The colours in which buttons were painted, from its making on; and how often they were dressed."""

    def __init__(self, root: QWidget) -> None:
        super().__init__(root)
        self.inks: set[str] = set()
        self.dressed = 0
        for button in root.findChildren(QPushButton):
            button.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(watched, QPushButton):
            if event.type() == QEvent.Type.Paint:
                self.inks.add(watched.palette().color(_INK).name())
            self.dressed += event.type() == QEvent.Type.StyleChange
        return False


def _settled(page: QWidget, qtbot: QtBot) -> QImage:
    """The page once what it polls has been shown."""
    seen = [QImage()]

    def is_settled() -> bool:
        qtbot.wait(300)
        seen.append(page.grab().toImage())
        return seen[-1] == seen[-2]

    qtbot.waitUntil(is_settled, timeout=WAIT_MS)
    return seen[-1]


def test_a_page_out_of_sight_is_dressed_when_it_is_shown(qapp: QApplication, qtbot: QtBot, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=_PLAIN) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.stack.count() == len(_PLAIN), timeout=WAIT_MS)
        assembly.appearance.choose(Choice.LIGHT)
        main.panel.hide()
        for entry in _PLAIN:
            main.go_to(entry.key)
            QApplication.processEvents()
        main.go_to("commands")
        page = find(main, QWidget, "settings_page")
        paints = _Paints(page)
        assembly.appearance.choose(Choice.DARK)
        QApplication.processEvents()
        assert (paints.dressed, paints.inks) == (0, set())
        main.go_to("settings")
        QApplication.processEvents()
        assert paints.dressed > 0
        assert paints.inks
        assert {ink.upper() for ink in paints.inks} <= {
            DARK.text,
            DARK.muted,
            DARK.disabled,
            DARK.on_primary,
            DARK.danger.ink,
        }
        followed = _settled(page, qtbot)
        assembly.appearance.choose(Choice.LIGHT)
        QApplication.processEvents()
        assert page.grab().toImage() != followed
        assembly.appearance.choose(Choice.DARK)
        qtbot.waitUntil(lambda: page.grab().toImage() == followed, timeout=WAIT_MS)
        assembly.appearance.choose(Choice.LIGHT)


def test_a_dialog_that_comes_later_or_was_closed_wears_the_theme(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=()) as assembly:
        assembly.appearance.choose(Choice.DARK)
        dialog = QDialog(assembly.window)
        column = QVBoxLayout(dialog)
        button, label = QPushButton("Close"), QLabel("muted")
        label.setProperty("role", "muted")
        column.addWidget(button)
        column.addWidget(label)
        for choice, theme in ((Choice.DARK, DARK), (Choice.LIGHT, LIGHT), (Choice.DARK, DARK)):
            assembly.appearance.choose(choice)
            dialog.show()
            qtbot.waitExposed(dialog)
            assert button.palette().color(_INK).name().upper() == theme.text
            assert label.palette().color(QPalette.ColorRole.WindowText).name().upper() == theme.muted
            dialog.hide()
        assembly.appearance.choose(Choice.LIGHT)
