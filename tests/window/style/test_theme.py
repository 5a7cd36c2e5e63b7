"""Contrast of every theme and of the style sheet, icons; the theme is applied at once, language and text size at the
next start.
"""

import re
from pathlib import Path

import pytest
import shiboken6
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication, QComboBox, QDialog, QLabel, QPushButton, QVBoxLayout
from pytestqt.qtbot import QtBot

from app.text.i18n import language
from tests.support.processes import ran_code
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from ui.main import WindowOptions
from ui.preferences.dialog import PreferencesDialog
from ui.style import appearance, theme
from ui.style.appearance import Appearance, style_sheet
from ui.style.icons import Icon, pixmap
from ui.style.theme import DARK, LIGHT, SUNLIGHT, THEMES, Choice, Theme, current


def wanted(theme: Theme) -> float:
    """Return the least contrast of text in a theme."""
    return 7.0 if theme is SUNLIGHT else 4.5


def surfaces_of(theme: Theme) -> tuple[str, str, str, str]:
    """Return the colours behind text."""
    return (theme.window, theme.surface, theme.sunken, theme.raised)


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours, 1 to 21, as WCAG 2.1 defines it (success criterion 1.4.3)."""
    darker, brighter = sorted((_luminance(one), _luminance(other)))
    return (brighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    one = QColor(colour)
    parts = (one.redF(), one.greenF(), one.blueF())
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(share * part for share, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("one", THEMES, ids=lambda one: one.name)
def test_every_text_is_readable_and_every_line_stands_out(one: Theme) -> None:
    inks = [tint.ink for tint in one.meanings.values()]
    pairs = [(text, ground) for text in (one.text, one.muted, *inks) for ground in (*surfaces_of(one), one.selection)]
    pairs += [(one.on_primary, one.primary), (one.window, one.text)]
    for tint in one.meanings.values():
        pairs += [(tint.on_fill, tint.fill), (tint.ink, tint.wash)]
    pairs += [(one.curves[lane], one.surface) for lane in range(3)]  # the lanes' titles
    assert [pair for pair in pairs if contrast(*pair) < wanted(one)] == []
    lines = [(line, ground) for line in (one.border, *one.curves, *inks, one.primary) for ground in surfaces_of(one)]
    assert [pair for pair in lines if contrast(*pair) < 3] == []


@pytest.mark.parametrize("one", THEMES, ids=lambda one: one.name)
def test_each_rule_of_the_style_sheet_that_colours_text_and_its_ground_is_readable(one: Theme) -> None:
    weak = []
    for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", style_sheet(one)):
        colours = dict(re.findall(r"(?<![\w-])(background|color): (#\w{6});", body))
        least = 3.0 if ":disabled" in selectors else wanted(one)  # WCAG requires none of what is disabled
        if len(colours) == 2 and contrast(*colours.values()) < least:
            weak.append(selectors.strip())
    assert weak == []


def test_auto_follows_the_system_and_a_choice_does_not(
    qapp: QApplication, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = {"is_dark": False}
    monkeypatch.setattr(appearance, "is_system_dark", lambda _app: system["is_dark"])

    def turn(*, is_dark: bool) -> None:
        system["is_dark"] = is_dark
        qapp.styleHints().colorSchemeChanged.emit(Qt.ColorScheme.Dark if is_dark else Qt.ColorScheme.Light)

    for other in qapp.findChildren(Appearance):  # of a window of another test; a program has one
        shiboken6.delete(other)
    followed = Appearance(qapp)
    try:
        assert theme.current() is LIGHT
        with qtbot.waitSignal(followed.changed):
            turn(is_dark=True)
        assert theme.current() is DARK
        with qtbot.assertNotEmitted(followed.changed):
            turn(is_dark=True)
        with qtbot.waitSignal(followed.changed):
            followed.choose(Choice.SUNLIGHT)
        turn(is_dark=False)
        assert theme.current() is SUNLIGHT
        followed.choose(Choice.AUTO)
        assert theme.current() is LIGHT
        assert followed.choice is Choice.AUTO
    finally:
        shiboken6.delete(followed)


def test_every_icon_draws_something(qapp: QApplication) -> None:
    for one in Icon:
        image = pixmap(one, 32, "#ff0000").toImage()
        painted = [(x, y) for x in range(32) for y in range(32) if image.pixelColor(x, y).alpha() > 128]
        assert len(painted) > 20, one


_INK = QPalette.ColorRole.ButtonText


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
        assert all(button.icon().isNull() for button in dialog.findChildren(QPushButton))  # black in the dark
        usual = main.top_bar.menu.width()
        choose(dialog.zoom, 125)
        choose(dialog.language, "zh_CN")
        main.show_preferences()
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
