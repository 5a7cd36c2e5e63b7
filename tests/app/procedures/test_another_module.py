"""Another module, that runs already, follows behind the open port at any frame of a procedure."""

from collections.abc import Callable

import pytest

from app.engine.identity import IdentityCheck, Trust
from app.engine.procedure import Procedure, ask_report
from app.limits.past import Past
from app.preflight.activation import activate_ready
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import Case, Person
from app.preflight.run import run_preflight
from app.preflight.verdict import Verdict, assess
from app.procedures.act import perform
from app.procedures.baud import BaudEnd, change_baud
from app.procedures.light_calibration import measure_light
from app.procedures.read import read_everything
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.settings.profiles import NO_PROFILE
from app.text.user_error import UserError
from app.trigger_records.filing import read_triggers
from protocol.catalogue import BY_NAME, Request
from tests.support.journals import FakeJournal
from tests.support.line.exchange import ExchangedRig
from tests.support.thorough import some

Begin = Callable[[ExchangedRig], Procedure[object]]
EDITS = {"attitude_threshold": 75, "freefall_acceleration": 0.5, "light_threshold": 1.5}
TRIGGERS = {"attitude_trigger": True, "freefall_trigger": True}


def act(which: Act) -> Begin:
    return lambda rig: perform(which, FakeJournal(), permit=rig.permit(which))


def write(**values: float) -> Begin:
    changes = [SettingChange(BY_NAME[name], value) for name, value in values.items()]
    return lambda _rig: write_all(changes, WriteContext(journal=FakeJournal()))


def check(_rig: ExchangedRig) -> Procedure[object]:
    return run_preflight(Evidence(port="sim"), is_enabling=True, journal=FakeJournal())


def number_of(begin: Begin, request: Request) -> int:
    """Which frame of the procedure it is."""
    rig = ExchangedRig(0)
    before = len(rig.line.requests)
    rig.run(begin(rig))
    return rig.line.requests[before:].index(request) + 1


@pytest.mark.parametrize("boots", [37, 90], ids=["the same boot count", "a higher one"])
@pytest.mark.parametrize(
    ("begin", "frames"),
    [
        (act(Act.ACTIVATE), range(1, 6)),
        (act(Act.SHUTDOWN), range(1, 6)),
        (act(Act.FORBID_DEPLOY), range(1, 6)),
        (act(Act.ZERO), range(1, 36, 4)),
        (write(**EDITS), range(1, 38)),
        (write(**TRIGGERS), range(1, 29)),
        (check, range(1, 64, 3)),
    ],
    ids=["activate", "shut down", "forbid", "zero", "settings", "triggers", "check"],
)
@pytest.mark.promise("a")
def test_nothing_is_sent_to_it_that_was_decided_for_the_one_before(begin: Begin, frames: range, boots: int) -> None:
    for frame in some(frames, one_in=2, first=boots):
        rig = ExchangedRig(frame, boots=boots)
        rig.run(begin(rig))
        assert rig.is_exchanged
        assert rig.to_second == [], frame


@pytest.mark.parametrize("is_active", [True, False])
@pytest.mark.parametrize(
    ("which", "frames", "outcome"),
    [
        (Act.ACTIVATE, (1, 2), Outcome.UNKNOWN),
        (Act.SHUTDOWN, (1,), Outcome.UNKNOWN),
        (Act.ZERO, (1, 2), Outcome.CONFIRMED),  # it acknowledged that before it was pulled out
    ],
)
def test_what_it_reports_after_an_act_is_not_said_of_the_first_one(
    which: Act, frames: tuple[int, ...], outcome: Outcome, is_active: bool
) -> None:
    number = number_of(act(which), REQUESTS[which])
    for after in frames:
        frame = number + after
        rig = ExchangedRig(frame, boots=37)
        rig.second.module.activate(is_active=is_active)
        performed = rig.run(perform(which, FakeJournal(), permit=rig.permit(which)))
        assert rig.is_exchanged
        assert (performed.outcome, performed.status) == (outcome, None), frame


@pytest.mark.parametrize("boots", [37, 90])
@pytest.mark.promise("a")
def test_it_is_not_activated_because_the_first_one_was_ready(boots: int) -> None:
    """On the command line, while the check is being stored."""
    rig, evidence = ExchangedRig(0, boots=boots), Evidence(port="sim")
    rig.session.identity = IdentityCheck()
    rig.run(run_preflight(evidence, is_enabling=True, journal=FakeJournal()))
    person = Person(who="R. Tanaka", are_records_reviewed=True)
    ready = assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past(module=None), person=person))
    assert ready.verdict is Verdict.READY
    rig.exchange_at(1)
    for _ in range(3):
        rig.run(ask_report())
    permit = Permit(Act.ACTIVATE, Origin.COMMAND_LINE, rig.clock())
    performed, after = rig.run(activate_ready(ready, FakeJournal(), permit))
    assert (rig.is_exchanged, rig.to_second) == (True, [])
    assert performed.sentence == "Nothing was sent. Void: no reply for a moment."
    assert after.disturbance is Disturbance.BROKEN


@pytest.mark.parametrize("boots", [37, 90])
@pytest.mark.promise("a")
def test_what_is_read_from_it_is_not_said_of_the_first_one(boots: int) -> None:
    """What was written to that one is unknown: it is neither verified nor refused."""
    changes = [SettingChange(BY_NAME[name], value) for name, value in EDITS.items()]
    number = number_of(write(**EDITS), BY_NAME["attitude_threshold"].set(75))
    for frame in some(range(number, number + 36), one_in=2, first=boots):
        rig, journal = ExchangedRig(frame, boots=boots), FakeJournal()
        report = rig.run(write_all(changes, WriteContext(journal=journal)))
        assert rig.is_exchanged
        assert (report.changed, {*journal.outcomes.values()}) == ((), {Outcome.UNKNOWN}), frame
        assert not any(written.verified or written.read_back for written in report.results), frame


@pytest.mark.parametrize("boots", [37, 90])
@pytest.mark.promise("a")
def test_its_baud_rate_is_not_said_of_the_first_one(boots: int) -> None:
    begin: Begin = lambda rig: change_baud(57600, FakeJournal(), permit=rig.permit(Act.CHANGE_BAUD))  # noqa: E731
    number = number_of(begin, BY_NAME["baud_rate"].set(57600))
    for frame in range(1, number + 3):
        rig, journal = ExchangedRig(frame, boots=boots), FakeJournal()
        changed = rig.run(change_baud(57600, journal, permit=rig.permit(Act.CHANGE_BAUD)))
        assert (rig.is_exchanged, rig.to_second) == (True, [])
        assert changed.end is (BaudEnd.NOT_SENT if frame < number else BaudEnd.LOST), frame
        assert set(journal.outcomes.values()) <= {Outcome.UNKNOWN, Outcome.NOT_SENT}, frame


@pytest.mark.parametrize(
    ("frame", "boots"), some([*((at, 90) for at in range(1, 26)), *((at, 37) for at in range(4, 26))], one_in=2)
)
@pytest.mark.promise("a")
def test_records_of_both_are_not_read_as_those_of_one(frame: int, boots: int) -> None:
    rig = ExchangedRig(frame, boots=boots)
    with pytest.raises(UserError, match=r"The module restarted|Two modules"):
        rig.run(read_triggers())
    assert rig.is_exchanged


@pytest.mark.parametrize("frame", range(1, 16))
@pytest.mark.promise("a")
def test_a_person_is_asked_which_module_it_is_where_settings_differ_after_the_silence(frame: int) -> None:
    """It is shorter than one after which anybody is asked whatever is read."""
    rig = ExchangedRig(frame, boots=37)
    rig.run(read_everything())
    rig.step_until(lambda: rig.session.identity.identity.trust is Trust.REFUTED, limit_s=10)


@pytest.mark.parametrize("frame", [1, 10, 20])
def test_the_light_of_both_is_no_measurement(frame: int) -> None:
    rig = ExchangedRig(frame)
    assert not rig.run(measure_light()).is_enough
