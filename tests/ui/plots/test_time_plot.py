"""The time plots: what is in sight, curves and ticks."""

import math
from itertools import pairwise
from unittest.mock import Mock

import numpy as np
import pytest
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.samples.ring_buffers import Envelope
from app.system.wall_clock import clock_text
from tests.support.window.contrast import style_all
from tests.support.window.cut_off import cut_off
from tests.support.window.steps import find
from tests.ui.plots.plot_bench import CONTROL, LEFT, NOW_S, Bench, labels_of
from ui.plots.axis import TimeAxis
from ui.plots.lane_view import points
from ui.plots.lanes import Scale, Span, fitting_scale
from ui.style.theme import LIGHT, THEMES, Size, font
from ui.widgets.readout import StateChip

PIXEL_S = 0.1
"""A live span ends at a whole pixel, at most so much later than the newest samples."""


# The span in sight


def test_a_live_plot_follows(bench: Bench) -> None:
    assert bench.plot.time_range.is_live
    assert bench.state == "live"
    bench.plot.draw(NOW_S + 5)
    assert bench.plot.time_range.span == pytest.approx((NOW_S - 55, NOW_S + 5), abs=PIXEL_S)
    assert bench.lane.view.viewRange()[0] == pytest.approx([-60, 0], abs=0.5)


def test_pause_holds_the_picture_while_recording_goes_on(bench: Bench, qtbot: QtBot) -> None:
    pause = bench.button("time-plot-pause")
    qtbot.mouseClick(pause, LEFT)
    bench.tilt.append(NOW_S + 12, 99)
    bench.plot.draw(NOW_S + 12)
    assert bench.state == "paused, 12 s behind"
    assert bench.plot.time_range.span.end_s == pytest.approx(NOW_S, abs=PIXEL_S)
    assert bench.lane.scale[:2] == (0, 90)
    assert pause.text() == "Live"
    qtbot.mouseClick(pause, LEFT)
    assert (bench.state, pause.text()) == ("live", "Pause")
    assert bench.plot.time_range.span.end_s == pytest.approx(NOW_S + 12, abs=PIXEL_S)
    assert bench.lane.scale[:2] == (0, 180)


@pytest.mark.parametrize(("window_s", "word"), [(10, "10 s"), (60, "60 s"), (600, "10 min")])
def test_the_length_of_the_time_line_is_chosen(bench: Bench, qtbot: QtBot, window_s: float, word: str) -> None:
    button = bench.button(f"time-plot-window-{window_s}")
    assert button.text() == word
    qtbot.mouseClick(button, LEFT)
    assert bench.plot.time_range.span.length_s == window_s
    assert button.isChecked()
    assert bench.plot.time_range.is_live


def test_a_button_is_pressed_only_while_its_length_is_in_sight(bench: Bench) -> None:
    def pressed() -> list[int]:
        return [seconds for seconds in (10, 60, 600) if bench.button(f"time-plot-window-{seconds}").isChecked()]

    assert pressed() == [60]
    bench.wheel(0.5, 1, CONTROL)
    assert pressed() == []
    bench.plot.time_range.choose_length(10)
    assert (pressed(), bench.plot.time_range.is_live) == ([10], False)
    bench.plot.time_range.back_to_live()
    assert pressed() == [10]


def test_zooming_keeps_the_place_and_its_bounds(bench: Bench) -> None:
    plot = bench.plot
    bench.wheel(0.25, 1, CONTROL)
    assert plot.time_range.span.length_s == pytest.approx(48)
    assert plot.time_range.span.start_s + 0.25 * 48 == pytest.approx(NOW_S - 45, abs=0.2)
    for _ in range(50):
        bench.wheel(0.25, 1, CONTROL)
    assert 0.02 < plot.time_range.span.length_s < 0.04
    for _ in range(100):
        bench.wheel(0.25, -1, CONTROL)
    assert plot.time_range.span.end_s <= NOW_S + PIXEL_S
    assert plot.time_range.span.length_s == pytest.approx(36000)


def test_panning_never_goes_beyond_now(bench: Bench, qtbot: QtBot) -> None:
    bench.plot.time_range.pan(-0.5)
    assert bench.plot.time_range.span == pytest.approx((NOW_S - 90, NOW_S - 30), abs=PIXEL_S)
    bench.plot.time_range.pan(9)
    assert bench.plot.time_range.span == pytest.approx((NOW_S - 60, NOW_S), abs=PIXEL_S)
    assert not bench.plot.time_range.is_live


def test_a_recording_is_shown_whole_and_bounds_the_view(recorded: Bench) -> None:
    plot, first_s = recorded.plot, NOW_S - 300
    assert plot.time_range.span == Span(first_s, NOW_S)
    assert (plot.time_range.is_live, plot.time_range.is_recorded, plot.time_range.is_whole) == (False, True, True)
    plot.time_range.choose_length(60)
    assert plot.time_range.span == Span(first_s + 120, first_s + 180)  # around its middle
    assert not plot.time_range.is_whole
    recorded.plot.time_range.pan(-99)
    assert plot.time_range.span == Span(first_s, first_s + 60)
    plot.time_range.show_instant(first_s + 100)
    assert plot.time_range.span == Span(first_s + 70, first_s + 130)
    assert plot.time_range.cursor_s == pytest.approx(first_s + 100)
    for _ in range(20):
        recorded.wheel(0.5, -1, CONTROL)
    assert plot.time_range.is_whole
    recorded.wheel(0.5, 3, CONTROL)
    plot.time_range.back_to_live()
    assert plot.time_range.span == Span(first_s, NOW_S)


def test_a_recording_of_a_single_report_has_a_view(qapp: QApplication, qtbot: QtBot) -> None:
    bench = Bench(qtbot, bounds=Span(NOW_S, NOW_S))
    assert bench.plot.time_range.span.start_s < NOW_S < bench.plot.time_range.span.end_s
    bench.plot.time_range.choose_length(600)
    assert bench.plot.time_range.is_whole


# What is drawn


def test_a_gap_and_a_silent_end_are_marked(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 20, NOW_S + 20.5], [12, 12])
    bench.plot.draw(NOW_S + 30)
    gaps = bench.lane.gaps
    assert gaps[0].start_s == pytest.approx(NOW_S, abs=0.1)
    assert gaps[0].end_s == NOW_S + 20
    assert gaps[1].start_s == NOW_S + 20.5
    connect = bench.lane.curve.opts["connect"]
    x, _ = bench.lane.curve.getData()
    assert [tuple(x[n : n + 2]) for n in np.flatnonzero(~np.asarray(connect))] == [pytest.approx((-30, -10), abs=0.2)]
    assert "no data" in bench.words


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_curves_are_wider_than_a_hairline_in_the_colours_of_the_theme(
    bench: Bench, qapp: QApplication, theme: object
) -> None:
    style_all(qapp, theme)  # type: ignore[arg-type]
    for lane, colour in zip(bench.view.lanes, theme.curves, strict=False):  # type: ignore[attr-defined]
        assert lane.curve.opts["pen"].color().name().upper() == colour.upper()
        assert lane.curve.line_px >= 2
    image = bench.plot.canvas.grab().toImage()
    assert image.pixelColor(2, 2).name().upper() == theme.surface.upper()  # type: ignore[attr-defined]
    x = round(bench.lane.box.center().x())
    rows = [y for y in range(image.height()) if image.pixelColor(x, y).name().upper() == theme.curves[0].upper()]  # type: ignore[attr-defined]
    assert len([y for y in rows if abs(y - bench.lane.y(12)) <= 3]) == bench.lane.curve.line_px


@pytest.mark.parametrize("rises", [True, False])
def test_a_slope_is_as_wide_and_has_no_gap(bench: Bench, rises: bool) -> None:
    """Lines side by side left a gap where a curve rose, and lay on each other where it fell."""
    length_s = 3.0  # as steep as it gets
    for value in np.arange(0, 91) if rises else np.arange(90, -1, -1):
        bench.tilt.append(NOW_S + 60 + length_s * (value if rises else 90 - value) / 90, value)
    bench.plot.draw(NOW_S + 60 + length_s)
    bench.plot.time_range.choose_length(60)
    image, x = bench.plot.canvas.grab().toImage(), round(bench.lane.x(NOW_S + 60 + length_s / 2))
    for column in range(x - 5, x + 6):
        rows = [y for y in range(image.height()) if image.pixelColor(column, y).name() == LIGHT.curves[0].lower()]
        rows = [y for y in rows if bench.lane.box.contains(column, y)]
        assert len(rows) >= 2
        assert rows == list(range(rows[0], rows[-1] + 1))


def test_it_scrolls_by_whole_pixels(bench: Bench) -> None:
    """Draws less than a pixel apart show the same span, and the next one is a pixel further on."""
    pixel_s = bench.plot.time_range.pixel_s
    aligned_s = math.floor(NOW_S / pixel_s + 1) * pixel_s

    def newest_x(pixels: float) -> float:
        bench.plot.draw(aligned_s + pixels * pixel_s)
        return float(bench.lane.curve.getData()[0][-1])

    first = newest_x(0.2)
    bench.plot.add_marks([])
    assert not bench.plot.canvas.is_due(aligned_s + 0.8 * pixel_s)
    assert newest_x(0.8) == first
    assert newest_x(1.2) == pytest.approx(first - pixel_s, abs=1e-6)


def test_following_leaves_range_ticks_and_steady_limits_alone(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """What decides how fast a redraw is."""
    calls = Mock()
    for lane in bench.view.lanes:
        monkeypatch.setattr(lane.view, "setRange", calls)
        for axis in (bench.view.times, lane.values):
            monkeypatch.setattr(axis, "generateDrawSpecs", calls)
        for item in (lane.grid, *lane.limits):
            monkeypatch.setattr(item, "setData", calls)
    for second in range(10):
        bench.tilt.append(NOW_S + second, 12)
        bench.plot.draw(NOW_S + second)
    assert not calls.called


def test_hidden_plots_draw_nothing(bench: Bench, qtbot: QtBot) -> None:
    before = bench.lane.curve.getData()[0].tolist()
    bench.plot.hide()
    bench.plot.draw(NOW_S + 20)
    assert bench.lane.curve.getData()[0].tolist() == before
    bench.plot.show()
    assert bench.lane.curve.getData()[0].tolist() != before


def test_the_state_is_whole_in_a_narrow_window_too(bench: Bench) -> None:
    bench.plot.time_range.toggle_pause()
    chip, header = find(bench.plot, StateChip, "time-plot-state"), find(bench.plot, QWidget, "time-plot-header")
    for width in (700, 500):
        bench.window.resize(width, 520)
        QApplication.processEvents()
        bench.plot.draw(NOW_S + 12)
        assert chip.accessibleName() == chip.toolTip() == "Plots: paused, 12 s behind"
        assert cut_off(header) == []
        pause = bench.button("time-plot-pause")
        assert bench.plot.rect().contains(pause.mapTo(bench.plot, pause.rect().topRight()))


def test_an_empty_plot_draws(qapp: QApplication, qtbot: QtBot) -> None:
    empty = Bench(qtbot, seconds=0)
    assert empty.plot.time_range.is_live
    assert len(empty.lane.curve.getData()[0]) == 0
    empty.plot.time_range.point(0.5)
    assert empty.plot.reading.endswith("Tilt no data, Acceleration no data")


def test_points_break_at_gaps_and_never_join_over_them() -> None:
    time_s = np.array([0.0, 1.0, 5.0, 6.0])
    value = np.array([1, 2, 3, 4], np.float32)
    curve = points(Envelope(time_s, time_s, value, value), origin_s=0, gap_s=2)
    assert curve.gaps == [Span(1, 5)]
    assert curve.x.tolist() == [0, 0, 1, 1, 5, 5, 6, 6]
    assert np.flatnonzero(~np.asarray(curve.connect)).tolist() == [3]
    none = np.array([])
    assert len(points(Envelope(none, none, none, none), origin_s=0, gap_s=2).x) == 0


def test_the_smallest_scale_that_holds_everything_is_taken() -> None:
    scales = (Scale(0, 90, 30), Scale(0, 180, 45))
    assert fitting_scale(scales, 3, 90) is scales[0]
    assert fitting_scale(scales, 3, 91) is scales[1]
    assert fitting_scale(scales, 3, 255) is scales[1]


# The time line


def ticks_of(bench: Bench, length_s: float, end_wall_s: float | None = None) -> list[tuple[float, str]]:
    """Those of a span, and their labels, on an axis with room for six."""
    axis: TimeAxis = bench.view.times
    axis.resize(6.5 * QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000"), 20)
    times = axis.show_span(length_s, end_wall_s)
    ((step_s, _),) = axis.tickSpacing(-length_s, 0, 0)
    return list(zip(times, axis.tickStrings(times, 1, step_s), strict=True))


def test_ticks_before_now_are_counted_from_the_end(bench: Bench) -> None:
    ticks = ticks_of(bench, 60)
    assert [label for _, label in ticks] == [*(f"−{n} s" for n in range(60, 0, -10)), "now"]
    assert [time_s for time_s, _ in ticks] == list(range(-60, 10, 10))
    assert ticks_of(bench, 600)[-2][1] == "−2 min"
    assert ticks_of(bench, 0.1)[-2][1] == "−0.02 s"


def test_ticks_of_the_clock_are_at_round_times(bench: Bench) -> None:
    ticks = ticks_of(bench, 60, 1_700_000_060.65)
    assert len(ticks) == 6
    assert all(((time_s + 60.4 + 1_700_000_000.25) % 10) == pytest.approx(0, abs=1e-6) for time_s, _ in ticks)
    assert all(label.endswith("0") and len(label) == 8 for _, label in ticks)
    assert clock_text(1_700_000_000.96, 1)[-4:] == "21.0"
    assert clock_text(1_700_000_000.94, 1)[-4:] == "20.9"


@pytest.mark.parametrize("width_px", range(400, 800, 50))
@pytest.mark.parametrize("is_clock", [False, True])
def test_the_times_below_the_plots_never_touch(bench: Bench, width_px: int, is_clock: bool) -> None:
    bench.view.shows_clock = is_clock
    bench.window.resize(width_px, 520)
    QApplication.processEvents()
    rooms = [room for _, room in labels_of(bench.view.times)]
    assert len(rooms) > 1
    assert rooms[0].left() >= 0
    assert all(earlier.right() + 4 <= later.left() for earlier, later in pairwise(rooms))


def test_the_cursor_time_covers_no_tick_label_partly(bench: Bench) -> None:
    """A label that it would touch is not there."""

    assert "−30 s" in bench.times
    bench.plot.time_range.point_at(NOW_S - 31)
    assert "−30 s" not in bench.times
    assert {"−60 s", "now"} <= set(bench.times)
    bench.plot.time_range.point(None)
    assert "−30 s" in bench.times
