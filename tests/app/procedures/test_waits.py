"""How long procedures wait for answers that do not come, and how often they ask; the clock is the simulator's."""

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future

import pytest

from app.engine.procedure import Cancelled, Procedure
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.act import perform
from app.procedures.ask_status import ask_status
from app.procedures.find import find_rate, look_for
from app.procedures.handshake import handshake
from app.procedures.history import read_history
from app.procedures.light_calibration import measure_light
from app.procedures.lock import lock
from app.procedures.power_cycle import survives_power_cycle
from app.procedures.read import read_everything
from app.procedures.settings_reading import read_settings
from app.procedures.stream import StreamSwitch
from app.procedures.write import write_verified
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Entry, Outcome, durable
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, STATUS, Request
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import end_watch, engine_view, settled_rig, watched

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
        (lambda: write_verified(FREEFALL_TIME, 1.2), SILENT, 6.06, 6),
        (lambda: write_verified(FREEFALL_TIME, 1.2), NO_SETTINGS, 6.07, 9),
        (write_one, {}, 0.65, 30),
        (write_one, {"mute-codes": "21"}, 4.11, 34),
        (write_one, {"mute-codes": "23"}, 8.93, 28),
        (lambda: write_one(is_held=True), {}, 2.15, 32),
        (lock, SILENT, 12.07, 33),
        (lambda: survives_power_cycle({}), SILENT, 120.6, 115),
        (lambda: survives_power_cycle({}), {}, 120.25, 242),
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
        (Act.ACTIVATE, {"keeps": False}, Outcome.REFUSED, 1.53, 44),
        (Act.SHUTDOWN, {"mute_codes": frozenset()}, Outcome.CONFIRMED, 1.65, 3),
        (Act.DEPLOY, {}, Outcome.CONFIRMED, 0.16, 3),
    ],
)
def test_after_an_act_the_module_is_asked_only_so_often(
    act: Act, options: dict[str, object], outcome: Outcome, took_s: float, frames: int
) -> None:
    rig = settled_rig(active=act is Act.DEPLOY)
    write, sent = rig.line.write, list[tuple[float, int]]()

    def changes(data: bytes) -> None:
        write(data)
        if data == REQUESTS[act].encode():
            rig.bench.change(**options)
            sent.append((rig.clock(), len(rig.line.requests)))

    rig.line.write = changes  # type: ignore[method-assign]
    permit = Permit(act, Origin.RITUAL if act is Act.DEPLOY else Origin.CONFIRMATION, rig.clock())
    assert rig.run(perform(act, FakeJournal(), permit=permit)).outcome is outcome
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


def test_a_silent_module_is_not_asked_again() -> None:
    rig = settled_rig(mute=True)
    assert not rig.run(ask_status())
    assert STATUS.query() not in rig.line.requests
    assert rig.line.requests.count(HEARTBEAT.query()) == 1


def test_a_module_that_answers_is_asked_once() -> None:
    rig = settled_rig()
    assert rig.run(ask_status())
    assert rig.line.requests.count(STATUS.query()) == 1
