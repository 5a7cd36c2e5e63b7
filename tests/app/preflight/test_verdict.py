"""How long a verdict holds, at the exact limits, and what its parts say."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.device import DeviceView, How, Known, Sleep
from app.limits.past import Past
from app.preflight.evidence import Disturbance, Evidence, FlagState, TriggerFlag
from app.preflight.findings import Case, CheckResult
from app.preflight.verdict import VALID_FOR_S, Void, assess, blocks_go, void_reason
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.text.messages import UserMessage
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Status

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
        finding = next(one.finding for one in assessment.checks if one.check.id == "round_trip")
        assert (finding.result, finding.limit.in_english()) == (result, limit)
        assert assessment.softened == (("round_trip",) if result is CheckResult.WARN else ())
