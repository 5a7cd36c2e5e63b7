"""Whose turn it is on the line: queued, urgent, in the background, cancelled."""

from concurrent.futures import Future
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Cancelled, Pause, Procedure, wait_for
from app.procedures.lock import lock
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, HEARTBEAT_REPLY, LOCK, STATUS, Request
from protocol.events import Answered, EndReason, Unanswered
from tests.support.line.frames import lose
from tests.support.line.sim_line import Rig, settled_rig
from tests.unit.protocol.link_bench import BOOTS

LIGHT = BY_NAME["light"]
STATUS_QUERY = STATUS.query()
SET = BY_NAME["freefall_time"].set(1.2)
ACTIVATE = ACTIVATION.set(True)


def ask(*requests: Request, **options: Any) -> Procedure[list[object]]:
    """Ask one after the other; what became of each."""
    outcomes: list[object] = []
    for request in requests:
        outcome = yield Ask(request, is_deliberate=True, **options)
        outcomes.append(outcome)
    return outcomes


def poll(what: Request = STATUS_QUERY) -> Procedure[None]:
    while True:
        yield Ask(what)
        yield Pause(0.05)


def asked(rig: Rig) -> list[Request]:
    """What was sent, but for the link's own questions."""
    return [request for request in rig.line.requests if request not in (BOOTS, HEARTBEAT.query())]


def rest() -> Procedure[None]:
    yield Pause(2.0)


# Waiting for bytes


def test_an_answer_that_came_while_the_computer_was_busy_is_in_time() -> None:
    """The driver has nothing yet, and this thread gets its turn again only later than it wanted."""
    rig = settled_rig()
    read, waits_s = rig.line.read, [0.4]

    def late(longest_s: float, gather_s: float) -> bytes:
        if not waits_s:
            return read(longest_s, gather_s)
        rig.clock.now_s += waits_s.pop()
        return b""

    rig.line.read = late  # type: ignore[method-assign]
    (answered,) = rig.run(ask(LIGHT.query()))
    assert isinstance(answered, Answered)
    assert answered.attempts == 1


@pytest.mark.promise("f")
def test_bytes_that_were_read_when_the_computer_had_slept_are_nobodys() -> None:
    rig = settled_rig()
    resting = rig.job(rest())

    def sleep(longest_s: float, gather_s: float) -> bytes:
        rig.clock.now_s += 60.0
        return HEARTBEAT_REPLY

    rig.line.read = sleep  # type: ignore[method-assign]
    rig.session.step()
    assert rig.conversation.ended is not None
    assert rig.conversation.ended.reason is EndReason.SLEPT
    assert isinstance(resting.error, Interrupted), "it did not go on with what was so before"


# Whose turn it is


@pytest.mark.promise("j")
@pytest.mark.parametrize(
    "what", ["nothing", "a question", "a set", "a held set", "records", "the link's own", "no module"]
)
def test_lock_leaves_at_once_whatever_is_in_flight(what: str) -> None:
    rig = settled_rig()
    rig.bench.change(lag_ms=200.0)
    match what:
        case "a question":
            rig.job(ask(LIGHT.query()))
        case "a set" | "a held set":
            rig.job(ask(SET))
        case "records":
            rig.job(ask(BY_NAME["trigger_records"].query()))
        case "the link's own":
            rig.step_until(lambda: rig.session._link.is_own)
        case "no module":
            rig.bench.module.power_off()
            rig.step_for(1.2)
    rig.session.step(0.001)
    if what == "a set":
        rig.step_until(lambda: SET in rig.line.requests)
    pressed_at = rig.clock()
    rig.job(lock(), is_urgent=True, outlives=True)
    rig.session.step(0.0)
    assert rig.line.requests[-1] == LOCK
    assert rig.clock() - pressed_at < 0.001


def test_after_lock_a_question_is_asked_again_and_a_set_is_unknown() -> None:
    rig = settled_rig()
    rig.bench.change(lag_ms=100.0)
    asking = rig.job(ask(LIGHT.query(), SET))
    rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    rig.step_until(lambda: SET in rig.line.requests)
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    answered, unknown = rig.end(asking)
    assert isinstance(answered, Answered)
    assert isinstance(unknown, Unanswered)
    assert unknown.may_be_done
    assert rig.line.requests.count(SET) == 1


@pytest.mark.promise("i")
@pytest.mark.parametrize("when", ["it waits for its turn", "it waits for a quiet line", "it was submitted"])
def test_nothing_dangerous_that_was_decided_before_lock_leaves_after_it(when: str) -> None:
    rig = settled_rig()
    if when == "it was submitted":
        rig.job(ask(*[LIGHT.query()] * 3))
    job = rig.job(ask(*[LIGHT.query()] * (2 if when == "it waits for its turn" else 1), ACTIVATE))
    if when == "it waits for a quiet line":
        rig.step_until(lambda: job.pending_ask is not None and job.pending_ask.request == ACTIVATE)
    elif when == "it waits for its turn":
        rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    rig.job(lock(), is_urgent=True, outlives=True)
    *_, last = rig.end(job)
    assert last == Unanswered(ACTIVATE, 0, 0.0, last.at)  # type: ignore[attr-defined]
    assert ACTIVATE not in rig.line.requests


def test_the_background_has_the_line_while_the_foreground_waits_for_a_disk() -> None:
    def waiting() -> Procedure[None]:
        yield from wait_for(Future(), 0.5)

    rig = Rig(background=poll).begin()
    rig.step_for(0.2)
    job = rig.job(waiting())
    rig.session.step()
    before = len(asked(rig))
    rig.end(job)
    assert len(asked(rig)) >= before + 6


# Cancelled


def test_a_cancelled_job_ends_at_once_and_leaves_the_line_free() -> None:
    rig = settled_rig()
    lose(rig.bench, LIGHT.code)
    first = rig.job(ask(LIGHT.query()))
    rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    first.cancel()
    sent = rig.line.requests.count(LIGHT.query())
    rig.session.step()
    assert isinstance(first.error, Cancelled)
    rig.run(ask(STATUS.query()))
    rig.step_for(1.0)
    assert rig.line.requests.count(LIGHT.query()) == sent


def test_after_a_cancellation_a_procedure_may_undo_what_it_changed() -> None:
    def careful() -> Procedure[object]:
        try:
            yield Pause(10.0)
        except Cancelled:
            return (yield Ask(SET))
        return None

    rig = settled_rig()
    job = rig.job(careful())
    rig.session.step()
    job.cancel()
    job.cancel()
    assert isinstance(rig.end(job), Answered)


def test_a_set_that_is_cancelled_before_it_left_is_known_not_to_have_left() -> None:
    told: list[object] = []

    def writing() -> Procedure[None]:
        yield Ask(LIGHT.query())
        told.append((yield Ask(SET)))
        yield Pause(10.0)

    rig = settled_rig()
    job = rig.job(writing())
    rig.step_until(lambda: job.pending_ask is not None and job.pending_ask.request == SET)
    job.cancel()
    rig.step_for(1.0)
    assert told == [Unanswered(SET, 0, 0.0, told[0].at)]  # type: ignore[attr-defined]
    assert SET not in rig.line.requests
