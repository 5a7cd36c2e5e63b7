"""The time plots: what is in sight, curves, limits, marks and ticks; mouse, keyboard and cursor."""

from itertools import combinations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetricsF, QWheelEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton, QToolButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.samples.samples import Series, StepFunction
from app.system.clock import clock_text
from tests.support.window.steps import find, given, style_all
from ui.plots.lane_view import Shown
from ui.plots.lanes import Lane, Limit, Mark, Scale, Span, TimeRange
from ui.plots.time_plot import PlotView, TimePlot
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Meaning, Size, font
from ui.widgets.readout import StateChip

NOW_S = 5000.0
LEFT = Qt.MouseButton.LeftButton
NONE, CONTROL = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier
PIXEL_S = 0.1
"""A live span ends at a whole pixel, at most so much later than the newest samples."""


class Bench:
    """A plot of tilt and acceleration in a window, with what it shows at hand."""

    def __init__(self, qtbot: QtBot, *, seconds: float = 120, bounds: Span | None = None) -> None:
        self.tilt, self.acc, self.fire, self.stale = Series(), Series(), StepFunction(), StepFunction()
        times = NOW_S - seconds + np.arange(1, int(seconds * 50) + 1) / 50
        self.tilt.append(times, np.full(len(times), 12))
        self.acc.append(times, np.ones(len(times)))
        self.fire.put(NOW_S - seconds, 60)
        limits = (
            Limit(self.fire, "{value}° fires", Meaning.DANGER),
            Limit(self.stale, "{value}° fires?", Meaning.DANGER, is_stale=True),
        )
        lanes = [
            Lane("Tilt", "°", self.tilt, (Scale(0, 90, 30), Scale(0, 180, 45)), limits, weight=3),
            Lane("Acceleration", "g", self.acc, (Scale(0, 2, 1),), decimals=1, weight=2),
        ]
        self.plot = TimePlot(lanes, wall_offset_s=1_700_000_000.0, bounds=bounds)
        self.view = find(self.plot, PlotView, "time-plot-canvas")
        self.lane = self.view.lanes[0]
        other, self.window = QLineEdit(), QWidget()
        layout = QVBoxLayout(self.window)
        layout.addWidget(other)
        layout.addWidget(self.plot)
        qtbot.addWidget(self.window)
        self.window.resize(800, 520)
        with qtbot.waitExposed(self.window):
            self.window.show()
        self.window.activateWindow()
        other.setFocus()
        self.plot.draw(NOW_S)

    @property
    def range(self) -> TimeRange:
        return self.plot.time_range

    @property
    def state(self) -> str:
        chip = find(self.plot, StateChip, "time-plot-state")
        return "live" if chip.isHidden() else chip.word

    @property
    def written(self) -> list[Shown]:
        """Words and icons in the plots, the most important first."""
        return self.view.overlay.shown

    @property
    def words(self) -> dict[str, QRectF]:
        """What is written into the plots, and where."""
        return {shown.what: shown.room for shown in self.written if isinstance(shown.what, str)}

    @property
    def lines(self) -> list[float]:
        """The places of the lines of marks and cursor, across."""
        return [x for x, _ in self.view.overlay.lines]

    @property
    def dots(self) -> list[QPointF]:
        return [place for place, _ in self.view.overlay.dots]

    def icon(self, icon: Icon) -> QRectF | None:
        """Where the icon of a mark is."""
        return next((shown.room for shown in self.written if shown.what is icon), None)

    def at(self, part: float) -> QPoint:
        """A point of the upper lane at a part of its width."""
        box = self.lane.box
        return QPoint(round(box.left() + part * box.width()), round(box.center().y()))

    def wheel(self, part: float, notches: int, modifiers: Qt.KeyboardModifier = NONE) -> bool:
        """Turn the wheel over the plot; whether it was taken."""
        place, away = QPointF(self.at(part)), QPoint(0, 120 * notches)
        shown = QPointF(self.view.mapToGlobal(place))
        phase = Qt.ScrollPhase.NoScrollPhase
        event = QWheelEvent(place, shown, QPoint(), away, Qt.MouseButton.NoButton, modifiers, phase, False)
        QApplication.sendEvent(self.view.viewport(), event)
        return event.isAccepted()


@pytest.fixture
def bench(qapp: QApplication, qtbot: QtBot) -> Bench:
    style_all(qapp, LIGHT)
    return Bench(qtbot)


# The span in sight


def test_a_live_plot_follows_and_pause_holds_the_picture_while_recording_goes_on(bench: Bench, qtbot: QtBot) -> None:
    bench.plot.draw(NOW_S + 5)
    assert (bench.state, bench.range.span) == ("live", pytest.approx((NOW_S - 55, NOW_S + 5), abs=PIXEL_S))
    assert bench.lane.view.viewRange()[0] == pytest.approx([-60, 0], abs=0.5)
    pause = find(bench.plot, QPushButton, "time-plot-pause")
    qtbot.mouseClick(pause, LEFT)
    bench.tilt.append(NOW_S + 17, 99)
    bench.plot.draw(NOW_S + 17)
    assert (bench.state, pause.text(), bench.lane.scale.high) == ("paused, 12 s behind", "Live", 90)
    assert bench.range.span.end_s == pytest.approx(NOW_S + 5, abs=PIXEL_S)
    qtbot.mouseClick(pause, LEFT)
    assert (bench.state, pause.text(), bench.lane.scale.high) == ("live", "Pause", 180)
    assert bench.range.span.end_s == pytest.approx(NOW_S + 17, abs=PIXEL_S)


def test_the_length_of_the_time_line_is_chosen(bench: Bench, qtbot: QtBot) -> None:
    button = find(bench.plot, QToolButton, "time-plot-window-600")
    qtbot.mouseClick(button, LEFT)
    assert (button.text(), button.isChecked(), bench.range.is_live) == ("10 min", True, True)
    assert bench.range.span.length_s == 600


def test_zooming_keeps_the_place_and_its_bounds(bench: Bench) -> None:
    bench.wheel(0.25, 1, CONTROL)
    assert bench.range.span.length_s == pytest.approx(48)
    assert bench.range.span.start_s + 0.25 * 48 == pytest.approx(NOW_S - 45, abs=0.2)
    for _ in range(50):
        bench.wheel(0.25, 1, CONTROL)
    assert 0.02 < bench.range.span.length_s < 0.04
    for _ in range(100):
        bench.wheel(0.25, -1, CONTROL)
    assert bench.range.span.end_s <= NOW_S + PIXEL_S
    assert bench.range.span.length_s == pytest.approx(36000)


def test_a_recording_is_shown_whole_and_bounds_the_view(qapp: QApplication, qtbot: QtBot) -> None:
    first_s = NOW_S - 300
    bench = Bench(qtbot, seconds=300, bounds=Span(first_s, NOW_S))
    time_range = bench.range
    assert (time_range.span, time_range.is_live, time_range.is_whole) == (Span(first_s, NOW_S), False, True)
    time_range.choose_length(60)
    assert time_range.span == Span(first_s + 120, first_s + 180)  # around its middle
    time_range.pan(-99)
    assert time_range.span == Span(first_s, first_s + 60)
    time_range.show_instant(first_s + 100)
    assert time_range.span == Span(first_s + 70, first_s + 130)
    time_range.point(None)  # the pointer left: the cursor of a recording stays
    assert time_range.cursor_s == pytest.approx(first_s + 100)
    for _ in range(20):
        bench.wheel(0.5, -1, CONTROL)
    assert time_range.is_whole
    bench.wheel(0.5, 3, CONTROL)
    time_range.back_to_live()
    assert time_range.span == Span(first_s, NOW_S)


def test_a_recording_of_a_single_report_and_an_empty_plot_have_a_view(qapp: QApplication, qtbot: QtBot) -> None:
    single = Bench(qtbot, bounds=Span(NOW_S, NOW_S))
    assert single.range.span.start_s < NOW_S < single.range.span.end_s
    single.range.choose_length(600)
    assert single.range.is_whole
    empty = Bench(qtbot, seconds=0)
    assert len(empty.lane.curve.getData()[0]) == 0
    empty.range.point(0.5)
    assert empty.plot.reading.endswith("Tilt no data, Acceleration no data")


# Curves, limits and marks


def test_a_gap_and_a_silent_end_are_marked(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 20, NOW_S + 20.5], [12, 12])
    bench.plot.draw(NOW_S + 30)
    first, last = bench.lane.gaps
    assert first == (pytest.approx(NOW_S, abs=0.1), NOW_S + 20)
    assert last.start_s == NOW_S + 20.5
    connect = bench.lane.curve.opts["connect"]
    x, _ = bench.lane.curve.getData()
    assert [tuple(x[n : n + 2]) for n in np.flatnonzero(~np.asarray(connect))] == [pytest.approx((-30, -10), abs=0.2)]
    assert "no data" in bench.words


@pytest.mark.promise("g")
def test_a_limit_stays_in_the_past_as_it_was_and_a_stale_one_is_greyed_and_says_so(bench: Bench) -> None:
    firm, stale = bench.lane.limits
    bench.fire.put(NOW_S - 30, 75)
    bench.plot.draw(NOW_S)
    x, y = firm.getData()
    assert (x.tolist(), y.tolist()) == (pytest.approx([-60, -30, -30, 0], abs=0.2), [60, 60, 75, 75])
    assert "75° fires" in bench.words
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 75)
    bench.plot.draw(NOW_S + 30)
    label = next(shown for shown in bench.written if shown.what == "75° fires?")
    assert label.ink == LIGHT.muted
    assert firm.getData()[0].tolist() == pytest.approx([-60, -30], abs=0.2)
    assert stale.getData()[0].tolist() == pytest.approx([-30, 0], abs=0.2)
    assert stale.opts["pen"].color().name().upper() == LIGHT.muted.upper()
    bench.plot.draw(NOW_S + 61)
    assert firm.getData()[0].tolist() == []
    assert "75° fires" not in bench.words


@pytest.mark.promise("g")
def test_the_most_important_mark_keeps_its_icon_where_its_time_is(bench: Bench) -> None:
    """Whichever comes first: two marks 0.2 s apart, of which only one icon has room."""
    triggered = Mark(NOW_S - 20, "triggered", Icon.PARACHUTE, Meaning.DANGER, 0)
    activated = Mark(NOW_S - 19.8, "activated", Icon.ACTIVE, Meaning.DANGER, 2)
    for marks in ((triggered, activated), (activated, triggered)):
        bench.plot.reset()
        bench.plot.add_marks(marks)
        bench.plot.draw(NOW_S)
        assert {"triggered", "activated"} & set(bench.words) == {"triggered"}
        assert bench.icon(Icon.ACTIVE) is None
        box = bench.lane.box
        x = pytest.approx(box.right() - box.width() / 3, abs=2)
        assert given(bench.icon(Icon.PARACHUTE)).center().x() == x
        assert len({round(line) for line in bench.lines}) == 2  # each has its line
        assert any(line == x for line in bench.lines)


@pytest.mark.parametrize("ago_s", [59.0, 57.0])
def test_no_word_covers_another(bench: Bench, ago_s: float) -> None:
    """The icon and the word of a mark are in the row of the first title; gaps are in the lane."""
    bench.plot.add_marks([Mark(NOW_S - ago_s, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 45)  # in the middle
    for seconds in range(0, 30, 3):
        bench.plot.draw(NOW_S + seconds)
        assert {"Tilt", "Acceleration"} <= set(bench.words)
        for first, second in combinations(bench.written, 2):
            assert not first.room.intersects(second.room), (first.what, second.what)
    assert "no data" in bench.words


# Ticks


def ticks_of(bench: Bench, length_s: float, end_wall_s: float | None = None) -> list[tuple[float, str]]:
    """Those of a span, and their labels, on an axis with room for six."""
    axis = bench.view.times
    axis.resize(6.5 * QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000"), 20)
    times = axis.show_span(length_s, end_wall_s)
    ((step_s, _),) = axis.tickSpacing(-length_s, 0, 0)
    return list(zip(times, axis.tickStrings(times, 1, step_s), strict=True))


def test_ticks_are_counted_from_the_end_or_at_round_times_of_the_clock(bench: Bench) -> None:
    ticks = ticks_of(bench, 60)
    assert [label for _, label in ticks] == [*(f"−{n} s" for n in range(60, 0, -10)), "now"]
    assert [time_s for time_s, _ in ticks] == list(range(-60, 10, 10))
    assert ticks_of(bench, 600)[-2][1] == "−2 min"
    assert ticks_of(bench, 0.1)[-2][1] == "−0.02 s"
    ticks = ticks_of(bench, 60, 1_700_000_060.65)
    assert len(ticks) == 6
    assert all(((time_s + 60.4 + 1_700_000_000.25) % 10) == pytest.approx(0, abs=1e-6) for time_s, _ in ticks)
    assert all(label.endswith("0") and len(label) == 8 for _, label in ticks)
    # A log whose clock was set on the way lasts for decades: 40,000 labels held the window for seconds.
    assert 2 <= len(ticks_of(bench, 1.7e9)) <= 7
    assert [clock_text(1_700_000_000 + part, 1)[-4:] for part in (0.96, 0.94)] == ["21.0", "20.9"]


# Mouse and keyboard


def test_the_wheel_zooms_with_ctrl_and_after_a_click(bench: Bench, qtbot: QtBot) -> None:
    assert not bench.wheel(0.5, 1)
    assert bench.range.is_live
    assert bench.wheel(0.5, 1, CONTROL)
    bench.range.back_to_live()
    qtbot.mouseClick(bench.view.viewport(), LEFT, pos=bench.at(0.5))
    assert bench.wheel(0.25, -1)
    assert bench.range.span.length_s == pytest.approx(75)


def test_dragging_moves_into_the_past_and_the_picture_stays_there(bench: Bench, qtbot: QtBot) -> None:
    viewport = bench.view.viewport()
    qtbot.mousePress(viewport, LEFT, pos=bench.at(0.2))
    qtbot.mouseMove(viewport, bench.at(0.7))
    qtbot.mouseRelease(viewport, LEFT, pos=bench.at(0.7))
    moved = bench.range.span
    assert moved.end_s == pytest.approx(NOW_S - 30, abs=1)
    bench.plot.draw(NOW_S + 3)
    assert bench.range.span == moved
    qtbot.mouseDClick(viewport, LEFT, pos=bench.at(0.5))
    assert bench.range.is_live


def test_everything_by_keyboard(bench: Bench, qtbot: QtBot) -> None:
    view, shift = bench.view, Qt.KeyboardModifier.ShiftModifier
    view.setFocus()
    for key, is_live in ((Qt.Key.Key_Space, False), (Qt.Key.Key_End, True)):
        qtbot.keyClick(view, key)
        assert bench.range.is_live is is_live
    qtbot.keyClick(view, Qt.Key.Key_Left)
    assert bench.range.span.end_s == pytest.approx(NOW_S - 6, abs=0.1)
    qtbot.keyClick(view, Qt.Key.Key_Right)
    for key, length_s in ((Qt.Key.Key_Plus, 48), (Qt.Key.Key_Minus, 60)):
        qtbot.keyClick(view, key)
        assert bench.range.span.length_s == pytest.approx(length_s)
    qtbot.keyClick(view, Qt.Key.Key_Left, shift)
    assert "Tilt 12°" in bench.plot.reading
    assert view.accessibleDescription() == bench.plot.reading
    qtbot.keyClick(view, Qt.Key.Key_Tab)
    assert not view.hasFocus()


# The cursor


def test_the_cursor_shows_values_while_live(bench: Bench, qtbot: QtBot) -> None:
    assert bench.plot.reading == ""
    qtbot.mouseMove(bench.view.viewport(), bench.at(0.5))
    assert bench.plot.reading.startswith(("−30.0 s · ", "−29.9 s · "))
    assert bench.plot.reading.endswith("Tilt 12°, Acceleration 1.0 g")
    assert {"12°", "1.0 g"} <= set(bench.words)
    assert all(QRectF(bench.view.viewport().rect()).contains(room) for room in bench.words.values())
    middle = pytest.approx(bench.lane.box.center().x(), abs=1)
    assert bench.lines == [middle]
    assert (bench.dots[0].x(), bench.dots[0].y()) == (middle, pytest.approx(bench.lane.y(12), abs=1))
    bench.plot.add_marks([Mark(NOW_S - 20, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.plot.draw(NOW_S + 10)
    assert " · triggered, Tilt 12°" in bench.plot.reading
    for widget in (bench.view.viewport(), bench.view):  # an error in here ended the program
        QApplication.sendEvent(widget, QEvent(QEvent.Type.Leave))
    assert (bench.plot.reading, bench.dots) == ("", [])


def test_the_cursor_reads_wherever_a_curve_is_drawn_and_invents_nothing(bench: Bench) -> None:
    """Between slow samples it said "no data" beside a dot."""
    bench.tilt.append([NOW_S + 20, NOW_S + 21], [5, 5])
    bench.acc.append(np.arange(NOW_S + 1, NOW_S + 10), np.ones(9))
    bench.plot.draw(NOW_S + 21)
    bench.range.point_at(NOW_S + 15)
    assert bench.plot.reading.endswith("Tilt no data, Acceleration no data")
    assert not bench.dots
    for at_s in (NOW_S + 4.45, NOW_S + 4.55):
        bench.range.point_at(at_s)
        assert bench.plot.reading.endswith("Acceleration 1.0 g")
        assert bench.dots[-1].x() == pytest.approx(bench.lane.x(round(at_s)), abs=1)  # the sample that is read
