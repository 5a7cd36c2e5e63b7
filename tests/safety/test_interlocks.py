"""The table of conditions, the permit, every place where a write begins, and which tests hold docs/safety.md."""

import ast
import re
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.engine.motion import MotionExtremes
from app.engine.procedure import TOO_SLOW
from app.safety.acts import EFFECTS, REQUESTS, TITLES, Act
from app.safety.interlocks import ASKS_NOTHING, CONDITIONS, Interlock, InterlockInputs, inputs_at, refusals
from app.safety.permit import Origin, Permit
from app.text.messages import message
from protocol.catalogue import Hazard
from protocol.events import Ended, EndReason

NOW = 1000.0
TALK = 7
WORDS = {
    "online": Interlock.ONLINE,
    "own": Interlock.NOT_SHARED,
    "quick": Interlock.LINE_IS_QUICK,
    "agrees": Interlock.AGREES,
    "fresh": Interlock.FRESH_STATUS,
    "locked": Interlock.IS_LOCKED,
    "active": Interlock.IS_ACTIVE,
    "unfired": Interlock.NOT_TRIGGERED,
    "flat": Interlock.BELOW_TILT,
    "level": Interlock.IS_LEVEL,
    "still": Interlock.IS_STILL,
    "follows": Interlock.RATE_FOLLOWS,
    "alone": Interlock.NOTHING_ELSE_ARMED,
    "confirmed": Interlock.CONFIRMED,
    "ritual": Interlock.RITUAL_DONE,
    "audit": Interlock.INTENT_DURABLE,
    "writable": Interlock.MAY_WRITE,
}
NEEDED = {
    Act.LOCK: "",
    Act.ACTIVATE: "online own quick agrees fresh locked unfired flat alone confirmed audit",
    Act.ZERO: "online own quick agrees fresh locked level still alone confirmed audit",
    Act.SHUTDOWN: "online own quick agrees fresh locked alone confirmed audit",
    Act.FORBID_DEPLOY: "online own quick agrees fresh alone confirmed audit",
    Act.DEPLOY: "online own quick agrees fresh active unfired alone ritual audit",
    Act.CHANGE_BAUD: "online own quick agrees fresh locked follows alone confirmed audit",
    Act.WRITE: "online own quick writable alone",
}
MOTIONS = {
    "still": MotionExtremes(NOW - 2.1, NOW - 0.2, 6.0, 8.0, 0.9, 1.1),
    "swings": MotionExtremes(NOW - 2.1, NOW - 0.2, 6.0, 9.0, 1.0, 1.0),
    "falls": MotionExtremes(NOW - 2.1, NOW - 0.2, 7.0, 7.0, 0.8, 1.0),
    "shakes": MotionExtremes(NOW - 2.1, NOW - 0.2, 7.0, 7.0, 1.0, 1.2),
    "short": MotionExtremes(NOW - 1.5, NOW - 0.2, 7.0, 7.0, 1.0, 1.0),
    "unknown": None,
}
TILT = {
    "flat": (7.0, 60.0),
    "sloping": (11.0, 60.0),
    "at it": (60.0, 60.0),
    "no tilt": (None, 60.0),
    "no threshold": (7.0, None),
}


def permits(act: Act) -> dict[str, Permit | None]:
    other = Act.ZERO if act is not Act.ZERO else Act.ACTIVATE
    return {
        "none": None,
        "confirmed": Permit(act, Origin.CONFIRMATION, NOW - 0.5, TALK),
        "ritual": Permit(act, Origin.RITUAL, NOW - 0.5, TALK),
        "another act": Permit(other, Origin.RITUAL, NOW - 0.5, TALK),
        "another conversation": Permit(act, Origin.RITUAL, NOW - 0.5, TALK - 1),
        "old": Permit(act, Origin.RITUAL, NOW - 3.5, TALK),
        "spent": Permit(act, Origin.RITUAL, NOW - 0.5, TALK, is_spent=True),
        "rehearsal": Permit(act, Origin.RITUAL, NOW - 0.5, TALK, is_rehearsal=True),
        "ahead": Permit(act, Origin.RITUAL, NOW + 0.1, TALK),
    }


MOST_CHANGES = 3


def rows_of(act: Act) -> Iterator[dict[str, Any]]:
    """A row in which the act is allowed, and every row that differs from it in up to three places: as no condition
    looks at more than three of them, each condition meets all that it can meet, alone and beside two others."""
    other = Act.ACTIVATE if act is not Act.ACTIVATE else Act.DEPLOY
    places: dict[str, list[Any]] = {
        "conversation": [TALK, None],
        "is_shared": [False, True],
        "is_slow": [False, True],
        "is_status_fresh": [True, False],
        "contradiction": [None, message("30: ACTIVE, status: LOCKED.")],
        "active": [act is Act.DEPLOY, True, False, None],
        "triggered": [False, True, None],
        "tilt": ["flat", *TILT],
        "armed": [None, act, other],
        "permit": ["ritual", *permits(act)],
        "is_audit_ready": [True, False],
        "is_unlocked": [False, True],
        "motion": ["still", *MOTIONS],
        "sets_rate": [True, False],
    }
    allowed = {name: values[0] for name, values in places.items()}
    others = {name: [one for one in dict.fromkeys(values) if one != values[0]] for name, values in places.items()}
    for count in range(MOST_CHANGES + 1):
        for names in combinations(places, count):
            for values in product(*(others[name] for name in names)):
                yield allowed | dict(zip(names, values, strict=True))


@pytest.mark.parametrize("act", Act)
@pytest.mark.promise("h")
def test_every_open_condition_is_named_whatever_else_is_open(act: Act) -> None:
    allowed = 0
    given = permits(act)
    for row in rows_of(act):
        tilt, permit, motion = (str(row.pop(name)) for name in ("tilt", "permit", "motion"))
        inputs = InterlockInputs(
            now=NOW, status_age_s=0.2, tilt_deg=TILT[tilt][0], attitude_threshold_deg=TILT[tilt][1],
            permit=given[permit], motion=MOTIONS[motion], **row,
        )  # fmt: skip
        is_online = row["conversation"] == TALK
        agrees = row["contradiction"] is None
        holds = {
            "online": is_online,
            "own": not row["is_shared"],
            "quick": not row["is_slow"],
            "agrees": agrees,
            "fresh": row["is_status_fresh"],
            "locked": row["active"] is False,
            "active": row["active"] is True,
            "unfired": row["triggered"] is False,
            "flat": tilt in ("flat", "sloping"),
            "level": tilt in ("flat", "no threshold"),
            "still": motion == "still",
            "follows": row["sets_rate"],
            "alone": row["armed"] in (None, act),
            "confirmed": permit in ("confirmed", "ritual") and is_online,
            "ritual": permit == "ritual" and is_online,
            "audit": row["is_audit_ready"],
            "writable": row["is_unlocked"] or (row["active"] is False and agrees and row["is_status_fresh"]),
        }
        expected = [WORDS[word] for word in NEEDED[act].split() if not holds[word]]
        assert [refusal.condition for refusal in refusals(act, inputs)] == expected
        known = [condition for condition in expected if condition in ASKS_NOTHING]
        assert [refusal.condition for refusal in refusals(act, inputs, only=ASKS_NOTHING)] == known
        allowed += not expected
    assert allowed > 0


def test_every_act_has_its_conditions_and_words() -> None:
    assert set(CONDITIONS) == set(TITLES) == set(EFFECTS) == set(Act)
    for act, request in REQUESTS.items():
        is_dangerous = request.hazard is Hazard.DANGEROUS
        assert is_dangerous is (act is not Act.LOCK)
        assert (Interlock.INTENT_DURABLE in CONDITIONS[act]) is is_dangerous


def test_a_condition_that_is_not_judged_here_is_no_condition_that_is_met() -> None:
    from app.safety.interlocks import _why_open

    with pytest.raises(ValueError, match="the values"):
        _why_open(Interlock.RISK_ACCEPTED, Act.WRITE, InterlockInputs(now=NOW))


def test_only_the_ritual_deploys() -> None:
    for origin in Origin:
        inputs = InterlockInputs(
            now=NOW, conversation=TALK, status_age_s=0.0, is_status_fresh=True, active=True, triggered=False,
            permit=Permit(Act.DEPLOY, origin, NOW, TALK),
        )  # fmt: skip
        assert bool(refusals(Act.DEPLOY, inputs)) is (origin is not Origin.RITUAL)


def sentences(act: Act, **known: Any) -> list[str]:
    inputs = InterlockInputs(now=NOW, **({"conversation": TALK} | known))
    return [refusal.sentence for refusal in refusals(act, inputs)]


@pytest.mark.parametrize(
    ("act", "known", "sentence"),
    [
        (Act.ZERO, {"conversation": None}, "The module does not answer."),
        (Act.ZERO, {"is_slow": True}, TOO_SLOW),
        (Act.ZERO, {}, "No current status."),
        (Act.ZERO, {"status_age_s": 1.125}, "The status is 1.1 s old."),
        (Act.ZERO, {"active": True}, "The module is ACTIVE: lock it first."),
        (Act.ZERO, {}, "Unknown: ACTIVE or LOCKED."),
        (Act.DEPLOY, {"active": False}, "The module is LOCKED: activate it first."),
        (Act.ACTIVATE, {"attitude_threshold_deg": 60}, "Unknown: tilt."),
        (Act.ACTIVATE, {"tilt_deg": 7}, "Unknown: attitude threshold."),
        (Act.ACTIVATE, {"tilt_deg": 70, "attitude_threshold_deg": 60},
         "Tilt 70° (threshold 60°): it would fire at once."),
        (Act.ZERO, {"tilt_deg": 12}, "Tilt 12°: lay it level (≤ 10°)."),
        (Act.ZERO, {"motion": MOTIONS["swings"]}, "It moves: 6–9°, 1.0–1.0 g in 2 s."),
        (Act.ZERO, {}, "Not watched for 2 s yet."),
        (Act.ACTIVATE, {"armed": Act.DEPLOY}, "Already armed: Deploy."),
        (Act.ACTIVATE, {"triggered": True}, "The module reports that it has fired."),
        (Act.ACTIVATE, {}, "Unknown: whether it has fired."),
        (Act.DEPLOY, {"is_audit_ready": False}, "The audit log cannot be written."),
        (Act.CHANGE_BAUD, {"sets_rate": False}, "The baud rate of a plain socket is set at its other end."),
        (Act.WRITE, {"active": True, "is_status_fresh": True}, "The module is ACTIVE: lock it first."),
        (Act.WRITE, {"active": False, "status_age_s": 2.0}, "The status is 2.0 s old."),
    ],
)  # fmt: skip
def test_the_sentence_names_the_open_condition(act: Act, known: dict[str, Any], sentence: str) -> None:
    assert sentence in sentences(act, **known)


@pytest.mark.parametrize(
    ("changes", "overtaken_at", "sentence"),
    [
        ({"is_spent": True}, None, "Confirm again: already used."),
        ({"conversation": 8}, None, "Confirm again: it may be another module."),
        ({}, NOW, "Confirm again: LOCK was pressed."),
        ({"granted_at": NOW - 10.0}, None, "Confirm again: 10.0 s old."),
        ({"is_rehearsal": True}, None, "Nothing is sent."),
        ({"act": Act.ACTIVATE}, None, "Not confirmed."),
        ({}, NOW - 1.0, None),
        ({}, None, None),
    ],
)
def test_why_a_permit_is_void(changes: dict[str, Any], overtaken_at: float | None, sentence: str | None) -> None:
    given: dict[str, Any] = {"act": Act.SHUTDOWN, "origin": Origin.CONFIRMATION, "granted_at": NOW - 0.5}
    permit = Permit(**({"conversation": TALK} | given | changes))
    said = sentences(
        Act.SHUTDOWN, permit=permit, overtaken_at=overtaken_at, status_age_s=0.0, is_status_fresh=True, active=False
    )
    assert said == ([] if sentence is None else [sentence])


def view(known: Known, ended: Ended | None = None) -> ConversationView:
    values = MappingProxyType({"active": known, "tilt_deg": known._replace(value=5)})
    return ConversationView(TALK, values=values, ended=ended)


def test_what_is_stale_or_only_acknowledged_is_not_known() -> None:
    assert inputs_at(view(Known(False, How.STREAMED, NOW)), NOW + 0.5).active is False
    assert inputs_at(view(Known(False, How.READ, NOW)), NOW + 1.5).active is None
    assert inputs_at(view(Known(False, How.ACKNOWLEDGED, NOW)), NOW).active is None
    assert inputs_at(ConversationView(), NOW).tilt_deg is None


def test_of_a_conversation_that_is_over_nothing_is_known() -> None:
    ended = view(Known(False, How.READ, NOW), ended=Ended(EndReason.SILENT, NOW))
    inputs = inputs_at(ended, NOW)
    assert (inputs.conversation, inputs.active, inputs.tilt_deg, inputs.is_status_fresh) == (None, None, None, False)


def test_a_permit_is_used_once() -> None:
    permit = Permit(Act.ZERO, Origin.COMMAND_LINE, NOW, TALK)
    assert [permit.spend(), permit.spend()] == [True, False]


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


ROOT = Path(__file__).parents[2]
SENDS = frozenset({"write_all", "set_each"})
"""The procedures that set settings; that they refuse what nobody accepted is held by `test_write.py`."""
BEGINNINGS = {
    "app/cli/set.py": "test_goldens.py::test_what_is_said_and_sent",
    "app/integration.py": "test_integration.py::test_what_takes_protection_away_is_sent_only_where_that_was_accepted",
    "app/fleet/provision.py": "test_cli_provision.py::test_without_consent_or_where_no_module_can_pass_nothing_is_sent",
    "app/preflight/run.py": "test_interlocks.py::test_a_check_only_enables",
    "ui/pages/fleet/group_jobs.py": "test_fleet_groups.py::"
    "test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any",
    "ui/session/settings_draft.py": "test_settings_page.py::test_against_the_advice_needs_a_second_click",
}
"""Files that write settings, and the test that shows how each asks: what is applied, restored or proposed becomes an
edit of the Settings page and is written there."""


def _calls(source: str) -> set[str]:
    tree = ast.parse(source)
    return {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}


@pytest.mark.promise("g")
def test_every_place_where_a_write_begins_is_in_the_table() -> None:
    texts = {path: path.read_text(encoding="utf-8") for room in ("app", "ui") for path in (ROOT / room).rglob("*.py")}
    # Parsing all of them takes a second.
    named = {path: text for path, text in texts.items() if any(name in text for name in SENDS)}
    writing = {path.relative_to(ROOT).as_posix() for path, text in named.items() if _calls(text) & SENDS}
    assert writing == BEGINNINGS.keys()
    for file, function in (row.split("::") for row in BEGINNINGS.values()):
        (path,) = (ROOT / "tests").rglob(file)
        assert f"def {function}(" in path.read_text(encoding="utf-8")


def test_a_check_only_enables() -> None:
    tree = ast.parse((ROOT / "app/preflight/run.py").read_text(encoding="utf-8"))
    changes = [ast.unparse(node) for node in ast.walk(tree)
               if isinstance(node, ast.Call) and ast.unparse(node.func) == "SettingChange"]  # fmt: skip
    assert changes == ["SettingChange(command, True)"]


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
