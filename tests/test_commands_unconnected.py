"""The Commands page while no port is open."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.fakes_ui import WAIT_MS, window
from tests.settings_bench import ENTRIES
from ui.commands_page import CommandsPage


def test_without_a_port_nothing_is_said_of_the_log(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=ENTRIES) as assembly:
        qtbot.waitUntil(lambda: assembly.window.findChild(CommandsPage) is not None, timeout=WAIT_MS)
        page = assembly.window.findChild(CommandsPage)
        assert page is not None
        page.refresh()
        for row in page.acts.values():
            assert "does not answer" in row.conditions.text()
            assert "log" not in row.conditions.text()
            assert not row.confirm.ask.isEnabled()
