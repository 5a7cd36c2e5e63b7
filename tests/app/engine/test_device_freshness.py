"""How long a value counts as current: by the stream's own rate, and one restart is one."""

import random
from itertools import pairwise

import pytest

from app.engine.device import Device, How
from app.engine.motion import WATCHED_FOR_S, MotionExtremes, MotionWatch
from app.procedures.read import read_everything
from app.safety.acts import Act
from app.safety.interlocks import Interlock, interlock_inputs, refusals
from protocol.catalogue import STATUS
from protocol.events import Received, Role, WentOnline
from protocol.frame import Direction, Frame, encode_long
from protocol.link_states import Presence
from protocol.messages import Status, decode
from tests.support.line.sim_line import Rig, settled_rig, watched

RAW = encode_long(STATUS.code, bytes((1, 10, 0, 0)))


def streamed(device: Device, at: float) -> None:
    frame = Frame(Direction.MODULE_TO_HOST, RAW)
    device.apply(Received(frame, decode(RAW), Role.STREAMED, at))


@pytest.mark.parametrize("period_s", [0.02, 0.5, 1.0])
def test_a_stream_with_jitter_never_flickers_to_stale(period_s: float) -> None:
    device, source = Device(), random.Random(1)
    device.apply(WentOnline(0.0))
    jitter_s = 0.03 if period_s >= 0.5 else 0.0
    arrivals = [turn * period_s + source.uniform(-jitter_s, jitter_s) for turn in range(1, 40)]
    streamed(device, arrivals[0])
    for earlier, later in pairwise(arrivals[1:]):
        streamed(device, earlier)
        just_before = later - 0.001
        view = device.view(just_before)
        assert view.fresh("tilt_deg", just_before) == 1
        named = interlock_inputs(view, just_before, must_be_proven=False)
        assert Interlock.FRESH_STATUS not in [one.condition for one in refusals(Act.SHUTDOWN, named)]


@pytest.mark.parametrize(("period_s", "stale_after_s"), [(0.02, 1.0), (0.5, 1.0), (0.9, 1.35), (1.0, 1.5)])
def test_a_stream_that_stops_is_stale_by_its_own_rate(period_s: float, stale_after_s: float) -> None:
    device = Device()
    for turn in range(4):
        streamed(device, turn * period_s)
    last = 3 * period_s
    view = device.view(last)
    assert view.values["tilt_deg"].how is How.STREAMED
    for late_s, is_fresh in ((stale_after_s - 0.01, True), (stale_after_s + 0.01, False)):
        assert (view.fresh("tilt_deg", last + late_s) is not None) is is_fresh


@pytest.mark.parametrize("boots", [5, 255])
def test_one_restart_is_counted_once_and_everything_is_read_once(boots: int) -> None:
    rig = settled_rig(boots=boots)
    rig.run(read_everything())
    watched(rig)
    rig.step_for(4.0)
    asked_before = len(rig.line.requests)
    rig.bench.restart()
    rig.step_for(3.0)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.restarts == 1
    assert view.fresh("boot_count", rig.clock.now_s) == (boots + 1) % 256
    asked = [request.command.name for request in rig.line.requests[asked_before:]]
    assert asked.count("freefall_time") == 1


def test_a_second_restart_that_nobody_heard_is_counted() -> None:
    rig = Rig()
    rig.run(read_everything())
    rig.bench.restart()
    rig.step_for(0.5)
    assert rig.session.device.view(rig.clock.now_s).restarts == 1
    rig.bench.module.memory.boot_count += 1
    rig.run(read_everything())
    assert rig.session.device.view(rig.clock.now_s).restarts == 2
    assert rig.session.device.view(rig.clock.now_s).presence is Presence.ONLINE


def fed(*reports: tuple[float, int, float]) -> MotionWatch:
    watch = MotionWatch()
    for at, tilt_deg, acceleration_g in reports:
        watch.feed(Status(tilt_deg, acceleration_g, False, False), at)
    return watch


def test_the_extremes_of_all_reports_within_and_between_slots() -> None:
    watch = fed((1.0, 5, 1.0), (1.0625, 9, 0.8), (1.0938, 7, 1.3), (1.5, 3, 1.0), (2.0, 4, 1.1))
    assert watch.view(2.0) == MotionExtremes(1.0, 2.0, 3, 9, 0.8, 1.3)
    seen = watch.view(2.0)
    assert seen is not None
    assert seen.tilt_change_deg == 6
    watch.clear()
    assert watch.view(2.0) is None


def test_a_report_counts_for_two_and_a_half_seconds() -> None:
    assert WATCHED_FOR_S == 2.5
    watch = fed((1.0, 9, 1.3), (1.25, 5, 1.0))
    assert watch.view(3.5) == MotionExtremes(1.0, 1.25, 5, 9, 1.0, 1.3)
    assert watch.view(3.625) == MotionExtremes(1.25, 1.25, 5, 5, 1.0, 1.0)
    assert watch.view(3.75) is not None
    assert watch.view(3.875) is None


def test_a_slot_lasts_a_tenth_of_a_second() -> None:
    for later_s, since in ((0.09375, 1.0), (0.125, 1.125)):
        watch = fed((1.0, 9, 1.0), (1.0 + later_s, 5, 1.0))
        seen = watch.view(1.0 + later_s + WATCHED_FOR_S)
        assert seen is not None
        assert seen.since == since, "the slot is dropped when its last report is too old"
