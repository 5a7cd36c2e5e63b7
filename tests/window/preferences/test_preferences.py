"""The theme applies at once, language and text size at the next start; a language needs a font."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox
from pytestqt.qtbot import QtBot

from app.text.i18n import language
from tests.support.processes import ran_code
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from ui.main import WindowOptions
from ui.preferences.dialog import PreferencesDialog
from ui.style.theme import SUNLIGHT, Choice, current


def choose(box: QComboBox, data: object) -> None:
    """As a person does: the row, then the signal of that."""
    box.setCurrentIndex(box.findData(data))
    box.activated.emit(box.currentIndex())


def test_the_theme_applies_at_once_and_language_and_size_at_the_next_start(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, options=WindowOptions(language="en")) as assembly:
        main = assembly.window
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        qtbot.keyClick(main, Qt.Key.Key_Comma, Qt.KeyboardModifier.ControlModifier)
        dialog = find(main, PreferencesDialog)
        assert dialog.isVisible()
        assert not dialog.isModal()  # LOCK stays in reach
        usual = main.top_bar.menu.width()
        choose(dialog.zoom, 125)
        choose(dialog.language, "zh_CN")
        dialog.bring_up()
        assert [box.currentData() for box in (dialog.zoom, dialog.language)] == [125, "zh_CN"]
        assert (dialog.windowTitle(), main.top_bar.menu.width()) == ("Preferences", usual)
        choose(dialog.theme, "sunlight")
        assert current() is SUNLIGHT
        choose(dialog.theme, "dark")
        main.resize(main.width(), 610)
        size = main.size()
    with window(qapp, tmp_path, options=WindowOptions()) as assembly:
        assert (language(), assembly.appearance.choice, assembly.window.size()) == ("zh_CN", Choice.DARK, size)
        assert assembly.window.top_bar.menu.width() > 1.15 * usual
        assembly.appearance.choose(Choice.LIGHT)


NO_CHINESE = """
import os, sys
from app.text.i18n import language
from ui import main

def tell(seconds, assembly, options):
    print(language(), assembly.window.windowTitle(), assembly.window.notice_bar.notice.text, flush=True)
    os._exit(0)

main._end_after = tell
main.run(main.WindowOptions(language="zh_CN", offscreen_seconds=1.0))
"""


def test_without_a_chinese_font_it_says_so_in_english(tmp_path: Path) -> None:
    (tmp_path / "fonts.conf").write_text(
        f"<?xml version='1.0'?><fontconfig><dir>{tmp_path}/none</dir><cachedir>{tmp_path}/c</cachedir></fontconfig>",
        encoding="utf-8",
    )
    said = ran_code(NO_CHINESE, FONTCONFIG_FILE=str(tmp_path / "fonts.conf")).stdout
    assert said.startswith("en DPS-S Configurator Install a Chinese font")
    assert "fonts-noto-cjk" in said
