"""The time plots: view, drawing, mouse and keyboard."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton, QToolButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.samples.ring_buffers import Series
from app.samples.step_function import StepFunction
from tests.support.window.painted_text import watching
from tests.support.window.steps import find
from ui.core.texts import Texts
from ui.plots.canvas import Canvas
from ui.plots.time_plot import TimePlot
from ui.plots.view import Lane, Limit, Mark, Scale, Span
from ui.style import appearance, theme
from ui.style.icons import Icon
from ui.style.theme import LIGHT, THEMES, Meaning
from ui.widgets.readout import StateChip

NOW_S = 5000.0


class Bench:
    """A plot of tilt and acceleration in a window, with what it shows at hand."""

    def __init__(self, qtbot: QtBot, *, seconds: float = 120, rate_hz: float = 50) -> None:
        self.tilt, self.acc, self.fire = Series(), Series(), StepFunction()
        times = NOW_S - seconds + np.arange(1, int(seconds * rate_hz) + 1) / rate_hz
        self.tilt.append(times, np.full(len(times), 12))
        self.acc.append(times, np.ones(len(times)))
        self.fire.put(NOW_S - seconds, 60)
        lanes = [
            Lane(
                "Tilt",
                "°",
                self.tilt,
                (Scale(0, 90, 30), Scale(0, 180, 45)),
                (Limit(self.fire, "{value}° fires", Meaning.DANGER, stale=StepFunction()),),
                weight=3,
            ),
            Lane("Acceleration", "g", self.acc, (Scale(0, 2, 1),), decimals=1, weight=2),
        ]
        self.texts = Texts()
        self.plot = TimePlot(lanes, self.texts, wall_offset_s=1_700_000_000.0)
        self.window = QWidget()
        layout = QVBoxLayout(self.window)
        self.other = QLineEdit()
        layout.addWidget(self.other)
        layout.addWidget(self.plot)
        qtbot.addWidget(self.window)
        self.window.resize(800, 520)
        with qtbot.waitExposed(self.window):
            self.window.show()
        self.window.activateWindow()
        self.other.setFocus()
        self.plot.draw(NOW_S)

    @property
    def canvas(self) -> Canvas:
        return find(self.plot, Canvas, "time-plot-canvas")

    @property
    def state(self) -> str:
        chip = find(self.plot, StateChip, "time-plot-state")
        return chip.word

    def button(self, name: str) -> QPushButton | QToolButton:
        found = self.plot.findChild(QPushButton, name) or self.plot.findChild(QToolButton, name)
        assert isinstance(found, QPushButton | QToolButton)
        return found

    def at(self, part: float) -> QPoint:
        """A point of the upper lane at a part of its width."""
        box = self.canvas.lanes[0].box
        return QPoint(round(box.left() + part * box.width()), round(box.center().y()))

    def wheel(self, part: float, notches: int, modifiers: Qt.KeyboardModifier) -> bool:
        """Turn the wheel over the plot; whether it was taken."""
        place = QPointF(self.at(part))
        event = QWheelEvent(
            place,
            QPointF(self.canvas.mapToGlobal(place)),
            QPoint(),
            QPoint(0, 120 * notches),
            Qt.MouseButton.NoButton,
            modifiers,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(self.canvas, event)
        return event.isAccepted()

    def pixels(self, colour: str) -> list[QPoint]:
        """Where the picture has a colour."""
        image = self.plot.picture().toImage()
        wanted = QColor(colour).rgb()
        return [
            QPoint(x, y) for x in range(image.width()) for y in range(image.height()) if image.pixel(x, y) == wanted
        ]


@pytest.fixture
def bench(qapp: QApplication, qtbot: QtBot) -> Bench:
    appearance.apply(qapp, LIGHT)
    return Bench(qtbot)


def test_a_live_plot_follows(bench: Bench) -> None:
    assert bench.plot.is_live
    assert bench.state == "live"
    bench.plot.draw(NOW_S + 5)
    assert bench.plot.span == Span(NOW_S - 55, NOW_S + 5)


def test_pause_holds_the_picture_while_recording_goes_on(bench: Bench, qtbot: QtBot) -> None:
    pause = bench.button("time-plot-pause")
    qtbot.mouseClick(pause, Qt.MouseButton.LeftButton)
    bench.tilt.append(NOW_S + 12, 99)
    bench.plot.draw(NOW_S + 12)
    assert bench.state == "paused, 12 s behind"
    assert bench.plot.span.end_s == NOW_S
    assert bench.canvas.lanes[0].scale == Scale(0, 90, 30)
    assert (pause.text(), pause.accessibleName()) == ("Live", "Live")
    qtbot.mouseClick(pause, Qt.MouseButton.LeftButton)
    assert (bench.state, pause.text()) == ("live", "Pause")
    assert bench.plot.span.end_s == NOW_S + 12
    assert bench.canvas.lanes[0].scale == Scale(0, 180, 45)


@pytest.mark.parametrize(("window_s", "word"), [(10, "10 s"), (60, "60 s"), (600, "10 min")])
def test_the_length_of_the_time_line_is_chosen(bench: Bench, qtbot: QtBot, window_s: float, word: str) -> None:
    button = bench.button(f"time-plot-window-{window_s}")
    assert button.text() == word
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert bench.plot.span.length_s == window_s
    assert button.isChecked()
    assert bench.plot.is_live


def test_the_wheel_zooms_only_with_focus_or_ctrl(bench: Bench, qtbot: QtBot) -> None:
    none, control = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier
    assert not bench.wheel(0.5, 1, none)
    assert bench.plot.is_live
    assert bench.wheel(0.5, 1, control)
    assert bench.plot.span.length_s == pytest.approx(48)
    assert not bench.plot.is_live
    bench.plot.back_to_live()
    bench.canvas.setFocus()
    assert bench.wheel(0.25, -1, none)
    assert bench.plot.span.length_s == pytest.approx(75)


def test_dragging_moves_into_the_past_and_the_picture_stays_there(bench: Bench, qtbot: QtBot) -> None:
    viewport = bench.canvas
    qtbot.mousePress(viewport, Qt.MouseButton.LeftButton, pos=bench.at(0.2))
    qtbot.mouseMove(viewport, bench.at(0.7))
    qtbot.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=bench.at(0.7))
    moved = bench.plot.span
    assert moved.end_s == pytest.approx(NOW_S - 30, abs=1)
    bench.plot.draw(NOW_S + 3)
    assert bench.plot.span == moved
    qtbot.mouseDClick(viewport, Qt.MouseButton.LeftButton, pos=bench.at(0.5))
    assert bench.plot.is_live


def test_everything_by_keyboard(bench: Bench, qtbot: QtBot) -> None:
    bench.canvas.setFocus()
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Space)
    assert not bench.plot.is_live
    qtbot.keyClick(bench.canvas, Qt.Key.Key_End)
    assert bench.plot.is_live
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Left)
    assert bench.plot.span.end_s == pytest.approx(NOW_S - 6)
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Right)
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Plus)
    assert bench.plot.span.length_s == pytest.approx(48)
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Minus)
    assert bench.plot.span.length_s == pytest.approx(60)
    qtbot.keyClick(bench.canvas, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    assert "Tilt 12°" in bench.plot.reading
    assert bench.canvas.accessibleDescription() == bench.plot.reading


def test_the_cursor_shows_values_while_live(bench: Bench, qtbot: QtBot) -> None:
    assert bench.plot.reading == ""
    qtbot.mouseMove(bench.canvas, bench.at(0.5))
    assert bench.plot.reading.startswith("−30.0 s · ")
    assert bench.plot.reading.endswith("Tilt 12°, Acceleration 1.0 g")
    bench.plot.add_mark(Mark(NOW_S - 20, "triggered", Icon.PARACHUTE, Meaning.DANGER))
    bench.plot.draw(NOW_S + 10)
    assert bench.plot.reading.startswith("−30.0 s · ")
    assert " · triggered, Tilt 12°" in bench.plot.reading
    bench.canvas.set_cursor(None)
    assert bench.plot.reading == ""


def test_the_cursor_does_not_invent_what_was_not_measured(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 20, NOW_S + 21], [5, 5])
    bench.plot.draw(NOW_S + 21)
    bench.canvas.set_cursor(1 - 10 / 60)
    assert bench.plot.reading.endswith("Tilt no data, Acceleration no data")


def test_a_gap_and_a_silent_end_are_marked(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 20, NOW_S + 20.5], [12, 12])
    bench.plot.draw(NOW_S + 30)
    gaps = bench.canvas.lanes[0].gaps
    assert gaps[0].start_s == pytest.approx(NOW_S, abs=0.1)
    assert gaps[0].end_s == NOW_S + 20
    assert gaps[1].start_s == NOW_S + 20.5
    box = bench.canvas.lanes[0].box
    gap_middle = box.left() + box.width() * (1 - 20 / 60)
    curve = [place.x() for place in bench.pixels(LIGHT.curves[0]) if box.contains(QPointF(place))]
    assert any(x < gap_middle - 150 for x in curve)
    assert not any(abs(x - gap_middle) < 40 for x in curve)


@pytest.mark.parametrize("one", THEMES, ids=lambda one: one.name)
def test_the_curve_is_where_its_value_is(one: theme.Theme, qapp: QApplication, qtbot: QtBot) -> None:
    appearance.apply(qapp, one)
    bench = Bench(qtbot)
    lane = bench.canvas.lanes[0]
    rows = {place.y() for place in bench.pixels(one.curves[0]) if lane.box.contains(QPointF(place))}
    assert rows
    assert all(abs(row - lane.y(12)) <= one.line_px for row in rows)
    assert len(rows) == one.line_px


def test_a_limit_stays_in_the_past_as_it_was(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, 75)
    bench.plot.draw(NOW_S)
    lane = bench.canvas.lanes[0]
    red = [place for place in bench.pixels(LIGHT.danger.ink) if lane.box.contains(QPointF(place))]
    middle = lane.box.center().x()
    old = [place.x() for place in red if abs(place.y() - lane.y(60)) <= 1]
    new = [place.x() for place in red if abs(place.y() - lane.y(75)) <= 1]
    assert min(old) < lane.box.left() + 10
    assert max(old) <= middle + 2
    assert min(new) >= middle - 2
    assert max(new) > lane.box.right() - 10
    bench.fire.put(NOW_S - 1, None)
    bench.plot.draw(NOW_S + 60)
    red = [place for place in bench.pixels(LIGHT.danger.ink) if lane.box.contains(QPointF(place))]
    assert max((place.x() for place in red), default=0) < lane.box.left() + 10


def test_a_limit_of_the_past_is_named_only_where_another_came_after_it(bench: Bench) -> None:
    def past() -> list[str]:
        bench.plot.draw(NOW_S)
        for _ in range(2):  # the background, with the axis, is kept from then on
            bench.canvas.repaint()
        with watching() as drawn:
            bench.canvas.repaint()
        return [one.text for one in drawn if one.text in ("60", "75")]

    bench.fire.put(NOW_S - 30, None)  # restarted
    bench.fire.put(NOW_S - 28, 60)
    assert past() == []
    bench.fire.put(NOW_S - 15, 75)
    assert past() == ["60"]


def test_the_cursor_time_covers_no_tick_label_partly(bench: Bench) -> None:
    bench.plot.point_at(NOW_S - 31)
    bench.plot.draw(NOW_S)
    picture = bench.canvas.grab().toImage()
    bottom = picture.height() - 6
    dark = [x for x in range(picture.width()) if picture.pixelColor(x, bottom).lightness() < 60]
    assert dark, "the time under the cursor"
    left = min(dark)
    beside = range(max(0, left - 14), left - 1)
    for x in beside:
        for y in range(bottom - 8, bottom + 1):
            assert picture.pixelColor(x, y) == QColor(LIGHT.surface), (x, y)


def test_marks_are_drawn_in_the_order_of_time(bench: Bench) -> None:
    before = bench.plot.picture().toImage()
    bench.plot.add_mark(Mark(NOW_S - 10, "triggered", Icon.PARACHUTE, Meaning.DANGER))
    bench.plot.add_mark(Mark(NOW_S - 40, "activated", Icon.ACTIVE, Meaning.ATTENTION))
    bench.plot.draw(NOW_S)
    strip = bench.canvas.marks
    assert bench.plot.picture().toImage() != before
    for colour, ago_s in ((LIGHT.danger.ink, 10), (LIGHT.tint(Meaning.ATTENTION).ink, 40)):
        x = strip.right() - ago_s / 60 * strip.width()
        found = [p for p in bench.pixels(colour) if strip.contains(QPointF(p))]
        assert any(abs(place.x() - x) < 10 for place in found)


def test_it_scrolls_by_whole_pixels(bench: Bench) -> None:
    """Draws less than a pixel apart show the same span, and the next one is a pixel further on."""
    pixel_s = 60 / bench.canvas.axis.width()
    aligned_s = math.floor(NOW_S / pixel_s + 1) * pixel_s

    def shown_end_s(pixels: float) -> float:
        bench.plot.draw(aligned_s + pixels * pixel_s)
        assert bench.canvas.shown is not None
        return bench.canvas.shown.end_s

    first = shown_end_s(0.2)
    assert shown_end_s(0.8) == first
    assert shown_end_s(1.2) == pytest.approx(first + pixel_s, abs=1e-6)


def test_the_time_line_can_show_the_clock(bench: Bench, qtbot: QtBot) -> None:
    before = bench.plot.picture().toImage()
    qtbot.mouseClick(bench.button("time-plot-clock"), Qt.MouseButton.LeftButton)
    assert bench.plot.picture().toImage() != before


def test_the_state_is_cut_to_what_there_is_room_for(bench: Bench) -> None:
    bench.plot.toggle_pause()
    bench.plot.draw(NOW_S + 12)
    chip = find(bench.plot, StateChip, "time-plot-state")
    assert bench.state == "paused, 12 s behind"
    beside_px = bench.window.width() - bench.plot.width()
    for word in ("paused", "", "paused, 12 s behind"):
        needed_px = bench.plot.header.sizeHint().width()
        bench.window.resize(700 if "12 s" in word else needed_px - 2 + beside_px, 520)
        QApplication.processEvents()
        bench.plot.draw(NOW_S + 12)
        assert bench.state == word
        assert chip.accessibleName() == "Plots: paused, 12 s behind"  # whole in any case
        assert chip.toolTip() == "Plots: paused, 12 s behind"
        pause = bench.button("time-plot-pause")
        assert bench.plot.rect().contains(pause.mapTo(bench.plot, pause.rect().topRight()))


def test_one_draw_serves_a_drag_and_its_cursor(bench: Bench, qtbot: QtBot) -> None:
    spans: list[Span] = []
    draw = bench.canvas.draw_curves

    def count(span: Span) -> None:
        spans.append(span)
        draw(span)

    bench.canvas.draw_curves = count  # type: ignore[method-assign]
    viewport = bench.canvas
    qtbot.mousePress(viewport, Qt.MouseButton.LeftButton, pos=bench.at(0.5))
    spans.clear()
    drag = QMouseEvent(
        QEvent.Type.MouseMove,
        QPointF(bench.at(0.7)),
        QPointF(viewport.mapToGlobal(bench.at(0.7))),
        Qt.MouseButton.NoButton,
        Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.NoModifier,
    )
    QApplication.sendEvent(viewport, drag)
    assert len(spans) == 1
    assert bench.plot.span.end_s == pytest.approx(NOW_S - 0.2 * 60, abs=0.3)
    assert bench.plot.cursor_s == pytest.approx(bench.plot.span.start_s + 0.7 * 60, abs=0.3)


def test_the_last_limits_of_a_recording_are_labelled(qapp: QApplication, qtbot: QtBot) -> None:
    appearance.apply(qapp, LIGHT)
    bench = Bench(qtbot)
    bench.fire.put(NOW_S, None)
    right = bench.canvas.lanes[0].box.right()
    assert any(point.x() > right + 6 for point in bench.pixels(LIGHT.danger.ink))


def test_a_theme_is_followed(bench: Bench, qapp: QApplication) -> None:
    for one in reversed(THEMES):
        appearance.apply(qapp, one)
        qapp.processEvents()
        assert bench.plot.picture().toImage().pixelColor(2, 2) == QColor(one.surface)


def test_an_empty_plot_draws(qapp: QApplication, qtbot: QtBot) -> None:
    empty = Bench(qtbot, seconds=0)
    assert empty.plot.is_live
    box = empty.canvas.lanes[0].box
    assert not [place for place in empty.pixels(LIGHT.curves[0]) if box.contains(QPointF(place))]
    empty.canvas.set_cursor(0.5)
    assert empty.plot.reading.endswith("Tilt no data, Acceleration no data")
