"""What the board says about a module, who comes first, and checks and profiles for several modules."""

from dataclasses import replace
from types import MappingProxyType

import pytest

from app.diagnosis.link_state import LinkState, Phase
from app.engine.conversation import ConversationView, How, Known
from app.fleet.card import Applied, AppliedProfile, Card, Need, changes_of, differences, outcome_of, result_line
from app.limits.limits import OutOfLimit, Outside
from app.preflight.evidence import void_of_end
from app.preflight.verdict import CheckState, Standing, assess, check_state
from app.procedures.lock import Locked
from app.procedures.read import read_everything
from app.procedures.write import WriteContext, write_all
from app.safety.journal import Outcome
from app.safety.last_known import Activation, SeenActivation
from app.settings.profiles import ManualLine, Profile
from protocol.catalogue import BAUD_RATE, BY_NAME
from protocol.events import Ended, EndReason
from protocol.fields import Value
from tests.support.journals import FakeJournal
from tests.support.line.frames import lose
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.preflight_rig import Fault, check

NOW = 100.0
FAILED = Locked(outcome=Outcome.UNKNOWN, sent=50)
GO, READY, NO_GO = (CheckState(one) for one in (Standing.GO, Standing.READY, Standing.NO_GO))
VOID = CheckState(Standing.VOID, void=void_of_end(Ended(EndReason.RESTARTED, 95.0)))
LOW = Outside(OutOfLimit.CELL_LOW, "3.80 V")


def view(*, ended: bool = False, **values: Value) -> ConversationView:
    known = {key: Known(value, How.READ, NOW) for key, value in ({"triggered": False} | values).items()}
    end = Ended(EndReason.PORT_LOST, NOW) if ended else None
    return ConversationView(number=1, ended=end, values=MappingProxyType(known))


def member(
    phase: Phase = Phase.ONLINE, state: Activation = Activation.LOCKED, conversation: ConversationView | None = None
) -> Card:
    link = LinkState(phase, "word", "What is known.")
    return Card(port="ttyUSB0", link=link, conversation=conversation or view(), activation=SeenActivation(state, 99.0))


TABLE = {
    "it has triggered": (member(conversation=view(triggered=True)), Need.TRIGGERED),
    "it had triggered when it was lost": (
        member(Phase.LOST, conversation=view(triggered=True, ended=True)), Need.TRIGGERED,
    ),
    "LOCK was not reported": (replace(member(), lock_failed=FAILED), Need.NOT_LOCKED),
    "LOCK goes on while the port is lost": (replace(member(Phase.LOST), lock_sent=3), Need.NOT_LOCKED),
    "lost while active": (member(Phase.LOST, Activation.WAS_ACTIVE), Need.WAS_ACTIVE),
    "it may have fired before it restarted": (replace(member(), may_have_fired=True), Need.MAY_HAVE_FIRED),
    "named in the conversation before": (replace(member(), expected="M-07"), Need.NAME),
    "lost": (member(Phase.LOST, Activation.WAS_LOCKED), Need.LINK),
    "being opened": (member(Phase.OPENING, Activation.UNKNOWN), Need.WAIT),
    "NO-GO": (replace(member(), check=NO_GO), Need.NO_GO),
    "active and never checked": (member(state=Activation.ACTIVE), Need.ACTIVE),
    "active after READY": (replace(member(state=Activation.ACTIVE), check=READY), Need.ACTIVE_READY),
    "being checked": (replace(member(), check=CheckState(Standing.CHECKING)), Need.WAIT),
    "never checked": (member(), Need.CHECK),
    "the check void": (replace(member(), check=VOID), Need.VOID),
    "READY": (replace(member(), check=READY), Need.ACTIVATE),
    "GO": (replace(member(state=Activation.ACTIVE), check=GO), Need.NOTHING),
    "GO with a low cell": (
        replace(member(state=Activation.ACTIVE), check=GO, cell_outside=LOW), Need.OUTSIDE,
    ),
}  # fmt: skip


@pytest.mark.promise("l")
def test_what_it_needs_next_and_why() -> None:
    for name, (card, need) in TABLE.items():
        found, sentence = card.needed()
        assert found is need, name
        assert sentence, name
        assert "{" not in sentence, name
    assert replace(member(), check=VOID).needed()[1] == "Check again: The module restarted."
    assert replace(member(), expected="M-07").needed()[1] == "M-07 again? Read its label."
    assert replace(member(), cell_outside=LOW).needed()[1] == "Cell voltage: low, limit 3.80 V"


# Verdicts


@pytest.mark.promise("l")
def test_no_go_names_what_stands_against_it() -> None:
    for options, line, why in (
        ({"cell": 3.4}, ManualLine("Bridle free", is_done=True), "Cell voltage"),
        ({}, ManualLine("Bridle free", is_done=False), "Bridle free"),
        ({}, ManualLine("Bridle free", is_required=True), "Bridle free"),
    ):
        case = check(Fault(options=options)).assessment.case
        assessment = assess(replace(case, profile=case.profile._replace(manual=(line,))))
        card = replace(member(), check=check_state(assessment, None, is_running=False))
        assert card.needed()[1] == f"Not met: {why}"


PROFILE = Profile(
    name="Show",
    settings={"attitude_threshold_deg": 70, "freefall_time_s": 1.2, "attitude_trigger": True, "baud_rate": 9600},
)


def applied(rig: Rig, *, is_cancelled: bool = False) -> AppliedProfile:
    """The profile written to a module that was read before."""
    rig.run(read_everything())
    rows = differences(PROFILE, rig.conversation, rig.clock())
    assert {row.command.key for row in rows} == PROFILE.settings.keys() - {BAUD_RATE.key}
    job = rig.job(write_all(changes_of(rows), WriteContext(journal=FakeJournal())))
    rig.step_for(0.05)
    if is_cancelled:
        job.cancel()
    rig.step_until(lambda: job.has_ended)
    return outcome_of(job.outcome())


@pytest.mark.promise("a")
def test_a_profile_is_compared_written_and_verified_on_each_and_never_called_fine_otherwise() -> None:
    sound, without_time = settled_rig(), settled_rig()
    lose(without_time.bench, BY_NAME["freefall_time"].code)
    results = {
        "a": applied(sound),
        "b": applied(without_time),
        "c": applied(settled_rig(active=True)),
        "d": applied(settled_rig(), is_cancelled=True),
    }
    assert [one.state for one in results.values()] == [
        *(Applied.ACKNOWLEDGED, Applied.FAILED, Applied.REFUSED, Applied.FAILED),
    ]
    assert (
        BY_NAME["attitude_trigger"].title in results["a"].why.translated()
    )  # it cannot be read back, and that is said
    assert results["d"].why.translated().startswith("Attitude threshold: ")
    line = result_line(results.items())
    assert line.startswith("1 written: a · 1 refused: c (The module is ACTIVE")
    assert " · 2 FAILED: b (" in line
    assert differences(PROFILE, sound.conversation, sound.clock()) == []
