"""A page that polls the module does so only while it is shown."""

from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.window.fakes_ui import page_entries, simulated, wait_online, window

SHOWN = page_entries("live", "settings", "preflight", "commands", "fleet")


def test_a_hidden_page_is_brought_up_to_date_when_it_is_shown_and_not_before(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("hidden"), window(qapp, tmp_path, entries=SHOWN) as assembly:
        assembly.window.connect_to(Target("sim://hidden", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: len(assembly.window._pages) == len(SHOWN))
        shown = {
            "commands": ("act_zero_conditions", QLabel.text),
            "settings": ("baud_message", QLabel.text),
            "preflight": ("verdict", QWidget.toolTip),
            "fleet": ("fleet_summary", QLabel.text),
        }

        def look(key: str) -> object:
            name, read = shown[key]
            widget: Any = assembly.window.findChild(QWidget, name)
            return read(widget)

        for key in (*shown, "live"):
            assembly.window.go_to(key)
        before = {key: look(key) for key in shown}
        assembly.ports.current.disconnect_port()
        qtbot.waitUntil(lambda: not assembly.ports.current.is_open)
        assert {key: look(key) for key in shown} == before
        for key in shown:
            assembly.window.go_to(key)
            assert look(key) != before[key], key
