"""LOCK is repeated until the module reports that it is locked: at the proven rate, within limits."""

from collections.abc import Callable
from itertools import cycle, groupby, pairwise
from typing import Any

import pytest
from hypothesis import settings

from app.engine.identity import UNKNOWN
from app.engine.procedure import LOCK_GAPS_S, LOCKS_FOR_S, MAX_LOCKS, LockRepeat, PortLost
from app.engine.session import Run
from app.procedures.act import perform
from app.procedures.find import find_rate
from app.procedures.lock import BREATH_S, SENTENCES, SILENT_S, Locked, lock, waiting_sentence
from app.safety.acts import Act
from app.safety.journal import NoJournal, Outcome
from protocol.catalogue import BAUD_RATES, BY_NAME, LOCK, Hazard, Request
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.lock_script import LockScript
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig, settled_rig

ACTIVE = BY_NAME["active"].query()


def press(rig: Rig, **more: Any) -> Run[Locked]:
    return rig.started(lock(more.pop("journal", None), **more), is_urgent=True)


def pressed(rig: Rig, **more: Any) -> Locked:
    return rig.end(press(rig, **more), limit_s=60)


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


@pytest.mark.promise("l")
def test_on_a_good_line_it_is_sent_once_and_asked_for_twice() -> None:
    rig = settled_rig(active=True)
    began = rig.clock()
    locked = pressed(rig)
    assert (locked.outcome, locked.sent, locked.is_acknowledged) == (Outcome.CONFIRMED, 1, True)
    assert rig.clock() - began < BREATH_S, "it waits for nothing"
    assert [request.command.name for request in rig.line.requests] == ["activation", "active", "status"]
    assert locked.sentence == "The module reports LOCKED."


def test_what_a_new_module_reports_is_not_logged_of_the_one_that_it_was_pressed_for() -> None:
    """A person says so while LOCK is still repeated."""
    rig, journal = settled_rig(active=True), FakeJournal()
    rig.session.confirm_identity(None, is_named=True, before=UNKNOWN)
    rig.bench.change(mute=True)
    run = press(rig, journal=journal)
    rig.step_until(lambda: not rig.session.identity.identity.is_settled)
    rig.session.treat_as_new(is_named=False)
    rig.bench.change(mute=False)
    assert (rig.end(run, limit_s=60).outcome, *journal.outcomes.values()) == (Outcome.CONFIRMED, Outcome.UNKNOWN)


@pytest.mark.promise("l")
def test_it_is_repeated_until_it_is_reported() -> None:
    rig = settled_rig(active=True)
    times = deafen(rig, lambda number, frame: frame == LOCK and number < 7)
    locked = pressed(rig)
    assert (locked.is_locked, locked.sent) == (True, 7)
    assert not rig.bench.module.state.is_active
    gaps = [later - sooner for sooner, later in pairwise(times)]
    assert all(0.1 <= gap <= 0.25 for gap in gaps), gaps
    assert locked.sentence == "The module reports LOCKED."


@pytest.mark.promise("l")
def test_it_is_repeated_while_the_answer_to_the_question_is_awaited() -> None:
    """Nothing of the module is heard for two seconds; it hears nothing either."""
    rig = settled_rig(active=True)
    until = rig.clock() + 2.0
    times = deafen(rig, lambda _number, _frame: rig.clock() < until)
    locked = pressed(rig)
    assert locked.is_locked
    gaps = [later - sooner for sooner, later in pairwise(times)]
    assert all(0.09 <= gap <= 0.21 for gap in gaps), gaps
    assert len(gaps) >= 12


def test_an_acknowledgement_alone_is_no_proof() -> None:
    rig = settled_rig(active=True)
    rig.run(lock())
    rig.bench.module.activate(is_active=True)
    rig.bench.change(mute_codes=frozenset((0x30, 0x32)))
    locked = pressed(rig)
    assert locked.is_acknowledged
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent > 1


def test_one_question_alone_is_enough_where_the_module_does_not_know_the_other() -> None:
    for code in (0x30, 0x32):
        assert pressed(settled_rig(active=True, **{"mute-codes": f"{code:02x}"})).is_locked


@pytest.mark.promise("l")
def test_it_ends_within_its_limits_and_says_what_is_not_known() -> None:
    rig, journal = settled_rig(active=True, mute=True), FakeJournal()
    began = rig.clock()
    locked = pressed(rig, journal=journal)
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent == locks(rig) <= MAX_LOCKS
    assert MAX_LOCKS * min(LOCK_GAPS_S) < rig.clock() - began < LOCKS_FOR_S + 8  # with a search for its rate
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
    journal.line_length = lambda: len(rig.line.sent)
    locked = pressed(rig, journal=journal)
    assert locked.is_locked
    assert [act for act, _frame, _detail in journal.intents] == [Act.LOCK]
    assert journal.sent_before[0] >= len(LOCK.encode())
    assert journal.outcomes == {0: Outcome.CONFIRMED}


@pytest.mark.promise("l")
def test_locking_needs_nothing_and_is_done_without_a_log() -> None:
    rig = settled_rig(active=True)
    assert pressed(rig, journal=NoJournal()).is_locked
    assert not rig.bench.module.state.is_active


@pytest.mark.parametrize("steps", range(0, 30, 3))
@pytest.mark.promise("l")
def test_nothing_dangerous_decided_before_goes_between_two_of_them(steps: int) -> None:
    rig = settled_rig()
    acting = rig.started(perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE)))
    deafen(rig, lambda number, frame: 0 < number < 5)
    for _ in range(steps):
        rig.session.step()
    before = len(rig.line.requests)
    locking = press(rig)
    rig.step_until(lambda: locking.is_done and acting.is_done, limit_s=60)
    after = rig.line.requests[before:]
    assert after.count(LOCK) >= 5
    assert not [request for request in after if request.hazard is Hazard.DANGEROUS]
    assert not rig.bench.module.state.is_active


def test_what_is_done_on_purpose_afterwards_ends_the_repeating() -> None:
    """The module is locked, which no report says: somebody who activates it is not locked out again."""
    rig = settled_rig(**{"mute-codes": "30"})
    deafen(rig, lambda _number, frame: frame == LOCK)
    rig.bench.module.activate(is_active=True)
    locking = press(rig)
    rig.step_for(0.5)
    assert not locking.is_done
    locking.cancel()
    assert rig.end(locking, limit_s=0.05).is_replaced
    count = locks(rig)
    rig.step_for(3.0)
    assert locks(rig) == count


def test_it_leaves_at_the_proven_rate_while_the_rate_is_searched() -> None:
    rig = settled_rig(active=True)
    rig.step_for(0.1)
    rig.run(find_rate(115200))
    finding = rig.started(find_rate(4800))
    rig.step_until(lambda: rig.line.baud_rate == 4800)
    locked = pressed(rig)
    assert (locked.is_locked, locked.sent) == (True, 1)
    assert rig.end(finding).baud_rate == 115200


def test_a_search_goes_on_at_its_own_rate_also_after_a_second_press() -> None:
    """Else it would take the answer at the rate of LOCK for one at its own."""
    rig = settled_rig(active=True)
    rig.run(find_rate(115200))
    finding = rig.started(find_rate(4800))
    rig.step_until(lambda: rig.line.baud_rate == 4800)
    rig.bench.change(mute=True)
    for _ in range(2):
        press(rig)
        rig.step_until(lambda: rig.line.baud_rate == 115200)
    end_faults(rig.bench)
    assert rig.end(finding).baud_rate == 115200


@pytest.mark.parametrize("rate", [4800, 9600, 57600])
@pytest.mark.parametrize("after_s", [0.0, 0.4, 1.3])
@pytest.mark.promise("l")
def test_it_is_sent_again_where_the_search_finds_the_module(rate: int, after_s: float) -> None:
    rig = settled_rig(active=True)
    rig.run(find_rate(115200))
    rig.bench.module.baud_rate = rate
    finding = rig.started(find_rate(115200))
    rig.step_for(after_s)
    locked = pressed(rig)
    assert locked.is_locked
    assert not rig.bench.module.state.is_active
    assert rig.end(finding).baud_rate == rate


def test_it_goes_on_counting_when_the_port_comes_back() -> None:
    repeat = LockRepeat()
    rig = settled_rig(active=True, mute=True)
    run = press(rig, repeat=repeat)
    rig.step_for(0.5)
    rig.session.close(why=PortLost())
    assert run.result is not None
    assert run.result.is_port_lost
    assert run.result.sent == repeat.sent > 1
    again = settled_rig(active=True)
    again.clock.now_s = rig.clock.now_s
    locked = pressed(again, repeat=repeat)
    assert locked.is_locked
    assert locked.sent == run.result.sent + 1


def test_a_port_lost_before_it_left_is_said() -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    run = press(rig, journal=journal)
    rig.session.close(why=PortLost())
    assert run.result is not None
    assert (run.result.outcome, run.result.sent) == (Outcome.NOT_SENT, 0)
    assert run.result.sentence == "LOCK was not sent: treat the module as ACTIVE."
    assert not journal.intents


def test_a_lock_that_left_is_logged_also_where_the_port_is_lost_before_any_answer() -> None:
    rig, journal = settled_rig(active=True, mute=True), FakeJournal()
    run = press(rig, journal=journal)
    rig.session.step(0.01)
    rig.session.close(why=PortLost())
    assert run.result is not None
    assert (run.result.outcome, run.result.sent) == (Outcome.UNKNOWN, 1)
    assert journal.outcomes == {0: Outcome.UNKNOWN}


def test_every_outcome_has_its_sentence() -> None:
    assert set(SENTENCES) == set(Outcome)
    for outcome in Outcome:
        for sent in (0, 1, 2):
            sentence = Locked(outcome=outcome, sent=sent).sentence
            assert sentence
            assert "{" not in sentence
    assert waiting_sentence(3) == "LOCK sent 3×, not yet reported"


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
        rig = settled_rig(active=True, seed=seed * 31 + 7, **faults)
        rig.step_for(0.3)
        locked = pressed(rig)
        assert not rig.bench.module.state.is_active, f"seed {seed}: it did not arrive"
        assert locked.is_locked is not False
        confirmed += locked.is_locked is True
    assert confirmed >= SEEDS * 0.95


def contradicting() -> Callable[[float], bool]:
    reports = cycle((True, False))
    return lambda _now: next(reports)


@pytest.mark.parametrize(
    ("answer", "outcome", "heard", "after"),
    [
        (contradicting(), Outcome.UNKNOWN, (True, True), 5),
        (lambda _now: True, Outcome.REFUSED, (True, True), 1),
        (lambda _now: None, Outcome.UNKNOWN, (False, False), 1),
        (lambda now: None if now < 10.0 else False, Outcome.CONFIRMED, (True, False), 2),
    ],
    ids=["contradictory", "active", "silent", "locked too late"],
)
def test_after_the_last_lock_the_state_is_asked_for_until_it_is_clear_at_most_five_times(
    answer: Callable[[float], bool | None], outcome: Outcome, heard: tuple[bool, bool], after: int
) -> None:
    script, journal = LockScript(answer, 115200, is_searched=False), FakeJournal()
    journal.line_length = lambda: script.repeat.sent
    locked = script.run(journal)
    assert (locked.outcome, (locked.is_heard, locked.is_acknowledged)) == (outcome, heard)
    assert journal.sent_before == [1]
    assert len(script.asked) < 3 * MAX_LOCKS, "between two LOCKs it waits"
    assert script.asked_after == after
    assert not script.rates
    assert script.progress
    assert all(done == sent - 1 for done, sent in script.progress)


@pytest.mark.parametrize(
    ("proven_rate", "is_searched", "before", "after"),
    [(None, False, [], []), (115200, True, [], [115200]), (9600, True, [9600], [9600])],
)
@pytest.mark.parametrize("silent_from", [0.0, 1.0])
def test_a_silent_module_is_searched_for_once_and_the_proven_rate_returns(
    proven_rate: int | None, is_searched: bool, before: list[int], after: list[int], silent_from: float
) -> None:
    script = LockScript(lambda now: True if now < silent_from else None, proven_rate, is_searched=is_searched)
    assert not script.run().is_locked
    assert [rate for _, rate in script.rates] == [*before, *BAUD_RATES, 115200, *after]
    began = script.rates[len(before)][0]
    assert SILENT_S < began - silent_from < SILENT_S + 0.5
    silent = [(at, request) for at, request in script.asked if at >= silent_from][:6]
    assert [len(list(same)) for _, same in groupby(request for _, request in silent)] == [3, 3]
    assert all(later - sooner > 0.3 + BREATH_S / 2 for (sooner, _), (later, _) in pairwise(silent))


def test_a_lock_that_a_sleep_of_the_computer_withheld_is_sent_after_a_breath_and_logged_once() -> None:
    script, journal = LockScript(lambda _now: False, 115200, is_searched=False), FakeJournal()
    script.withheld = 1
    assert script.run(journal).sent == 1
    assert script.asked[0][0] >= BREATH_S
    assert journal.outcomes == {0: Outcome.CONFIRMED}
