"""LOCK goes before everything else, waits for nothing, and is repeated until the module reports that it is locked."""

from collections.abc import Callable
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from hypothesis import settings

from app.engine.procedure import LOCK_GAPS_S, MAX_LOCKS, Job
from app.procedures.act import Performed, perform
from app.procedures.find import find_rate
from app.procedures.lock import OWED, Locked, lock
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.permit import Interlock
from protocol.catalogue import LOCK, Hazard, Request
from tests.module.module import Module
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame, lose
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import Rig, settled_rig

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
    lose(rig.bench, 0x30, 0x32)
    locked = pressed(rig)
    assert locked.is_acknowledged
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent > 1


@pytest.mark.promise("l")
def test_without_an_acknowledgement_reports_of_active_are_no_refusal() -> None:
    rig = settled_rig(active=True)
    deafen(rig, lambda _number, frame: frame == LOCK)
    locked = pressed(rig)
    assert (locked.outcome, locked.is_locked, locked.is_acknowledged) == (Outcome.UNKNOWN, None, False)
    assert locked.sentence.endswith("not confirmed: treat the module as ACTIVE.")


@pytest.mark.parametrize("is_there_first", [True, False])
@pytest.mark.promise("l")
def test_it_ends_within_its_limits_with_a_search_for_the_rate_and_says_what_is_not_known(is_there_first: bool) -> None:
    rig, journal = settled_rig(active=True) if is_there_first else Rig({"mute": True}), FakeJournal()
    rig.bench.change(mute=True)
    began = rig.clock()
    locked = pressed(rig, journal)
    assert (locked.outcome, locked.is_locked) == (Outcome.UNKNOWN, None)
    assert locked.sent == locks(rig) <= MAX_LOCKS
    assert MAX_LOCKS * min(LOCK_GAPS_S) < rig.clock() - began < 12.0
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert locked.sentence.endswith("not confirmed: treat the module as ACTIVE.")


@pytest.mark.promise("l")
def test_owed_since_a_conversation_that_has_ended_it_clears_nothing_of_it() -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    locked = pressed(rig, journal, pressed_in=OWED)
    assert locked.sentence == "The module that answers now reports LOCKED."
    assert journal.outcomes == {0: Outcome.UNKNOWN}


@pytest.mark.promise("l")
def test_pressed_in_a_conversation_that_has_ended_it_clears_nothing_of_it() -> None:
    """The window hears of the end when the next one goes on already."""
    rig, journal = settled_rig(active=True), FakeJournal()
    locked = pressed(rig, journal, pressed_in=rig.session.conversations - 1)
    assert locked.sentence == "The module that answers now reports LOCKED."
    assert journal.outcomes == {0: Outcome.UNKNOWN}


def test_the_frame_leaves_before_the_journal_is_asked_and_waits_for_none() -> None:
    rig, journal, sent_before = settled_rig(active=True), FakeJournal(), list[int]()
    journal.is_held = True
    journal.on_begin = lambda: sent_before.append(locks(rig))
    assert pressed(rig, journal).is_locked
    assert [act for act, _frame, _detail in journal.intents] == [Act.LOCK]
    assert sent_before == [1]
    assert journal.outcomes == {0: Outcome.CONFIRMED}


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
    rig.line.move(deaf, 0.0, is_announced=False)
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
    rig.line.move(other, 0.0, is_announced=False)
    locked = rig.end(job)
    assert locked.is_locked
    assert locked.sentence == "The module that answers now reports LOCKED."
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert other.log.sent(0x30)
    assert other.log.sent(0x32)


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

SLOW = {"lag_ms": 60.0}


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


# Bad lines

SEEDS = settings().max_examples // 4
"""1,000 in the profile `thorough`."""
LOSSY: dict[str, tuple[float, bool, dict[str, float]]] = {
    "a fifth of the frames lost": (0.2, False, {"drop": 0.2}),
    "and a stream": (0.2, True, {"drop": 0.2}),
    "answers 1.4 s late": (0.0, False, {"lag_ms": 1400.0}),
    "answers 0.4 s late, some lost": (0.0, False, {"lag_ms": 400.0, "drop": 0.2}),
    "damaged": (0.2, False, {"corrupt": 0.04}),
}
"""The share of the host's frames that is lost, whether the module streams, and the faults of its answers."""


@pytest.mark.parametrize(("lost", "is_streaming", "faults"), LOSSY.values(), ids=LOSSY)
@pytest.mark.promise("l")
def test_on_bad_lines_it_arrives_and_is_never_claimed_wrongly(
    lost: float, is_streaming: bool, faults: dict[str, float]
) -> None:
    confirmed = 0
    for seed in range(SEEDS):
        rig = Rig({"active": True, "seed": seed * 31 + 7, **faults})
        dice = Random(seed)
        at_each_frame(rig.bench, lambda _request, dice=dice: dice.random() >= lost)  # type: ignore[misc]
        if is_streaming:
            rig.bench.module.start_stream(rig.clock())
        rig.step_for(0.5)
        locked = pressed(rig)
        assert not rig.bench.module.state.is_active, f"seed {seed}: it did not arrive"
        assert locked.is_locked is not False
        confirmed += locked.is_locked is True
    assert confirmed >= SEEDS * 0.95
