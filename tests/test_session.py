"""Procedures on the simulated module, on a fake clock: what is known, how, and what was sent for it."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from app.device import Doubt, How
from app.procedure import Ask, Cancelled, PortLost, Procedure
from app.procedures.find import find_rate
from app.procedures.greet import Silence, greet
from app.procedures.history import read_history
from app.procedures.lock import lock
from app.procedures.read import READABLE, read_everything
from app.procedures.stream import StreamSwitch, watch
from app.session import Run
from app.transport import PortError, PortTrouble
from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, Hazard
from protocol.messages import TriggerRecord
from tests import reference_decoder
from tests.sim_line import Rig

SETTLED = {"uptime": 60, "noise": 0}


def rig_with(**options: object) -> Rig:
    return Rig(SETTLED | options)


def test_reading_everything_says_what_the_module_holds() -> None:
    rig = rig_with(boots=37, cell=4.0)
    everything = rig.run(read_everything())
    assert everything.errors == {}
    assert everything.status is not None
    assert everything.status.acceleration_g == 1.0
    assert everything.values == {
        "boot_count": 37,
        "cell_voltage_v": 4.0,
        "charging": False,
        "light_v": pytest.approx(0.3),
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
    }
    view = rig.session.device.view(rig.clock.now_s)
    assert view.values["freefall_time_s"].how is How.READ
    assert "attitude_trigger" not in view.values
    assert view.values["baud_rate"].value == 115200


def test_reading_everything_costs_its_exchanges_and_no_more() -> None:
    rig = rig_with(delay_ms=3)
    rig.run(greet())
    start_s = rig.clock.now_s
    rig.run(read_everything())
    took_s = rig.clock.now_s - start_s
    trips = rig.session.link_view()
    assert trips.round_trip_median_s is not None
    assert took_s <= 1.3 * len(READABLE) * trips.round_trip_median_s


@pytest.mark.parametrize("procedure", [greet, read_everything, read_history, find_rate])
@pytest.mark.parametrize("options", [{}, {"drop": 0.3}, {"corrupt": 0.05}, {"double": 0.5}, {"stream-at-boot": True}])
def test_what_only_reads_sends_nothing_but_questions(procedure: Callable, options: dict) -> None:  # type: ignore[type-arg]
    rig = rig_with(**options)
    rig.run(procedure())
    assert {request.hazard for request in rig.line.requests} <= {Hazard.NONE}


@pytest.mark.parametrize(
    "options",
    [
        {"voltage-code": "34"},
        {"voltage-code": "35"},
        {"ack": "one"},
        {"double": 1.0},
        {"split-ms": 30},
        {"delay-ms": 300},
        {"stream-at-boot": True, "rate": 1440},
    ],
)
def test_reading_everything_holds_in_every_dialect(options: dict[str, object]) -> None:
    rig = rig_with(cell=3.8, **options)
    everything = rig.run(read_everything())
    assert everything.errors == {}
    assert everything.values["cell_voltage_v"] == 3.8


def test_half_of_the_replies_lost_is_said_and_never_guessed() -> None:
    for seed in range(20):
        rig = rig_with(drop=0.5, seed=seed, cell=3.8, boots=9)
        everything = rig.run(read_everything())
        for key, value in everything.values.items():
            assert value == pytest.approx(
                {
                    "boot_count": 9,
                    "cell_voltage_v": 3.8,
                    "charging": False,
                    "light_v": 0.3,
                    "light_threshold_v": 1.8,
                    "attitude_threshold_deg": 60,
                    "freefall_acceleration_g": 0.5,
                    "freefall_time_s": 1.6,
                }[key]
            )


def test_a_code_that_is_not_answered_is_one_error_among_values() -> None:
    rig = rig_with(**{"mute-codes": "14"})
    everything = rig.run(read_everything())
    assert list(everything.errors) == ["light_v"]
    assert (everything.errors["light_v"].attempts, everything.errors["light_v"].waited_s) == (3, 1.0)
    assert len(everything.values) == len(READABLE) - 2


def test_a_module_that_falls_silent_ends_the_reading_soon() -> None:
    rig = rig_with()
    rig.run(greet())
    rig.bench.change(mute=True)
    start_s = rig.clock.now_s
    everything = rig.run(read_everything())
    assert everything.is_line_dead
    assert rig.clock.now_s - start_s < 2.6


@pytest.mark.parametrize(
    ("options", "silence"),
    [
        ({"mute": True}, Silence.NOTHING),
        ({"mute": True, "echo": True}, Silence.ECHO),
        ({"baud": 9600}, Silence.NOTHING),
        ({"baud": 57600, "stream-at-boot": True}, Silence.GARBAGE),
        ({"mute-codes": "01", "stream-at-boot": True}, Silence.OTHER_FRAMES),
    ],
)
def test_no_answer_says_what_was_seen_instead(options: dict[str, object], silence: Silence) -> None:
    rig = rig_with(**options)
    start_s = rig.clock.now_s
    greeting = rig.run(greet())
    assert greeting.silence is silence
    assert rig.clock.now_s - start_s < 2


@pytest.mark.parametrize("rate", [4800, 9600, 19200, 38400, 57600, 115200])
def test_the_rate_is_found_wherever_it_is(rate: int) -> None:
    rig = rig_with(baud=rate)
    found = rig.run(find_rate(115200))
    assert found.baud_rate == rate
    assert found.tried[0] == 115200
    assert found.tried[-1] == rate
    assert rig.line.baud_rate == rate


def test_no_rate_is_found_where_nothing_answers_and_the_port_keeps_its_own() -> None:
    rig = rig_with(mute=True)
    found = rig.run(find_rate(57600))
    assert found.baud_rate is None
    assert found.tried == (57600, 115200, 38400, 19200, 9600, 4800)
    assert rig.line.baud_rate == 115200


@pytest.mark.parametrize("count", [0, 1, 9])
@pytest.mark.parametrize("records", ["together", "spaced", "pieces"])
@pytest.mark.parametrize("empty", ["none", "zeros", "ones"])
def test_e06_e07_all_records_and_no_empty_slot(count: int, records: str, empty: str) -> None:
    rig = rig_with(history=count, records=records, **{"empty-slots": empty})
    history = rig.run(read_history())
    assert history.is_confirmed
    assert len(history.records) == count
    assert history.empty_slots == (9 - count if empty != "none" else 0)


def test_records_lost_on_the_way_are_asked_for_again() -> None:
    complete = 0
    for seed in range(10):
        rig = rig_with(history=9, corrupt=0.004, records="spaced", seed=seed)
        history = rig.run(read_history())
        assert all(isinstance(record, TriggerRecord) for record in history.records)
        complete += len(history.records) == 9
    assert complete >= 8


def test_records_come_while_it_streams() -> None:
    rig = rig_with(history=9, records="spaced", rate=1440, **{"stream-at-boot": True})
    assert len(rig.run(read_history()).records) == 9


def test_lock_is_sent_once_and_believed_only_when_the_module_says_so() -> None:
    rig = rig_with(active=True)
    locked = rig.run(lock())
    assert (locked.is_acknowledged, locked.is_locked) == (True, True)
    assert [request.command.name for request in rig.line.requests] == ["activation", "status", "status"]
    assert not rig.bench.state().is_active


def watched(rig: Rig, switch: StreamSwitch | None = None) -> StreamSwitch:
    switch = switch or StreamSwitch()
    rig.session.run_in_background(watch(switch))
    return switch


def end_watch(rig: Rig) -> None:
    background = rig.session.background
    assert background is not None
    background.cancel()
    rig.step_until(lambda: rig.session.background is None, limit_s=5)


def test_the_stream_is_switched_on_and_off_again() -> None:
    rig = rig_with(rate=50)
    watched(rig)
    rig.step_for(4)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.is_streaming
    assert view.stream_hz == pytest.approx(50, rel=0.1)
    assert view.values["serial_output"].how is How.STREAMED
    end_watch(rig)
    assert not rig.bench.state().is_streaming


def test_a_module_that_streamed_before_is_left_streaming() -> None:
    rig = rig_with(rate=20, **{"stream-at-boot": True})
    watched(rig)
    rig.step_for(4)
    end_watch(rig)
    assert rig.bench.state().is_streaming
    assert SERIAL_OUTPUT.name not in {request.command.name for request in rig.line.requests}


def test_a_stream_of_one_report_a_second_is_a_stream() -> None:
    rig = rig_with(rate=1, **{"stream-at-boot": True})
    watched(rig)
    rig.step_for(4)
    for _ in range(20):
        rig.step_for(0.37)
        assert rig.session.device.view(rig.clock.now_s).is_streaming
    assert SERIAL_OUTPUT.name not in {request.command.name for request in rig.line.requests}
    end_watch(rig)
    assert rig.bench.state().is_streaming


@pytest.mark.parametrize("stream", ["acknowledged", "silent"])
def test_a_module_that_will_not_stream_is_polled(stream: str) -> None:
    rig = rig_with(stream=stream)
    watched(rig)
    rig.step_for(10)
    rig.session.device.take_samples()
    rig.step_for(5)
    assert len(rig.session.device.take_samples()) >= 40
    asked = [request for request in rig.line.requests if request == SERIAL_OUTPUT.set(True)]
    assert len(asked) == 1


def test_while_streaming_the_slow_values_stay_fresh() -> None:
    rig = rig_with(rate=1440)
    watched(rig)
    rig.step_for(10)
    view = rig.session.device.view(rig.clock.now_s)
    for key in ("cell_voltage_v", "charging", "light_v", "tilt_deg", "active"):
        assert view.fresh(key, rig.clock.now_s) is not None, key


def test_at_line_rate_no_status_is_lost() -> None:
    rig = rig_with(rate=1440)
    rig.run(greet())
    sent_before = rig.session.device.take_samples()
    assert sent_before == []
    rig.session.run_in_background(watch(StreamSwitch(), read_all=False))
    rig.step_for(20)
    end_watch(rig)
    rig.step_for(0.5)
    counters = rig.session.link_view().counters
    samples = rig.session.device.take_samples()
    assert counters.rejected == 0
    statuses = [found for found in reference_decoder.frames(bytes(rig.line.arrived)) if found.raw[:3] == b"Au2"]
    assert len(statuses) > 1440 * 15
    assert len(samples) == len(statuses)
    assert all(earlier.at <= later.at for earlier, later in pairwise(samples))


def test_a_restart_casts_doubt_on_everything_until_it_is_read_again() -> None:
    rig = rig_with(boots=5)
    rig.run(read_everything())
    rig.run(_set_trigger())
    assert rig.session.device.view(rig.clock.now_s).values["attitude_trigger"].how is How.ACKNOWLEDGED
    rig.bench.restart()
    rig.step_until(lambda: rig.session.device.view(0).restarts == 1, limit_s=20)
    view = rig.session.device.view(rig.clock.now_s)
    assert "attitude_trigger" not in view.values
    assert view.values["freefall_time_s"].doubt is Doubt.RESTARTED
    watched(rig)
    rig.step_for(1)
    again = rig.session.device.view(rig.clock.now_s)
    assert again.fresh("freefall_time_s", rig.clock.now_s) == 1.6
    assert again.fresh("boot_count", rig.clock.now_s) == 6


def _set_trigger() -> Procedure[None]:
    yield Ask(BY_NAME["attitude_trigger"].set(True))


def test_a_silent_module_goes_offline_and_what_was_known_is_stale() -> None:
    rig = rig_with()
    watched(rig)
    rig.step_for(3)
    rig.bench.change(mute=True)
    rig.step_for(2)
    view = rig.session.device.view(rig.clock.now_s)
    assert view.presence.value == "offline"
    assert all(known.doubt is Doubt.LINK_LOST for known in view.values.values())
    rig.bench.heal()
    rig.step_for(4)
    assert rig.session.device.view(rig.clock.now_s).fresh("freefall_time_s", rig.clock.now_s) == 1.6


def test_a_live_value_grows_stale_with_age() -> None:
    rig = rig_with()
    rig.run(read_everything())
    view = rig.session.device.view(rig.clock.now_s)
    assert view.fresh("active", rig.clock.now_s) is False
    later = view.known("active", rig.clock.now_s + 1.5)
    assert later is not None
    assert later.doubt is Doubt.AGED
    assert view.fresh("freefall_time_s", rig.clock.now_s + 3600) == 1.6


def test_a_cancelled_procedure_ends_at_once() -> None:
    rig = rig_with(mute=True)
    run = Run(read_everything())
    rig.session.run(run)
    rig.step_for(0.1)
    run.cancel()
    start_s = rig.clock.now_s
    rig.step_until(lambda: run.is_done)
    assert rig.clock.now_s - start_s < 0.1
    assert isinstance(run.error, Cancelled)


def test_a_lost_port_ends_every_procedure() -> None:
    rig = rig_with()
    watched(rig)
    run = Run(find_rate())
    rig.session.run(run)
    rig.bench.unplug()
    with pytest.raises(PortError) as lost:
        rig.step_for(1)
    assert lost.value.trouble is PortTrouble.LOST
    rig.session.close(why=lost.value)
    assert run.error is lost.value
    assert rig.line.is_closed
    assert all(known.is_stale for known in rig.session.device.view(0).values.values())


def test_closing_without_a_reason_says_port_lost() -> None:
    rig = rig_with(mute=True)
    run = Run(greet())
    rig.session.run(run)
    rig.session.close()
    rig.session.close()
    assert isinstance(run.error, PortLost)


def test_a_second_procedure_waits_for_the_first() -> None:
    rig = rig_with()
    first, second = Run(read_everything()), Run(greet())
    rig.session.run(first)
    rig.session.run(second)
    rig.step_until(lambda: first.is_done)
    assert not second.is_done
    rig.step_until(lambda: second.is_done)
    assert rig.line.requests[-1] == HEARTBEAT.query()


def test_an_urgent_procedure_goes_first_and_the_others_go_on() -> None:
    rig = rig_with(active=True, **{"mute-codes": "14"})
    rig.run(greet())
    reading, locking = Run(read_everything()), Run(lock())
    rig.session.run(reading)
    rig.step_until(lambda: rig.line.requests[-1].command.name == "light")
    start_s = rig.clock.now_s
    rig.session.run(locking, is_urgent=True)
    rig.step_until(lambda: locking.is_done)
    assert rig.clock.now_s - start_s < 0.1
    assert not rig.bench.state().is_active
    rig.step_until(lambda: reading.is_done)
    assert reading.result is not None
    assert list(reading.result.errors) == ["light_v"]


def test_the_background_does_not_hold_up_the_foreground() -> None:
    rig = rig_with(**{"mute-codes": "14,32,33,34"})
    watched(rig)
    rig.step_for(0.05)
    start_s = rig.clock.now_s
    assert rig.run(greet()).is_answered
    assert rig.clock.now_s - start_s < 0.1


def test_a_bug_in_a_procedure_ends_only_that_procedure() -> None:
    def broken() -> Procedure[None]:
        yield from greet()
        raise ZeroDivisionError

    rig = rig_with()
    with pytest.raises(ZeroDivisionError):
        rig.run(broken())
    assert rig.run(greet()).is_answered


def test_a_dangerous_request_never_leaves_without_an_explicit_act() -> None:
    def careless() -> Procedure[None]:
        yield Ask(BY_NAME["zero_sensor"].query())

    rig = rig_with()
    with pytest.raises(ValueError, match="explicit act"):
        rig.run(careless())
    assert rig.line.sent == b""
