"""How long a verdict holds, what a check is made of, and what must be unbroken for a trigger to count as enabled
(E8).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.device import DeviceView, How, Known, Sleep
from app.engine.procedure import Ask, Procedure
from app.limits.past import Past
from app.preflight.evidence import Disturbance, Evidence, FlagState, FrameLog, TriggerFlag
from app.preflight.findings import Case, CheckResult
from app.preflight.reading_object import reading_object
from app.preflight.run import TRIGGERS, run_preflight
from app.preflight.verdict import VALID_FOR_S, Verdict, Void, assess, blocks_go, void_reason
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.simulator.bench import SimulatedBench
from app.text.messages import UserMessage
from protocol.catalogue import HEARTBEAT, HEARTBEAT_REPLY
from protocol.events import Received, Rejected, Role, Sent
from protocol.fields import Value
from protocol.frame import HOST_FRAME_LENGTH, Direction, Fault, Frame, Noise, Reason
from protocol.link_states import Presence
from protocol.messages import Status
from tests.support.line.frames import at_frame
from tests.support.line.odd_module import OddSetup, end_faults
from tests.support.line.sim_line import Rig
from tests.support.records.preflight_rig import judged
from tests.support.thorough import some

ENDED, OPENED = 1000.0, 900.0


def evidence(**more: Any) -> Evidence:
    return Evidence(**{"port": "sim", "ended_at": ENDED, "opened_at": OPENED, **more})


def void(
    now: float = ENDED, *, opened_at: float | None = OPENED, found: Evidence | None = None,
    values: Mapping[str, Value] = MappingProxyType({}), **device: Any,
) -> Void | None:  # fmt: skip
    known = {key: Known(value, How.READ, now) for key, value in values.items()}
    view = DeviceView(known, **{"presence": Presence.ONLINE, **device})
    case = Case(evidence=found or evidence(), profile=NO_PROFILE, past=Past())
    return void_reason(assess(case), view, now, opened_at=opened_at)


@pytest.mark.parametrize(
    ("now", "reason"),
    [
        (ENDED, None),
        (ENDED + VALID_FOR_S, None),
        (ENDED + VALID_FOR_S + 0.125, Disturbance.TOO_OLD),
        (ENDED - 0.125, Disturbance.TOO_OLD),
    ],
)
def test_a_verdict_holds_for_fifteen_minutes(now: float, reason: Disturbance | None) -> None:
    assert VALID_FOR_S == 15 * 60
    assert void(now) == (None if reason is None else Void(reason))


@pytest.mark.parametrize(
    ("known", "reason"),
    [
        ({"opened_at": None}, Disturbance.DISCONNECTED),
        ({"opened_at": OPENED + 1}, Disturbance.DISCONNECTED),
        ({"restarts": 1}, Disturbance.RESTARTED),
        ({"last_sleep": Sleep(ENDED, 60.0)}, Disturbance.SLEPT),
        ({"last_sleep": Sleep(ENDED - 0.125, 60.0)}, None),
        ({"presence": Presence.OFFLINE}, Disturbance.SILENT),
        ({"breaks": 1}, Disturbance.BROKEN),
        ({"found": evidence(disturbance=Disturbance.SILENT)}, Disturbance.SILENT),
        ({"found": evidence(ended_at=None)}, Disturbance.INTERRUPTED),
    ],
)
def test_what_happened_after_the_check_voids_it(known: dict[str, Any], reason: Disturbance | None) -> None:
    assert void(**known) == (None if reason is None else Void(reason))


@pytest.mark.parametrize(
    ("checked", "key", "value", "shown"),
    [
        ({"values": {"boot_count": 7}}, "boot_count", 8, "changed: Boot count"),
        ({"values": {"freefall_time_s": 1.6}}, "freefall_time_s", 1.7, "changed: Free-fall time"),
        ({"baud_rate": 115200}, "baud_rate", 9600, "changed: Baud rate"),
        ({"series": {"charging": [True, False]}}, "charging", True, "changed: Charging"),
        ({"status": Status(0, 1.0, False, False)}, "triggered", True, "changed: Triggered"),
        ({"flags": {"attitude_trigger": TriggerFlag(FlagState.ENABLED)}}, "attitude_trigger", False,
         "changed: Attitude trigger"),
        ({"flags": {"attitude_trigger": TriggerFlag(FlagState.DISABLED)}}, "attitude_trigger", True,
         "changed: Attitude trigger"),
    ],
)  # fmt: skip
def test_a_value_that_changed_is_named(checked: dict[str, Any], key: str, value: Value, shown: str) -> None:
    found = void(found=evidence(**checked), values={key: value})
    assert found is not None
    assert (found.reason, found.message.in_english()) == (Disturbance.CHANGED, shown)
    assert void(found=evidence(), values={key: value}) is None, "it was not checked"


def test_a_trigger_that_is_no_longer_known_voids_unless_a_restart_is_still_undecided() -> None:
    enabled = evidence(flags={"attitude_trigger": TriggerFlag(FlagState.ENABLED)})
    assert void(found=enabled, values={"attitude_trigger": True}) is None
    found = void(found=enabled)
    assert found is not None
    assert found.reason is Disturbance.CHANGED
    assert void(found=enabled, undecided=frozenset({"attitude_trigger"})) is None
    never_set = evidence(flags={"attitude_trigger": TriggerFlag(FlagState.NEVER_SET)})
    assert void(found=never_set) is None


@pytest.mark.parametrize(
    ("is_done", "is_required", "against"),
    [(True, True, False), (False, True, True), (False, False, True), (None, True, True), (None, False, False)],
)
def test_a_manual_item_stands_against_go(is_done: bool | None, is_required: bool, against: bool) -> None:
    item = ManualLine("Bridle free", is_done=is_done, is_required=is_required)
    assert blocks_go(item) is against
    case = Case(evidence=evidence(), profile=Profile(manual=(item,)), past=Past())
    assert (UserMessage("Bridle free") in assess(case).titles_against) is against


def test_a_limit_softer_than_advised_is_a_warning_with_the_advice() -> None:
    status = {"status_age_s": 0.5, "round_trips_s": [0.05]}
    for most_ms, result, limit in (
        (100.0, CheckResult.PASS, "≤ 100 ms"),
        (90.0, CheckResult.PASS, "≤ 90 ms"),
        (101.0, CheckResult.WARN, "≤ 101 ms, advised ≤ 100 ms"),
        (40.0, CheckResult.FAIL, "≤ 40 ms"),
    ):
        limits = {"round_trip_max_ms": most_ms}
        assessment = assess(Case(evidence=evidence(**status), profile=Profile(limits=limits), past=Past()))
        finding = next(check.finding for check in assessment.checks if check.check.id == "round_trip")
        assert (finding.result, finding.limit.in_english()) == (result, limit)
        assert assessment.softened == (("round_trip",) if result is CheckResult.WARN else ())


OPTIONS = {"uptime": 60, "noise": 0}


def checked(rig: Rig, *, is_enabling: bool = False) -> tuple[Verdict, Evidence]:
    evidence = Evidence(port="sim")
    rig.run(run_preflight(evidence, is_enabling=is_enabling))
    return judged(rig, evidence).assessment.verdict, evidence


def twin(rig: Rig, *, boots: int = 37) -> SimulatedBench:
    """Another module: the same boot count and settings, its triggers never enabled."""
    return SimulatedBench(OddSetup(uptime=60.0, noise=0.0, boots=boots), clock=rig.clock)


def exchange_at(rig: Rig, number: int, other: SimulatedBench, silent_s: float) -> None:
    """At this request the other module takes its place, after such a silence."""

    def exchange() -> None:
        rig.line.lead_to(other, silent_s)
        rig.line.write(bytes(rig.line.sent[-HOST_FRAME_LENGTH:]))

    at_frame(rig.bench, number, exchange, is_lost=True)


@pytest.mark.promise("f")
def test_ready_holds_in_the_conversation_in_which_they_were_enabled() -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    rig.step_for(30)
    assert checked(rig)[0] is Verdict.READY
    rig.bench.module.activate(is_active=True)
    assert checked(rig)[0] is Verdict.GO


@pytest.mark.parametrize("is_active", [False, True])
@pytest.mark.promise("f")
def test_a_new_opening_of_the_port_knows_nothing(is_active: bool) -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    again = Rig(OPTIONS)
    again.bench.module.activate(is_active=is_active)
    verdict, evidence = checked(again)
    assert verdict is Verdict.NO_GO
    assert {evidence.flags[command.key].state for command in TRIGGERS} == {FlagState.NEVER_SET}


@pytest.mark.promise("f")
def test_a_restart_that_the_boot_count_does_not_count() -> None:
    """A brown-out or a watchdog: only two heartbeats tell."""
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    rig.bench.module.memory.boot_count -= 1
    rig.bench.restart()
    rig.step_for(2)
    assert rig.bench.module.memory.boot_count == 37
    verdict, evidence = checked(rig)
    assert (verdict, evidence.values["boot_count"]) == (Verdict.NO_GO, 37)


@pytest.mark.parametrize("silent_s", [0.2, 0.3, 0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("is_active", [False, True])
@pytest.mark.promise("f")
def test_a_twin_put_in_its_place_between_two_checks(silent_s: float, is_active: bool) -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    other = twin(rig)
    other.module.activate(is_active=is_active)
    rig.line.lead_to(other, silent_s)
    verdict, evidence = checked(rig)
    assert rig.line.bench is other
    assert (verdict, evidence.values["boot_count"]) == (Verdict.NO_GO, 37)


@pytest.mark.parametrize("silent_s", [0.35, 0.5, 1.0, 1.5, 2.0])
@pytest.mark.promise("f")
def test_a_twin_put_in_its_place_in_the_middle_of_a_check(silent_s: float) -> None:
    """At every request after the heartbeats, until nothing is asked of the other one any more."""
    whole = Rig(OPTIONS)
    assert checked(whole, is_enabling=True)[0] is Verdict.READY
    begin = 25
    for number in some(range(begin, len(whole.line.requests), 7), one_in=2, first=round(20 * silent_s)):
        rig = Rig(OPTIONS)
        other = twin(rig)
        exchange_at(rig, number, other, silent_s)
        assert checked(rig, is_enabling=True)[0] is Verdict.NO_GO, (number, whole.line.requests[number - 1])


@pytest.mark.promise("f")
def test_a_module_of_another_start_put_in_its_place_without_any_silence() -> None:
    whole = Rig(OPTIONS)
    checked(whole, is_enabling=True)
    for number in some(range(25, len(whole.line.requests) - 12, 3), one_in=2):
        rig = Rig(OPTIONS)
        other = twin(rig, boots=38)
        exchange_at(rig, number, other, 0.0)
        assert checked(rig, is_enabling=True)[0] is Verdict.NO_GO, number


@pytest.mark.promise("f")
def test_a_module_that_does_not_answer_the_question_for_its_records_stays_known() -> None:
    rig = Rig(OPTIONS | {"mute_codes": "35"})
    _verdict, evidence = checked(rig, is_enabling=True)
    assert evidence.disturbance is None
    assert {evidence.flags[command.key].state for command in TRIGGERS} == {FlagState.ENABLED}


def test_one_lost_answer_breaks_nothing_and_an_unanswered_second_does() -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    breaks = rig.session.device.view(rig.clock.now_s).breaks
    for wait_s, is_broken in ((0.2, False), (1.0, True)):
        rig.bench.change(mute=True)
        rig.run(_ask_once(wait_s))
        end_faults(rig.bench)
        rig.run(_ask_once(1.0))
        view = rig.session.device.view(rig.clock.now_s)
        assert (view.breaks > breaks) is is_broken
        assert (TRIGGERS[0].key in view.values) is not is_broken


def _ask_once(wait_s: float) -> Procedure[None]:
    yield Ask(HEARTBEAT.query(), (wait_s,))


FRAME = Frame(Direction.MODULE_TO_HOST, HEARTBEAT_REPLY)


def received(role: Role, count: int) -> list[Received]:
    return [Received(FRAME, None, role, float(number)) for number in range(count)]


def test_of_a_stream_only_the_first_reports_are_kept() -> None:
    log = FrameLog()
    sent = Sent(HEARTBEAT.query().encode(), HEARTBEAT.query(), 1, 0.0)
    noise = Rejected(Noise(b"x", Fault(Reason.NO_HEADER, "noise"), 0), 0.0)
    log.feed([sent, *received(Role.ANSWER, 2), *received(Role.STREAMED, 204), *received(Role.ANSWER, 2), noise])
    assert (len(log.frames), log.left_out) == (206, 4)
    assert (log.frames[0].way, log.frames[1].way, log.frames[-1].way) == ("out", "in", "noise")


def test_no_more_frames_are_kept_than_the_bound() -> None:
    log = FrameLog()
    log.feed(received(Role.ANSWER, 1502))
    assert (len(log.frames), log.left_out) == (1500, 2)


def test_what_is_unknown_is_null() -> None:
    nothing = reading_object(port="sim", baud_rate=9600, round_trip_s=None, values={}, errors={"light_v": "no reply"})
    assert (nothing.link.port, nothing.link.baud_rate, nothing.link.round_trip_ms) == ("sim", 9600, None)
    assert nothing.light_v is None
    assert nothing.errors == {"light_v": "no reply"}
    some = reading_object(port="sim", baud_rate=9600, round_trip_s=0.01234, values={"light_v": 1.8}, errors={})
    assert some.link.round_trip_ms == 12.3
    assert some.light_v == 1.8
