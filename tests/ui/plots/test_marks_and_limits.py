"""Marks, limits and axes of the plots, the charts of the link and the picture of a record: nothing overlaps."""

from itertools import combinations, pairwise

import pyqtgraph as pg
import pytest
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication, QGraphicsScene
from pytestqt.qtbot import QtBot

from app.samples.ring_buffers import Series
from app.samples.step_function import StepFunction
from tests.support.window.steps import given
from tests.ui.plots.plot_bench import NOW_S, Bench, labels_of
from ui.pages.diagnosis.statistics import OverTime, Stretch
from ui.plots.lane_view import LaneView
from ui.plots.lanes import Lane, Limit, Mark, Scale, Span
from ui.plots.overlay import Overlay
from ui.plots.time_plot import TimePlot
from ui.style import theme
from ui.style.appearance import Appearance
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Choice, Meaning


@pytest.mark.promise("g")
def test_the_most_important_mark_keeps_its_icon(bench: Bench) -> None:
    """Whichever comes first: two marks 0.2 s apart, of which only one icon has room."""
    for first, second in (("triggered", "activated"), ("activated", "triggered")):
        bench.plot.reset()
        for number, word in enumerate((first, second)):
            rank, icon = (0, Icon.PARACHUTE) if word == "triggered" else (2, Icon.ACTIVE)
            bench.plot.add_marks([Mark(NOW_S - 20 + 0.2 * number, word, icon, Meaning.DANGER, rank)])
        bench.plot.draw(NOW_S)
        assert "triggered" in bench.words
        assert "activated" not in bench.words
        assert bench.icon(Icon.PARACHUTE, Meaning.DANGER) is not None
        assert bench.icon(Icon.ACTIVE, Meaning.DANGER) is None
        assert len({round(x) for x in bench.lines}) == 2  # each has its line


def test_marks_are_where_their_time_is(bench: Bench) -> None:
    bench.plot.add_marks([Mark(NOW_S - 10, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.plot.add_marks([Mark(NOW_S - 40, "activated", Icon.ACTIVE, Meaning.ATTENTION)])
    bench.plot.draw(NOW_S)
    box = bench.lane.box
    for icon, meaning, ago_s in ((Icon.PARACHUTE, Meaning.DANGER, 10), (Icon.ACTIVE, Meaning.ATTENTION, 40)):
        x, room = box.right() - ago_s / 60 * box.width(), bench.icon(icon, meaning)
        assert given(room).center().x() == pytest.approx(x, abs=2)
        assert any(line == pytest.approx(x, abs=1.5) for line in bench.lines)


def test_hundreds_of_marks_are_lines_at_as_many_pixels(bench: Bench) -> None:
    bench.plot.add_marks([Mark(NOW_S - n * 0.001, "offline", Icon.LINK_LOST) for n in range(900)])
    bench.plot.draw(NOW_S)
    assert 5 < len(bench.lines) <= 14


@pytest.mark.parametrize("ago_s", [59.5, 59.0, 58.0, 57.0, 30.0])
def test_no_word_covers_another(bench: Bench, ago_s: float) -> None:
    """The icon and the word of a mark are in the row of the first title; gaps and stale limits are in the lane."""
    bench.plot.add_marks([Mark(NOW_S - ago_s, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 45)  # in the middle
    count = 0
    for seconds in range(0, 30, 3):
        bench.plot.draw(NOW_S + seconds)
        count += len({"no data", "stale"} & set(bench.words))
        for first, second in combinations(bench.written, 2):
            assert not first.room.intersects(second.room), (first.what, second.what)
    assert {"Tilt", "Acceleration"} <= set(bench.words)
    assert count > 10


@pytest.mark.parametrize("values", [(60, 59, 58), (58, 59, 60), (0, 0, 0), (90, 89, 90), (10, 80, 45)])
def test_labels_of_limits_never_overlap(qapp: QApplication, qtbot: QtBot, values: tuple[float, ...]) -> None:
    scene, limits = QGraphicsScene(), []
    for number, value in enumerate(values):
        limits.append(Limit(StepFunction(), f"limit {number}", Meaning.DANGER))
        limits[-1].steps.put(0.0, value)
    lane = LaneView(Lane("Tilt", "°", Series(), (Scale(0, 90, 30),), tuple(limits)), scene)
    lane.place(QRectF(0, 0, 500, 40))
    lane.draw(Span(0.0, 60.0), [])
    overlay = Overlay()
    overlay.clear(lane.box, has_focus=False)
    lane.name_limits(overlay)
    assert [shown.what for shown in overlay.shown] == ["limit 0", "limit 1", "limit 2"]
    assert not any(first.room.intersects(second.room) for first, second in combinations(overlay.shown, 2))
    assert overlay.shown[0].room.center().y() == pytest.approx(lane.y(values[0]), abs=1)  # the most important one


def test_a_word_takes_the_first_free_place_or_none(qapp: QApplication) -> None:
    overlay = Overlay()
    overlay.clear(QRectF(), has_focus=False)
    assert overlay.put("first", LIGHT.muted, [QPointF(0, 0)])
    below = given(overlay.put("second", LIGHT.muted, [QPointF(1, 1), QPointF(1, 40)]))
    assert below.top() == 40
    assert overlay.put("third", LIGHT.muted, [QPointF(2, 2), QPointF(2, 41)]) is None
    assert overlay.put("third", LIGHT.muted, [QPointF(2, 2)], is_above=True) is not None
    assert [shown.what for shown in overlay.shown] == ["first", "second", "third"]
    overlay.clear(QRectF(), has_focus=False)
    assert overlay.shown == []


# Limits


def test_a_limit_stays_in_the_past_as_it_was(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, 75)
    bench.plot.draw(NOW_S)
    firm = bench.lane.limits[0]
    assert [(part.value, part.is_current) for part in firm.segments] == [(60, False), (75, True)]
    x, y = firm.getData()
    assert x.tolist() == pytest.approx([-60, -30, -30, 0], abs=0.2)
    assert y.tolist() == [60, 60, 75, 75]
    assert {"60", "75° fires"} <= set(bench.words)
    bench.fire.put(NOW_S - 1, None)
    bench.plot.draw(NOW_S + 60)
    assert firm.getData()[0].tolist() == []
    assert "75° fires" not in bench.words


def test_a_limit_of_the_past_is_named_only_where_another_came_after_it(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, None)  # restarted
    bench.fire.put(NOW_S - 28, 60)
    bench.plot.draw(NOW_S)
    assert not {"60", "75"} & set(bench.words)
    bench.fire.put(NOW_S - 15, 75)
    bench.plot.draw(NOW_S)
    assert {"60", "75"} & set(bench.words) == {"60"}


@pytest.mark.promise("g")
def test_a_stale_limit_stays_greyed_and_says_that_it_is_stale(bench: Bench) -> None:
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 60)
    bench.plot.draw(NOW_S + 30)
    assert {"60° fires", "stale"} <= set(bench.words)
    label = next(shown for shown in bench.written if shown.what == "60° fires")
    assert label.ink == LIGHT.muted
    firm, stale = bench.lane.limits
    assert firm.getData()[0].tolist() == pytest.approx([-60, -30], abs=0.2)
    assert stale.getData()[0].tolist() == pytest.approx([-30, 0], abs=0.2)
    assert stale.opts["pen"].color().name().upper() == LIGHT.muted.upper()


@pytest.mark.parametrize("length_s", [2.0, 60.0])
def test_the_last_limits_of_a_recording_are_labelled(bench: Bench, length_s: float) -> None:
    """They are lost as the port is closed, a moment before the end: many pixels of a short recording."""
    bench.plot.time_range.choose_length(length_s)
    bench.fire.put(NOW_S - 0.02, None)
    bench.plot.draw(NOW_S)
    assert bench.words["60° fires"].left() > bench.lane.box.right()


def test_an_axis_grows_and_does_not_shrink_while_it_follows(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 1, NOW_S + 2], [120, 10])
    bench.plot.draw(NOW_S + 2)
    bench.tilt.append([NOW_S + 70, NOW_S + 90], [10, 10])
    bench.plot.draw(NOW_S + 90)  # the peak is out of sight
    assert bench.lane.scale[:2] == (0, 180)
    bench.plot.time_range.choose_length(10)
    assert bench.lane.scale[:2] == (0, 90)


def test_a_limit_beyond_the_scale_widens_it(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, 120)
    bench.plot.draw(NOW_S)
    assert bench.lane.scale[:2] == (0, 180)


@pytest.mark.parametrize("percent", [100, 200])
def test_at_their_least_height_all_plots_are_there_and_nothing_covers_the_times(
    qapp: QApplication, qtbot: QtBot, percent: int
) -> None:
    theme.zoom(percent)
    looks = Appearance(qapp, Choice.SUNLIGHT)
    weights = {"Tilt": 5, "Acceleration": 3, "Light": 2, "Cell voltage": 2}
    lanes = [Lane(title, "", Series(), (Scale(0, 4, 2),), weight=weight) for title, weight in weights.items()]
    plot = TimePlot(lanes, wall_offset_s=0.0)
    qtbot.addWidget(plot)
    looks.apply_theme(plot)
    plot.resize(600, plot.minimumSizeHint().height())
    plot.show()
    QApplication.processEvents()
    view = plot.canvas
    text_px = QFontMetricsF(theme.font(theme.Size.SMALL)).height()
    for lane in view.lanes:
        assert lane.box.height() >= text_px
        # An item beyond its bounds is not drawn.
        assert all(line.boundingRect() == lane.view.viewRect() for line in (lane.curve, lane.grid, *lane.limits))
    assert all(upper.box.bottom() < lower.box.top() for upper, lower in pairwise(view.lanes))
    assert view.rect().contains(view.lanes[-1].box.toRect())
    labels = [view.times.mapRectToScene(room) for _, room in labels_of(view.times)]
    assert labels
    assert not any(shown.room.intersects(label) for shown in view.overlay.shown for label in labels)


def test_the_ground_is_not_kept_over_a_change_of_theme(qtbot: QtBot) -> None:
    """The map of flight logs stood on white in the dark theme."""
    chart = OverTime()
    qtbot.addWidget(chart)
    chart.show()
    assert chart.view.getViewWidget().cacheMode() == pg.GraphicsView.CacheModeFlag.CacheNone


@pytest.mark.parametrize("percent", [100, 200])
def test_over_time_names_each_of_its_bands_at_every_size_of_text(
    qtbot: QtBot, qapp: QApplication, percent: int
) -> None:
    """At 200 % the three labels lay on each other."""
    theme.zoom(percent)
    Appearance(qapp, Choice.LIGHT)
    chart = OverTime()
    qtbot.addWidget(chart)
    chart.show_stretch(Stretch(100.0, 60.0, ()))
    chart.resize(chart.minimumSizeHint())
    chart.show()
    QApplication.processEvents()
    labels = labels_of(chart.axes["left"])
    assert {text.split("\n")[0] for text, _ in labels} == {"Slowest answer", "Without reply", "Invalid bytes"}
    assert not any(one.intersects(other) for (_, one), (_, other) in combinations(labels, 2))
