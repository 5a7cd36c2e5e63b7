"""Icon labels in the colours of the theme."""

from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS
from ui.style import appearance
from ui.style.appearance import Appearance
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Choice, Meaning, Theme
from ui.widgets.labels import IconLabel


def colours(label: IconLabel) -> set[str]:
    image = label.pixmap().toImage()
    pixels = (image.pixelColor(x, y) for x in range(image.width()) for y in range(image.height()))
    return {pixel.name().upper() for pixel in pixels if pixel.alpha() == 255}


def test_it_follows_the_theme_by_itself(qapp: QApplication, qtbot: QtBot) -> None:
    appearance.apply(qapp, LIGHT)
    window = QWidget()
    qtbot.addWidget(window)
    label, muted = IconLabel("loud", 32), IconLabel("muted", 32)
    layout = QVBoxLayout(window)
    for one in (label, muted):
        layout.addWidget(one)
    label.show_icon(Icon.WARNING, Meaning.DANGER)
    muted.show_icon(Icon.LIVE, is_muted=True)

    def has_colours_of(theme: Theme) -> bool:
        return QColor(theme.danger.ink).name().upper() in colours(label) and theme.muted in colours(muted)

    assert has_colours_of(LIGHT)
    appearance.apply(qapp, DARK)
    qtbot.waitUntil(lambda: has_colours_of(DARK), timeout=WAIT_MS)
    appearance.apply(qapp, LIGHT)
    qtbot.waitUntil(lambda: has_colours_of(LIGHT), timeout=WAIT_MS)


def test_icons_grow_with_the_text_in_sunlight(qapp: QApplication, qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    part = QWidget(window)
    button, label = QPushButton(icon(Icon.LOCK), "LOCK"), IconLabel("sign", 16, keeps_place=True)
    layout = QVBoxLayout(part)
    layout.addWidget(button)
    layout.addWidget(label)
    look = Appearance(qapp, Choice.LIGHT)
    look.apply_theme(window)
    set_icon_size(button, 16)
    window.show()
    for theme, side in ((Choice.SUNLIGHT, round(16 * SUNLIGHT.scale)), (Choice.LIGHT, 16)):
        look.choose(theme)
        qtbot.waitUntil(lambda wanted=side: label.width() == wanted, timeout=WAIT_MS)  # type: ignore[misc]
        assert button.iconSize().height() == side
