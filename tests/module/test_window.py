"""The window against the independent module, in real time on a pseudo-terminal; the module's log is the judge."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options
from tests.support.window.fakes_ui import connect, page_entries, window
from tests.support.window.steps import find, press, show_page
from ui.main import Assembly
from ui.pages.settings.page import SettingsPage

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
SETTINGS = {"light_threshold": 0x15, "attitude_threshold": 0x20, "freefall_acceleration": 0x21, "freefall_time": 0x22}


@pytest.fixture
def module() -> Module:
    made = Module(Options(), now=now())
    made.settings[0x15] = 20
    return made


@pytest.fixture
def assembly(qtbot: QtBot, qapp: QApplication, tmp_path: Path, module: Module) -> Iterator[Assembly]:
    with Line(module) as line, window(qapp, tmp_path, entries=page_entries("settings")) as made:
        connect(qtbot, made, line.port)
        yield made


def write(qtbot: QtBot, page: SettingsPage, values: dict[str, str]) -> None:
    """Type the values and write them; what is against advice is accepted by a second press."""
    for name, text in values.items():
        box = find(page, QLineEdit, f"{name}_wanted")
        box.setFocus()
        box.selectAll()
        qtbot.keyClicks(box, text)
        qtbot.keyClick(box, Qt.Key.Key_Tab)
    button = find(page, QPushButton, "settings_write")
    qtbot.waitUntil(button.isEnabled)
    press(qtbot, button)


def test_what_is_typed_is_what_the_module_gets(qtbot: QtBot, assembly: Assembly, module: Module) -> None:
    values = {
        "light_threshold": "3.3",
        "attitude_threshold": "80",
        "freefall_acceleration": "0.3",
        "freefall_time": "2.55",
    }
    bytes_sent = [33, 80, 3, 255]
    page = show_page(qtbot, assembly.window, "settings", SettingsPage)
    qtbot.waitUntil(lambda: find(page, QLineEdit, "freefall_time_wanted").text() != "")
    write(qtbot, page, values)
    qtbot.waitUntil(lambda: [module.settings[code] for code in SETTINGS.values()] == bytes_sent)
    for code, byte in zip(SETTINGS.values(), bytes_sent, strict=True):
        assert [entry.value for entry in module.log.sets(code)] == [byte]
    qtbot.waitUntil(lambda: all(is_read_back(module, code) for code in SETTINGS.values()))
    assert module.log.acts() == []


def is_read_back(module: Module, code: int) -> bool:
    set_at = module.log.sets(code)[0].at_s
    return any(entry.at_s > set_at and not entry.is_set for entry in module.log.got(code))


def reported_active(assembly: Assembly) -> object:
    """What the window knows of the activation, None for nothing."""
    reading = assembly.ports.current.module.view.known("active", assembly.ports.clock())
    return None if reading is None else reading.value


def test_lock_reaches_an_active_module_by_key(qtbot: QtBot, assembly: Assembly, module: Module) -> None:
    module.settings[0x10] = 1
    qtbot.waitUntil(lambda: reported_active(assembly) is True)
    qtbot.keyClick(assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil(lambda: reported_active(assembly) is False)
    assert module.settings[0x10] == 0
    assert {entry.frame for entry in module.log.acts()} == {bytes.fromhex("42 61 10 02 00 12")}


@pytest.mark.parametrize(("is_fall_on", "said"), [(True, "both on"), (False, "fall off")])
def test_the_top_bar_says_what_became_of_the_triggers(
    is_fall_on: bool, said: str, qtbot: QtBot, assembly: Assembly, module: Module
) -> None:
    """Known only a while after they were set, whatever page is shown."""
    page = show_page(qtbot, assembly.window, "settings", SettingsPage)
    chip = assembly.window.top_bar.triggers
    button = find(page, QPushButton, "settings_write")

    def press_what_is_next() -> bool:
        """Where the machine stood still for a moment, the conversation has ended, and all is done again."""
        anyway = page.strip.button("write_anyway")
        if anyway is not None:
            press(qtbot, anyway)
        elif not page.work.job.is_running and said not in chip.accessibleName():
            page.work.choose("attitude_trigger", True)
            page.work.choose("freefall_trigger", is_fall_on)
            if button.isEnabled():
                press(qtbot, button)
        return said in chip.accessibleName()

    qtbot.waitUntil(press_what_is_next)
