"""Preferences apply at once and at the next start; a language needs a font."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox
from pytestqt.qtbot import QtBot

from app.text.i18n import language
from tests.support.processes import ran_code
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from ui.core.preferences import Preferences
from ui.main import WindowOptions
from ui.preferences.dialog import PreferencesDialog
from ui.style.theme import Choice, scale_in_use


def choose(box: QComboBox, data: object) -> None:
    """As a person does: the row, then the signal of that."""
    box.setCurrentIndex(box.findData(data))
    box.activated.emit(box.currentIndex())


def test_preferences_apply_at_once_and_are_saved(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
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
        qtbot.waitUntil(lambda: main.top_bar.menu.width() == round(usual * 1.25))
        choose(dialog.theme, "sunlight")
        assert scale_in_use() == 1.25  # not twice as large
        choose(dialog.language, "zh_CN")
        assert dialog.windowTitle() == "偏好设置"
        dialog.sidebar.click()
        assert main.navigation.is_wide
        main.menus["names"].trigger()
        assert not dialog.sidebar.isChecked()
        main.choices.use_theme("light")  # not in the dialog
        main.choices.use_zoom(150)
        main.choices.use_language("en")
        shown = [box.currentData() for box in (dialog.theme, dialog.zoom, dialog.language)]
        assert shown == ["light", 150, "en"]
        main.choices.use_language("zh_CN")
        choose(dialog.zoom, 100)
        choose(dialog.theme, "dark")
        main.resize(main.width(), 610)
        size = main.size()
    after = Preferences(tmp_path / "window.ini")
    assert (after.language, after.theme, after.zoom_percent) == ("zh_CN", "dark", 100)
    assert not after.is_sidebar_wide
    with window(qapp, tmp_path, options=WindowOptions()) as assembly:
        assert (language(), assembly.appearance.choice, assembly.window.size()) == ("zh_CN", Choice.DARK, size)
        assembly.appearance.choose(Choice.LIGHT)


NO_CHINESE = """
import os, sys
from pathlib import Path
from PySide6.QtWidgets import QApplication
from app.text.i18n import language
from ui.core.preferences import Preferences
from ui.main import WindowOptions, assemble
from ui.services.storage import Storage
app = QApplication([])
folder = Path(sys.argv[1])
options = WindowOptions(language="zh_CN")
assembly = assemble(app, options, preferences=Preferences(folder / "w.ini"), storage=Storage(folder), entries=())
window = assembly.window
window.choices.need_fonts(window.attention.queue_notice)
print(language(), window.windowTitle(), window.notice_bar.notice.text)
window.choices.use_language("zh_CN")
print(language(), sep="", flush=True)
os._exit(0)
"""


def test_without_a_chinese_font_it_says_so_in_english(tmp_path: Path) -> None:
    (tmp_path / "fonts.conf").write_text(
        f"<?xml version='1.0'?><fontconfig><dir>{tmp_path}/none</dir><cachedir>{tmp_path}/c</cachedir></fontconfig>",
        encoding="utf-8",
    )
    ended = ran_code(NO_CHINESE, tmp_path, FONTCONFIG_FILE=str(tmp_path / "fonts.conf"))
    first, second = ended.stdout.splitlines()
    assert first.startswith("en DPS-S Configurator Install a Chinese font")
    assert "fonts-noto-cjk" in first
    assert second == "en"
