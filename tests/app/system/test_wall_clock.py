"""The time of day stays right over a sleep, in which the monotonic clock stands still."""

from datetime import datetime

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.captures.traffic_buffer import TrafficBuffer
from app.engine.conversation import StatusSample
from app.system.wall_clock import JUMP_S, WallClock
from tests.support.records.recordings_made import NOON, Clock, asked
from tests.support.window.live_bench import live_bench
from ui.pages.diagnosis.traffic_model import Column, TrafficModel

NIGHT_S = 8 * 3600.0


def clocks() -> tuple[Clock, WallClock]:
    clock = Clock()
    return clock, WallClock(clock, clock.wall)


def test_each_time_keeps_the_offset_of_its_moment() -> None:
    clock, wall = clocks()
    clock.now_s = 1010.0
    assert not wall.poll()
    clock.wall_offset_s += NIGHT_S
    clock.now_s = 1010.1
    assert wall.poll()
    assert not wall.poll()
    assert wall.at(1009.0) == NOON.timestamp() + 9.0
    assert wall.at(1010.05) == NOON.timestamp() + 10.05 + NIGHT_S
    assert wall.offset_s == clock.wall_offset_s


def test_a_time_server_at_work_changes_nothing() -> None:
    clock, wall = clocks()
    clock.wall_offset_s += JUMP_S
    assert not wall.poll()


def test_rows_of_the_traffic_bear_the_time_of_day_at_which_they_came(qapp: QApplication) -> None:
    clock, wall = clocks()
    model = TrafficModel()
    model.wall = wall
    for at in (1000.0, 1001.0):
        clock.now_s = at
        model.append([asked(at)])
        clock.wall_offset_s += NIGHT_S
    model.show_new()
    times = [model.index(row, Column.TIME.value).data() for row in (0, 1)]
    wanted = [datetime.fromtimestamp(NOON.timestamp() + after) for after in (0.0, 1.0 + NIGHT_S)]  # noqa: DTZ006
    assert times == [f"{one:%H:%M:%S}.000" for one in wanted]


def test_a_capture_says_when_its_first_entry_came() -> None:
    clock, wall = clocks()
    buffer = TrafficBuffer()
    buffer.wall = wall
    buffer.feed([asked(1000.0)])
    clock.now_s, clock.wall_offset_s = 1001.0, clock.wall_offset_s + NIGHT_S
    buffer.feed([asked(1001.0)])
    assert buffer.started_at() == NOON


def test_the_live_page_starts_over_with_the_right_time(qtbot: QtBot, qapp: QApplication) -> None:
    clock, wall = clocks()
    with live_bench(qtbot, qapp) as bench:
        bench.page.wall = wall
        bench.say()
        assert len(bench.page.data.tilt) == 1
        clock.now_s, clock.wall_offset_s = 1000.02, clock.wall_offset_s + NIGHT_S
        bench.now_s = 1000.02
        bench.hand_over(StatusSample(1000.02, 9, 1.0, False, False))
        qtbot.waitUntil(lambda: bench.page.data.tilt.exact_since_s == 1000.02)
        bench.page.refresh()
        assert bench.page.data.tilt.last == (1000.02, 9.0)
        assert len(bench.page.data.tilt) == 1
        assert bench.page._origin().wall_offset_s == clock.wall_offset_s
        assert bench.page.plot.canvas.wall_offset_s == clock.wall_offset_s
