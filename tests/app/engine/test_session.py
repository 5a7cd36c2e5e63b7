"""Whose turn it is on the line: queued, urgent, in the background, cancelled; and what never leaves."""

from collections.abc import Generator
from concurrent.futures import Future
from itertools import pairwise
from typing import Any

import pytest

from app.engine.conversation import Interrupted, NoModule
from app.engine.procedure import (
    LOCK_GAPS_S,
    LOCKS_FOR_S,
    MAX_LOCKS,
    Ask,
    Await,
    Cancelled,
    Inspect,
    Job,
    Listen,
    LockRepeat,
    Pause,
    Procedure,
    Report,
    UseRate,
    ask_value,
)
from app.engine.session import BATCH_S
from app.engine.transport import PortError, PortTrouble
from app.procedures.lock import lock
from app.procedures.read import read_everything
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, HEARTBEAT_REPLY, LOCK, STATUS, Request
from protocol.events import Answered, EndReason, OutcomeUnknown, Received, Role, Unanswered
from protocol.frame import Direction, Frame
from protocol.link import LinkMisused
from tests.support.line.link_bench import BOOTS
from tests.support.line.sim_line import Rig, settled_rig, watched_rig

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


# Waiting for bytes


def test_no_read_gathers_while_an_answer_is_awaited() -> None:
    rig = settled_rig()
    read, gathered = rig.line.read, list[float]()

    def noted(longest_s: float, gather_s: float) -> bytes:
        gathered.append(gather_s)
        return read(longest_s, gather_s)

    rig.line.read = noted  # type: ignore[method-assign]
    rig.run(ask(LIGHT.query()))
    assert set(gathered) == {0.0}
    gathered.clear()
    rig.session.step()
    assert gathered == [BATCH_S] == [0.008], "a stream is gathered while no answer is awaited"


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
    assert rig.conversation.is_going


def test_a_step_ends_when_a_disk_may_be_done() -> None:
    rig = settled_rig()
    read, limits_s = rig.line.read, list[float]()

    def noted(longest_s: float, gather_s: float) -> bytes:
        limits_s.append(longest_s)
        return read(longest_s, gather_s)

    def waiting() -> Procedure[None]:
        yield Await(Future(), 0.5)

    rig.job(waiting())
    rig.session.step()
    rig.line.read = noted  # type: ignore[method-assign]
    rig.session.step(5.0)
    assert limits_s == [pytest.approx(0.002)]


@pytest.mark.promise("j")
def test_lock_is_repeated_at_its_times() -> None:
    rig = settled_rig(active=True)
    rig.bench.change(mute=True)
    rig.job(lock(), is_urgent=True, outlives=True)
    sent_at: list[float] = []
    while len(sent_at) < 8:
        before = rig.line.requests.count(LOCK)
        rig.session.step(5.0)
        sent_at += [rig.clock()] * (rig.line.requests.count(LOCK) - before)
    gaps_s = [later - sooner for sooner, later in pairwise(sent_at)]
    assert gaps_s[1:5] == pytest.approx(LOCK_GAPS_S[1:5], abs=2e-3)


# Whose turn it is


def test_a_second_job_waits_for_the_first() -> None:
    rig = settled_rig()
    first, second = rig.job(read_everything()), rig.job(ask(LIGHT.query()))
    rig.end(first)
    assert not second.has_ended
    rig.end(second)
    assert rig.line.requests[-1] == LIGHT.query()


@pytest.mark.promise("j")
def test_lock_goes_first_and_the_others_go_on() -> None:
    rig = settled_rig(active=True, **{"mute-codes": "14"})
    reading = rig.job(read_everything())
    rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    start_s = rig.clock.now_s
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    assert rig.clock.now_s - start_s < 0.1
    assert not rig.bench.module.state.is_active
    assert list(rig.end(reading).errors) == ["light_v"]


@pytest.mark.promise("j")
@pytest.mark.parametrize(
    "what", ["nothing", "a question", "a set", "a held set", "records", "the link's own", "no module"]
)
def test_lock_leaves_at_once_whatever_is_in_flight(what: str) -> None:
    rig = settled_rig()
    rig.bench.change(delay_ms=200)
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
            rig.bench.power_off()
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
    rig.bench.change(delay_ms=50)
    asking = rig.job(ask(LIGHT.query(), SET))
    rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    rig.step_until(lambda: SET in rig.line.requests)
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    answered, unknown = rig.end(asking)
    assert isinstance(answered, Answered)
    assert isinstance(unknown, OutcomeUnknown)
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


def test_a_second_lock_replaces_the_first() -> None:
    rig = settled_rig(active=True)
    rig.bench.change(mute=True)
    first = rig.job(lock(), is_urgent=True, outlives=True)
    rig.step_for(0.2)
    second = rig.job(lock(), is_urgent=True, outlives=True)
    assert rig.end(first).is_replaced
    assert not second.has_ended


@pytest.mark.promise("j")
def test_the_port_is_not_set_to_the_rate_that_it_has_when_an_overtaken_job_goes_on() -> None:
    rig = settled_rig()
    overtaken = rig.job(read_everything())
    rig.step_for(0.002)
    rates: list[int] = []
    rig.line.use_rate = rates.append  # type: ignore[method-assign, assignment]
    rig.job(lock(), is_urgent=True, outlives=True)
    rig.end(overtaken)
    assert rates == [], "it would discard what is being received"


def test_the_background_does_not_hold_up_the_foreground() -> None:
    rig = Rig({"mute-codes": "14"}, background=lambda: poll(LIGHT.query())).begin()
    rig.step_for(0.02)
    start_s = rig.clock.now_s
    rig.run(ask(STATUS.query()))
    assert rig.clock.now_s - start_s < 0.4, "one question of its own at most"


def test_the_background_has_the_line_while_the_foreground_waits_for_a_disk() -> None:
    def waiting() -> Procedure[None]:
        yield Await(Future(), 0.5)

    rig = Rig(background=poll).begin()
    rig.step_for(0.2)
    job = rig.job(waiting())
    rig.session.step()
    before = len(asked(rig))
    rig.step_for(0.09)
    assert len(asked(rig)) == before
    rig.end(job)
    assert len(asked(rig)) >= before + 6


# Cancelled


def test_a_cancelled_job_ends_at_once_and_leaves_the_line_free() -> None:
    rig = settled_rig(**{"mute-codes": "14"})
    first = rig.job(ask(LIGHT.query()))
    rig.step_until(lambda: LIGHT.query() in rig.line.requests)
    first.cancel()
    sent = rig.line.requests.count(LIGHT.query())
    rig.session.step()
    assert isinstance(first.error, Cancelled)
    rig.run(ask(STATUS.query()))
    rig.step_for(1.0)
    assert rig.line.requests.count(LIGHT.query()) == sent


def test_a_job_that_is_cancelled_before_its_turn_leaves_the_line_alone() -> None:
    rig = settled_rig()
    rig.job(ask(*[LIGHT.query()] * 5))
    waiting = rig.job(ask(STATUS.query()))
    waiting.cancel()
    rig.step_for(0.5)
    assert isinstance(waiting.error, Cancelled)
    assert STATUS.query() not in rig.line.requests


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


# What never leaves


@pytest.mark.promise("i")
@pytest.mark.parametrize("request_", [BY_NAME["zero_sensor"].query(), ACTIVATE, BY_NAME["deploy"].set(True)])
def test_a_dangerous_request_never_leaves_without_an_explicit_act(request_: Request) -> None:
    def careless() -> Procedure[None]:
        yield Ask(request_)

    rig = settled_rig()
    with pytest.raises(LinkMisused):
        rig.run(careless())
    assert request_ not in rig.line.requests
    rig.run(ask(LIGHT.query()))


@pytest.mark.promise("i")
@pytest.mark.parametrize("drop", [0.0, 0.3])
def test_a_dangerous_request_leaves_once(drop: float) -> None:
    rig = settled_rig()
    rig.bench.change(drop=drop)
    job = rig.job(ask(ACTIVATE))
    rig.step_for(5.0)
    assert job.has_ended
    assert rig.line.requests.count(ACTIVATE) == 1


@pytest.mark.promise("a")
@pytest.mark.parametrize("request_", [SET, ACTIVATE, BY_NAME["serial_output"].set(True)])
def test_16_on_a_slow_line_only_questions_and_lock_leave(request_: Request) -> None:
    rig = Rig({"uptime": 60, "delay_ms": 350}).begin()
    rig.run(read_everything())
    (refused,) = rig.run(ask(request_))
    assert refused == Unanswered(request_, 0, 0.0, refused.at)  # type: ignore[attr-defined]
    assert request_ not in rig.line.requests
    assert rig.conversation.is_slow
    rig.end(rig.job(lock(), is_urgent=True, outlives=True))
    assert LOCK in rig.line.requests


@pytest.mark.promise("k")
def test_a_bug_in_a_procedure_ends_only_that_job() -> None:
    def broken() -> Procedure[None]:
        yield Ask(LIGHT.query())
        raise ZeroDivisionError

    rig = settled_rig()
    with pytest.raises(ZeroDivisionError):
        rig.run(broken())
    rig.run(ask(LIGHT.query()))
    assert rig.conversation.is_going


# Without a module


def test_a_job_waits_two_seconds_for_a_conversation() -> None:
    rig = Rig({"mute": True})
    job = rig.job(ask(LIGHT.query()))
    began = rig.clock()
    with pytest.raises(NoModule):
        rig.end(job)
    assert rig.clock() - began == pytest.approx(2.0, abs=0.05)
    assert LIGHT.query() not in rig.line.requests


def test_a_job_goes_on_when_the_conversation_begins() -> None:
    rig = Rig({"mute": True})
    job = rig.job(ask(LIGHT.query()))
    rig.step_for(1.5)
    rig.bench.change(mute=False)
    (answered,) = rig.end(job)
    assert isinstance(answered, Answered)


def test_a_job_of_the_port_needs_no_conversation() -> None:
    rig = Rig({"mute": True})
    began = rig.clock()
    (unanswered,) = rig.run(ask(HEARTBEAT.query(), limit_s=0.4), outlives=True)
    assert isinstance(unanswered, Unanswered)
    assert rig.clock() - began < 0.5


# The port


def test_a_lost_port_ends_every_job() -> None:
    rig = watched_rig()
    rig.step_for(3)
    jobs = [rig.job(poll()), rig.job(poll()), rig.job(poll(HEARTBEAT.query()), outlives=True)]
    rig.step_for(0.2)
    rig.bench.unplug()
    with pytest.raises(PortError) as lost:
        rig.step_for(1)
    assert lost.value.trouble is PortTrouble.LOST
    rig.session.close(EndReason.PORT_LOST)
    for job in jobs:
        assert isinstance(job.error, Interrupted)
        assert job.error.reason is EndReason.PORT_LOST
    assert rig.line.is_closed
    ended = rig.conversation.ended
    assert ended is not None
    assert ended.reason is EndReason.PORT_LOST


def test_what_a_procedure_sees() -> None:
    def look() -> Procedure[Any]:
        return (yield Inspect())

    rig = settled_rig(boots=37)
    view = rig.run(look())
    assert view.conversation.boot_count == 37
    assert (view.baud_rate, view.proven_rate, view.sets_rate) == (115200, 115200, True)
    assert (view.overtaken_at, view.is_rate_in_doubt) == (None, False)
    assert view.link.round_trip_median_s is not None


def test_a_job_that_begins_with_a_look_goes_on_at_once() -> None:
    def look_and_ask() -> Procedure[None]:
        yield Inspect()
        yield Ask(LIGHT.query())

    rig = settled_rig()
    rig.job(look_and_ask())
    rig.session.step(0.0)
    assert rig.line.requests[-1] == LIGHT.query()


def test_a_search_for_the_rate_is_seen_by_lock() -> None:
    seen: list[bool] = []

    def search() -> Procedure[None]:
        yield UseRate(9600)
        yield Pause(1.0)

    def look() -> Procedure[None]:
        seen.append((yield Inspect()).is_rate_in_doubt)

    rig = settled_rig()
    rig.job(search(), outlives=True)
    rig.step_for(0.1)
    rig.end(rig.job(look(), is_urgent=True, outlives=True))
    assert seen == [True]


# LOCK's times, and single effects


def test_lock_is_repeated_for_ten_seconds_from_the_first_one() -> None:
    assert (LOCKS_FOR_S, MAX_LOCKS) == (10.0, 50)
    assert all(0.1 < gap_s < 0.2 for gap_s in LOCK_GAPS_S)
    repeat = LockRepeat()
    assert repeat.is_due(5.0)
    repeat.note_sent(5.0)
    assert (repeat.until, repeat.next_at, repeat.sent) == (15.0, 5.0 + LOCK_GAPS_S[0], 1)
    assert not repeat.is_due(5.0)
    assert repeat.is_due(repeat.next_at)
    repeat.note_sent(6.0)
    assert (repeat.until, repeat.next_at, repeat.sent) == (15.0, 6.0 + LOCK_GAPS_S[1], 2)
    assert repeat.is_repeating(14.875)
    assert not repeat.is_repeating(15.0)


def test_lock_is_sent_fifty_times_at_most() -> None:
    repeat = LockRepeat()
    for count in range(MAX_LOCKS):
        assert repeat.is_repeating(0.0), count
        repeat.note_sent(0.0)
    assert not repeat.is_repeating(0.0)


def started(effect: object, now: float = 10.0) -> Job[Any]:
    def procedure() -> Generator[Any, Any, object]:
        return (yield effect)

    job: Job[Any] = Job(procedure())
    job.start(now)
    return job


def test_a_pause_ends_at_its_time() -> None:
    job = started(Pause(0.5))
    assert job.due_at == 10.5
    job.tick(10.375)
    assert not job.has_ended
    job.tick(10.5)
    assert (job.has_ended, job.outcome(), job.due_at) == (True, 10.5, None)


def test_listening_returns_what_came_meanwhile() -> None:
    heard = Received(Frame(Direction.MODULE_TO_HOST, HEARTBEAT_REPLY), None, Role.STREAMED, 10.25)
    job = started(Listen(0.5))
    job.hear(heard)
    job.tick(10.5)
    assert job.outcome() == (heard,)
    paused = started(Pause(0.5))
    paused.hear(heard)
    paused.tick(10.5)
    assert paused.outcome() == 10.5


def test_waiting_ends_with_the_future_or_at_its_limit() -> None:
    slow: Future[None] = Future()
    job = started(Await(slow, 2.0))
    assert (job.awaits_since, job.due_at) == (10.0, None)
    job.tick(11.875)
    assert not job.has_ended
    job.tick(12.0)
    assert (job.has_ended, job.outcome(), job.awaits_since) == (True, False, None)
    quick: Future[None] = Future()
    job = started(Await(quick, 2.0))
    quick.set_result(None)
    job.tick(10.125)
    assert job.outcome() is True
    assert started(Await(quick, 2.0)).outcome() is True, "it is done already"


def test_a_report_does_not_hold_a_procedure_up() -> None:
    def procedure() -> Generator[Any, Any, object]:
        return (yield Report(1, 2, "Working"))

    told: list[Report] = []
    job: Job[Any] = Job(procedure(), told.append)
    job.start(10.0)
    assert (job.outcome(), told) == (10.0, [Report(1, 2, "Working")])


def test_one_value_and_no_answer() -> None:
    rig = settled_rig(**{"mute-codes": "33"})
    reading = rig.run(ask_value(LIGHT))
    assert reading is not None
    assert rig.run(ask_value(BY_NAME["charging"])) is None
