"""A check is of one conversation: every single fault is named, what ends the conversation makes it void with its
sentence, and GO and READY come only when everything holds."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Report
from app.limits.past import Past
from app.preflight.checks import CHECKS, REPORTS_NEEDED, Case
from app.preflight.evidence import Evidence, TriggerFlag
from app.preflight.run import STEPS, run_preflight
from app.preflight.verdict import Verdict, assess, verdict_of
from app.procedures.stream import StreamSwitch
from app.procedures.write import SettingChange, WriteContext, WriteFault, set_each
from app.records.record import read_document, sign
from app.records.verification import RecordState, StationNames, verify
from app.safety.journal import Outcome
from app.settings.profiles import NO_PROFILE
from app.simulator.bench import SimulatedBench
from app.text.messages import message
from protocol.catalogue import BY_NAME, Hazard
from protocol.events import EndReason
from protocol.stale_replies import TRIGGER_FLAGS
from tests.files.records.test_record import AT, PERSON
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame, lose, refuse, restart_silently
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.preflight_rig import FAULTS, Arrange, Fault, assert_only_questions, check, gather, on_request
from tests.support.records.stored import station

FLAGS = [command.key for command in TRIGGER_FLAGS]


STREAMS = Fault(arrange=lambda rig: rig.bench.module.start_stream(rig.clock()))


@pytest.mark.parametrize("quirk", [Fault(), replace(STREAMS, options={"rate": 500.0}), Fault(options={"lag_ms": 40.0})])
def test_a_sound_module_is_ready(quirk: Fault) -> None:
    checked = check(quirk)
    assert (checked.assessment.verdict, checked.against) == (Verdict.READY, set())
    assert_only_questions(checked)
    sets = [request for request in checked.rig.line.requests if request.hazard is not Hazard.NONE]
    assert [request.command for request in sets] == list(TRIGGER_FLAGS)


@pytest.mark.parametrize("name", FAULTS)
def test_each_single_fault_is_named_and_its_record_does_not_contradict_itself(name: str) -> None:
    fault = FAULTS[name]
    checked = check(fault)
    assert checked.assessment.verdict is Verdict.NO_GO
    assert fault.named <= checked.against
    assert [one.check for one in checked.assessment.checks] == list(CHECKS)
    assert_only_questions(checked, is_enabling=fault.is_enabling)
    signed = sign(checked.record({"at": AT}, **PERSON), station())
    assert verify(read_document(signed.text.encode()), StationNames(None)).state is RecordState.INTACT
    assert signed.record.follows is Verdict.NO_GO


def test_go_is_of_an_active_module_whose_triggers_were_enabled_before() -> None:
    enabled = check()
    enabled.rig.bench.module.activate(is_active=True)
    before = len(enabled.rig.line.requests)
    evidence = gather(enabled.rig, is_enabling=True)
    assessment = assess(replace(enabled.assessment.case, evidence=evidence))
    assert (assessment.verdict, assessment.open_checks) == (Verdict.GO, ())
    # Nothing is written on an active module.
    assert not [request for request in enabled.rig.line.requests[before:] if request.hazard is not Hazard.NONE]


def test_a_locked_module_is_never_go_and_an_active_one_never_ready() -> None:
    assert verdict_of(is_fine=True, is_active=False) is Verdict.READY
    assert verdict_of(is_fine=True, is_active=True) is Verdict.GO
    for is_fine, is_active in ((False, False), (False, True), (False, None), (True, None)):
        assert verdict_of(is_fine=is_fine, is_active=is_active) is Verdict.NO_GO


def test_nobody_there_is_all_unknown() -> None:
    checked = check(Fault(options={"mute": True}))
    # What was done by hand before stands.
    assert checked.against == {check.id for check in CHECKS} - {"guided_tests", "service"}
    assert checked.rig.clock.now_s - 1000.0 < 12.0


# What it reads


def test_the_last_reading_decides_what_is_known() -> None:
    time = BY_NAME["freefall_time"]
    for first, last in ((True, False), (False, True)):
        evidence, rig, ends = Evidence(port="sim"), settled_rig(), list[Callable[[], None]]()

        def answers(
            report: Report,
            rig: Rig = rig,
            ends: list[Callable[[], None]] = ends,
            first: bool = first,
            last: bool = last,
        ) -> None:
            if report.total == STEPS:
                while ends:
                    ends.pop()()
                if not (first if report.done < STEPS - 1 else last):
                    ends.append(lose(rig.bench, time.code))

        rig.run(run_preflight(evidence), answers)
        assert (time.key in evidence.values, time.key in evidence.unanswered) == (last, not last)
        assert len(evidence.states) == 2
        assert evidence.status == evidence.states[-1].status


def test_a_stream_that_begins_meanwhile_is_no_second_module() -> None:
    """The program switches it on a while after the connection, also while a check waits for the disk."""
    rig, evidence, journal = settled_rig(StreamSwitch(), rate=50), Evidence(port="sim"), FakeJournal()
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
    ("spoil", "flag", "outcome"),
    [
        (lose, TriggerFlag(True), Outcome.CONFIRMED),
        (refuse, TriggerFlag(why=message(WriteFault.REFUSED.value)), Outcome.REFUSED),
        (
            lambda bench: lose(bench, 0x16, 0x17),
            TriggerFlag(why=message(WriteFault.NO_REPLY.value)),
            Outcome.UNKNOWN,
        ),
    ],
)
@pytest.mark.promise("f")
def test_what_came_of_enabling_the_triggers_is_known_and_logged(
    spoil: Callable[[SimulatedBench], object], flag: TriggerFlag, outcome: Outcome
) -> None:
    evidence, journal, rig = Evidence(port="sim"), FakeJournal(), settled_rig()
    spoil(rig.bench)
    state_of_module = rig.bench.module.state
    state_of_module.attitude_is_enabled = state_of_module.freefall_is_enabled = False
    rig.run(run_preflight(evidence, is_enabling=True, journal=journal))
    assert [evidence.flags[key] for key in FLAGS] == [flag, flag]
    assert set(journal.outcomes.values()) == {outcome}
    sets = [request for request in rig.line.requests if request.command in TRIGGER_FLAGS]
    assert len(sets) == 2, "each is sent once"


def test_what_was_disabled_in_this_conversation_is_known_as_disabled() -> None:
    rig = settled_rig()
    changes = [SettingChange(command, False) for command in TRIGGER_FLAGS]
    rig.run(set_each(changes, WriteContext(journal=FakeJournal(), accepted_risks=frozenset(changes))))
    assert [gather(rig).flags[key] for key in FLAGS] == [TriggerFlag(False)] * 2


# What moves, and what ends it


def later(code: int, number: int, after_s: float, act: Callable[[Rig], object]) -> Arrange:
    """Do this so long after the `number`-th frame of this code."""
    return on_request(code, number, lambda rig: rig.bench.module.plan(rig.clock() + after_s, lambda _at_s: act(rig)))


def moves(name: str, raw: int) -> Callable[[Rig], None]:
    return lambda rig: setattr(rig.bench.module.memory, name, raw)


def restarts(rig: Rig) -> None:
    restart_silently(rig.bench)


LIES = {
    "threshold moves 50 ms after it was read": ("read_twice", later(0x20, 1, 0.05, moves("attitude_threshold", 20))),
    "free-fall time moves when the light is read": ("read_twice", later(0x14, 1, 0.0, moves("freefall_time", 5))),
    "to a value that the advice allows": ("read_twice", later(0x17, 1, 0.5, moves("attitude_threshold", 80))),
    "restarts silently after a trigger was enabled": ("attitude_trigger", later(0x16, 1, 0.03, restarts)),
    "restarts silently while it is measured": ("connection", later(0x32, 6, 0.0, restarts)),
}


@pytest.mark.parametrize("name", LIES)
@pytest.mark.promise("f")
def test_what_moves_is_named(name: str) -> None:
    named, arrange = LIES[name]
    checked = check(Fault(frozenset((named,)), arrange=arrange))
    assert checked.assessment.verdict is Verdict.NO_GO
    assert named in checked.against
    assert_only_questions(checked)


ENDS: dict[EndReason, Callable[[Rig], object]] = {
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.SILENT: lambda rig: rig.bench.change(mute=True),
    EndReason.CONTRADICTED: lambda rig: setattr(rig.bench.module.memory, "freefall_time", 33),
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
    EndReason.SLEPT: lambda rig: setattr(rig.clock, "now_s", rig.clock.now_s + 8 * 3600.0),
    EndReason.ANOTHER: lambda rig: rig.session.treat_as_another(),
}


@pytest.mark.parametrize("reason", ENDS, ids=lambda reason: reason.name)
@pytest.mark.promise("f")
def test_whatever_ends_the_conversation_makes_it_void_with_that_sentence(reason: EndReason) -> None:
    rig, evidence = settled_rig(), Evidence(port="sim")
    job = rig.job(run_preflight(evidence, is_enabling=True, journal=FakeJournal()))
    rig.step_for(1.0)
    assert evidence.void is None
    ENDS[reason](rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=20.0)
    assert job.error is not None
    evidence.note_error(job.error)
    ended = rig.conversation.ended
    assert evidence.void is not None
    assert evidence.void.word == reason.name.lower()
    if ended is not None:
        assert evidence.void.message == Interrupted(ended.reason, ended.contradiction).message
    assert evidence.ended_at is None
    assert assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past())).verdict is Verdict.NO_GO
    assert not any(flag.is_enabled for flag in evidence.flags.values())


def test_the_check_that_follows_in_the_next_conversation_begins_empty() -> None:
    rig = settled_rig()
    assert gather(rig, is_enabling=True).is_complete
    at_frame(rig.bench, 1, rig.bench.restart)
    rig.step_for(3.0)
    evidence = gather(rig)
    assert (evidence.is_complete, evidence.conversation) == (True, 2)
    assert [evidence.flags[key] for key in FLAGS] == [TriggerFlag()] * 2
