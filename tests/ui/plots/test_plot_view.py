"""View model of the plots: time spans, scales, points and ticks."""

import math
from itertools import pairwise
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from PySide6.QtCore import QRectF
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication

from app.samples.ring_buffers import Envelope
from ui.plots.axis import before_now, clock_text, clock_times
from ui.plots.curve import points
from ui.plots.paint import Picture, _tick_labels
from ui.plots.view import Scale, Span, TimeView, fitting_scale
from ui.style.theme import Size, font


def test_a_view_is_live_until_it_is_paused() -> None:
    view = TimeView(60)
    assert view.span(100) == Span(40, 100)
    assert view.span(101) == Span(41, 101)
    view.hold(101)
    assert view.span(113) == Span(41, 101)
    assert (view.is_live, view.behind_s(113)) == (False, 12)
    view.follow_live()
    assert view.span(113) == Span(53, 113)
    assert view.behind_s(113) == 0


def test_zooming_keeps_the_place_and_its_bounds() -> None:
    view = TimeView(60)
    view.zoom(0.5, at_s=70, now_s=100)
    assert view.span(100) == Span(55, 85)
    for _ in range(100):
        view.zoom(0.5, at_s=70, now_s=100)
    assert 0.02 < view.span(100).length_s < 0.04
    for _ in range(100):
        view.zoom(2, at_s=70, now_s=100)
    assert view.span(100).end_s <= 100
    assert view.span(100).length_s == 36000


def test_panning_never_goes_beyond_now() -> None:
    view = TimeView(10)
    view.pan(-30, now_s=100)
    assert view.span(100) == Span(60, 70)
    view.pan(500, now_s=100)
    assert view.span(100) == Span(90, 100)
    assert not view.is_live
    view.choose(60, now_s=100)
    assert view.span(100) == Span(40, 100)


def test_a_recording_is_shown_whole_and_bounds_the_view() -> None:
    view = TimeView(60, bounds=Span(1000, 1300))
    assert view.span(0) == Span(1000, 1300)
    assert (view.is_live, view.is_recorded, view.is_whole, view.behind_s(9999)) == (False, True, True, 0)
    view.choose(60, now_s=0)
    assert view.span(0) == Span(1120, 1180)  # around its middle
    assert not view.is_whole
    view.pan(-500, now_s=0)
    assert view.span(0) == Span(1000, 1060)
    view.pan(9999, now_s=0)
    assert view.span(0) == Span(1240, 1300)
    view.show_instant(1100, now_s=0)
    assert view.span(0) == Span(1070, 1130)
    view.zoom(1000, at_s=1100, now_s=0)
    assert view.span(0) == Span(1000, 1300)
    assert view.is_whole
    view.zoom(0.1, at_s=1000, now_s=0)
    view.follow_live()
    assert view.span(0) == Span(1000, 1300)


def test_a_recording_of_a_single_report_has_a_view() -> None:
    view = TimeView(60, bounds=Span(5.0, 5.0))
    assert view.span(0).start_s < 5.0 < view.span(0).end_s
    view.zoom(0.01, at_s=5.0, now_s=0)
    view.choose(600, now_s=0)
    assert view.is_whole


def test_the_smallest_scale_that_holds_everything_is_taken() -> None:
    scales = (Scale(0, 90, 30), Scale(0, 180, 45))
    assert fitting_scale(scales, 3, 90) is scales[0]
    assert fitting_scale(scales, 3, 91) is scales[1]
    assert fitting_scale(scales, 3, 255) is scales[1]


def test_points_break_at_gaps_and_never_join_over_them() -> None:
    time_s = np.array([0.0, 1.0, 5.0, 6.0])
    value = np.array([1, 2, 3, 4], np.float32)
    found = points(Envelope(time_s, time_s, value, value), origin_s=0, gap_s=2)
    assert found.gaps == [Span(1, 5)]
    assert np.array_equal(np.isnan(found.x), np.isnan(found.y))
    assert found.x.tolist()[:4] == [0, 0, 1, 1]
    assert math.isnan(found.x[4])
    assert found.x.tolist()[5:] == [5, 5, 6, 6]
    none = np.array([])
    assert len(points(Envelope(none, none, none, none), origin_s=0, gap_s=2).x) == 0


def test_ticks_before_now_stand_still_while_time_goes_on() -> None:
    first = before_now(Span(40, 100), most=7)
    assert [tick.label for tick in first] == ["now", *(f"−{n} s" for n in range(10, 70, 10))]
    second = before_now(Span(41.3, 101.3), most=7)
    assert [tick.time_s - 1.3 for tick in second] == pytest.approx([tick.time_s for tick in first])
    assert before_now(Span(0, 600), most=6)[1].label == "−2 min"
    assert before_now(Span(0, 0.1), most=6)[1].label == "−0.02 s"


def test_ticks_of_the_clock_are_at_round_times() -> None:
    ticks = clock_times(Span(0.4, 60.4), most=7, wall_offset_s=1_700_000_000.25)
    assert len(ticks) == 6
    assert all(((tick.time_s + 1_700_000_000.25) % 10) == pytest.approx(0, abs=1e-6) for tick in ticks)
    assert all(tick.label.endswith("0") and len(tick.label) == 8 for tick in ticks)
    assert clock_text(1_700_000_000.96, 1)[-4:] == "21.0"
    assert clock_text(1_700_000_000.94, 1)[-4:] == "20.9"


@pytest.mark.parametrize("width_px", range(300, 700, 50))
def test_the_times_below_the_plots_never_touch(qapp: QApplication, width_px: int) -> None:
    span = Span(0.0, 300.0)
    axis = QRectF(50, 0, width_px, 20)
    ticks = clock_times(span, most=int(width_px / 60), wall_offset_s=1_700_000_000.0 - 20)
    picture = cast("Picture", SimpleNamespace(ticks=ticks, axis=axis, x=lambda at_s: 50 + at_s / 300 * width_px))
    rooms = sorted((room for room, _label in _tick_labels(picture, QFontMetricsF(font(Size.SMALL)))), key=QRectF.left)
    assert len(rooms) > 1
    assert all(one.right() + 4 <= other.left() for one, other in pairwise(rooms))
