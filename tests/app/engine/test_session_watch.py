"""What keeps the screen fresh, on the simulated module: streamed or polled, left as found, doubted when perhaps old."""

import math
from collections.abc import Callable
from itertools import pairwise

import pytest

from app.engine.device import How, StaleReason
from app.engine.identity import Trust
from app.engine.procedure import Ask, Procedure
from app.engine.session import Run
from app.procedures.handshake import handshake
from app.procedures.read import READABLE, read_everything
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import await_flags_free, await_flags_known
from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, Request
from tests.app.engine.test_identity import OPTIONS, trust
from tests.support.line import reference_decoder
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig, end_watch, settled_rig, watched
from tests.support.thorough import some


def test_everything_is_read_first_and_again_after_a_restart() -> None:
    rig, sent = settled_rig(), 0
    watched(rig)
    for _ in range(2):
        rig.step_for(1)
        asked = [
            request.command
            for request in rig.line.requests[sent:]
            if request.is_repeatable and request.command is not HEARTBEAT
        ]
        assert [command for command in asked if command in READABLE][: len(READABLE)] == list(READABLE)
        rig.bench.restart()
        rig.step_until(lambda: rig.session.device.view(0).restarts == 1)
        sent = len(rig.line.requests)


def test_a_stream_of_one_report_a_second_is_a_stream() -> None:
    rig = settled_rig(rate=1, **{"stream-at-boot": True})
    watched(rig)
    rig.step_for(4)
    for _ in range(20):
        rig.step_for(0.37)
        assert rig.session.device.view(rig.clock.now_s).is_streaming
    assert SERIAL_OUTPUT.name not in {request.command.name for request in rig.line.requests}
    end_watch(rig)
    assert rig.bench.module.is_streaming


@pytest.mark.parametrize("stream", ["acknowledged", "silent"])
def test_a_module_that_will_not_stream_is_polled(stream: str) -> None:
    rig = settled_rig(stream=stream)
    watched(rig)
    rig.step_for(10)
    rig.session.device.take_samples()
    rig.step_for(5)
    assert len(rig.session.device.take_samples()) >= 40
    assert rig.line.requests.count(SERIAL_OUTPUT.set(True)) == 1
    rig.bench.restart()
    rig.step_for(5)
    assert rig.line.requests.count(SERIAL_OUTPUT.set(True)) == 2, "the next start may be another module's"


def test_while_streaming_the_slow_values_stay_fresh() -> None:
    rig = settled_rig(rate=1440)
    watched(rig)
    rig.step_for(10)
    view = rig.session.device.view(rig.clock.now_s)
    for key in ("cell_voltage_v", "charging", "light_v", "tilt_deg", "active"):
        assert view.fresh(key, rig.clock.now_s) is not None, key


def test_at_line_rate_no_status_is_lost() -> None:
    rig = settled_rig(rate=1440)
    rig.run(handshake())
    sent_before = rig.session.device.take_samples()
    assert sent_before == []
    rig.session.run_in_background(watch(StreamSwitch(), read_all=False))
    rig.step_for(5)
    end_watch(rig)
    rig.step_for(0.5)
    counters = rig.session.link_view().counters
    samples = rig.session.device.take_samples()
    assert counters.rejected == 0
    statuses = [found for found in reference_decoder.frames(bytes(rig.line.arrived)) if found.raw[:3] == b"Au2"]
    assert len(statuses) > 1440 * 2
    assert len(samples) == len(statuses)
    assert all(earlier.at <= later.at for earlier, later in pairwise(samples))


@pytest.mark.promise("a")
def test_a_restart_casts_doubt_on_everything_until_it_is_read_again() -> None:
    rig = settled_rig(boots=5)
    rig.run(read_everything())
    enable_trigger(rig)
    assert rig.session.device.view(rig.clock.now_s).values["attitude_trigger"].how is How.ACKNOWLEDGED
    rig.bench.restart()
    rig.step_until(lambda: rig.session.device.view(0).restarts == 1, limit_s=20)
    view = rig.session.device.view(rig.clock.now_s)
    assert "attitude_trigger" not in view.values
    assert view.values["freefall_time_s"].stale_reason is StaleReason.RESTARTED
    watched(rig)
    rig.step_for(1)
    again = rig.session.device.view(rig.clock.now_s)
    assert again.fresh("freefall_time_s", rig.clock.now_s) == 1.6
    assert again.fresh("boot_count", rig.clock.now_s) == 6
    assert again.fresh("baud_rate", rig.clock.now_s) == 115200
    rig.bench.restart()
    rig.step_until(lambda: not rig.session.device.view(rig.clock.now_s).is_streaming, limit_s=20)
    rig.step_until(lambda: rig.session.device.view(rig.clock.now_s).restarts == 2, limit_s=20)
    rig.step_until(lambda: rig.session.device.view(rig.clock.now_s).is_streaming, limit_s=20)
    known = rig.session.device.view(rig.clock.now_s).values["freefall_time_s"]
    assert not known.is_stale, "read at once, not when its turn comes"


def _hide_restart(rig: Rig) -> None:
    """In the middle of a heartbeat that is asked for again: its own two count as the answers to those."""
    rig.bench.change(drop=1.0)
    rig.session.run(Run(_ask_heartbeat()))
    rig.step_until(lambda: rig.line.requests[-2:] == [HEARTBEAT.query()] * 2)
    end_faults(rig.bench)
    rig.bench.restart()
    rig.step_for(0.2)


def _show_first_heartbeat(rig: Rig) -> None:
    """Before it is decided that it was a restart."""
    rig.bench.restart()
    rig.step_for(0.01)


@pytest.mark.parametrize(("restart", "is_suspected"), [(_hide_restart, True), (_show_first_heartbeat, False)])
def test_what_may_be_a_restart_leaves_nothing_fresh_that_one_loses(
    restart: Callable[[Rig], None], is_suspected: bool
) -> None:
    """Else the flag would be shown as it had been set, and the module has forgotten it."""
    rig = settled_rig()
    enable_trigger(rig)
    restart(rig)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.restarts == 0
    assert view.is_restart_suspected is is_suspected
    assert "attitude_trigger" not in view.values


def test_a_restart_that_looks_like_late_answers_is_told_by_the_boot_count_at_once() -> None:
    rig = settled_rig()
    rig.run(read_everything())
    enable_trigger(rig)
    watched(rig)
    rig.step_for(4.0)
    _hide_restart(rig)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.restarts == 1
    assert "attitude_trigger" not in view.values


def test_a_late_heartbeat_takes_away_only_until_the_boot_count_is_known() -> None:
    rig, request = settled_rig(), BY_NAME["attitude_trigger"].set(True)
    rig.run(read_everything())
    rig.run(await_flags_free(request))
    rig.run(ask(request))
    rig.bench.change(delay_ms=250)
    rig.run(_ask_heartbeat())
    rig.step_for(0.2)
    end_faults(rig.bench)
    watched(rig)
    rig.step_for(4.0)
    view = rig.session.device.view(rig.clock.now_s)
    assert (view.restarts, view.is_restart_suspected) == (0, False)
    assert view.fresh("attitude_trigger", rig.clock.now_s) is True


def test_what_is_written_while_it_is_in_doubt_stays_as_written() -> None:
    rig = settled_rig()
    rig.run(read_everything())
    enable_trigger(rig)
    rig.bench.change(delay_ms=250)
    rig.run(_ask_heartbeat())
    rig.step_for(0.2)
    rig.bench.change(mute=True)
    enable_trigger(rig)
    end_faults(rig.bench)
    rig.run(read_everything())
    view = rig.session.device.view(rig.clock.now_s)
    assert not view.is_restart_suspected
    assert "attitude_trigger" not in view.values  # nobody knows whether it was carried out


def _ask_heartbeat() -> Procedure[None]:
    yield Ask(HEARTBEAT.query(), (0.2,))


def enable_trigger(rig: Rig) -> None:
    """Enable it, and wait until its acknowledgement counts."""
    request = BY_NAME["attitude_trigger"].set(True)
    rig.run(await_flags_free(request))
    rig.run(ask(request))
    rig.run(await_flags_known())


def ask(request: Request) -> Procedure[None]:
    yield Ask(request)


@pytest.mark.promise("f")
def test_a_module_exchanged_behind_an_open_port_is_never_shown_with_the_values_of_the_former() -> None:
    """It announces no start, and takes its place in less time than it takes to be offline."""
    rig = settled_rig(boots=5, rate=50)
    watched(rig)
    rig.step_for(13)
    rig.silence(0.7)
    rig.bench.module.memory.attitude_threshold = 75
    rig.bench.module.memory.boot_count = 9
    seen = set()
    for _ in range(100):
        rig.step_for(0.01)
        view = rig.session.device.view(rig.clock.now_s)
        assert (view.restarts, view.presence.value) in ((0, "online"), (1, "online"))
        seen.add(tuple(view.fresh(key, rig.clock.now_s) for key in ("attitude_threshold_deg", "boot_count")))
    assert {threshold for threshold, _ in seen} == {None, 75}
    assert {boots for _, boots in seen} == {None, 9}
    assert (75, 9) in seen, "read again at once"
    rig.step_for(5)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.is_streaming
    assert all(view.fresh(key, rig.clock.now_s) is not None for key in view.values)


def test_a_setting_that_reads_otherwise_is_asked_for_again_at_once() -> None:
    """A damaged frame may have said so, or another module."""
    rig, command = settled_rig(), BY_NAME["attitude_threshold"]
    watched(rig)
    rig.step_for(5)
    rig.bench.module.memory.attitude_threshold = 75
    asked = rig.line.requests.count(command.query())
    while rig.session.device.view(rig.clock()).values[command.key].value != 75:
        rig.step_for(0.05)
    rig.step_for(1.0)
    assert rig.line.requests.count(command.query()) >= asked + 2


@pytest.mark.parametrize("lasts_s", [0.7, 0.9, 1.1, 1.3])
@pytest.mark.parametrize("begins_s", [0.0, 0.1, 0.2, 0.3])
@pytest.mark.promise("f")
def test_no_silence_in_which_the_module_could_be_exchanged_is_missed(lasts_s: float, begins_s: float) -> None:
    """Whenever it begins, also while the module streams and nothing but what does not stream is asked."""
    rig = settled_rig()
    watched(rig)
    rig.step_for(5)
    enable_trigger(rig)
    rig.step_for(begins_s)
    rig.silence(lasts_s)
    rig.step_for(0.3)
    assert rig.session.device.view(rig.clock()).known("attitude_trigger", rig.clock()) is None


@pytest.mark.parametrize("is_busy", [False, True])
@pytest.mark.parametrize("lasts_s", [1.4, 1.7, 2.0, 2.5, 4.0])
@pytest.mark.promise("a")
def test_a_module_without_a_name_is_asked_about_after_an_absence(lasts_s: float, *, is_busy: bool) -> None:
    """Whenever it begins, also while something is read."""
    for begins_s in some((0.0, 0.07, 0.15, 0.23, 0.31, 0.4), one_in=2, first=is_busy):
        rig = Rig(OPTIONS, is_attended=True)
        watched(rig)
        rig.step_for(5 + begins_s)
        assert trust(rig) is Trust.UNNAMED
        rig.bench.change(mute=True)
        if is_busy:
            rig.session.run(Run(read_everything()))
        rig.step_for(lasts_s)
        end_faults(rig.bench)
        rig.step_for(4)
        assert trust(rig) is Trust.UNPROVEN, begins_s


def test_where_a_stream_ends_by_itself_everything_that_tells_modules_apart_is_read_at_once() -> None:
    """Exchanged too quickly for a silence, or restarted without its heartbeats."""
    rig = settled_rig(boots=37)
    watched(rig)
    rig.step_for(4)
    rig.bench.module.memory.boot_count = 38
    rig.bench.module._stream_due_s = math.inf
    rig.step_until(lambda: rig.session.device.view(0).values["boot_count"].value == 38, limit_s=2.5)


@pytest.mark.parametrize("begins_s", [0.1, 0.2, 0.4, 0.5, 0.7])
def test_where_a_stream_has_a_gap_everything_that_tells_modules_apart_is_read_at_once(begins_s: float) -> None:
    """Too short for a silence, whenever the questions in between are asked."""
    rig = settled_rig(boots=37, rate=10)
    watched(rig)
    rig.step_for(5 + begins_s)
    rig.silence(0.36)
    rig.bench.module.memory.boot_count = 38
    rig.step_until(lambda: rig.session.device.view(0).values["boot_count"].value == 38, limit_s=1.5)


def test_what_streams_after_a_gap_does_not_say_that_the_module_is_locked_before_its_boot_count_is_read() -> None:
    """Another one may have taken the place of the ACTIVE one, which was pulled out."""
    rig = settled_rig(boots=37, rate=10, active=True)
    watched(rig)
    rig.step_for(5.1)
    rig.silence(0.36)
    rig.bench.module.memory.boot_count = 38
    rig.bench.module.activate(is_active=False)

    def is_read() -> bool:
        values = rig.session.device.view(rig.clock()).values
        assert values["active"].value is True or values["boot_count"].value == 38
        return values["active"].value is False

    rig.step_until(is_read, limit_s=1.5)


def test_a_stream_goes_on_after_a_silence_and_is_still_steered() -> None:
    rig, switch = settled_rig(), StreamSwitch()
    rig.session.run_in_background(watch(switch))
    rig.step_for(5)
    rig.silence(3)
    rig.step_for(5)
    for is_wanted in (False, True):
        switch.is_wanted = is_wanted
        rig.step_for(3)
        assert rig.bench.module.is_streaming is is_wanted
