"""How long procedures wait for answers, and how often they ask, on the simulator's clock; reports around an act."""

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import pytest

from app.engine.device import StatusSample
from app.engine.procedure import ASK_EVERY_S, Cancelled, Procedure
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.act import READINGS, WATCH_S, ZEROED_WITHIN_DEG, Performed, _Observed, _outcome, perform
from app.procedures.ask_status import ask_status
from app.procedures.find import find_rate, look_for
from app.procedures.handshake import handshake
from app.procedures.history import read_history
from app.procedures.light_calibration import measure_light
from app.procedures.lock import lock
from app.procedures.read import read_everything
from app.procedures.settings_reading import read_settings
from app.procedures.stream import StreamSwitch
from app.procedures.write import write_verified
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Entry, Outcome, durable
from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, STATUS, Request
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import Rig, end_watch, engine_view, settled_rig, watched

SILENT: dict[str, object] = {"mute": True}
NO_PROOF: dict[str, object] = {"mute-codes": "23,33,30,31"}
NO_SETTINGS: dict[str, object] = {"mute-codes": "20,21,22,14,34,35,32"}
FREEFALL_TIME = BY_NAME["freefall_time"]
ON, OFF = SERIAL_OUTPUT.set(True), SERIAL_OUTPUT.set(False)


def write_one(*, is_held: bool = False) -> Procedure[WriteReport]:
    journal = FakeJournal()
    journal.is_held = is_held
    return write_all([SettingChange(FREEFALL_TIME, 1.2)], WriteContext(journal=journal))


@pytest.mark.parametrize(
    ("procedure", "options", "took_s", "frames"),
    [
        (handshake, SILENT, 1.53, 2),
        (ask_status, SILENT, 4.0, 4),
        (ask_status, NO_SETTINGS, 6.99, 15),
        (read_everything, {}, 0.01, 9),
        (read_everything, SILENT, 4.06, 4),
        (read_settings, SILENT, 4.59, 5),
        (read_settings, NO_SETTINGS, 5.89, 18),
        (read_settings, NO_PROOF, 4.58, 16),
        (read_history, SILENT, 4.06, 4),
        (read_history, NO_SETTINGS, 3.0, 6),
        (read_history, {}, 1.05, 23),
        (find_rate, SILENT, 7.86, 12),
        (find_rate, NO_PROOF, 10.2, 17),
        (lambda: look_for(57600, 38400), SILENT, 12.6, 20),
        (lambda: look_for(57600, 38400), NO_PROOF, 14.94, 25),
        (measure_light, SILENT, 40.6, 40),
        (lambda: write_verified(FREEFALL_TIME, 1.2), SILENT, 4.0, 4),
        (lambda: write_verified(FREEFALL_TIME, 1.2), NO_SETTINGS, 4.06, 5),
        (write_one, {}, 0.7, 42),
        (write_one, {"mute-codes": "21"}, 5.69, 60),
        (write_one, {"mute-codes": "23"}, 26.73, 100),
        (lambda: write_one(is_held=True), {}, 2.35, 59),
        (lock, SILENT, 12.07, 33),
        (lambda: run_preflight(Evidence(port="sim")), SILENT, 11.06, 11),
        (lambda: run_preflight(Evidence(port="sim")), NO_SETTINGS, 26.3, 104),
    ],
)
def test_what_is_not_answered_costs_its_time_and_no_more(
    procedure: Callable[[], Procedure[object]], options: dict[str, object], took_s: float, frames: int
) -> None:
    rig = settled_rig(**options)
    began = rig.clock()
    rig.run(procedure(), limit_s=200)
    assert rig.clock() - began == pytest.approx(took_s, abs=0.05)
    assert len(rig.line.requests) == frames


@pytest.mark.parametrize(("took_s", "is_slow"), [(0.1, False), (0.11, True)])
def test_a_disk_is_slow_that_takes_longer_than_a_tenth_of_a_second(took_s: float, is_slow: bool) -> None:
    entry: Entry = Future()
    waiting = durable(entry)
    next(waiting)
    for _ in range(2):
        waiting.send(engine_view(0.0))
    entry.set_result(1)
    waiting.send(True)
    with pytest.raises(StopIteration) as ended:
        waiting.send(engine_view(took_s))
    assert ended.value.value is is_slow


@pytest.mark.parametrize(
    ("act", "options", "outcome", "took_s", "frames"),
    [
        (Act.ACTIVATE, SILENT, Outcome.UNKNOWN, 4.56, 6),
        (Act.ZERO, SILENT, Outcome.UNKNOWN, 4.56, 6),
        (Act.FORBID_DEPLOY, SILENT, Outcome.UNKNOWN, 4.56, 6),
        (Act.SHUTDOWN, SILENT, Outcome.UNKNOWN, 2.66, 3),
        (Act.DEPLOY, SILENT, Outcome.UNKNOWN, 7.32, 10),
        (Act.ACTIVATE, {"keeps": False}, Outcome.REFUSED, 1.53, 60),
        (Act.SHUTDOWN, {"mute_codes": frozenset()}, Outcome.CONFIRMED, 1.65, 3),
        (Act.DEPLOY, {}, Outcome.CONFIRMED, 0.16, 3),
    ],
)
def test_after_an_act_the_module_is_asked_only_so_often(
    act: Act, options: dict[str, object], outcome: Outcome, took_s: float, frames: int
) -> None:
    rig = settled_rig(active=act is Act.DEPLOY)
    sent = list[tuple[float, int]]()

    def change(request: Request) -> None:
        if request == REQUESTS[act]:
            rig.bench.change(**options)
            sent.append((rig.clock(), len(rig.line.requests)))

    at_each_frame(rig.bench, change)
    assert rig.run(perform(act, FakeJournal(), permit=rig.permit(act))).outcome is outcome
    ((at, count),) = sent
    assert rig.clock() - at == pytest.approx(took_s, abs=0.05)
    assert len(rig.line.requests) - count == frames


@pytest.mark.parametrize(("is_wanted", "seconds", "count"), [(True, 20, 198), (False, 60, 120)])
def test_without_a_stream_each_value_is_asked_for_in_its_time(is_wanted: bool, seconds: int, count: int) -> None:
    rig = settled_rig(stream="silent")
    watched(rig, StreamSwitch(is_wanted=is_wanted))
    rig.step_for(5)
    before = len(rig.line.requests)
    rig.step_for(seconds)
    asked = Counter(request.command.name for request in rig.line.requests[before:])
    assert asked.pop("status") == pytest.approx(count, abs=2)
    settings = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
    slow, rare = ("cell_voltage", "charging", "light"), ("boot_count", *settings)
    assert asked == dict.fromkeys(slow, seconds) | dict.fromkeys(rare, seconds // 10)


@pytest.mark.parametrize(("off_after_s", "frames"), [(1.4, [ON, OFF, ON]), (1.6, [ON, OFF])])
def test_a_stream_that_does_not_begin_within_a_second_and_a_half_is_not_switched_on_again(
    off_after_s: float, frames: list[Request]
) -> None:
    rig, switch = settled_rig(stream="acknowledged"), StreamSwitch()
    watched(rig, switch)
    rig.step_until(lambda: ON in rig.line.requests)
    assert rig.clock() - rig.session.opened_at == pytest.approx(2.2, abs=0.1)
    rig.step_for(off_after_s)
    switch.is_wanted = False
    rig.step_for(0.15)
    switch.is_wanted = True
    rig.step_for(0.15)
    assert [request for request in rig.line.requests if request in (ON, OFF)] == frames


def test_off_is_sent_three_times_to_a_module_that_does_not_answer_it() -> None:
    rig = settled_rig()
    watched(rig)
    rig.step_for(4)
    rig.bench.change(mute_codes=frozenset({SERIAL_OUTPUT.code}))
    background = rig.session.background
    end_watch(rig)
    assert rig.line.requests.count(OFF) == 3
    assert background is not None
    assert isinstance(background.error, Cancelled)


def test_a_module_that_answers_is_asked_once() -> None:
    rig = settled_rig()
    assert rig.run(ask_status())
    assert rig.line.requests.count(STATUS.query()) == 1


# Reports before and after an act


def do(rig: Rig, act: Act) -> None:
    rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))


def test_a_module_counts_as_on_after_two_answers_half_a_second_apart() -> None:
    """A doubled reply to an earlier heartbeat answers once."""
    rig = Rig({"shuts_down": False})
    sent: list[tuple[float, Request]] = []
    at_each_frame(rig.bench, lambda request: sent.append((rig.clock(), request)))
    do(rig, Act.SHUTDOWN)
    frames = [request for _, request in sent]
    beats_s = [at for at, request in sent[frames.index(REQUESTS[Act.SHUTDOWN]) :] if request == HEARTBEAT.query()]
    assert beats_s[1] - beats_s[0] > 0.5


@pytest.mark.parametrize(("options", "fences"), [({}, 0), ({"mute_codes": frozenset((0x10,))}, 1)])
def test_only_the_first_report_after_an_unanswered_act_waits_behind_another_question(
    options: dict[str, Any], fences: int
) -> None:
    rig = Rig(options)
    do(rig, Act.ACTIVATE)
    sent = rig.line.requests
    afterwards = sent[sent.index(REQUESTS[Act.ACTIVATE]) + 1 :]
    assert len([request for request in afterwards if request != STATUS.query()]) == fences
    assert afterwards[fences:] == [STATUS.query()] * READINGS


def test_before_zeroing_reports_are_asked_for_at_a_steady_pace() -> None:
    rig = Rig({"tilt": 4})
    do(rig, Act.ZERO)
    reports = rig.line.requests.count(STATUS.query())
    assert 0.9 < reports / (WATCH_S / ASK_EVERY_S) < 1.2, reports


LOCKED = StatusSample(0.0, 0, 1.0, triggered=False, active=False)
ACTIVE, FIRED = LOCKED._replace(active=True), LOCKED._replace(triggered=True, active=True)
CONFIRMED, REFUSED, UNKNOWN = Outcome.CONFIRMED, Outcome.REFUSED, Outcome.UNKNOWN


@pytest.mark.parametrize(
    ("raw", "reports", "outcome"),
    [
        (1, (ACTIVE, ACTIVE), CONFIRMED),
        (None, (ACTIVE, ACTIVE), CONFIRMED),
        (1, (ACTIVE,), UNKNOWN),
        (1, (LOCKED, ACTIVE), UNKNOWN),
        (1, (LOCKED, LOCKED), REFUSED),
        (0, (LOCKED, LOCKED), REFUSED),
        (None, (LOCKED, LOCKED), UNKNOWN),
        (1, (), UNKNOWN),
    ],
)
def test_an_activation_is_what_two_reports_say(
    raw: int | None, reports: tuple[StatusSample, ...], outcome: Outcome
) -> None:
    assert _outcome(Act.ACTIVATE, _Observed(raw == 1, raw, reports)) is outcome


@pytest.mark.parametrize(
    ("raw", "has_fired", "reports", "outcome"),
    [
        (1, False, (LOCKED, LOCKED), CONFIRMED),
        (0, True, (LOCKED, LOCKED), CONFIRMED),
        (0, False, (LOCKED, FIRED), CONFIRMED),
        (0, False, (LOCKED, LOCKED), REFUSED),
        (0, None, (LOCKED, LOCKED), UNKNOWN),
        (0, False, (LOCKED,), UNKNOWN),
        (None, False, (LOCKED, LOCKED), UNKNOWN),
        (2, False, (LOCKED, LOCKED), UNKNOWN),
    ],
)
def test_not_fired_is_said_only_where_everything_says_so(
    raw: int | None, has_fired: bool | None, reports: tuple[StatusSample, ...], outcome: Outcome
) -> None:
    assert _outcome(Act.DEPLOY, _Observed(raw == 1, raw, reports, has_fired=has_fired)) is outcome


@pytest.mark.parametrize(
    ("act", "raw", "is_alive", "outcome"),
    [
        (Act.SHUTDOWN, 1, True, REFUSED),
        (Act.SHUTDOWN, 1, False, CONFIRMED),
        (Act.SHUTDOWN, None, False, UNKNOWN),
        (Act.ZERO, 1, None, CONFIRMED),
        (Act.ZERO, 0, None, REFUSED),
        (Act.FORBID_DEPLOY, None, None, UNKNOWN),
    ],
)
def test_what_follows_from_an_acknowledgement(
    act: Act, raw: int | None, is_alive: bool | None, outcome: Outcome
) -> None:
    assert _outcome(act, _Observed(raw == 1, raw, is_alive=is_alive)) is outcome


@pytest.mark.parametrize(
    ("tilt_deg", "sentence"),
    [
        (0, "Acknowledged. Tilt now 0°."),
        (1, "Acknowledged. Tilt now 1°."),
        (2, "Acknowledged. Tilt now 2°, not 0°: check the mounting."),
        (None, "Acknowledged. Could not read the tilt: check it."),
    ],
)
def test_after_zeroing_the_tilt_is_said(tilt_deg: int | None, sentence: str) -> None:
    assert ZEROED_WITHIN_DEG == 1
    status = None if tilt_deg is None else StatusSample(0.0, tilt_deg, 1.0, False, False)
    done = Performed(act=Act.ZERO, outcome=CONFIRMED, status=status)
    assert done.sentence == sentence
    assert done.is_level is (tilt_deg in (0, 1))
