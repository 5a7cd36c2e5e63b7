"""The time plots: what is in sight, curves and ticks."""

import numpy as np
import pytest
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.system.clock import clock_text
from tests.window.plots.plot_bench import CONTROL, LEFT, NOW_S, Bench
from ui.plots.charts import TimeAxis
from ui.plots.lanes import Span
from ui.style.theme import Size, font

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


def test_an_empty_plot_draws(qapp: QApplication, qtbot: QtBot) -> None:
    empty = Bench(qtbot, seconds=0)
    assert empty.plot.time_range.is_live
    assert len(empty.lane.curve.getData()[0]) == 0
    empty.plot.time_range.point(0.5)
    assert empty.plot.reading.endswith("Tilt no data, Acceleration no data")


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
