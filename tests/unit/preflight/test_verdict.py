"""How long a verdict holds, and what voids it: the end of its conversation, a change, an act that may have fired."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import pytest

from app.engine.conversation import ConversationView, How, Known, StatusSample
from app.limits.past import Past
from app.preflight.checks import Case, Person
from app.preflight.evidence import FIRED, OVER, TOO_OLD, UNFINISHED, Evidence, TriggerFlag, Void
from app.preflight.reading_object import readings_of
from app.preflight.run import activate_ready
from app.preflight.verdict import Assessment, Standing, Verdict, assess, check_state, void_of_news, void_reason
from app.safety.journal import REQUESTS, Act, Outcome
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.text.messages import UserMessage
from protocol.events import Ended, EndReason, Sent
from protocol.fields import Value
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.preflight_rig import gather, judged

ENDED = 1000.0


def evidence(**more: Any) -> Evidence:
    return Evidence(**{"port": "sim", "conversation": 3, "ended_at": ENDED, **more})


def void(
    now: float = ENDED, *, found: Evidence | None = None, values: Mapping[str, Value] = MappingProxyType({}),
    number: int = 3, ended: Ended | None = None,
) -> Void | None:  # fmt: skip
    known = {key: Known(value, How.READ, now) for key, value in values.items()}
    view = ConversationView(number=number, ended=ended, values=MappingProxyType(known))
    case = Case(evidence=found or evidence(), profile=NO_PROFILE, past=Past())
    return void_reason(assess(case), view, now)


def test_a_verdict_holds_for_fifteen_minutes() -> None:
    for now, reason in ((0.0, None), (900.0, None), (900.125, TOO_OLD), (-0.125, TOO_OLD)):
        assert void(ENDED + now) == reason, now


@pytest.mark.parametrize("reason", list(EndReason))
@pytest.mark.promise("f")
def test_it_is_void_with_the_sentence_with_which_its_conversation_ends(reason: EndReason) -> None:
    found = void(ended=Ended(reason, ENDED))
    assert found is not None
    assert found.word == reason.name.lower()
    assert found.message.in_english().endswith((".", "?"))


def test_it_is_void_in_another_conversation_and_where_it_did_not_end() -> None:
    assert void(number=4) == OVER
    assert void(found=evidence(ended_at=None)) == UNFINISHED
    assert void(found=evidence(void=FIRED)) == FIRED


@pytest.mark.parametrize(
    ("checked", "key", "value", "shown"),
    [
        ({"values": {"freefall_time_s": 1.6}}, "freefall_time_s", 1.7, "Changed: Free-fall time."),
        ({"series": {"charging": [True, False]}}, "charging", True, "Changed: Charging."),
        ({"flags": {"attitude_trigger": TriggerFlag(True)}}, "attitude_trigger", False,
         "Changed: Attitude trigger."),
        # Not known any more: it was set and not acknowledged, or an acknowledgement came once more.
        ({"flags": {"attitude_trigger": TriggerFlag(True)}}, "boot_count", 7, "Changed: Attitude trigger."),
    ],
)  # fmt: skip
def test_a_value_that_changed_is_named(checked: dict[str, Any], key: str, value: Value, shown: str) -> None:
    found = void(found=evidence(**checked), values={key: value})
    assert found is not None
    assert (found.word, found.message.in_english()) == ("changed", shown)
    assert void(found=evidence(), values={key: value}) is None, "it was not checked"
    same = {"freefall_time_s": 1.6, "charging": False, "attitude_trigger": True}
    assert void(found=evidence(**checked), values=same) is None


def sample(*, triggered: bool) -> StatusSample:
    return StatusSample(ENDED, 0, 1.0, triggered, active=True)


@pytest.mark.promise("f")
def test_a_deploy_that_left_and_a_trigger_that_was_seen_void_it() -> None:
    deploy = REQUESTS[Act.DEPLOY]
    assert void_of_news([Sent(deploy.encode(), deploy, 1, ENDED)], []) == FIRED
    assert void_of_news([], [sample(triggered=False), sample(triggered=True)]) == FIRED
    forbid = REQUESTS[Act.FORBID_DEPLOY]
    assert void_of_news([Sent(forbid.encode(), forbid, 1, ENDED)], [sample(triggered=False)]) is None
    assert void(values={"triggered": True}) == FIRED
    was_seen = evidence(reports=[sample(triggered=True)])
    assert void(found=was_seen, values={"triggered": True}) is None, "it is NO-GO by that already"


def test_a_manual_item_stands_against_go() -> None:
    for is_done, is_required, against in (
        (True, True, False), (False, True, True), (False, False, True), (None, True, True), (None, False, False),
    ):  # fmt: skip
        item = ManualLine("Bridle free", is_done=is_done, is_required=is_required)
        case = Case(evidence=evidence(), profile=Profile(manual=(item,)), past=Past())
        assert (UserMessage("Bridle free") in assess(case).titles_against) is against, (is_done, is_required)


@pytest.mark.promise("l")
def test_how_a_check_stands() -> None:
    found = assess(Case(evidence=evidence(), profile=NO_PROFILE, past=Past()))
    assert check_state(None, None, is_running=True) == check_state(None, FIRED, is_running=True)
    assert check_state(None, FIRED, is_running=True).standing is Standing.CHECKING
    assert check_state(found, FIRED, is_running=False) == (Standing.VOID, found, FIRED)
    assert check_state(found, None, is_running=False) == (Standing.NO_GO, found, None)
    assert check_state(found, None, is_running=False).ended_at == ENDED


# With a module


def test_an_opened_bay_or_a_low_cell_voids() -> None:
    rig, least = settled_rig(), NO_PROFILE.limit("cell_voltage_min_v")
    assessment = judged(rig, gather(rig, is_enabling=True)).assessment
    now, view = rig.clock(), rig.conversation
    for key, value, is_void in (
        ("light_v", 1.7, False), ("light_v", 1.8, True),
        ("cell_voltage_v", least, False), ("cell_voltage_v", least - 0.02, True),
    ):  # fmt: skip
        changed = view._replace(values={**view.values, key: Known(value, How.READ, now)})
        found = void_reason(assessment, changed, now)
        assert (found is not None and found.word == "changed") is is_void, (key, value)


# From READY to GO


def ready_case(rig: Rig) -> Assessment:
    found = gather(rig, is_enabling=True)
    ready = assess(Case(evidence=found, profile=NO_PROFILE, past=Past(), person=Person(are_records_reviewed=True)))
    assert ready.verdict is Verdict.READY
    return ready


def test_what_is_no_longer_ready_is_not_activated() -> None:
    rig = settled_rig()
    ready = ready_case(rig)
    rig.clock.now_s += 1.0
    rig.session.treat_as_another()
    rig.begin()
    performed, found = rig.run(activate_ready(ready, FakeJournal(), rig.permit(Act.ACTIVATE)))
    assert performed.outcome is Outcome.NOT_SENT
    assert found.void == OVER
    assert REQUESTS[Act.ACTIVATE].encode() not in rig.acts


def test_the_round_trip_of_its_readings_is_the_median() -> None:
    assert readings_of(evidence(round_trips_s=[0.009, 0.001, 0.002])).link.round_trip_ms == 2.0
    assert readings_of(evidence()).link.round_trip_ms is None
