"""Marks, limits and axes of the plots: nothing important is hidden, nothing overlaps."""

from itertools import combinations, pairwise

import pytest
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.samples.ring_buffers import Series
from tests.support.window.painted_text import watching
from tests.support.window.steps import find
from tests.ui.plots.test_time_plot import NOW_S, Bench
from ui.plots.canvas import Canvas
from ui.plots.limits import LimitLine, apart, word_places
from ui.plots.time_plot import TimePlot
from ui.plots.view import Lane, Mark, Scale
from ui.style import appearance, theme
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Meaning


@pytest.fixture
def bench(qapp: QApplication, qtbot: QtBot) -> Bench:
    appearance.apply(qapp, LIGHT)
    return Bench(qtbot)


def test_the_most_important_mark_keeps_its_icon(bench: Bench) -> None:
    """Whichever comes first: two marks 0.2 s apart, of which only one icon has room."""
    for first, second in (("triggered", "activated"), ("activated", "triggered")):
        bench.plot.reset()
        for number, word in enumerate((first, second)):
            rank, icon = (0, Icon.PARACHUTE) if word == "triggered" else (2, Icon.ACTIVE)
            bench.plot.add_mark(Mark(NOW_S - 20 + 0.2 * number, word, icon, Meaning.DANGER, rank))
        with watching() as drawn:
            bench.plot.draw(NOW_S)
            bench.canvas.repaint()
        assert [one.text for one in drawn if one.text in (first, second)] == ["triggered"]


@pytest.mark.parametrize("ago_s", [59.5, 59.0, 58.0, 57.0, 30.0])
def test_the_title_of_the_first_plot_is_beside_a_mark(bench: Bench, ago_s: float) -> None:
    """The icon and the word of the mark are in the row of the title."""
    bench.plot.add_mark(Mark(NOW_S - ago_s, "triggered", Icon.PARACHUTE, Meaning.DANGER))
    with watching() as drawn:
        bench.plot.draw(NOW_S)
        bench.canvas.repaint()
    title, word = (next(one for one in drawn if one.text == text) for text in ("Tilt", "triggered"))
    assert not title.place.intersects(word.place.adjusted(-17, 0, 0, 0))  # with the icon before the word


def test_no_data_is_never_written_over_the_word_of_a_limit(bench: Bench) -> None:
    stale = bench.canvas.lanes[0].lane.limits[0].stale
    assert stale is not None
    bench.fire.put(NOW_S, None)
    stale.put(NOW_S, 45)  # in the middle
    found = 0
    for seconds in range(2, 30):
        with watching() as drawn:
            bench.plot.draw(NOW_S + seconds)
            bench.canvas.repaint()
        gaps = [one.place for one in drawn if one.text == "no data"]
        words = [one.place for one in drawn if one.text == "stale"]
        found += len(gaps)
        assert not any(one.intersects(other) for one in gaps for other in words)
    assert found


@pytest.mark.parametrize("places", [[50.0, 51.0], [2.0, 1.0, 3.0], [98.0, 99.0, 99.5], [0.0, 0.0], [10.0, 90.0], []])
def test_labels_of_limits_never_overlap(places: list[float]) -> None:
    found = sorted(apart(places, 15, 0, 100))
    assert all(lower - upper >= 14.99 for upper, lower in pairwise(found))
    assert all(-0.01 <= one <= 100.01 for one in found)
    if places == [10.0, 90.0]:
        assert found == places


@pytest.mark.parametrize("ys", [(50.0, 50.0), (50.0, 58.0), (50.0, 52.0, 54.0), (10.0, 90.0)])
def test_words_of_limits_never_overlap(bench: Bench, ys: tuple[float, ...]) -> None:
    line = LimitLine(0, 300, 0, LIGHT.muted, "stale", ())
    found = word_places([line._replace(y=y) for y in ys], QFontMetricsF(theme.font(theme.Size.SMALL, is_bold=True)))
    assert not any(one.intersects(other) for (_, one), (_, other) in combinations(found, 2))
    assert found


def test_a_stale_limit_stays_and_says_that_it_is_stale(bench: Bench) -> None:
    stale = bench.canvas.lanes[0].lane.limits[0].stale
    assert stale is not None
    bench.fire.put(NOW_S, None)
    stale.put(NOW_S, 60)
    with watching() as drawn:
        bench.plot.draw(NOW_S + 30)
        bench.canvas.repaint()
    assert {"60° fires", "stale"} <= {one.text for one in drawn}
    lane = bench.canvas.lanes[0]
    y = round(lane.y(60))
    grey = [p for p in bench.pixels(LIGHT.muted) if abs(p.y() - y) <= 1 and p.x() > lane.box.center().x()]
    assert grey
    assert not [p for p in bench.pixels(LIGHT.danger.ink) if p.x() > lane.box.center().x() + 2]


def test_an_axis_grows_and_does_not_shrink_while_it_follows(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 1, NOW_S + 2], [120, 10])
    bench.plot.draw(NOW_S + 2)
    bench.tilt.append([NOW_S + 70, NOW_S + 90], [10, 10])
    bench.plot.draw(NOW_S + 90)  # the peak is out of sight
    assert bench.canvas.lanes[0].scale == Scale(0, 180, 45)
    bench.plot.choose_window(10)
    assert bench.canvas.lanes[0].scale == Scale(0, 90, 30)


def test_a_limit_beyond_the_scale_widens_it(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, 120)
    bench.plot.draw(NOW_S)
    assert bench.canvas.lanes[0].scale == Scale(0, 180, 45)


def test_in_a_low_window_the_first_plots_stay_high_enough_to_read(bench: Bench, qtbot: QtBot) -> None:
    scales = (Scale(0, 4, 2),)
    weights = {"Tilt": 5, "Acceleration": 3, "Light": 2, "Cell voltage": 2}
    plot = TimePlot([Lane(title, "", Series(), scales, weight=one) for title, one in weights.items()], bench.texts)
    qtbot.addWidget(plot)
    plot.show()
    canvas = find(plot, Canvas, "time-plot-canvas")
    seen = {}
    for height in (600, 300, 240, 600):
        plot.resize(600, height)
        QApplication.processEvents()
        seen[height] = [lane.lane.title for lane in canvas.lanes]
        canvas.set_cursor(None)
        canvas.set_cursor(0.5)
        assert all(f"{title} no data" in plot.reading for title in weights)
        text_px = QFontMetricsF(theme.font(theme.Size.SMALL)).height()
        assert len(canvas.lanes) == 2 or canvas.lanes[-1].box.height() >= text_px
        assert all(one.box.bottom() < other.box.top() for one, other in pairwise(canvas.lanes))
    assert seen[600] == list(weights)
    assert seen[240] == ["Tilt", "Acceleration"]
