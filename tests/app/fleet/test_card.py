"""What the board says about a module, and who comes first."""

from dataclasses import replace
from types import MappingProxyType

import pytest

from app.diagnosis.link_state import LinkState, Phase
from app.engine.device import DeviceView, How, Known, StaleReason
from app.engine.identity import Identity, Trust
from app.fleet.card import Card, LockState, Need, by_need, card_of
from app.fleet.check_set import SetMember
from app.fleet.verdicts import HeldVerdict, KeptCheck
from app.limits.out_of_limits import LimitsInUse
from app.preflight.evidence import Disturbance
from app.preflight.verdict import Verdict, Void, assess
from app.procedures.lock import Locked
from app.records.filing import Filed
from app.safety.journal import Outcome
from app.safety.last_known import Activation, SeenActivation
from app.settings.profiles import ManualLine
from app.text.messages import UserMessage
from protocol.fields import Value
from protocol.link_states import Presence
from tests.support.records.preflight_rig import Checked, check

NOW = 100.0
FAILED = Locked(outcome=Outcome.UNKNOWN, sent=50)
GO, READY, NO_GO = (HeldVerdict(one, 90.0) for one in (Verdict.GO, Verdict.READY, Verdict.NO_GO))
VOID = HeldVerdict(None, 90.0, Void(Disturbance.RESTARTED))
VALUES: dict[str, Value] = {"tilt_deg": 7, "triggered": False, "cell_voltage_v": 4.0}


def view(at: float = NOW, stale: StaleReason | None = None, **values: Value) -> DeviceView:
    known = {key: Known(value, How.READ, at, stale) for key, value in (VALUES | values).items()}
    return DeviceView(MappingProxyType(known), Presence.ONLINE, 0.0)


def member(
    phase: Phase = Phase.ONLINE, state: Activation = Activation.LOCKED, device: DeviceView | None = None
) -> Card:
    link = LinkState(phase, "/dev/ttyUSB0", 115200)
    return Card(port="ttyUSB0", link=link, device=device or view(), activation=SeenActivation(state, 99.0))


TABLE = {
    "it has triggered": (member(device=view(triggered=True)), Need.TRIGGERED),
    "it had triggered when it was lost": (
        member(Phase.LOST, device=view(triggered=True, stale=StaleReason.LINK_LOST)), Need.TRIGGERED,
    ),
    "LOCK was not reported": (replace(member(), lock=LockState(failed=FAILED)), Need.NOT_LOCKED),
    "LOCK goes on while the port is lost": (replace(member(Phase.LOST), lock=LockState(sent=3)), Need.NOT_LOCKED),
    "lost while active": (member(Phase.LOST, Activation.WAS_ACTIVE), Need.WAS_ACTIVE),
    "perhaps another one": (replace(member(), identity=Identity(Trust.REFUTED)), Need.IDENTITY),
    "lost": (member(Phase.LOST, Activation.WAS_LOCKED), Need.LINK),
    "no answer": (member(Phase.SILENT, Activation.UNKNOWN), Need.LINK),
    "being opened": (member(Phase.OPENING, Activation.UNKNOWN), Need.WAIT),
    "NO-GO": (replace(member(), verdict=NO_GO), Need.NO_GO),
    "NO-GO while lost": (replace(member(Phase.LOST), verdict=NO_GO), Need.LINK),
    "active and never checked": (member(state=Activation.ACTIVE), Need.ACTIVE),
    "active, the check void": (replace(member(state=Activation.ACTIVE), verdict=VOID), Need.ACTIVE),
    "being checked": (replace(member(), is_checking=True, verdict=NO_GO), Need.WAIT),
    "never checked": (member(), Need.CHECK),
    "the check void": (replace(member(), verdict=VOID), Need.VOID),
    "READY": (replace(member(), verdict=READY), Need.ACTIVATE),
    "GO": (replace(member(state=Activation.ACTIVE), verdict=GO), Need.NOTHING),
    "GO with a low cell": (
        replace(member(state=Activation.ACTIVE, device=view(cell_voltage_v=3.5)), verdict=GO), Need.OUTSIDE,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLE)
def test_what_it_needs_next(name: str) -> None:
    one, need = TABLE[name]
    card = card_of(one, NOW, LimitsInUse())
    assert card.need is need
    assert card.next_step(NOW)
    assert "{" not in card.next_step(NOW)


def test_what_is_due_stands_below_what_it_needs_and_never_beside_nothing() -> None:
    due = (UserMessage("Repack overdue since 2026-11-23."),)
    locked, at_go = (replace(TABLE[name][0], name="M-07", due=due) for name in ("never checked", "GO"))
    assert card_of(locked, NOW, LimitsInUse()).next_step(NOW) == "Start the check.\nRepack overdue since 2026-11-23."
    assert card_of(at_go, NOW, LimitsInUse()).next_step(NOW) == "Repack overdue since 2026-11-23."


def test_who_needs_a_person_comes_first() -> None:
    cards = [card_of(one, NOW, LimitsInUse()) for one, _ in TABLE.values()]
    ordered = by_need(cards)
    assert [card.need.rank for card in ordered] == sorted(card.need.rank for card in cards)
    assert ordered[0].need is Need.TRIGGERED
    assert ordered[-1].need is Need.NOTHING
    names = [card_of(replace(member(), name=name), NOW, LimitsInUse()) for name in ("", "M-10", "M-2", "m-1")]
    assert [card.name for card in by_need(names)] == ["m-1", "M-2", "M-10", ""]


@pytest.mark.parametrize("phase", [one for one in Phase if one is not Phase.ONLINE])
def test_a_card_that_is_not_connected_shows_no_number(phase: Phase) -> None:
    card = card_of(member(phase), NOW, LimitsInUse())
    assert (card.tilt_deg, card.cell_v, card.cell_outside) == (None, None, None)
    assert card.need is not Need.NOTHING


def test_old_numbers_are_not_shown_although_the_link_stands() -> None:
    card = card_of(member(device=view(NOW - 60.0)), NOW, LimitsInUse())
    assert (card.tilt_deg, card.cell_v) == (None, None)
    fresh = card_of(member(), NOW, LimitsInUse())
    assert (fresh.tilt_deg, fresh.cell_v) == (7, 4.0)


# Verdicts


def checked(**options: str) -> tuple[Checked, Filed]:
    found = check(options=options)
    return found, Filed(found.assessment, {})


def test_a_verdict_holds_until_something_speaks_against_it_and_stays_void_then() -> None:
    found, filed = checked()
    now, device = found.rig.clock(), found.rig.session.device.view(found.rig.clock())
    kept = KeptCheck(filed).polled(device, now, is_open=True)
    assert kept.held(device, now).verdict is Verdict.READY
    kept = kept.polled(device, now, is_open=False).polled(device, now, is_open=True)  # unplugged for a moment
    held = kept.held(device, now)
    assert (held.verdict, held.void) == (None, Void(Disturbance.DISCONNECTED))
    late = KeptCheck(filed).polled(device, now + 3600.0, is_open=True)
    assert late.held(device, now + 3600.0).verdict is None


def test_ready_is_not_go_because_it_was_activated_and_go_is_ready_when_it_is_locked() -> None:
    found, filed = checked()
    device, now = found.rig.session.device.view(found.rig.clock()), found.rig.clock()
    active = replace(device, values=MappingProxyType({**device.values, "active": Known(True, How.READ, now)}))
    assert KeptCheck(filed).polled(active, now, is_open=True).held(active, now).verdict is None
    case = filed.assessment.case
    assert case.evidence.status is not None
    seen_active = replace(case, evidence=replace(case.evidence, status=case.evidence.status._replace(active=True)))
    kept = KeptCheck(Filed(assess(seen_active), {}))
    both = (kept.polled(view, now, is_open=True).held(view, now) for view in (active, device))
    assert [held.verdict for held in both] == [Verdict.GO, Verdict.READY]


@pytest.mark.parametrize(
    ("options", "manual", "why"),
    [
        ({"cell": "3.4"}, (), "Cell voltage"),
        ({}, (ManualLine("Bridle free", is_done=False),), "Bridle free"),
        ({}, (ManualLine("Bridle free", is_required=True),), "Bridle free"),
    ],
)
def test_no_go_names_what_stands_against_it(options: dict[str, str], manual: tuple[ManualLine, ...], why: str) -> None:
    found, filed = checked(**options)
    case = filed.assessment.case
    assessment = assess(replace(case, profile=replace(case.profile, manual=manual)))
    now = found.rig.clock()
    device = found.rig.session.device.view(now)
    held = KeptCheck(Filed(assessment, {})).polled(device, now, is_open=True).held(device, now)
    card = card_of(replace(member(), verdict=held), NOW, LimitsInUse())
    assert card.need is Need.NO_GO
    assert card.next_step(NOW) == f"Not met: {why}"
    assert SetMember("ttyUSB0", "M-7", Filed(assessment, {})).why == why
