"""Readout, state chip, gauge and notice bar: accessible names, appearance, stable layout.

Rows, columns, wrapping rows, elided texts and icons; the wheel changes only the value of a focused widget.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QWheelEvent
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollBar,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.text.i18n import tr
from tests.support.window.contrast import style_all
from tests.support.window.cut_off import cut_off
from tests.support.window.steps import let_lay_out
from tests.support.window.walk import walking
from ui.plots.gauge import TiltGauge
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Meaning
from ui.widgets.controls import ElidedLabel, control, scroll_area, set_role
from ui.widgets.readout import Freshness, Readout


@pytest.fixture(autouse=True)
def in_light(qapp: QApplication) -> None:
    style_all(qapp, LIGHT)


def picture(widget: QWidget) -> QImage:
    widget.resize(widget.sizeHint())
    return widget.grab().toImage()


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


WIDTH = 100


def test_an_elided_text_is_whole_in_the_tooltip(qtbot: QtBot) -> None:
    window = QWidget()  # Windows makes none as narrow as the label
    qtbot.addWidget(window)
    label = ElidedLabel()
    label.setParent(window)
    label.setText("The module answers. Next: Settings, then Pre-flight.")
    label.resize(800, 20)
    window.resize(900, 20)
    window.show()
    label.grab()
    assert label.toolTip() == ""
    label.resize(label.fontMetrics().horizontalAdvance("The module") + 10, 20)  # whatever font other tests left
    wide = label.grab().toImage()
    assert label.toolTip() == label.text() == "The module answers. Next: Settings, then Pre-flight."
    label.setText("The module")
    assert label.grab().toImage() != wide
    assert label.toolTip() == ""


TURNED = QComboBox | QAbstractSpinBox | QAbstractSlider | QLineEdit
ONE_NOTCH = 120


def turned_by_wheel(root: QWidget) -> list[QWidget]:
    return [
        widget
        for widget in root.findChildren(QWidget)
        if isinstance(widget, TURNED)
        and not isinstance(widget, QScrollBar)
        and not isinstance(widget.parent(), QComboBox | QAbstractSpinBox)
        and not widget.objectName().startswith("qt_")
    ]


def value_of(widget: QWidget) -> object:
    match widget:
        case QComboBox():
            return widget.currentIndex()
        case QAbstractSpinBox() | QLineEdit():
            return widget.text()
        case QAbstractSlider():
            return widget.value()
    raise TypeError(widget)


def turn(widget: QWidget, notches: int) -> QWheelEvent:
    centre = QPointF(widget.rect().center())
    event = QWheelEvent(
        centre, QPointF(widget.mapToGlobal(centre.toPoint())), QPoint(), QPoint(0, notches * ONE_NOTCH),
        Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    event.ignore()
    QApplication.sendEvent(widget, event)
    return event


def test_what_scrolls_shows_that_it_has_the_focus_and_what_does_not_is_no_stop(
    qtbot: QtBot, qapp: QApplication
) -> None:
    style_all(qapp, LIGHT)
    content = QWidget()
    area = scroll_area(content, "notes", tr("Note"))
    qtbot.addWidget(area)
    area.resize(WIDTH, WIDTH)
    content.setMinimumHeight(2 * WIDTH)
    with qtbot.waitExposed(area):
        area.show()
    area.activateWindow()
    qtbot.waitUntil(area.isActiveWindow)
    assert area.focusPolicy() is Qt.FocusPolicy.StrongFocus
    area.clearFocus()
    before = area.grab().toImage()
    area.setFocus()
    assert area.grab().toImage() != before
    content.setMinimumHeight(0)
    let_lay_out(area)
    assert area.focusPolicy() is Qt.FocusPolicy.NoFocus


def test_the_wheel_turns_only_what_has_the_focus(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    tried: set[str] = set()
    with walking(qtbot, qapp, tmp_path) as walk:
        walk.window.panel.hide()
        walk.connect()
        walk.window.menus["simulator"].setChecked(True)
        walk.settle()
        walk.window.navigation.setFocus()
        for widget in turned_by_wheel(walk.window):
            before = value_of(widget)
            for notches in (1, -1, -1):
                turn(widget, notches)
                assert value_of(widget) == before, widget.objectName()
            tried.add(type(widget).__name__)
    assert {"QComboBox", "NumberLine", "QSlider", "QLineEdit"} <= tried
