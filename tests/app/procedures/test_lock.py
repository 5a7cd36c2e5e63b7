"""LOCK goes before everything else, waits for nothing, and is repeated until the module reports that it is locked."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import settings

from app.engine.procedure import LOCK_GAPS_S, LOCKS_FOR_S, MAX_LOCKS, Ask, Job, LockRepeat, Procedure
from app.procedures.act import Performed, perform
from app.procedures.baud import BaudEnd, change_baud
from app.procedures.find import find_rate
from app.procedures.lock import SENTENCES, Locked, lock, waiting_sentence
from app.procedures.read import read_settings
from app.procedures.write import SetReply, SettingChange, WriteContext, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import NoJournal, Outcome
from protocol.catalogue import BY_NAME, LOCK, Hazard, Request
from protocol.events import EndReason
from tests.module.module import Module
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.module_line import ModuleRig
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig, settled_rig

LIGHT = BY_NAME["light_threshold"]
ACTIVATION = 0x10
CONFIRMED_ACTS = [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY]


def press(rig: Rig | ModuleRig, journal: Any = None, **more: Any) -> Job[Locked]:
    return rig.job(lock(journal, **more), is_urgent=True, outlives=True)


def pressed(rig: Rig | ModuleRig, journal: Any = None, **more: Any) -> Locked:
    return rig.end(press(rig, journal, **more), limit_s=60)


def locks(rig: Rig) -> int:
    return rig.line.requests.count(LOCK)


def deafen(rig: Rig, is_lost: Callable[[int, Request], bool]) -> list[float]:
    """Frames to the module are lost where `is_lost` (number of the LOCK, frame) says so; the times of all LOCKs."""
    times = list[float]()

    def lossy(request: Request) -> bool:
        if request == LOCK:
            times.append(rig.clock())
        return not is_lost(len(times), request)

    at_each_frame(rig.bench, lossy)
    return times


# On one module


@pytest.mark.promise("l")
def test_on_a_good_line_it_is_sent_once_and_asked_for_twice() -> None:
    rig = settled_rig(active=True)
    began, before = rig.clock(), len(rig.line.requests)
    locked = pressed(rig)
    assert (locked.outcome, locked.sent, locked.is_acknowledged) == (Outcome.CONFIRMED, 1, True)
    assert rig.clock() - began < 0.2, "it waits for nothing"
    assert [request.command.name for request in rig.line.requests[before:]][:3] == ["activation", "active", "status"]
    assert locked.sentence == "The module reports LOCKED."
    assert not rig.bench.module.state.is_active


@pytest.mark.promise("l")
def test_it_is_sent_before_any_module_has_answered() -> None:
    """As `dps-s lock` does, directly after opening the port."""
    rig = Rig({"uptime": 60, "active": True})
    locked = pressed(rig)
    assert rig.line.requests[0] == LOCK
    assert locked.sentence == "The module reports LOCKED."


@pytest.mark.promise("l")
def test_it_is_repeated_until_it_is_reported() -> None:
    rig = settled_rig(active=True)
    times = deafen(rig, lambda number, frame: frame == LOCK and number < 7)
    locked = pressed(rig)
    assert (locked.is_locked, locked.sent) == (True, 7)
    assert not rig.bench.module.state.is_active
    gaps = [later - sooner for sooner, later in pairwise(times)]
    assert all(0.1 <= gap <= 0.25 for gap in gaps), gaps


@pytest.mark.promise("l")
def test_it_is_repeated_while_the_answer_to_the_question_is_awaited() -> None:
    """Nothing of the module is heard for two seconds; it hears nothing either."""
    rig = settled_rig(active=True)
    until = rig.clock() + 2.0
    times = deafen(rig, lambda _number, _frame: rig.clock() < until)
    assert pressed(rig).is_locked
    gaps = [later - sooner for sooner, later in pairwise(times)]
    assert all(0.09 <= gap <= 0.25 for gap in gaps), gaps
    assert len(gaps) >= 11


def test_an_acknowledgement_alone_is_no_proof() -> None:
    rig = settled_rig(active=True)
    rig.bench.change(mute_codes=frozenset((0x30, 0x32)))
    locked = pressed(rig)
    assert locked.is_acknowledged
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent > 1


@pytest.mark.parametrize("code", [0x30, 0x32])
def test_one_question_alone_is_enough_where_the_module_does_not_know_the_other(code: int) -> None:
    assert pressed(settled_rig(active=True, mute_codes=frozenset((code,)))).is_locked


@pytest.mark.promise("l")
def test_it_ends_within_its_limits_and_says_what_is_not_known() -> None:
    rig, journal = settled_rig(active=True, mute=False), FakeJournal()
    rig.bench.change(mute=True)
    began = rig.clock()
    locked = pressed(rig, journal)
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent == locks(rig) <= MAX_LOCKS
    assert MAX_LOCKS * min(LOCK_GAPS_S) < rig.clock() - began < LOCKS_FOR_S + 12  # with a search for its rate
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert locked.sentence.endswith("not confirmed: treat the module as ACTIVE.")


@pytest.mark.parametrize(
    ("options", "outcome", "is_locked"),
    [({"refuses": True}, Outcome.UNKNOWN, None), ({"locks": "no"}, Outcome.REFUSED, False)],
)
def test_a_module_that_stays_active_is_told_until_the_end(
    options: dict[str, object], outcome: Outcome, is_locked: bool | None
) -> None:
    """Whether LOCK has not arrived yet, or was acknowledged and not obeyed."""
    locked = pressed(settled_rig(active=True, **options))
    assert (locked.outcome, locked.is_locked, locked.sent) == (outcome, is_locked, MAX_LOCKS)


def test_the_frame_leaves_before_the_journal_is_asked_and_waits_for_none() -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    journal.is_held = True
    journal.line_length = lambda: locks(rig)
    assert pressed(rig, journal).is_locked
    assert [act for act, _frame, _detail in journal.intents] == [Act.LOCK]
    assert journal.sent_before == [1]
    assert journal.outcomes == {0: Outcome.CONFIRMED}


@pytest.mark.promise("l")
def test_locking_needs_nothing_and_is_done_without_a_log() -> None:
    rig = settled_rig(active=True)
    assert pressed(rig, NoJournal()).is_locked
    assert not rig.bench.module.state.is_active


def test_what_is_done_on_purpose_afterwards_ends_the_repeating() -> None:
    """The module is locked, which no report says: somebody who activates it is not locked out again."""
    rig = settled_rig(active=True, mute_codes=frozenset((0x30,)))
    deafen(rig, lambda _number, frame: frame == LOCK)
    locking = press(rig)
    rig.step_for(0.5)
    assert not locking.has_ended
    locking.cancel()
    assert rig.end(locking, limit_s=0.5).is_replaced
    count = locks(rig)
    rig.step_for(3.0)
    assert locks(rig) == count


def test_every_outcome_has_its_sentence() -> None:
    assert set(SENTENCES) == set(Outcome)
    for outcome in Outcome:
        for sent in (0, 1, 2):
            assert "{" not in Locked(outcome=outcome, sent=sent).sentence
    assert waiting_sentence(3) == "LOCK sent 3×, not yet reported"


# Through the end of a conversation, by the independent module


def active_rig(options: Options | None = None) -> ModuleRig:
    rig = ModuleRig(options or Options(delay_s=0.001))
    rig.module.settings[ACTIVATION] = 1
    return rig.begin()


@pytest.mark.parametrize("begins_s", [0.0, 0.002, 0.005, 0.1])
@pytest.mark.parametrize("silent_s", [0.3, 0.5, 0.8, 1.5, 3.0])
@pytest.mark.promise("l")
def test_after_a_silence_it_is_locked_if_this_module_reports_it(silent_s: float, begins_s: float) -> None:
    rig, journal = active_rig(), FakeJournal()
    job = press(rig, journal)
    rig.step_for(begins_s)
    rig.module.be_silent(rig.clock(), silent_s)
    locked = rig.end(job)
    assert locked.is_locked
    assert rig.module.settings[ACTIVATION] == 0
    if locked.may_be_another:
        assert locked.sentence == "The module that answers now reports LOCKED."
        assert journal.outcomes == {0: Outcome.UNKNOWN}, "what was left ACTIVE before stays so"


@pytest.mark.parametrize("off_s", [0.1, 0.3, 0.6, 2.0])
@pytest.mark.parametrize("survives", [False, True])
def test_a_restart_meanwhile_is_locked_again(off_s: float, *, survives: bool) -> None:
    rig = active_rig(Options(delay_s=0.001, activation_survives=survives))
    job = press(rig)
    rig.module.restart(rig.clock(), off_s=off_s)
    assert rig.end(job).is_locked
    assert rig.module.settings[ACTIVATION] == 0


@pytest.mark.parametrize("gap_s", [0.5, 0.8, 1.5])
@pytest.mark.parametrize("begins_s", [0.0, 0.002, 0.004, 0.006])
@pytest.mark.promise("l")
def test_it_is_never_said_of_another_module_that_does_not_report_it(gap_s: float, begins_s: float) -> None:
    """One that takes its place, is ACTIVE and does not listen to LOCK."""
    rig = active_rig()
    deaf = Module(Options(delay_s=0.001, ignored_sets={ACTIVATION: -1}), name="deaf", now=rig.clock())
    deaf.settings[ACTIVATION] = 1
    job = press(rig)
    rig.step_for(begins_s)
    rig.module.be_silent(rig.clock(), 60.0)
    deaf.be_silent(rig.clock(), gap_s)
    is_done = job.has_ended
    rig.line.modules = (deaf,)
    locked = rig.end(job)
    assert is_done or locked.is_locked is not True


@pytest.mark.parametrize("frame", [2, 3])
@pytest.mark.promise("l")
def test_what_a_locked_module_in_its_place_reports_clears_nothing(frame: int) -> None:
    """The first one heard LOCK, and perhaps reported once; the one that answers then is asked for both reports."""
    rig, journal = active_rig(), FakeJournal()
    other = Module(Options(delay_s=0.001), name="other", now=rig.clock())
    heard = len(rig.module.log.got())
    rig.module.at_frame = lambda _question: (
        rig.module.be_silent(rig.clock(), 60.0) if len(rig.module.log.got()) - heard + 1 >= frame else None
    )
    job = press(rig, journal)
    rig.step_until(lambda: len(rig.module.log.got()) - heard >= frame)
    other.be_silent(rig.clock(), 0.5)
    rig.line.modules = (other,)
    locked = rig.end(job)
    assert locked.is_locked
    assert locked.sentence == "The module that answers now reports LOCKED."
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert other.log.sent(0x30)
    assert other.log.sent(0x32)


def test_it_goes_on_counting_when_the_port_comes_back() -> None:
    repeat = LockRepeat()
    rig = settled_rig(active=True)
    rig.bench.change(mute=True)
    job = press(rig, repeat=repeat)
    rig.step_for(0.5)
    rig.session.close(EndReason.PORT_LOST)
    before = job.outcome()
    assert before.is_port_lost
    assert before.sent == repeat.sent > 1
    again = Rig({"uptime": 60, "active": True})
    again.clock.now_s = again.session._looked_at = rig.clock.now_s
    locked = pressed(again, repeat=repeat)
    assert locked.is_locked
    assert locked.sent >= before.sent + 1


@pytest.mark.parametrize("has_left", [False, True])
def test_a_port_that_is_lost_is_said(has_left: bool) -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    rig.bench.change(mute=True)
    job = press(rig, journal)
    if has_left:
        rig.session.step(0.01)
    rig.session.close(EndReason.PORT_LOST)
    locked = job.outcome()
    assert (locked.outcome, locked.sent) == ((Outcome.UNKNOWN, 1) if has_left else (Outcome.NOT_SENT, 0))
    assert [*journal.outcomes.values()] == ([Outcome.UNKNOWN] if has_left else [])


# While the rate is searched


@pytest.mark.parametrize("is_pressed_twice", [False, True])
def test_it_leaves_at_the_proven_rate_while_the_rate_is_searched(is_pressed_twice: bool) -> None:
    rig = settled_rig(active=True)
    finding = rig.job(find_rate(4800), outlives=True)
    rig.step_until(lambda: rig.line.baud_rate == 4800)
    if is_pressed_twice:
        press(rig)
    locked = pressed(rig)
    assert (locked.is_locked, locked.sent) == (True, 1)
    assert rig.end(finding).baud_rate == 115200


@pytest.mark.parametrize("rate", [4800, 9600, 57600])
@pytest.mark.parametrize("after_s", [0.05, 0.4, 1.3])
@pytest.mark.promise("l")
def test_it_is_sent_again_where_the_search_finds_the_module(rate: int, after_s: float) -> None:
    rig = settled_rig(active=True)
    rig.bench.module.baud_rate = rate
    finding = rig.job(find_rate(115200), outlives=True)
    rig.step_for(after_s)
    assert pressed(rig).is_locked
    assert not rig.bench.module.state.is_active
    assert rig.end(finding).baud_rate == rate


# Before everything else

SLOW = {"delay_ms": 60.0}


def under_way(rig: Rig, act: Act) -> Job[Performed]:
    return rig.job(perform(act, FakeJournal(), permit=rig.permit(act)))


@pytest.mark.parametrize("act", CONFIRMED_ACTS)
@pytest.mark.parametrize("steps", range(0, 24, 2))
@pytest.mark.promise("e")
def test_nothing_dangerous_leaves_after_lock_was_pressed(act: Act, steps: int) -> None:
    rig = settled_rig(**SLOW)
    performing = under_way(rig, act)
    for _ in range(steps):
        rig.session.step()
    before = rig.line.requests
    locking = press(rig)
    rig.step_until(lambda: performing.has_ended and locking.has_ended)
    assert not [request for request in rig.line.requests[len(before) :] if request.hazard is Hazard.DANGEROUS]
    if REQUESTS[act] in before:
        return
    performed = performing.outcome()
    assert performed.outcome is Outcome.NOT_SENT
    refused = [refusal.condition for refusal in performed.refusals]
    assert refused in ([Interlock.CONFIRMED], [])  # none where it was waiting for a quiet line
    assert not rig.bench.module.state.is_active


@pytest.mark.parametrize("steps", range(0, 30, 3))
@pytest.mark.promise("l")
def test_nothing_dangerous_decided_before_goes_between_two_of_them(steps: int) -> None:
    rig = settled_rig()
    acting = under_way(rig, Act.ACTIVATE)
    deafen(rig, lambda number, frame: 0 < number < 5)
    for _ in range(steps):
        rig.session.step()
    before = len(rig.line.requests)
    locking = press(rig)
    rig.step_until(lambda: locking.has_ended and acting.has_ended, limit_s=60)
    after = rig.line.requests[before:]
    assert after.count(LOCK) >= 5
    assert not [request for request in after if request.hazard is Hazard.DANGEROUS]
    assert not rig.bench.module.state.is_active


def test_the_baud_rate_is_not_changed_after_lock_was_pressed() -> None:
    rig = settled_rig(**SLOW)
    changing = rig.job(change_baud(9600, FakeJournal(), permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)
    press(rig)
    assert rig.end(changing).end is BaudEnd.NOT_SENT


def test_what_is_confirmed_after_lock_is_done() -> None:
    rig = settled_rig(**SLOW)
    pressed(rig)
    rig.step_for(1.0)
    done = rig.run(perform(Act.ZERO, FakeJournal(), permit=rig.permit(Act.ZERO)))
    assert done.outcome is Outcome.CONFIRMED


def ask_at_once(request: Request) -> Procedure[Any]:
    return (yield Ask(request, is_deliberate=True))


def set_in_flight(rig: Rig) -> None:
    rig.job(ask_at_once(LIGHT.set(2.0)))
    rig.step_until(lambda: rig.line.requests[-1:] == [LIGHT.set(2.0)])


def question_in_flight(rig: Rig) -> None:
    rig.job(read_settings())
    rig.step_until(lambda: rig.line.requests[-1:] == [LIGHT.query()])


@pytest.mark.parametrize("wait", [lambda rig: rig.step_for(0.3), set_in_flight, question_in_flight])
@pytest.mark.promise("j")
def test_lock_waits_for_no_answer(wait: Callable[[Rig], object]) -> None:
    """The module hears and its answers are lost."""
    rig = settled_rig(active=True)
    rig.bench.change(drop=1.0)
    wait(rig)
    sent = len(rig.line.requests)
    press(rig)
    rig.session.step(0.0)
    assert rig.line.requests[sent] == LOCK
    rig.step_for(0.01)
    assert not rig.bench.module.state.is_active


def test_lock_pressed_again_leaves_at_once_and_takes_the_place_of_the_first() -> None:
    rig = settled_rig(active=True)
    rig.bench.change(mute=True)
    first = press(rig)
    rig.step_until(lambda: locks(rig) == 1)
    second = press(rig)
    rig.session.step(0.0)
    assert locks(rig) == 2
    end_faults(rig.bench)
    assert rig.end(first).is_replaced
    assert rig.end(second).is_locked


def test_a_set_that_lock_overtakes_is_not_sent_again_and_is_read_back() -> None:
    rig = settled_rig(**SLOW)
    changes = [SettingChange(LIGHT, 2.0)]
    writing = rig.job(write_all(changes, WriteContext(journal=FakeJournal())))
    rig.step_until(lambda: rig.line.requests[-1:] == [LIGHT.set(2.0)])
    press(rig)
    (written,) = rig.end(writing).results
    assert rig.line.requests.count(LIGHT.set(2.0)) == 1
    assert (written.heard, written.verified) == (SetReply.NOTHING, True)


def test_an_act_that_lock_overtakes_is_of_unknown_outcome_until_the_module_tells() -> None:
    rig = settled_rig(**SLOW)
    performing = under_way(rig, Act.ACTIVATE)
    rig.step_until(lambda: rig.line.requests[-1:] == [REQUESTS[Act.ACTIVATE]])
    locking = press(rig)
    assert rig.end(performing).outcome is Outcome.UNKNOWN
    assert rig.end(locking).is_locked
    assert rig.line.requests.count(REQUESTS[Act.ACTIVATE]) == 1
    assert not rig.bench.module.state.is_active


# Bad lines

SEEDS = settings().max_examples // 4
"""1,000 in the profile `thorough`."""
LOSSY: dict[str, dict[str, Any]] = {
    "a fifth of the frames lost": {"drop": 0.2, "direction": "both"},
    "and a stream": {"drop": 0.2, "direction": "both", "stream_at_boot": True},
    "answers 1.4 s late": {"delay_ms": 1400.0},
    "answers up to 0.4 s late, some lost": {"delay_ms": 100.0, "jitter_ms": 300.0, "drop": 0.2},
    "a module that needs 5 ms between frames": {"min_gap_ms": 5.0},
    "30 ms, and some are lost": {"min_gap_ms": 30.0, "drop": 0.2, "direction": "both"},
    "half duplex under a stream of 200 Hz": {"half_duplex": True, "stream_at_boot": True, "rate": 200},
    "damaged": {"corrupt": 0.04, "direction": "both"},
}


@pytest.mark.parametrize("faults", LOSSY.values(), ids=LOSSY)
@pytest.mark.promise("l")
def test_on_bad_lines_it_arrives_and_is_never_claimed_wrongly(faults: dict[str, Any]) -> None:
    confirmed = 0
    for seed in range(SEEDS):
        rig = Rig({"uptime": 60, "active": True, "seed": seed * 31 + 7, **faults})
        rig.step_for(0.5)
        locked = pressed(rig)
        assert not rig.bench.module.state.is_active, f"seed {seed}: it did not arrive"
        assert locked.is_locked is not False
        confirmed += locked.is_locked is True
    assert confirmed >= SEEDS * 0.95
