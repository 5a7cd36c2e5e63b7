"""The table of conditions, the permit, every place where a write begins, and which tests hold docs/safety.md."""

import re
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.conversation import ConversationView, How, Known, StatusSample
from app.safety.journal import Act
from app.safety.permit import ASKS_NOTHING, Interlock, InterlockInputs, Origin, Permit, inputs_at, refusals
from app.text.messages import message
from protocol.events import Ended, EndReason

NOW = 1000.0
TALK = 7
_ALWAYS = "ONLINE NOT_SHARED LINE_IS_QUICK AGREES FRESH_STATUS"
_EXPLICIT = "NOTHING_ELSE_ARMED CONFIRMED INTENT_DURABLE"
NEEDED = {
    Act.LOCK: "",
    Act.ACTIVATE: f"{_ALWAYS} IS_LOCKED NOT_TRIGGERED BELOW_TILT {_EXPLICIT}",
    Act.ZERO: f"{_ALWAYS} IS_LOCKED IS_LEVEL IS_STILL {_EXPLICIT}",
    Act.SHUTDOWN: f"{_ALWAYS} IS_LOCKED {_EXPLICIT}",
    Act.FORBID_DEPLOY: f"{_ALWAYS} {_EXPLICIT}",
    Act.DEPLOY: f"{_ALWAYS} IS_ACTIVE NOT_TRIGGERED NOTHING_ELSE_ARMED RITUAL_DONE INTENT_DURABLE",
    Act.CHANGE_BAUD: f"{_ALWAYS} IS_LOCKED RATE_FOLLOWS {_EXPLICIT}",
    Act.WRITE: "ONLINE NOT_SHARED LINE_IS_QUICK MAY_WRITE NOTHING_ELSE_ARMED",
}


def report(at: float, tilt_deg: int, acceleration_g: float) -> StatusSample:
    return StatusSample(at, tilt_deg, acceleration_g, triggered=False, active=False)


LAST = report(NOW - 0.2, 7, 1.1)
STILL = (report(NOW - 2.1, 6, 0.9), report(NOW - 1.0, 8, 1.0), LAST)


def permit(act: Act, **changes: Any) -> Permit:
    return replace(Permit(act, Origin.RITUAL, NOW - 0.5, TALK), **changes)


def made(**changes: Any) -> InterlockInputs:
    """Of a conversation in which everything is as it has to be, but for these fields of it or of the inputs."""
    threshold = {"attitude_threshold_deg": Known(60, How.READ, NOW)}
    talk = ConversationView(TALK, values=MappingProxyType(threshold), reports=STILL)
    of_talk = {name: changes.pop(name) for name in ConversationView._fields if name in changes}
    return InterlockInputs(now=NOW, conversation=talk._replace(**of_talk), **changes)


def opened(act: Act) -> dict[str, list[tuple[dict[str, Any], str]]]:
    """By what is not as it has to be: the inputs, and the conditions that are open then."""
    other = Act.ZERO if act is not Act.ZERO else Act.ACTIVATE
    asked = "CONFIRMED RITUAL_DONE"
    return {
        "conversation": [({"ended": Ended(EndReason.SILENT, NOW)}, f"ONLINE BELOW_TILT {asked}")],
        "port": [({"is_shared": True}, "NOT_SHARED")],
        "line": [({"lag_s": 0.5}, "LINE_IS_QUICK")],
        "agreement": [({"contradiction": message("30: ACTIVE, status: LOCKED.")}, "AGREES MAY_WRITE")],
        "age": [({"is_status_fresh": False}, "FRESH_STATUS MAY_WRITE")],
        "state": [
            ({"active": act is not Act.DEPLOY}, "IS_ACTIVE" if act is Act.DEPLOY else "IS_LOCKED MAY_WRITE"),
            ({"active": None}, "IS_ACTIVE IS_LOCKED MAY_WRITE"),
        ],
        "trigger": [({"triggered": True}, "NOT_TRIGGERED"), ({"triggered": None}, "NOT_TRIGGERED")],
        "tilt": [
            ({"tilt_deg": 11.0}, "IS_LEVEL"),
            ({"tilt_deg": 60.0}, "BELOW_TILT IS_LEVEL"),
            ({"tilt_deg": None}, "BELOW_TILT IS_LEVEL"),
            ({"values": {}}, "BELOW_TILT"),
        ],
        "motion": [
            ({"reports": reports}, "IS_STILL")
            for reports in (
                (),
                STILL[1:],
                # It moved and came to rest again.
                (*STILL, LAST._replace(tilt_deg=9), LAST),
                (*STILL, LAST._replace(acceleration_g=0.8), LAST),
                (*STILL, LAST._replace(acceleration_g=1.2), LAST),
            )
        ],
        "armed": [({"armed": other}, "NOTHING_ELSE_ARMED")],
        "permit": [
            ({"permit": None}, asked),
            ({"permit": permit(act, origin=Origin.CONFIRMATION)}, "RITUAL_DONE"),
            ({"permit": permit(other)}, asked),
            ({"permit": permit(act, conversation=TALK - 1)}, asked),
            ({"permit": permit(act, granted_at=NOW - 3.5)}, asked),
            ({"permit": permit(act, granted_at=NOW + 0.1)}, asked),
            ({"permit": permit(act, is_spent=True)}, asked),
            ({"overtaken_at": NOW}, asked),
            ({"overtaken_at": NOW - 0.5}, asked),  # in one moment
        ],
        "audit": [({"is_audit_ready": False}, "INTENT_DURABLE")],
        "rate": [({"sets_rate": False}, "RATE_FOLLOWS")],
    }


@pytest.mark.parametrize("act", Act)
@pytest.mark.promise("h")
def test_every_open_condition_is_named_whatever_else_is_open(act: Act) -> None:
    """Each alone, and beside one other."""
    allowed: dict[str, Any] = {
        "is_status_fresh": True, "active": act is Act.DEPLOY, "triggered": False, "tilt_deg": 7.0, "armed": act,
        "permit": permit(act),
    }  # fmt: skip
    assert refusals(act, made(**allowed)) == ()
    needed = NEEDED[act].split()
    for first, second in product(opened(act).values(), repeat=2):
        for one, another in product(first, second):
            if first is second and one is not another:
                continue
            open_ones = {*one[1].split(), *another[1].split()}
            expected = [Interlock[name] for name in needed if name in open_ones]
            inputs = made(**allowed | one[0] | another[0])
            assert [refusal.condition for refusal in refusals(act, inputs)] == expected, (one, another)
            known = [condition for condition in expected if condition in ASKS_NOTHING]
            assert [refusal.condition for refusal in refusals(act, inputs, only=ASKS_NOTHING)] == known


def view(known: Known, ended: Ended | None = None) -> ConversationView:
    return ConversationView(TALK, values=MappingProxyType({"active": known, "tilt_deg": known}), ended=ended)


def test_what_is_stale_or_only_acknowledged_is_not_known() -> None:
    assert inputs_at(view(Known(False, How.STREAMED, NOW)), NOW + 0.5).active is False
    assert inputs_at(view(Known(False, How.READ, NOW)), NOW + 1.5).active is None
    assert inputs_at(view(Known(False, How.ACKNOWLEDGED, NOW)), NOW).active is None
    ended = view(Known(False, How.READ, NOW), ended=Ended(EndReason.SILENT, NOW))
    assert inputs_at(ended, NOW).active is None


@pytest.mark.parametrize(
    ("origin", "seconds"), [(Origin.RITUAL, 3), (Origin.CONFIRMATION, 6), (Origin.COMMAND_LINE, 10)]
)
@pytest.mark.promise("e")
def test_a_permit_lasts_as_long_as_its_origin_says(origin: Origin, seconds: int) -> None:
    permit = Permit(Act.ZERO, origin, NOW, TALK)
    assert permit.is_in_time(NOW)
    assert permit.is_in_time(NOW + seconds)
    assert not permit.is_in_time(NOW + seconds + 0.125)
    assert not permit.is_in_time(NOW - 0.125)


TESTS = Path(__file__).parents[1]
PAGE = TESTS.parent / "docs" / "safety.md"


def test_each_requirement_of_the_page_is_held_by_tests() -> None:
    letters = re.findall(r"^## ([a-z])\. ", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert letters == list("abcdefghijkl")
    texts = "".join(path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py"))
    marks = re.findall(r"@pytest\.mark\.promise\((.*)\)", texts)
    assert {letter: sum(f'"{letter}"' in mark for mark in marks) >= 3 for letter in letters} == dict.fromkeys(
        letters, True
    )
