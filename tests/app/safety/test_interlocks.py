"""The table of conditions, the permit, every place where a write begins, and which tests hold docs/safety.md."""

import ast
import re
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.device import DeviceView, How, Known, StaleReason
from app.engine.motion import MotionExtremes
from app.safety.acts import EFFECTS, REQUESTS, TITLES, Act
from app.safety.interlocks import CONDITIONS, Interlock, InterlockInputs, interlock_inputs, refusals
from app.safety.permit import Origin, Permit
from protocol.catalogue import Hazard
from protocol.link_states import Presence

NOW = 1000.0
WORDS = {
    "online": Interlock.ONLINE,
    "meant": Interlock.IS_IDENTITY_SETTLED,
    "fresh": Interlock.FRESH_STATUS,
    "locked": Interlock.IS_LOCKED,
    "active": Interlock.IS_ACTIVE,
    "unfired": Interlock.NOT_TRIGGERED,
    "flat": Interlock.BELOW_TILT,
    "level": Interlock.IS_LEVEL,
    "still": Interlock.IS_STILL,
    "alone": Interlock.NOTHING_ELSE_ARMED,
    "confirmed": Interlock.CONFIRMED,
    "ritual": Interlock.RITUAL_DONE,
    "audit": Interlock.INTENT_DURABLE,
    "writable": Interlock.MAY_WRITE,
}
NEEDED = {
    Act.LOCK: "",
    Act.ACTIVATE: "online meant fresh locked unfired flat alone confirmed audit",
    Act.ZERO: "online meant fresh locked level still alone confirmed audit",
    Act.SHUTDOWN: "online meant fresh locked alone confirmed audit",
    Act.FORBID_DEPLOY: "online meant fresh alone confirmed audit",
    Act.DEPLOY: "online meant fresh active unfired alone ritual audit",
    Act.CHANGE_BAUD: "online meant fresh locked alone confirmed audit",
    Act.WRITE: "online meant writable alone",
}
STATUS = {
    "never": (None, None),
    "now": (NOW - 0.2, None),
    "old": (NOW - 3.0, None),
    "restarted": (NOW - 0.2, StaleReason.RESTARTED),
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
        "confirmed": Permit(act, Origin.CONFIRMATION, NOW - 0.5),
        "ritual": Permit(act, Origin.RITUAL, NOW - 0.5),
        "other": Permit(other, Origin.RITUAL, NOW - 0.5),
        "old": Permit(act, Origin.RITUAL, NOW - 1.5),
        "spent": Permit(act, Origin.RITUAL, NOW - 0.5, is_spent=True),
        "rehearsal": Permit(act, Origin.RITUAL, NOW - 0.5, is_rehearsal=True),
        "ahead": Permit(act, Origin.RITUAL, NOW + 0.1),
    }


MOST_CHANGES = 3


def rows_of(act: Act) -> Iterator[dict[str, Any]]:
    """A row in which the act is allowed, and every row that differs from it in up to three places: as no condition
    looks at more than three of them, each condition meets all that it can meet, alone and beside two others."""
    other = Act.ACTIVATE if act is not Act.ACTIVATE else Act.DEPLOY
    places: dict[str, list[Any]] = {
        "presence": [Presence.ONLINE, *Presence],
        "status": ["now", *STATUS],
        "active": [act is Act.DEPLOY, True, False, None],
        "triggered": [False, True, None],
        "tilt": ["flat", *TILT],
        "armed": [None, act, other],
        "permit": ["ritual", *permits(act)],
        "is_audit_ready": [True, False],
        "is_unlocked": [False, True],
        "motion": ["still", *MOTIONS],
        "is_meant": [True, False],
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
        status, tilt, permit, motion = (str(row[name]) for name in ("status", "tilt", "permit", "motion"))
        inputs = InterlockInputs(
            now=NOW, presence=row["presence"], status_at=STATUS[status][0], status_fault=STATUS[status][1],
            active=row["active"], triggered=row["triggered"], tilt_deg=TILT[tilt][0],
            attitude_threshold_deg=TILT[tilt][1], armed=row["armed"], permit=given[permit],
            is_unlocked=row["is_unlocked"], is_audit_ready=row["is_audit_ready"], motion=MOTIONS[motion],
            is_identity_settled=row["is_meant"],
        )  # fmt: skip
        holds = {
            "online": row["presence"] is Presence.ONLINE,
            "meant": row["is_meant"],
            "fresh": status == "now",
            "locked": row["active"] is False,
            "active": row["active"] is True,
            "unfired": row["triggered"] is False,
            "flat": tilt in ("flat", "sloping"),
            "level": tilt in ("flat", "no threshold"),
            "still": motion == "still",
            "alone": row["armed"] in (None, act),
            "confirmed": permit in ("confirmed", "ritual"),
            "ritual": permit == "ritual",
            "audit": row["is_audit_ready"],
            "writable": row["is_unlocked"] or row["active"] is False,
        }
        expected = [WORDS[word] for word in NEEDED[act].split() if not holds[word]]
        assert [refusal.condition for refusal in refusals(act, inputs)] == expected
        allowed += not expected
    assert allowed > 0


def test_every_act_has_its_conditions_and_words() -> None:
    assert set(CONDITIONS) == set(TITLES) == set(EFFECTS) == set(Act)
    for act, request in REQUESTS.items():
        is_dangerous = request.hazard is Hazard.DANGEROUS
        assert is_dangerous is (act is not Act.LOCK)
        assert (Interlock.INTENT_DURABLE in CONDITIONS[act]) is is_dangerous


def test_the_rate_is_changed_only_where_the_port_follows() -> None:
    for act in Act:
        refused = {one.condition for one in refusals(act, InterlockInputs(now=NOW, sets_rate=False))}
        assert (Interlock.RATE_FOLLOWS in refused) is (act is Act.CHANGE_BAUD)


def test_only_the_ritual_deploys() -> None:
    for origin in Origin:
        inputs = InterlockInputs(
            now=NOW, presence=Presence.ONLINE, status_at=NOW, active=True, triggered=False,
            permit=Permit(Act.DEPLOY, origin, NOW),
        )  # fmt: skip
        assert bool(refusals(Act.DEPLOY, inputs)) is (origin is not Origin.RITUAL)


@pytest.mark.parametrize(
    ("act", "inputs", "sentence"),
    [
        (Act.ZERO, InterlockInputs(now=NOW), "The module does not answer."),
        (Act.ZERO, InterlockInputs(now=NOW), "No current status."),
        (Act.ZERO, InterlockInputs(now=NOW, active=True), "The module is ACTIVE: lock it first."),
        (Act.DEPLOY, InterlockInputs(now=NOW, active=False), "The module is LOCKED: activate it first."),
        (Act.ACTIVATE, InterlockInputs(now=NOW, attitude_threshold_deg=60), "Unknown: Tilt."),
        (Act.ACTIVATE, InterlockInputs(now=NOW, tilt_deg=7), "Unknown: Attitude threshold."),
        (Act.ACTIVATE, InterlockInputs(now=NOW, armed=Act.DEPLOY), "Already armed: Deploy."),
        (Act.ACTIVATE, InterlockInputs(now=NOW, triggered=True), "The module reports that it has fired."),
        (Act.ACTIVATE, InterlockInputs(now=NOW), "Unknown: Trigger."),
        (Act.DEPLOY, InterlockInputs(now=NOW, is_audit_ready=False),
         "The audit log cannot be written."),
        (Act.WRITE, InterlockInputs(now=NOW, active=True),
         "The module is ACTIVE: lock it first."),
    ],
)  # fmt: skip
def test_the_sentence_names_the_open_condition(act: Act, inputs: InterlockInputs, sentence: str) -> None:
    assert sentence in [refusal.sentence for refusal in refusals(act, inputs)]


def test_what_is_stale_or_only_acknowledged_is_not_known() -> None:
    def view(known: Known) -> DeviceView:
        return DeviceView(MappingProxyType({"active": known, "tilt_deg": Known(5, How.READ, NOW)}), Presence.ONLINE)

    assert interlock_inputs(view(Known(False, How.STREAMED, NOW)), NOW + 0.5, must_be_proven=False).active is False
    assert interlock_inputs(view(Known(False, How.READ, NOW)), NOW + 1.5, must_be_proven=False).active is None
    assert (
        interlock_inputs(view(Known(False, How.READ, NOW, StaleReason.RESTARTED)), NOW, must_be_proven=False).active
        is None
    )
    assert interlock_inputs(view(Known(False, How.ACKNOWLEDGED, NOW)), NOW, must_be_proven=False).active is None
    assert interlock_inputs(DeviceView(), NOW, must_be_proven=False).tilt_deg is None


def test_what_sends_counts_from_when_the_status_was_sent_and_displays_from_when_it_arrived() -> None:
    known = Known(5, How.STREAMED, NOW - 0.2, sent_after=NOW - 0.9)
    view = DeviceView(MappingProxyType({"tilt_deg": known}), Presence.ONLINE, lag_s=1.5)
    sends, shows = (interlock_inputs(view, NOW, must_be_proven=one) for one in (True, False))
    assert (sends.status_at, sends.status_fault) == (NOW - 0.9, None)
    assert (shows.status_at, shows.status_fault) == (pytest.approx(NOW - 1.7), StaleReason.LATE)  # less what it is late


@pytest.mark.parametrize(("lag_s", "named_s"), [(None, None), (0.02, None), (2.5, 2.5)])
def test_a_lag_is_named_only_where_data_arrives_too_late(lag_s: float | None, named_s: float | None) -> None:
    assert interlock_inputs(DeviceView(lag_s=lag_s), NOW, must_be_proven=False).lag_s == named_s


def test_a_permit_is_used_once() -> None:
    permit = Permit(Act.ZERO, Origin.COMMAND_LINE, NOW)
    assert [permit.spend(), permit.spend()] == [True, False]


def open_for(act: Act, **known: Any) -> dict[Interlock, str]:
    return {refusal.condition: refusal.sentence for refusal in refusals(act, InterlockInputs(now=NOW, **known))}


@pytest.mark.parametrize(
    ("known", "sentence"),
    [
        ({"status_at": NOW}, None),
        ({"status_at": NOW - 1.0}, None),
        ({"status_at": NOW - 1.125}, "The status is 1.1 s old."),
        ({"status_at": NOW - 1.5, "status_fresh_for_s": 1.5}, None),
        ({"status_at": NOW - 1.625, "status_fresh_for_s": 1.5}, "The status is 1.6 s old."),
        ({"status_at": NOW + 0.125}, "The status is 0.0 s old."),
        ({"status_at": NOW - 1.125, "lag_s": 2.5}, "Data arrives 2.5 s late."),
        ({"status_at": NOW - 0.5, "status_fault": StaleReason.LATE, "lag_s": 2.5}, "Data arrives 2.5 s late."),
        ({"status_at": NOW - 3.0, "lag_s": 2.5, "presence": Presence.OFFLINE}, "The status is 3.0 s old."),
        ({"status_at": NOW - 0.5, "status_fault": StaleReason.RESTARTED, "lag_s": 2.5}, "No current status."),
        ({"lag_s": 2.5}, "No current status."),
        ({"status_at": float("-inf")}, "No current status."),
    ],
)
def test_a_status_counts_for_a_second_and_its_age_is_named(known: dict[str, Any], sentence: str | None) -> None:
    assert open_for(Act.SHUTDOWN, **known).get(Interlock.FRESH_STATUS) == sentence


@pytest.mark.parametrize(
    ("tilt_deg", "level", "below"),
    [
        (10.0, None, None),
        (11.0, "Tilt 11°: lay it level (≤ 10°).", None),
        (59.0, "Tilt 59°: lay it level (≤ 10°).", None),
        (60.0, "Tilt 60°: lay it level (≤ 10°).", "Tilt 60° (threshold 60°): it would fire at once."),
    ],
)
def test_the_tilt_at_its_limits(tilt_deg: float, level: str | None, below: str | None) -> None:
    known = {"tilt_deg": tilt_deg, "attitude_threshold_deg": 60.0}
    assert open_for(Act.ZERO, **known).get(Interlock.IS_LEVEL) == level
    assert open_for(Act.ACTIVATE, **known).get(Interlock.BELOW_TILT) == below


@pytest.mark.parametrize(
    ("motion", "sentence"),
    [
        (MotionExtremes(0.0, 1.8, 6.0, 8.0, 0.9, 1.1), None),
        (MotionExtremes(0.0, 1.75, 6.0, 8.0, 0.9, 1.1), "Not watched for 2 s yet."),
        (MotionExtremes(0.0, 1.8, 6.0, 9.0, 0.9, 1.1), "It moves: 6–9°, 0.9–1.1 g in 2 s."),
        (MotionExtremes(0.0, 1.8, 6.0, 8.0, 0.8, 1.1), "It moves: 6–8°, 0.8–1.1 g in 2 s."),
        (MotionExtremes(0.0, 1.8, 6.0, 8.0, 0.9, 1.2), "It moves: 6–8°, 0.9–1.2 g in 2 s."),
    ],
)
def test_it_is_still_within_two_degrees_and_a_tenth_of_a_g(motion: MotionExtremes, sentence: str | None) -> None:
    assert open_for(Act.ZERO, motion=motion).get(Interlock.IS_STILL) == sentence


@pytest.mark.parametrize(
    ("origin", "seconds"), [(Origin.RITUAL, 1), (Origin.CONFIRMATION, 5), (Origin.COMMAND_LINE, 10)]
)
def test_a_permit_lasts_as_long_as_its_origin_says(origin: Origin, seconds: int) -> None:
    permit = Permit(Act.ZERO, origin, NOW)
    assert permit.is_good(Act.ZERO, NOW)
    assert permit.is_good(Act.ZERO, NOW + seconds)
    assert not permit.is_good(Act.ZERO, NOW + seconds + 0.125)
    assert not permit.is_good(Act.ZERO, NOW - 0.125)
    assert not permit.is_good(Act.ACTIVATE, NOW)


@pytest.mark.parametrize(
    ("name", "why"),
    [("slept_until", "computer slept"), ("overtaken_at", "LOCK was pressed"), ("opened_at", "port reopened")],
)
def test_what_came_after_a_permit_voids_it(name: str, why: str) -> None:
    for granted_at, is_void in ((NOW - 0.25, True), (NOW - 0.125, True), (NOW, False)):
        permit = Permit(Act.ZERO, Origin.CONFIRMATION, granted_at)
        found = open_for(Act.ZERO, permit=permit, **{name: NOW - 0.125}).get(Interlock.CONFIRMED)
        assert found == (f"Confirm again: {why}." if is_void else None)


def test_a_permit_that_does_not_count_is_named_with_the_reason() -> None:
    def why(permit: Permit, act: Act = Act.ZERO) -> str | None:
        return open_for(act, permit=permit).get(Interlock.RITUAL_DONE if act is Act.DEPLOY else Interlock.CONFIRMED)

    assert why(Permit(Act.ZERO, Origin.CONFIRMATION, NOW, is_spent=True)) == "Confirm again: already used."
    assert why(Permit(Act.ZERO, Origin.CONFIRMATION, NOW - 5.5)) == "Confirm again: 5.5 s old."
    assert why(Permit(Act.ZERO, Origin.CONFIRMATION, NOW + 1.0)) == "Confirm again: 0.0 s old."
    assert why(Permit(Act.ZERO, Origin.CONFIRMATION, NOW, is_rehearsal=True)) == "Nothing is sent."
    assert why(Permit(Act.ACTIVATE, Origin.CONFIRMATION, NOW)) == "Not confirmed."
    assert why(Permit(Act.DEPLOY, Origin.CONFIRMATION, NOW), Act.DEPLOY) == "Not armed and held for 2 s."


ROOT = Path(__file__).parents[3]
SENDS = frozenset({"write_all", "write_logged", "write_verified"})
"""The procedures that set settings; that they refuse what nobody accepted is held by `test_write_all.py`."""
BEGINNINGS = {
    "app/cli/settings/set.py": "test_goldens.py::test_what_is_said_and_sent",
    "app/preflight/provision.py": "test_cli_provision.py::"
    "test_without_consent_or_where_no_module_can_pass_nothing_is_sent",
    "app/preflight/run.py": "test_interlocks.py::test_a_check_only_enables",
    "app/procedures/write_all.py": "test_write_all.py::"
    "test_nothing_that_takes_protection_away_is_sent_unless_a_person_accepted_it",
    "ui/pages/fleet/group_jobs.py": "test_fleet_groups.py::"
    "test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any",
    "ui/pages/settings/controller.py": "test_settings_page.py::test_against_the_advice_needs_a_second_click",
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


TESTS = Path(__file__).parents[2]
PAGE = TESTS.parent / "docs" / "safety.md"


def test_each_requirement_of_the_page_is_held_by_tests() -> None:
    letters = re.findall(r"^## ([a-z])\. ", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert letters == list("abcdefghijkl")
    texts = "".join(path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py"))
    marks = re.findall(r"@pytest\.mark\.promise\((.*)\)", texts)
    assert {letter: sum(f'"{letter}"' in mark for mark in marks) >= 3 for letter in letters} == dict.fromkeys(
        letters, True
    )
