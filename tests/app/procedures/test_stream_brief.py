"""A stream that is asked for: on within half a second, and left as it was found where that can be known."""

from concurrent.futures import Future
from itertools import pairwise

import pytest

from app.engine.device import DeviceView, How, Known
from app.engine.procedure import Ask
from app.procedures.handshake import handshake
from app.procedures.stream import (
    BRIEF_LISTEN_S,
    MIN_EXPECTED,
    StreamSwitch,
    _is_listening,
    _StreamProgress,
    _turn,
    watch,
)
from app.store.stream_memory import StreamMemory
from protocol.catalogue import SERIAL_OUTPUT
from protocol.events import Sent
from tests.support.line.sim_line import Rig, end_watch, engine_view

ON, OFF = SERIAL_OUTPUT.set(True), SERIAL_OUTPUT.set(False)


def begun(**options: object) -> tuple[Rig, StreamSwitch]:
    """Greeted and watched as the command line does; half a second after the port was opened."""
    rig, switch = Rig({"uptime": 60, **options}), StreamSwitch(is_recorded=True)
    rig.run(handshake())
    rig.session.run_in_background(watch(switch, read_all=False, listens_briefly=True))
    rig.step_for(rig.session.opened_at + 0.5 - rig.clock.now_s)
    return rig, switch


def sets(rig: Rig) -> list[object]:
    return [request for request in rig.line.requests if request.command is SERIAL_OUTPUT]


@pytest.mark.parametrize("rate", [20, 50, 200, 1440])
@pytest.mark.promise("c")
def test_it_streams_at_its_full_rate_within_half_a_second(rate: int) -> None:
    rig, switch = begun(rate=rate)
    assert sets(rig) == [ON]
    rig.session.device.take_samples()
    rig.step_for(1.0)
    samples = rig.session.device.take_samples()
    assert len(samples) == pytest.approx(rate, rel=0.01, abs=2)
    assert switch.began_at is not None
    assert 0 < switch.began_at - rig.session.opened_at < 0.25
    end_watch(rig)
    assert sets(rig) == [ON, OFF]
    assert not switch.is_unknown_before


@pytest.mark.parametrize("rate", [20, 50, 200, 1440])
@pytest.mark.promise("c")
def test_one_that_was_on_is_left_on(rate: int) -> None:
    assert rate * BRIEF_LISTEN_S > MIN_EXPECTED
    rig, switch = begun(rate=rate, **{"stream-at-boot": True})
    assert switch.began_at == rig.session.opened_at
    rig.step_for(3)
    end_watch(rig)
    assert sets(rig) == []
    assert rig.bench.module.is_streaming


@pytest.mark.parametrize("rate", [1, 50])
def test_while_it_streams_a_question_is_asked_three_times_a_second(rate: int) -> None:
    """In nothing else its silence shows."""
    rig, _switch = begun(rate=rate, **{"stream-at-boot": True})
    rig.step_for(2.5)
    rig.session.take_events()
    rig.step_for(5)
    times = [event.at for event in rig.session.take_events() if isinstance(event, Sent)]
    assert max(after - before for before, after in pairwise(times)) < 0.4
    end_watch(rig)


@pytest.mark.promise("c")
def test_of_a_slow_one_it_is_said_that_it_may_have_been_on() -> None:
    rig, switch = begun(rate=2)
    rig.step_for(5)
    assert not switch.is_unknown_before
    end_watch(rig)
    assert sets(rig) == [ON, OFF]
    assert switch.is_unknown_before


def test_one_report_is_enough_to_listen_longer() -> None:
    """A slow stream that happens to show at once."""
    rig = Rig({"uptime": 60, "rate": 3, "stream-at-boot": True})
    rig.step_until(rig.session.device.take_samples)
    switch = StreamSwitch(is_recorded=True)
    rig.session.run_in_background(watch(switch, read_all=False, listens_briefly=True))
    rig.step_for(4)
    end_watch(rig)
    assert sets(rig) == []
    assert rig.bench.module.is_streaming


@pytest.mark.parametrize("stream", ["acknowledged", "silent"])
def test_one_that_does_not_stream_is_polled(stream: str) -> None:
    rig, switch = begun(stream=stream)
    rig.step_for(3)
    rig.session.device.take_samples()
    rig.step_for(2)
    assert len(rig.session.device.take_samples()) > 15
    assert switch.began_at is not None
    end_watch(rig)
    assert not switch.is_unknown_before


@pytest.mark.parametrize(
    ("now", "is_streamed", "is_brief", "is_listening"),
    [
        (0.2, False, True, False),
        (0.19, False, True, True),
        (0.2, True, True, True),
        (0.2, False, False, True),
        (2.2, True, True, False),
        (2.2, False, False, False),
    ],
)
def test_listening_ends_at_its_limit(now: float, is_streamed: bool, is_brief: bool, is_listening: bool) -> None:
    values = {"active": Known(False, How.STREAMED, 0.0)} if is_streamed else {}
    assert (
        _is_listening(_StreamProgress(StreamMemory(), is_brief), engine_view(now, DeviceView(values))) is is_listening
    )


@pytest.mark.parametrize(("now", "first"), [(0.49, "boot_count"), (0.5, "status")])
def test_a_status_is_polled_half_a_second_after_the_opening(now: float, first: str) -> None:
    course = _StreamProgress(StreamMemory(), listens_briefly=True, intent=Future())
    asked = next(_turn(course, StreamSwitch(), engine_view(now), read_all=False))
    assert isinstance(asked, Ask)
    assert asked.request.command.name == first


@pytest.mark.parametrize(("after_s", "is_ours"), [(1.99, True), (2.0, False)])
def test_a_stream_that_appears_after_a_restart_is_ours_if_that_came_about_when_it_was_switched_on(
    after_s: float, is_ours: bool
) -> None:
    course = _StreamProgress(StreamMemory(), switched_on_at=100.0)
    view = engine_view(100.0 + after_s)
    restarted = view._replace(device=view.device._replace(restarts=1))
    next(_turn(course, StreamSwitch(), restarted, read_all=False))
    assert (course.may_be_ours, course.has_given_up) == (is_ours, False)


def test_it_goes_on_listening_where_it_is_not_asked_for() -> None:
    """The window, where a page shows the polled status meanwhile."""
    rig = Rig({"uptime": 60})
    rig.run(handshake())
    rig.session.run_in_background(watch(StreamSwitch(), read_all=False))
    rig.step_for(2.0)
    assert sets(rig) == []
