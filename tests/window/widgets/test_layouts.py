"""Rows, columns, wrapping rows, elided texts and icons; the wheel changes only the value of a focused widget."""

from pathlib import Path

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QAbstractSlider, QAbstractSpinBox, QApplication, QComboBox, QLineEdit, QScrollBar, QWidget
from pytestqt.qtbot import QtBot

from app.text.i18n import tr
from tests.support.window.contrast import style_all
from tests.support.window.steps import let_lay_out
from tests.support.window.walk import walking
from ui.style.theme import LIGHT
from ui.widgets.controls import ElidedLabel, scroll_area

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
