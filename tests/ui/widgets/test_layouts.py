"""Rows, columns, wrapping rows, elided texts and icons; the wheel changes only the value of a focused widget."""

from pathlib import Path

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QWheelEvent
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QScrollBar,
    QVBoxLayout,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.text.i18n import tr
from tests.support.window.contrast import style_all
from tests.support.window.cut_off import cut_off_in_paint
from tests.support.window.painted_text import watching
from tests.support.window.steps import let_lay_out
from tests.support.window.walk import walking
from ui.style.icons import Icon
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Meaning, Theme
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import scroll_area

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
    assert label.toolTip() == ""
    label.resize(label.fontMetrics().horizontalAdvance("The module") + 10, 20)  # whatever font other tests left
    assert label.toolTip() == label.text() == "The module answers. Next: Settings, then Pre-flight."
    assert label.minimumSizeHint().width() == 0
    wide = label.grab().toImage()
    label.setText("The module")
    assert label.toolTip() == ""
    assert label.grab().toImage() != wide


def test_a_label_is_found_where_it_is_elided_and_not_where_its_text_ends_with_dots(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    label = ElidedLabel()
    label.setParent(window)
    label.setText("Looking for thresholds…")
    found = []
    for width_px in (800, 60):
        label.resize(width_px, 20)
        with watching() as drawn:
            label.grab()
        label.setToolTip("")
        found.append(cut_off_in_paint(drawn))
    assert found[0] == []
    assert len(found[1]) == 1


def colours(label: IconLabel) -> set[str]:
    image = label.pixmap().toImage()
    pixels = (image.pixelColor(x, y) for x in range(image.width()) for y in range(image.height()))
    return {pixel.name().upper() for pixel in pixels if pixel.alpha() == 255}


def test_it_follows_the_theme_by_itself(qapp: QApplication, qtbot: QtBot) -> None:
    style_all(qapp, LIGHT)
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
    style_all(qapp, DARK)
    qtbot.waitUntil(lambda: has_colours_of(DARK))
    style_all(qapp, LIGHT)
    qtbot.waitUntil(lambda: has_colours_of(LIGHT))


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
    for one in (LIGHT, DARK, SUNLIGHT):
        style_all(qapp, one)
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
        assert area.grab().toImage() != before, one.name
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
