"""Readout, gauge, number line, elided text, the panel "Simulated module"; the wheel turns only what has the focus."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QInputMethodEvent, QWheelEvent
from PySide6.QtWidgets import QAbstractSlider, QAbstractSpinBox, QApplication, QComboBox, QLineEdit, QScrollBar, QWidget
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from protocol.catalogue import BY_NAME, SETTINGS, Command
from protocol.fields import Quantity
from tests.support.line.sim_line import FakeClock
from tests.support.window.steps import style_all
from tests.support.window.walk import walking
from ui.plots.gauge import TiltGauge
from ui.simulator.panel import SimulatorPanel
from ui.style.theme import LIGHT
from ui.widgets.controls import ElidedLabel, in_column
from ui.widgets.number_line import Dial, NumberKind, NumberLine
from ui.widgets.readout import Freshness, Readout


@pytest.fixture(autouse=True)
def in_light(qapp: QApplication) -> None:
    style_all(qapp, LIGHT)


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
            widget.resize(widget.sizeHint())
            image = widget.grab().toImage().convertToFormat(QImage.Format.Format_Grayscale8)
            for x in range(image.width()):
                for y in range(image.height()):
                    is_drawn = abs(QColor(image.pixel(x, y)).lightness() - ground) > 25
                    image.setPixelColor(x, y, QColor("black" if is_drawn else "white"))
            assert image not in shapes
            shapes.append(image)


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
    label.setWordWrap(True)
    label.setText("Incomprehensibly")
    label.resize(label.fontMetrics().horizontalAdvance("Incompre"), 60)
    label.grab()
    assert label.toolTip() == "Incomprehensibly", "it would be cut without a word"


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


def test_the_wheel_turns_only_what_has_the_focus(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    tried: set[str] = set()
    with walking(qtbot, qapp, tmp_path) as walk:
        walk.window.panel.hide()
        walk.connect()
        walk.window.menus["simulator"].setChecked(True)
        assert walk.find(SimulatorPanel).tilt.isEnabled()  # it controls the module that was connected before
        walk.settle()
        walk.window.navigation.setFocus()
        for widget in turned_by_wheel(walk.window):
            before = value_of(widget)
            for notches in (1, -1, -1):
                turn(widget, notches)
                assert value_of(widget) == before, widget.objectName()
            tried.add(type(widget).__name__)
    assert {"QComboBox", "NumberLine", "QSlider", "QLineEdit"} <= tried


@pytest.fixture
def made(qtbot: QtBot) -> NumberLine:
    """Of the free-fall time, 0.00 s to 2.55 s."""
    field = BY_NAME["freefall_time"].write
    assert isinstance(field, Quantity)
    line = NumberLine(NumberKind.of_field(field), may_be_empty=True)
    qtbot.addWidget(line)
    return line


@pytest.mark.parametrize("typed", ["１．２", "１。２", "１，２", "1,2", "1.2", "1.2s", "１．２ｓ", "1.20", " 1.2 s"])
def test_a_number_may_be_typed_in_many_ways(qapp: QApplication, made: NumberLine, typed: str) -> None:
    commit = QInputMethodEvent()  # as an input method hands over what was typed
    commit.setCommitString(typed)
    qapp.sendEvent(made, commit)
    assert (made.text(), made.number, made.is_wrong) == (typed, 1.2, False)


@pytest.mark.parametrize("typed", ["16", "2.56", "256", "-1", "six", "0.555", "1.2 V", "1e0", "1.2.3", "nan", "9" * 60])
def test_what_cannot_be_sent_stays_as_typed_in_red(qtbot: QtBot, made: NumberLine, typed: str) -> None:
    """650 once became 65, 300 became 30, and 16 seconds became 1.00 s."""
    qtbot.keyClicks(made, typed)
    assert (made.text(), made.number, made.property("role")) == (typed, None, "wrong")
    qtbot.keyClick(made, Qt.Key.Key_Up)  # an arrow key does not correct it either
    assert made.text() == typed


def test_what_is_typed_is_not_completed_under_the_hand(qtbot: QtBot, made: NumberLine) -> None:
    made.show_number(1.6, "muted")
    assert (made.text(), made.property("role")) == ("1.60", "muted")
    made.selectAll()
    qtbot.keyClicks(made, "2.")
    made.show_number(2.0)
    assert (made.text(), made.property("role")) == ("2.", "")
    made.show_number(None)  # nothing is known: nothing that looks like a value
    assert made.text() == ""


@pytest.mark.parametrize("command", [command for command in SETTINGS if isinstance(command.write, Quantity)])
def test_every_value_of_the_module_can_be_typed(command: Command) -> None:
    assert isinstance(command.write, Quantity)
    kind = NumberKind.of_field(command.write)
    for raw in range(256):
        value = float(command.write.decode(raw))
        assert kind.read(kind.shown(value)) == value
        assert kind.read(command.write.text(raw)) == value


def test_a_dial_keeps_its_value_while_what_is_typed_cannot_be_used(qtbot: QtBot) -> None:
    dial, around = Dial("tilt", NumberKind.of(0, 180, 1, "°", 0)), QWidget()
    in_column(dial, dial.range, of=around)
    qtbot.addWidget(around)
    turned: list[float] = []
    dial.turned.connect(turned.append)
    dial.set_value(60)
    around.show()
    dial.box.selectAll()
    qtbot.keyClicks(dial.box, "650")
    assert dial.box.text() == "650"
    assert (dial.is_wrong, dial.value, dial.slider.value()) == (True, 65, 65)
    assert (dial.range.isVisible(), dial.range.text()) == (True, "0° to 180°, in steps of 1°")
    dial.set_value(65)  # shown again by its page
    assert (dial.box.text(), dial.is_wrong) == ("650", True)
    qtbot.keyClick(dial.box, Qt.Key.Key_Backspace)
    assert (dial.is_wrong, dial.range.isVisible(), turned[-1]) == (False, False, 65)


def click(qtbot: QtBot, button: QWidget) -> None:
    """With the mouse, at the left, where the box of a check box is."""
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton, pos=QPoint(10, button.height() // 2))


def type_into(qtbot: QtBot, box: QAbstractSpinBox | QLineEdit, text: str) -> None:
    box.setFocus()
    box.selectAll()
    qtbot.keyClicks(box, text)
    qtbot.keyClick(box, Qt.Key.Key_Return)


def test_every_control_does_what_it_says(qtbot: QtBot) -> None:
    # Inside a window, as in its dock: offscreen, Qt warns of windows that have a smallest size of their own.
    window, panel, clock = QWidget(), SimulatorPanel(), FakeClock()
    qtbot.addWidget(window)
    bench = SimulatedBench(clock=clock)
    panel.setParent(window)
    panel.use_bench(bench)
    for one in (window, panel):
        one.resize(320, 520)
    window.show()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    panel.tilt.slider.setFocus()
    qtbot.keyClick(panel.tilt.slider, Qt.Key.Key_Right)
    assert bench.world.tilt_deg == 1
    type_into(qtbot, panel.tilt.box, "70")
    assert (bench.world.tilt_deg, panel.tilt.slider.value()) == (70, 70)
    type_into(qtbot, panel.cell.box, "3.60")
    assert bench.world.cell_v == pytest.approx(3.6)
    for box in (panel.bay, panel.charger, panel.lifelike):
        click(qtbot, box)
    assert (bench.world.bay_is_open, bench.world.has_external_power, bench.world.is_lifelike) == (True, True, True)
    click(qtbot, panel.restart)
    assert bench.module.memory.boot_count == 38
    for is_plugged_in in (False, True):
        click(qtbot, panel.unplugged)
        assert bench.is_plugged_in is is_plugged_in
    for name, box in panel.faults.items():
        for is_on in (True, False):
            click(qtbot, box)
            assert bool(getattr(bench.module.setup, name)) is is_on
    for is_active in (False, True):
        bench.module.activate(is_active=is_active)
        click(qtbot, panel.trigger)
        assert bench.module.is_triggered is is_active
    type_into(qtbot, panel.fall_height, "30")
    click(qtbot, panel.drop)
    assert bench.world.is_falling(bench.clock())
    assert not panel.drop.isEnabled()
    clock.now_s += 10
    panel.refresh()
    assert panel.drop.isEnabled()
    bench.module.power_off()
    click(qtbot, panel.restart)
    assert bench.module.is_on
    panel.use_bench(None)
    assert (panel.tilt.isEnabled(), panel.summary.text()) == (False, "No simulated module")
