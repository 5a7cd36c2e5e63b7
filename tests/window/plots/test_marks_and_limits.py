"""Marks, limits and axes of the plots, the charts of the link and the picture of a record: nothing overlaps."""

from itertools import combinations

import pytest

from tests.support.window.steps import given
from tests.window.plots.plot_bench import NOW_S, Bench
from ui.plots.lanes import Mark
from ui.style.icons import Icon
from ui.style.theme import LIGHT, Meaning


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


@pytest.mark.parametrize("ago_s", [59.0, 57.0])
def test_no_word_covers_another(bench: Bench, ago_s: float) -> None:
    """The icon and the word of a mark are in the row of the first title; gaps and stale limits are in the lane."""
    bench.plot.add_marks([Mark(NOW_S - ago_s, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 45)  # in the middle
    count = 0
    for seconds in range(0, 30, 3):
        bench.plot.draw(NOW_S + seconds)
        count += "no data" in bench.words
        for first, second in combinations(bench.written, 2):
            assert not first.room.intersects(second.room), (first.what, second.what)
    assert {"Tilt", "Acceleration"} <= set(bench.words)
    assert count > 5


# Limits


def test_a_limit_stays_in_the_past_as_it_was(bench: Bench) -> None:
    bench.fire.put(NOW_S - 30, 75)
    bench.plot.draw(NOW_S)
    firm = bench.lane.limits[0]
    x, y = firm.getData()
    assert x.tolist() == pytest.approx([-60, -30, -30, 0], abs=0.2)
    assert y.tolist() == [60, 60, 75, 75]
    assert "75° fires" in bench.words
    bench.fire.put(NOW_S - 1, None)
    bench.plot.draw(NOW_S + 60)
    assert firm.getData()[0].tolist() == []
    assert "75° fires" not in bench.words


@pytest.mark.promise("g")
def test_a_stale_limit_stays_greyed_and_says_that_it_is_stale(bench: Bench) -> None:
    bench.fire.put(NOW_S, None)
    bench.stale.put(NOW_S, 60)
    bench.plot.draw(NOW_S + 30)
    assert "60° fires?" in bench.words
    label = next(shown for shown in bench.written if shown.what == "60° fires?")
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
