"""The device: what makes each value known, stale and unknown."""

from collections.abc import Callable

import pytest

from app.engine.device import (
    FRESH_FOR_S,
    MAX_LAG_S,
    SLOW_KEYS,
    STATUS_KEYS,
    STREAM_PROVES_S,
    Device,
    DeviceView,
    How,
    Known,
    Sleep,
    StaleReason,
)
from app.engine.setting_changes import UNREADABLE
from app.safety.acts import REQUESTS, Act
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, SERIAL_OUTPUT, STATUS, Command, Request
from protocol.events import Answered, OutcomeUnknown, Received, Restarted, Role, WentOffline, WentOnline
from protocol.frame import Direction, Frame, encode_long, encode_reply
from protocol.link_states import Presence
from protocol.messages import Acknowledgement, Reading, decode
from tests.support.line.link_bench import PULSE, RECORD

NOW = 1000.0
THRESHOLD, TIME = BY_NAME["attitude_threshold"], BY_NAME["freefall_time"]
TRIGGER = BY_NAME["attitude_trigger"]
"""It cannot be read (E8)."""
BAUD, BOOT_COUNT = BY_NAME["baud_rate"], BY_NAME["boot_count"]


def heard(raw: bytes, role: Role, at: float = NOW, asked: Request | None = None, said_after: float = NOW) -> Received:
    return Received(Frame(Direction.MODULE_TO_HOST, raw), decode(raw, asked), role, at, said_after)


def status(tilt: int = 7, *, active: bool = False, triggered: bool = False) -> bytes:
    return encode_long(STATUS.code, bytes((tilt, 10, int(triggered), int(active))))


def read(command: Command, raw: int, at: float = NOW) -> Answered:
    return Answered(command.query(), (Reading(command, raw),), 1, 0.003, at)


def acknowledged(request: Request, raw: int | None = None, at: float = NOW) -> Answered:
    echo = request.data if raw is None else raw
    return Answered(request, (Acknowledgement(request, echo),), 1, 0.003, at)


def view(device: Device, now: float = NOW) -> DeviceView:
    return device.view(now)


@pytest.fixture
def device() -> Device:
    """A module that answered: a setting that can be read, one that cannot, a boot count and a status."""
    one = Device(115200)
    one.apply(WentOnline(NOW))
    one.apply(read(THRESHOLD, 60))
    one.apply(read(BOOT_COUNT, 37))
    one.apply(acknowledged(TRIGGER.set(True)))
    one.apply(heard(status(), Role.ANSWER))
    return one


def reasons(device: Device, now: float = NOW) -> dict[str, StaleReason | None]:
    shown = view(device, now)
    return {key: known.stale_reason for key in shown.values if (known := shown.known(key, now)) is not None}


# Known


def test_nothing_is_known_before_the_module_said_it() -> None:
    shown = view(Device(115200))
    assert shown.values == {}
    assert shown.presence is Presence.UNKNOWN
    assert shown.known("attitude_threshold_deg", NOW) is None
    assert shown.fresh("attitude_threshold_deg", NOW) is None
    assert shown.proven("active", NOW) is None


def test_an_answer_is_read_and_an_acknowledgement_acknowledged(device: Device) -> None:
    values = view(device).values
    assert values["attitude_threshold_deg"] == Known(60, How.READ, NOW)
    assert values["attitude_trigger"] == Known(True, How.ACKNOWLEDGED, NOW)
    assert values["active"] == Known(False, How.READ, NOW, sent_after=NOW)
    assert values["baud_rate"] == Known(115200, How.READ, NOW), "a frame came at this rate"


def test_a_port_without_a_rate_proves_none() -> None:
    device = Device()
    device.apply(WentOnline(NOW))
    assert "baud_rate" not in view(device).values


def test_an_acknowledged_activation_is_known_and_other_acts_leave_the_status_in_doubt(device: Device) -> None:
    device.apply(acknowledged(ACTIVATION.set(True)))
    assert view(device).values["active"] == Known(True, How.ACKNOWLEDGED, NOW)
    device.apply(acknowledged(ACTIVATION.set(False)))  # proves nothing: a module that does not lock says the same
    assert view(device).values["active"] == Known(True, How.ACKNOWLEDGED, NOW, StaleReason.WRITE_UNCONFIRMED)
    device.apply(acknowledged(REQUESTS[Act.ZERO]))
    assert view(device).values["tilt_deg"].stale_reason is StaleReason.WRITE_UNCONFIRMED
    assert view(device).values["tilt_deg"].value == 7


@pytest.mark.parametrize(("act", "key"), [(Act.DEPLOY, "triggered"), (Act.ZERO, "tilt_deg")])
def test_what_was_reported_before_an_act_without_an_answer_is_in_doubt(device: Device, act: Act, key: str) -> None:
    device.apply(OutcomeUnknown(REQUESTS[act], 1.0, NOW))
    assert view(device).values[key].stale_reason is StaleReason.WRITE_UNCONFIRMED


@pytest.mark.parametrize("role", [Role.LATE, Role.ECHO])
def test_a_status_that_answers_nothing_of_now_is_no_value(device: Device, role: Role) -> None:
    device.apply(heard(status(80, active=True), role, NOW + 0.1))
    assert view(device).fresh("tilt_deg", NOW + 0.1) == 7
    assert len(device.take_samples()) == 1


def test_every_report_is_a_sample_and_the_last_one_the_value(device: Device) -> None:
    device.take_samples()
    for number in range(5):
        device.apply(heard(status(number), Role.STREAMED, NOW + number / 100))
    assert [sample.tilt_deg for sample in device.take_samples()] == [0, 1, 2, 3, 4]
    assert device.take_samples() == []
    known = view(device).values["tilt_deg"]
    assert (known.value, known.how, known.at) == (4, How.STREAMED, NOW + 0.04)


def test_two_streamed_reports_prove_the_serial_output_and_one_does_not(device: Device) -> None:
    device.apply(heard(status(), Role.STREAMED, NOW))
    device.apply(Restarted(is_certain=True, at=NOW))  # what came before is no second one
    device.apply(heard(status(), Role.STREAMED, NOW))
    assert not view(device).is_streaming
    assert SERIAL_OUTPUT.key not in view(device).values
    device.apply(heard(status(), Role.STREAMED, NOW + 0.5))
    shown = view(device, NOW + 0.5)
    assert shown.is_streaming
    assert shown.stream_hz == 2.0
    assert shown.fresh(SERIAL_OUTPUT.key, NOW + 0.5) is True
    assert shown.fresh(SERIAL_OUTPUT.key, NOW + 0.5 + STREAM_PROVES_S + 0.01) is None
    assert not device.view(NOW + 0.5 + STREAM_PROVES_S).is_streaming
    device.apply(acknowledged(SERIAL_OUTPUT.set(False), at=NOW + 0.6))
    assert not view(device, NOW + 0.6).is_streaming
    assert view(device, NOW + 0.6).fresh(SERIAL_OUTPUT.key, NOW + 0.6) is False


def test_the_rate_of_a_stream_is_counted_over_three_seconds(device: Device) -> None:
    for number in range(11):
        device.apply(heard(status(), Role.STREAMED, NOW + number / 10))
    assert view(device, NOW + 1.0).stream_hz == pytest.approx(10.0)
    assert view(device, NOW + 4.05).stream_hz == 0.0


# Stale


@pytest.mark.parametrize("key", [*STATUS_KEYS, *SLOW_KEYS])
def test_a_live_value_ages(key: str) -> None:
    known = Known(1, How.READ, NOW, sent_after=NOW)
    shown = DeviceView({key: known})
    limit_s = FRESH_FOR_S[key]
    assert limit_s == (1.0 if key in STATUS_KEYS else 5.0)
    assert shown.fresh(key, NOW + limit_s) == 1
    aged = shown.known(key, NOW + limit_s + 0.01)
    assert aged is not None
    assert aged.stale_reason is StaleReason.AGED
    assert shown.proven(key, NOW + limit_s) is not None
    assert shown.proven(key, NOW + limit_s + 0.01) is None


def test_settings_and_the_boot_count_do_not_age(device: Device) -> None:
    shown = view(device)
    for key in ("attitude_threshold_deg", "boot_count", "attitude_trigger"):
        assert shown.fresh(key, NOW + 3600) is not None


def test_a_report_of_unproven_age_proves_nothing() -> None:
    device = Device()
    device.apply(heard(status(), Role.STREAMED, NOW, said_after=NOW - 1.1))
    assert view(device).fresh("active", NOW) is False
    assert view(device).proven("active", NOW) is None


@pytest.mark.parametrize(("lag_s", "is_late"), [(None, False), (MAX_LAG_S, False), (MAX_LAG_S + 0.01, True)])
def test_on_a_late_line_no_status_is_current(device: Device, lag_s: float | None, is_late: bool) -> None:
    known = view(device).values
    shown = DeviceView(known, lag_s=lag_s)
    assert shown.is_late is is_late
    assert (shown.fresh("tilt_deg", NOW) is None) is is_late
    tilt = shown.known("tilt_deg", NOW)
    assert tilt is not None
    assert tilt.at == pytest.approx(known["tilt_deg"].at - is_late * (lag_s or 0.0))  # so old it is at least
    assert shown.fresh("attitude_threshold_deg", NOW) == 60


@pytest.mark.parametrize(
    ("doubt", "reason"),
    [
        (lambda device: device.apply(WentOffline(NOW)), StaleReason.LINK_LOST),
        (lambda device: device.mark_all_stale(StaleReason.LINK_LOST), StaleReason.LINK_LOST),
    ],
    ids=["offline", "port lost"],
)
def test_a_lost_link_leaves_everything_stale(
    device: Device, doubt: Callable[[Device], None], reason: StaleReason
) -> None:
    doubt(device)
    assert set(reasons(device).values()) == {reason}
    assert view(device).values["attitude_threshold_deg"].value == 60
    device.apply(read(THRESHOLD, 61, NOW + 1))
    assert view(device).fresh("attitude_threshold_deg", NOW + 1) == 61


def test_the_first_reason_stays(device: Device) -> None:
    device.apply(OutcomeUnknown(THRESHOLD.set(70), 1.0, NOW))
    device.mark_all_stale(StaleReason.LINK_LOST)
    assert reasons(device)["attitude_threshold_deg"] is StaleReason.WRITE_UNCONFIRMED
    assert reasons(device)["boot_count"] is StaleReason.LINK_LOST


@pytest.mark.parametrize("is_refused", [False, True])
def test_an_unconfirmed_set_leaves_what_can_be_read_stale_and_nothing_else(device: Device, is_refused: bool) -> None:
    request = THRESHOLD.set(70)
    device.apply(acknowledged(request, 0x63) if is_refused else OutcomeUnknown(request, 1.0, NOW))
    known = view(device).values["attitude_threshold_deg"]
    assert (known.value, known.stale_reason) == (60, StaleReason.WRITE_UNCONFIRMED)
    assert [key for key, reason in reasons(device).items() if reason] == ["attitude_threshold_deg"]


def test_another_baud_rate_is_known_by_a_frame_only(device: Device) -> None:
    device.apply(acknowledged(BAUD.set(9600)))
    known = view(device).values["baud_rate"]
    assert (known.value, known.stale_reason) == (115200, StaleReason.WRITE_UNCONFIRMED)
    device.use_rate(9600)
    device.apply(WentOnline(NOW + 1))
    assert view(device).fresh("baud_rate", NOW + 1) == 9600


# Unknown


@pytest.mark.parametrize("may_have_restarted", [False, True])
def test_an_unconfirmed_set_of_what_cannot_be_read_is_unknown(device: Device, may_have_restarted: bool) -> None:
    assert TRIGGER.key in UNREADABLE
    if may_have_restarted:
        device.apply(heard(PULSE, Role.DUPLICATE, NOW, HEARTBEAT.query()))
    device.apply(OutcomeUnknown(TRIGGER.set(False), 1.0, NOW))
    device.apply(read(BOOT_COUNT, 37))  # it did not restart
    assert view(device).known(TRIGGER.key, NOW) is None


def test_a_restart_leaves_stale_what_can_be_read_and_unknown_what_cannot(device: Device) -> None:
    device.apply(Restarted(is_certain=True, at=NOW))
    shown = view(device)
    assert shown.restarts == 1
    assert shown.known(TRIGGER.key, NOW) is None
    assert {key for key, reason in reasons(device).items() if reason is not StaleReason.RESTARTED} == {"baud_rate"}


@pytest.mark.parametrize(("boots", "restarts"), [(37, 0), (38, 1), (36, 1)])
def test_a_boot_count_that_moved_is_a_restart(device: Device, boots: int, restarts: int) -> None:
    device.apply(read(BOOT_COUNT, boots, NOW + 1))
    assert view(device, NOW + 1).restarts == restarts
    assert (view(device, NOW + 1).known(TRIGGER.key, NOW + 1) is None) is bool(restarts)
    assert view(device, NOW + 1).fresh("boot_count", NOW + 1) == boots


def test_a_restart_that_was_heard_is_not_counted_again_by_its_boot_count(device: Device) -> None:
    device.apply(Restarted(is_certain=True, at=NOW))
    device.apply(read(BOOT_COUNT, 38, NOW + 1))
    assert view(device, NOW + 1).restarts == 1
    device.apply(read(BOOT_COUNT, 39, NOW + 2))
    assert view(device, NOW + 2).restarts == 2


def test_the_boot_count_wraps() -> None:
    device = Device()
    device.apply(read(BOOT_COUNT, 255))
    device.apply(read(BOOT_COUNT, 0))
    assert view(device).restarts == 1


@pytest.mark.parametrize(("boots", "is_known_again"), [(37, True), (38, False)])
def test_a_heartbeat_that_may_be_a_restarts_is_decided_by_the_boot_count(
    device: Device, boots: int, is_known_again: bool
) -> None:
    device.apply(heard(PULSE, Role.DUPLICATE, NOW + 0.1, HEARTBEAT.query()))
    shown = view(device, NOW + 0.1)
    assert shown.is_restart_suspected
    assert shown.undecided == {TRIGGER.key}
    assert shown.known(TRIGGER.key, NOW + 0.1) is None
    assert shown.fresh("attitude_threshold_deg", NOW + 0.1) == 60
    assert shown.fresh("boot_count", NOW + 0.1) is None
    device.apply(heard(encode_reply(BOOT_COUNT.code, 38), Role.LATE, NOW + 0.15, BOOT_COUNT.query()))
    assert view(device, NOW + 0.15).fresh("boot_count", NOW + 0.15) is None, "it may be from before"
    device.apply(read(BOOT_COUNT, boots, NOW + 0.2))
    shown = view(device, NOW + 0.2)
    assert not shown.is_restart_suspected
    assert shown.undecided == frozenset()
    assert (shown.fresh(TRIGGER.key, NOW + 0.2) is True) is is_known_again
    assert shown.fresh("boot_count", NOW + 0.2) == boots


def test_the_first_boot_count_does_not_tell_whether_there_was_a_restart() -> None:
    device = Device(115200)
    device.apply(acknowledged(TRIGGER.set(True)))
    device.apply(heard(PULSE, Role.DUPLICATE, NOW + 0.1, HEARTBEAT.query()))
    device.apply(read(BOOT_COUNT, 37, NOW + 0.2))
    assert view(device, NOW + 0.2).fresh(TRIGGER.key, NOW + 0.2) is None


def test_only_the_serial_output_that_is_switched_off_ends_a_stream(device: Device) -> None:
    assert not Device().view(NOW).is_restart_suspected
    for number in (0, 1):
        device.apply(heard(status(), Role.STREAMED, NOW + number / 10))
    for request in (TRIGGER.set(False), SERIAL_OUTPUT.set(True)):
        device.apply(acknowledged(request, at=NOW + 0.1))
        assert device.view(NOW + 0.2).is_streaming
    device.apply(acknowledged(SERIAL_OUTPUT.set(False), at=NOW + 0.1))
    assert not device.view(NOW + 0.2).is_streaming


def test_a_heartbeat_that_was_waited_for_casts_no_doubt(device: Device) -> None:
    device.apply(heard(PULSE, Role.ANSWER, NOW + 0.1, HEARTBEAT.query()))
    assert view(device).undecided == frozenset()
    assert view(device).fresh(TRIGGER.key, NOW) is True


# What else is seen


def test_presence_follows_the_link(device: Device) -> None:
    assert (view(device).presence, view(device).presence_since) == (Presence.ONLINE, NOW)
    device.apply(WentOffline(NOW + 5))
    assert (view(device).presence, view(device).presence_since) == (Presence.OFFLINE, NOW + 5)


@pytest.mark.parametrize(("role", "is_kept"), [(Role.LATE, True), (Role.UNSOLICITED, True), (Role.ANSWER, False)])
def test_a_record_outside_an_answer_is_kept(device: Device, role: Role, is_kept: bool) -> None:
    device.apply(heard(RECORD, role))
    assert [stray_record.raw for stray_record in view(device).stray_records] == [RECORD] * is_kept


def test_a_view_does_not_change_any_more(device: Device) -> None:
    before = view(device)
    device.apply(read(THRESHOLD, 61))
    assert before.values["attitude_threshold_deg"].value == 60
    with pytest.raises(TypeError):
        before.values["attitude_threshold_deg"] = Known(1, How.READ, NOW)  # type: ignore[index]


def test_a_sleep_is_remembered(device: Device) -> None:
    assert view(device).last_sleep is None
    device.note_sleep(Sleep(NOW + 40, 30.0))
    assert view(device).last_sleep == (NOW + 40, 30.0)
