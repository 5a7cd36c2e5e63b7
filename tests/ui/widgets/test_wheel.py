"""The wheel changes only the value of a focused widget, on every page and panel."""

from pathlib import Path

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDoubleSpinBox,
    QLineEdit,
    QScrollBar,
    QWidget,
)
from pytestqt.qtbot import QtBot

from tests.support.window.walk import walking

TURNED = QComboBox | QAbstractSpinBox | QAbstractSlider | QLineEdit
ONE_NOTCH = 120


def turned_by_wheel(root: QWidget) -> list[QWidget]:
    return [
        one
        for one in root.findChildren(QWidget)
        if isinstance(one, TURNED)
        and not isinstance(one, QScrollBar)
        and not isinstance(one.parent(), QComboBox | QAbstractSpinBox)
        and not one.objectName().startswith("qt_")
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


def test_the_wheel_turns_only_what_has_the_focus(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    tried: set[str] = set()
    with walking(qtbot, qapp, tmp_path) as walk:
        walk.window.panel.hide()
        walk.connect()
        walk.press("live_would_fire")
        walk.window.menus["simulator"].setChecked(True)
        walk.settle()
        walk.find(QWidget, "simulator_fold_line").click()  # type: ignore[attr-defined]
        walk.window.navigation.setFocus()
        for widget in turned_by_wheel(walk.window):
            before = value_of(widget)
            for notches in (1, -1, -1):
                turn(widget, notches)
                assert value_of(widget) == before, widget.objectName()
            tried.add(type(widget).__name__)
        walk.window.menus["simulator"].setChecked(False)
        walk.window.go_to("settings")
        walk.window.activateWindow()
        qtbot.waitUntil(walk.window.isActiveWindow)
        field = walk.find(QDoubleSpinBox, "attitude_threshold_number")
        qtbot.waitUntil(field.isEnabled)
        field.setFocus()
        assert turn(field, 1).isAccepted()
        qtbot.waitUntil(lambda: field.text() == "61")
    assert {"QComboBox", "QDoubleSpinBox", "QSlider", "QLineEdit"} <= tried
