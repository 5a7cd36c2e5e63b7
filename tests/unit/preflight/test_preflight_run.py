"""A check is of one conversation: what ends that makes it void with its sentence, and the check says how it went."""

import itertools
from collections.abc import Callable

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Cancelled, Report
from app.limits.past import Past
from app.preflight.evidence import HEARTBEATS, UNFINISHED, Evidence, TriggerFlag
from app.preflight.findings import Case, CheckResult
from app.preflight.line_checks import REPORTS_NEEDED
from app.preflight.run import STEPS, TRIGGERS, run_preflight
from app.preflight.verdict import Verdict, assess
from app.procedures.write import WAITING, WriteFault
from app.safety.journal import Outcome
from app.settings.profiles import NO_PROFILE
from app.text.messages import UserError, message
from protocol.catalogue import ATTITUDE_TRIGGER, BY_NAME, FREEFALL_TRIGGER, HEARTBEAT, Request
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame, at_frame
from tests.support.line.sim_line import Rig, settled_rig, watched_rig
from tests.support.records.preflight_rig import gather

FLAGS = [command.key for command in TRIGGERS]


def lose(rig: Rig, is_lost: Callable[[int], bool], request: Request) -> None:
    """Loses each such request of which `is_lost` says so by its number."""
    numbers = itertools.count(1)
    at_each_frame(rig.bench, lambda sent: not (sent == request and is_lost(next(numbers))))


def verdict_of(evidence: Evidence) -> Verdict:
    return assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past())).verdict


def test_a_heartbeat_that_had_to_be_asked_again_is_lost() -> None:
    rig = settled_rig()
    lose(rig, lambda number: number % 5 == 0, HEARTBEAT.query())
    evidence = gather(rig)
    assert evidence.void is None
    assert (evidence.heartbeats_sent, evidence.heartbeats_lost) == (HEARTBEATS, 4)


@pytest.mark.parametrize(("first", "last"), [(True, False), (False, True)])
def test_the_last_reading_decides_what_is_known(first: bool, last: bool) -> None:
    evidence, rig = Evidence(port="sim"), settled_rig()
    time = BY_NAME["freefall_time"]

    def answers(report: Report) -> None:
        if report.total == STEPS:
            does_answer = first if report.done < STEPS - 1 else last
            rig.bench.change(mute_codes=frozenset(() if does_answer else (time.code,)))

    rig.run(run_preflight(evidence), answers)
    assert (time.key in evidence.values, time.key in evidence.faults) == (last, not last)


def test_a_check_reports_its_seven_steps_and_keeps_the_last_status() -> None:
    evidence, reports, journal = Evidence(port="sim"), list[Report](), FakeJournal()
    rig = settled_rig()
    rig.run(run_preflight(evidence, is_enabling=True, journal=journal), reports.append)
    steps = [report for report in reports if report.total == STEPS]
    assert sorted({report.done for report in steps}) == list(range(STEPS))
    assert WAITING in {report.doing for report in reports}, "a person waits for late answers"
    assert [dict(detail) for _, _, detail in journal.intents] == [
        {"freefall_trigger": True},
        {"attitude_trigger": True},
    ]
    assert journal.outcomes == {0: Outcome.CONFIRMED, 1: Outcome.CONFIRMED}
    assert evidence.last is not None
    assert evidence.status == evidence.last.status
    assert evidence.ended_at is not None


def test_a_stream_that_begins_meanwhile_is_no_second_module() -> None:
    """The program switches it on a while after the connection, also while a check waits for the disk."""
    rig, evidence, journal = watched_rig(rate=50), Evidence(port="sim"), FakeJournal()
    journal.is_held = True
    rig.step_for(1.5)
    job = rig.job(run_preflight(evidence, is_enabling=True, journal=journal))
    while not job.has_ended:
        rig.step_for(0.5)
        journal.flush()
    assert rig.conversation.is_streaming
    assert len(evidence.reports) > REPORTS_NEEDED
    assert not evidence.is_answered_twice


# The triggers


@pytest.mark.parametrize(
    ("options", "flag", "outcome"),
    [
        ({}, TriggerFlag(True), Outcome.CONFIRMED),
        ({"ack": "one"}, TriggerFlag(True), Outcome.CONFIRMED),
        ({"refuses": True}, TriggerFlag(why=message(WriteFault.REFUSED.value)), Outcome.REFUSED),
        ({"mute_codes": "16,17"}, TriggerFlag(why=message(WriteFault.NO_REPLY.value)), Outcome.UNKNOWN),
    ],
)
def test_what_came_of_enabling_the_triggers_is_known_and_logged(
    options: dict[str, str], flag: TriggerFlag, outcome: Outcome
) -> None:
    evidence, journal, rig = Evidence(port="sim"), FakeJournal(), settled_rig(**options)
    state_of_module = rig.bench.module.state
    state_of_module.attitude_is_enabled = state_of_module.freefall_is_enabled = False
    rig.run(run_preflight(evidence, is_enabling=True, journal=journal))
    assert [evidence.flags[key] for key in FLAGS] == [flag, flag]
    assert set(journal.outcomes.values()) == {outcome}
    sets = [request for request in rig.line.requests if request.command in (ATTITUDE_TRIGGER, FREEFALL_TRIGGER)]
    assert len(sets) == 2, "each is sent once"


def test_nothing_is_enabled_on_an_active_module_and_it_says_why() -> None:
    rig = settled_rig(active=True)
    evidence = gather(rig, is_enabling=True)
    refused = evidence.flags[FREEFALL_TRIGGER.key]
    assert refused.is_enabled is None
    assert refused.why.in_english() == "not sent: The module is ACTIVE: lock it first."
    assert rig.acts == []


@pytest.mark.promise("f")
def test_on_a_line_that_repeats_answers_no_trigger_is_known() -> None:
    rig = settled_rig(double_codes="16,17", double_ms=400)
    evidence = gather(rig, is_enabling=True)
    repeated = TriggerFlag(why=message(WriteFault.REPEATED.value))
    assert [evidence.flags[key] for key in FLAGS] == [repeated, repeated]
    assert verdict_of(evidence) is Verdict.NO_GO


# Its end


def checking(rig: Rig) -> Evidence:
    """A check that has been going on for a second."""
    evidence = Evidence(port="sim")
    rig.job(run_preflight(evidence, is_enabling=True, journal=FakeJournal()))
    rig.step_for(1.0)
    assert evidence.void is None
    return evidence


ENDS: dict[EndReason, Callable[[Rig], object]] = {
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.SILENT: lambda rig: rig.bench.change(mute=True),
    EndReason.CONTRADICTED: lambda rig: setattr(rig.bench.module.memory, "freefall_time", 33),
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
    EndReason.CLOSED: lambda rig: rig.session.close(EndReason.CLOSED),
    EndReason.SLEPT: lambda rig: setattr(rig.clock, "now_s", rig.clock.now_s + 8 * 3600.0),
    EndReason.ANOTHER: lambda rig: rig.session.treat_as_another(),
}


@pytest.mark.parametrize("reason", ENDS, ids=lambda reason: reason.value)
@pytest.mark.promise("f")
def test_whatever_ends_the_conversation_makes_it_void_with_that_sentence(reason: EndReason) -> None:
    rig = settled_rig()
    evidence = checking(rig)
    ENDS[reason](rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: evidence.void is not None, limit_s=20.0)
    ended = rig.conversation.ended
    assert evidence.void is not None
    assert evidence.void.word == reason.name.lower()
    if ended is not None:
        assert evidence.void.message == Interrupted(ended.reason, ended.contradiction).message
    assert evidence.ended_at is None
    assert verdict_of(evidence) is Verdict.NO_GO
    assert not any(flag.is_enabled for flag in evidence.flags.values())


def test_the_first_reason_stays() -> None:
    evidence = Evidence(port="sim")
    evidence.note_error(Interrupted(EndReason.SLEPT))
    first = evidence.void
    evidence.note_error(Interrupted(EndReason.PORT_LOST))
    assert evidence.void == first
    for error, word in ((UserError("no"), "usage"), (Cancelled(), "cancelled"), (ValueError(), UNFINISHED.word)):
        other = Evidence(port="sim")
        other.note_error(error)
        assert other.void is not None
        assert other.void.word == word


def test_the_check_that_follows_in_the_next_conversation_begins_empty() -> None:
    rig = settled_rig()
    assert gather(rig, is_enabling=True).is_complete
    at_frame(rig.bench, 1, rig.bench.restart)
    rig.step_for(3.0)
    evidence = gather(rig)
    assert evidence.is_complete
    assert evidence.conversation == 2
    assert [evidence.flags[key] for key in FLAGS] == [TriggerFlag()] * 2
    found = assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past())).result("attitude_trigger")
    assert found is CheckResult.UNKNOWN
