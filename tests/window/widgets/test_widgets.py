"""Readout, state chip, gauge and notice bar: accessible names, appearance, stable layout."""

from collections.abc import Callable
from functools import partial

import pytest
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.text.i18n import tr
from tests.support.window.contrast import style_all
from tests.support.window.cut_off import cut_off
from ui.plots.gauge import TiltGauge
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Meaning
from ui.widgets.controls import control, set_role
from ui.widgets.readout import Freshness, Readout, StateChip


@pytest.fixture(autouse=True)
def in_light(qapp: QApplication) -> None:
    style_all(qapp, LIGHT)


def picture(widget: QWidget) -> QImage:
    widget.resize(widget.sizeHint())
    return widget.grab().toImage()


def colours(image: QImage) -> dict[str, int]:
    """How many pixels have each colour."""
    found: dict[str, int] = {}
    for x in range(image.width()):
        for y in range(image.height()):
            name = image.pixelColor(x, y).name().upper()
            found[name] = found.get(name, 0) + 1
    return found


def test_a_readout_names_caption_value_unit_limit_and_note(qtbot: QtBot) -> None:
    one = Readout("Light", unit="V", template="00.0")
    qtbot.addWidget(one)
    assert (one.freshness, one.accessibleName()) == (Freshness.UNKNOWN, "Light: unknown")
    one.show_value("0.3")
    assert one.accessibleName() == "Light: 0.3 V"
    one.set_limit("1.8 V")
    one.show_value("0.3", meaning=Meaning.ATTENTION, note="below the threshold")
    assert one.accessibleName() == "Light: 0.3 V, limit 1.8 V, below the threshold"
    one.show_value("0.3", freshness=Freshness.STALE, note="12 s ago")
    assert one.accessibleName() == "Light: 0.3 V, limit 1.8 V, 12 s ago"
    one.set_caption("光线")
    assert one.accessibleName().startswith("光线: 0.3 V")


def test_nothing_moves_when_a_digit_is_added(qtbot: QtBot) -> None:
    one = Readout("Tilt", unit="V", template="000")
    qtbot.addWidget(one)
    one.show_value("7")
    before = [label.geometry() for label in one.findChildren(QLabel)]
    hint = one.sizeHint()
    for show in (lambda: one.show_value("107"), one.show_unknown, lambda: one.show_value("8")):
        show()
        assert one.sizeHint().height() == hint.height()
    assert [label.geometry() for label in one.findChildren(QLabel)] == before
    one.show_value("10000")
    one.resize(one.sizeHint())
    assert cut_off(one) == []  # more than the usual number takes more room


def test_fresh_stale_and_unknown_differ_in_shape(qtbot: QtBot) -> None:
    """Compared as black and white, so that the difference is not one of colour."""
    one, gauge = Readout("Tilt", unit="°"), TiltGauge()
    shows: tuple[tuple[QWidget, tuple[Callable[[], None], ...]], ...] = (
        (one, (partial(one.show_value, "12"), partial(one.show_value, "12", freshness=Freshness.STALE),
               one.show_unknown)),
        (gauge, (partial(gauge.show_tilt, 12), partial(gauge.show_tilt, 12, stale_age="1 s"),
                 partial(gauge.show_tilt, None))),
    )  # fmt: skip
    ground = QColor(LIGHT.window).lightness()
    for widget, ways in shows:
        qtbot.addWidget(widget)
        shapes: list[QImage] = []
        for show in ways:
            show()
            image = picture(widget).convertToFormat(QImage.Format.Format_Grayscale8)
            for x in range(image.width()):
                for y in range(image.height()):
                    is_drawn = abs(QColor(image.pixel(x, y)).lightness() - ground) > 25
                    image.setPixelColor(x, y, QColor("black" if is_drawn else "white"))
            assert image not in shapes
            shapes.append(image)


def test_only_attention_and_danger_are_filled(qtbot: QtBot) -> None:
    chip = StateChip("Lock")
    qtbot.addWidget(chip)
    for meaning in (Meaning.ATTENTION, Meaning.DANGER):
        chip.show_state("ACTIVE", Icon.ACTIVE, meaning)
        assert colours(picture(chip))[LIGHT.tint(meaning).fill] > 800
    for quiet in (None, Meaning.GOOD, Meaning.INFORMATION, Meaning.UNKNOWN):
        chip.show_state("LOCKED", Icon.LOCK, quiet)
        assert colours(picture(chip))[LIGHT.surface] > 800
    chip.show_state("ACTIVE", Icon.ACTIVE, Meaning.ATTENTION, stale_age="12 s ago")
    assert colours(picture(chip)).get(LIGHT.tint(Meaning.ATTENTION).fill, 0) == 0
    assert chip.accessibleName() == "Lock: ACTIVE, 12 s ago"


def test_a_chip_says_what_is_unknown(qtbot: QtBot) -> None:
    chip = StateChip("Trigger")
    qtbot.addWidget(chip)
    assert (chip.word, chip.meaning) == ("unknown", Meaning.UNKNOWN)
    assert chip.accessibleName() == chip.toolTip() == "Trigger: unknown"
    assert [label.text() for label in chip.findChildren(QLabel) if label.text()] == ["Trigger", "unknown"]
    chip.show_state("TRIGGERED", Icon.PARACHUTE, Meaning.DANGER)
    assert [label.text() for label in chip.findChildren(QLabel) if label.text()] == ["TRIGGERED"]


def test_the_gauge_says_tilt_age_and_threshold(qtbot: QtBot) -> None:
    gauge = TiltGauge()
    qtbot.addWidget(gauge)
    assert gauge.accessibleName() == "Tilt: unknown"
    gauge.show_tilt(12, fires_deg=60, rearms_deg=50)
    assert gauge.accessibleName() == "Tilt: 12°, 60° fires"
    gauge.show_tilt(12, stale_age="12 s ago", fires_deg=60)
    assert gauge.accessibleName() == "Tilt: 12°, 12 s ago, 60° fires"
    gauge.show_tilt(None, fires_deg=60)
    assert gauge.freshness is Freshness.UNKNOWN
    assert gauge.accessibleName() == "Tilt: unknown, 60° fires"


def test_the_picture_of_a_button_has_the_colour_of_its_text_in_every_role(qtbot: QtBot) -> None:
    button = control(QPushButton(tr("LOCK")), "lock", picture=Icon.LOCK)
    qtbot.addWidget(button)

    def lightest() -> int:
        drawn = button.icon().pixmap(16).toImage()
        pixels = [drawn.pixelColor(x, y) for x in range(16) for y in range(16)]
        return max(pixel.lightness() for pixel in pixels if pixel.alpha() > 200)

    assert lightest() < 100
    set_role(button, "primary")
    assert lightest() > 200
    set_role(button, "")
    assert lightest() < 100
