"""Acts, the change of the baud rate among them: at most one frame for one permit, and never claimed too much."""

from dataclasses import replace
from typing import Any

import pytest

from app.engine.conversation import StatusSample
from app.engine.procedure import TOO_SLOW
from app.procedures.act import Armed, Performed, inputs_of, perform
from app.procedures.find import find_rate
from app.procedures.lock import lock
from app.procedures.read import Present
from app.procedures.write import (
    SettingChange,
    WriteContext,
    WriteFault,
    WriteReport,
    change_baud,
    why_not_verified,
    write_all,
)
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.permit import Interlock
from app.text.i18n import CHINESE, set_language
from protocol.catalogue import BY_NAME, STATUS
from protocol.events import EndReason
from tests.module.options import Options
from tests.module.wire import Question
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame, lose
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import AnyRig, engine_view, settled_rig

READY: dict[Act, dict[str, Any]] = {
    Act.ACTIVATE: {},
    Act.ZERO: {"tilt": 4},
    Act.SHUTDOWN: {},
    Act.FORBID_DEPLOY: {},
    Act.DEPLOY: {"active": True},
}
"""A module in the state in which the act is allowed."""


def do(rig: AnyRig, act: Act, journal: FakeJournal | None = None, **more: Any) -> Performed:
    more.setdefault("permit", rig.permit(act))
    return rig.run(perform(act, journal or FakeJournal(), **more))


@pytest.mark.parametrize("act", READY)
def test_an_act_that_is_allowed_is_done_once_and_confirmed(act: Act) -> None:
    rig, journal, sent_before = settled_rig(**READY[act]), FakeJournal(), list[int]()
    journal.on_begin = lambda: sent_before.append(len(rig.line.sent))
    begun = rig.clock()
    done = do(rig, act, journal)
    assert done.outcome is Outcome.CONFIRMED
    # Before zeroing it has to lie still for two seconds; a second report of firing, and a silence, take their time.
    assert rig.clock() - begun < {Act.ZERO: 2.4, Act.DEPLOY: 0.6, Act.SHUTDOWN: 1.6}.get(act, 0.4)
    frame = REQUESTS[act].encode()
    assert rig.acts == [frame]
    assert journal.outcomes == {0: Outcome.CONFIRMED}
    assert journal.intents[0][:2] == (act, frame)
    assert bytes(rig.line.sent).find(frame) >= sent_before[0], "the intent came first"
    module = rig.bench.module
    assert module.state.is_active is (act in (Act.ACTIVATE, Act.DEPLOY))
    assert module.is_triggered is (act is Act.DEPLOY)
    assert module.is_on is (act is not Act.SHUTDOWN)
    assert module.state.is_forbidden is (act is Act.FORBID_DEPLOY)
    assert module.memory.zero_tilt_deg == (4 if act is Act.ZERO else 0)


@pytest.mark.parametrize("act", READY)
@pytest.mark.parametrize("what", ["no permit", "another conversation", "armed", "log", "log fails"])
@pytest.mark.promise("h")
def test_an_open_condition_is_named_and_nothing_is_sent_nor_asked(act: Act, what: str) -> None:
    rig, journal = settled_rig(**READY[act]), FakeJournal()
    permit = None if what == "no permit" else rig.permit(act)
    if permit is not None and what == "another conversation":
        permit = replace(permit, conversation=permit.conversation + 1)
    journal.is_ready = what != "log"
    journal.is_broken = what == "log fails"
    asked = len(rig.line.requests)
    done = do(rig, act, journal, permit=permit, armed=Armed(Act.CHANGE_BAUD if what == "armed" else None))
    assert done.outcome is Outcome.NOT_SENT
    assert len(done.refusals) == 1
    assert done.sentence.startswith("Nothing was sent. ")
    assert {request.command.name for request in rig.line.requests[asked:]} <= {"boot_count"}, "the link's own"
    assert not journal.intents


@pytest.mark.parametrize(
    ("act", "options", "lost", "condition"),
    [
        (Act.ACTIVATE, {"active": True}, (), Interlock.IS_LOCKED),
        (Act.ACTIVATE, {"tilt": 60}, (), Interlock.BELOW_TILT),
        (Act.ACTIVATE, {}, (0x20,), Interlock.BELOW_TILT),
        (Act.ACTIVATE, {}, (0x32,), Interlock.FRESH_STATUS),
        (Act.ZERO, {"active": True}, (), Interlock.IS_LOCKED),
        (Act.SHUTDOWN, {"active": True}, (), Interlock.IS_LOCKED),
        (Act.DEPLOY, {}, (), Interlock.IS_ACTIVE),
        (Act.DEPLOY, {"active": True, "tilt": 80}, (), Interlock.NOT_TRIGGERED),
    ],
)
def test_the_modules_own_state_refuses(
    act: Act, options: dict[str, Any], lost: tuple[int, ...], condition: Interlock
) -> None:
    rig, journal = settled_rig(**options), FakeJournal()
    lose(rig.bench, *lost)
    rig.step_for(0.1)  # its sensor has seen how it lies
    done = do(rig, act, journal)
    assert condition in {refusal.condition for refusal in done.refusals}
    assert rig.acts == []
    assert journal.outcomes == {0: Outcome.NOT_SENT}


@pytest.mark.parametrize("act", [Act.DEPLOY, Act.ZERO, Act.FORBID_DEPLOY])
@pytest.mark.promise("e")
def test_one_permit_is_one_frame(act: Act) -> None:
    """Also where the module would be in the right state for a second one."""
    rig = settled_rig(**READY[act])
    permit = rig.permit(act)
    jobs = [rig.job(perform(act, FakeJournal(), permit=permit)) for _ in range(3)]
    assert [rig.end(job).outcome for job in jobs] == [Outcome.CONFIRMED, *[Outcome.NOT_SENT] * 2]
    assert permit.is_spent
    assert len(rig.acts) == 1


# Slow lines


@pytest.mark.parametrize("act", [*READY, None])
@pytest.mark.promise("h")
def test_on_a_line_that_is_too_slow_commands_are_refused_in_one_sentence(act: Act | None) -> None:
    """What was asked is a second old when the frame arrives. LOCK and questions work."""
    rig = settled_rig(**READY.get(act or Act.ZERO, {}), lag_ms=400.0)
    rig.step_for(5.0)
    began = rig.clock()
    if act is None:
        changes = [SettingChange(BY_NAME["freefall_time"], 1.2)]
        refused = rig.run(write_all(changes, WriteContext(journal=FakeJournal()))).refusals
    else:
        refused = do(rig, act).refusals
        assert rig.clock() - began < 0.5, "it is said at once"
    assert [refusal.message.text for refusal in refused] == [TOO_SLOW]
    assert rig.acts == []
    assert rig.run(lock(), is_urgent=True, outlives=True).is_locked


# What the module reports afterwards


@pytest.mark.promise("h")
def test_a_module_that_reports_its_activation_late_is_not_said_to_be_still_locked() -> None:
    rig = ModuleRig().begin()
    began = rig.clock()

    def report_late(question: Any) -> None:
        is_late = rig.module.settings[0x10] == 1 and rig.clock() - began < 0.6
        rig.module.options.instead = {0x30: "01 00", 0x32: "02 0a 00 00"} if is_late else {}

    rig.module.at_frame = report_late
    done = do(rig, Act.ACTIVATE)
    assert rig.clock() - began < 0.8, "it is asked often"
    assert done.outcome is Outcome.CONFIRMED
    assert len(rig.module.log.sets(0x10)) == 1


def test_after_activating_30_has_to_agree_too() -> None:
    rig = ModuleRig().begin()

    rig.module.at_frame = lambda question: rig.module.options.instead.update({0x30: "01 00"} if question.is_set else {})
    assert do(rig, Act.ACTIVATE).outcome is Outcome.UNKNOWN
    assert rig.module.settings[0x10] == 1


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.DEPLOY])
def test_an_act_whose_answer_was_lost_is_confirmed_by_the_report(act: Act) -> None:
    rig = settled_rig(**READY[act])
    at_each_frame(rig.bench, lambda request: rig.bench.change(drop=float(request == REQUESTS[act])))
    done = do(rig, act)
    assert done.outcome is Outcome.CONFIRMED
    assert len(rig.acts) == 1


def test_an_activation_without_an_answer_is_not_said_to_be_refused() -> None:
    """It may still be carried out."""
    done = do(ModuleRig(Options(lost_sets={ACTIVATION: -1})).begin(), Act.ACTIVATE)
    assert done.outcome is Outcome.UNKNOWN


def test_a_module_that_goes_on_answering_is_not_switched_off() -> None:
    done = do(ModuleRig(Options(ignored_sets={0x12: -1})).begin(), Act.SHUTDOWN)
    assert done.outcome is Outcome.REFUSED


def test_a_report_from_before_the_act_is_not_taken_for_one_from_after_it() -> None:
    rig = settled_rig()
    lose(rig.bench, 0x11)
    do(rig, Act.FORBID_DEPLOY)
    after = rig.line.requests[rig.line.requests.index(REQUESTS[Act.FORBID_DEPLOY]) + 1 :]
    assert after.index(STATUS.query()) > 0, "another question is answered first"


# The disk


@pytest.mark.promise("h")
def test_an_intent_that_is_never_durable_is_given_up() -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    journal.is_held = True
    begun = rig.clock()
    done = do(rig, Act.DEPLOY, journal)
    assert rig.clock() - begun == pytest.approx(1.0, abs=0.3)
    assert [refusal.condition for refusal in done.refusals] == [Interlock.INTENT_DURABLE]
    assert "too slow" in done.sentence
    set_language(CHINESE)
    assert done.sentence.endswith("磁盘写入过慢。")
    assert rig.acts == []
    assert journal.outcomes == {0: Outcome.NOT_SENT}


# Two modules on one line


@pytest.mark.promise("f")
def test_where_questions_are_answered_twice_nothing_is_done() -> None:
    """Two modules that tell the same contradict nothing, and yet both would obey."""
    rig = ModuleRig(Options(query_copies={0x30: [0.002]})).begin()
    done = do(rig, Act.ACTIVATE)
    assert [refusal.condition for refusal in done.refusals] == [Interlock.AGREES]
    assert rig.module.log.sets(ACTIVATION) == []


@pytest.mark.parametrize("silent_from", [{}, {0x31: 2}, {0x32: 2}, {0x32: 3}, {0x31: 2, 0x32: 2}])
@pytest.mark.promise("f")
def test_not_fired_needs_every_witness(silent_from: dict[int, int]) -> None:
    rig = ModuleRig(Options(query_copies={0x32: [0.025]}, refused_sets={0x11})).begin()
    rig.module.settings[ACTIVATION] = 1

    def fall_silent(question: Question) -> None:
        first = silent_from.get(question.code)
        if first is not None and len(rig.module.log.got(question.code)) + 1 >= first:
            rig.module.options.lost_queries[question.code] = -1

    rig.module.at_frame = fall_silent
    assert do(rig, Act.DEPLOY).outcome is (Outcome.UNKNOWN if silent_from else Outcome.REFUSED)
    assert rig.module.log.sets(0x11)


@pytest.mark.promise("a")
@pytest.mark.parametrize(("age_s", "is_fresh"), [(0.9, True), (1.1, False)])
def test_a_status_is_as_old_as_the_question_before_it(age_s: float, is_fresh: bool) -> None:
    status = StatusSample(100.0, 7, 1.0, triggered=False, active=False)
    present = Present(active=False, triggered=False, status=status, asked_at=100.0 - age_s)
    assert inputs_of(engine_view(100.0), present=present).is_status_fresh is is_fresh


BAUD, ACTIVATION = 0x24, 0x10
RATES = {"old": 115200, "new": 9600}


def change(rig: ModuleRig, journal: FakeJournal) -> WriteReport:
    return rig.run(change_baud(9600, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)


@pytest.mark.parametrize(
    ("options", "fault", "is_acknowledged"),
    [
        ({}, None, True),
        ({"acknowledged_by_one": {BAUD}}, None, True),
        ({"baud_answer": "new"}, None, False),
        ({"baud_answer": "none"}, None, False),
        ({"baud_at_once": False}, WriteFault.AT_RESTART, True),
        ({"lost_sets": {BAUD: -1}}, WriteFault.NOT_SET, False),
    ],
)
def test_every_behaviour_is_said_as_what_it_is(
    options: dict[str, Any], fault: WriteFault | None, is_acknowledged: bool
) -> None:
    rig, journal, sent_before = ModuleRig(Options(**options)).begin(), FakeJournal(), list[int]()
    journal.on_begin = lambda: sent_before.append(len(rig.module.log.sets(BAUD)))
    written = change(rig, journal).results[0]
    assert (written.fault, written.is_acknowledged, written.verified) == (fault, is_acknowledged, fault is None)
    assert written.read_back == rig.line.baud_rate == rig.module.rate
    assert len(rig.module.log.sets(BAUD)) == 1
    assert rig.conversation.is_going
    assert [detail for _act, _frame, detail in journal.intents] == [RATES]
    outcome = {None: Outcome.CONFIRMED, WriteFault.NOT_SET: Outcome.REFUSED}.get(fault, Outcome.UNKNOWN)
    assert journal.outcomes == {0: outcome}
    assert sent_before == [0]


def test_a_module_that_answers_at_a_third_rate_holds_another_value() -> None:
    rig, journal = ModuleRig().begin(), FakeJournal()

    def go_elsewhere(question: Question) -> None:
        if question.code == BAUD:
            rig.line.plan(0.02, lambda: setattr(rig.module, "rate", 57600))

    rig.module.at_frame = go_elsewhere
    written = change(rig, journal).results[0]
    assert (written.fault, written.read_back, written.verified) == (WriteFault.NOT_SET, 57600, False)
    assert journal.outcomes == {0: Outcome.REFUSED}


def test_a_lost_module_says_how_to_get_it_back_and_stays_written_down() -> None:
    rig, journal = ModuleRig().begin(), FakeJournal()

    def fall_silent(question: Question) -> None:
        if question.code == BAUD:
            rig.module.be_silent(rig.clock() + 0.005, 120.0)

    rig.module.at_frame = fall_silent
    rig.module.options.baud_answer = "none"
    report = change(rig, journal)
    assert (report.results[0].fault, report.results[0].read_back) == (WriteFault.MODULE_LOST, None)
    assert "find its rate" in str(why_not_verified(report.results[0], report))
    assert rig.line.baud_rate == 115200
    assert journal.outcomes == {0: Outcome.UNKNOWN}, "it may have been carried out"
    rig.module.be_silent(rig.clock(), 0.0)
    assert rig.run(find_rate(9600, 115200), outlives=True).baud_rate == rig.module.rate


def test_a_break_in_the_middle_stays_written_down_as_unknown() -> None:
    rig, journal = ModuleRig().begin(), FakeJournal()
    job = rig.job(change_baud(9600, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)
    rig.step_until(lambda: rig.module.log.sets(BAUD))
    rig.session.close(EndReason.PORT_LOST)
    report = job.outcome()
    assert report.interrupted is not None
    assert (report.results[0].is_sent, report.results[0].fault) == (True, WriteFault.INTERRUPTED)
    assert journal.outcomes == {0: Outcome.UNKNOWN}


@pytest.mark.parametrize("is_active", [True, False])
def test_a_change_of_the_rate_that_is_not_allowed_is_not_sent(is_active: bool) -> None:
    rig, journal = ModuleRig(), FakeJournal()
    rig.module.settings[ACTIVATION] = is_active
    journal.is_broken = not is_active
    rig.begin()
    report = change(rig, journal)
    assert (report.results[0].fault, report.results[0].is_sent) == (WriteFault.NOT_ALLOWED, False)
    said = why_not_verified(report.results[0], report)
    assert said is not None
    assert said.in_english().startswith("not sent: ")
    assert said.in_english().endswith("The disk is full.") is not is_active
    assert rig.module.log.sets(BAUD) == []
