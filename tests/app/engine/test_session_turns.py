"""Whose turn it is on the line: queued, urgent, in the background, cancelled, broken off; and what never leaves."""

from collections.abc import Generator
from concurrent.futures import Future
from itertools import pairwise
from typing import Any

import pytest

from app.engine.procedure import (
    LOCK_GAPS_S,
    LOCKS_FOR_S,
    MAX_LOCKS,
    Ask,
    Await,
    Cancelled,
    Listen,
    LockRepeat,
    Pause,
    PortLost,
    Procedure,
    Report,
    UseRate,
    is_alive,
)
from app.engine.session import BATCH_S, Run
from app.engine.transport import PortError, PortTrouble
from app.procedures.find import find_rate
from app.procedures.handshake import handshake
from app.procedures.lock import lock
from app.procedures.read import read_everything
from protocol.catalogue import BY_NAME, HEARTBEAT, HEARTBEAT_REPLY, LOCK
from protocol.events import FellSilent, Received, Role, Unanswered
from protocol.frame import Direction, Frame
from tests.support.line.sim_line import end_watch, settled_rig, watched


def test_no_read_gathers_while_an_answer_is_awaited() -> None:
    rig = settled_rig()
    read, gathered = rig.line.read, list[float]()

    def noted(longest_s: float, gather_s: float) -> bytes:
        gathered.append(gather_s)
        return read(longest_s, gather_s)

    rig.line.read = noted  # type: ignore[method-assign]
    rig.run(read_everything())
    assert set(gathered) == {0.0}
    gathered.clear()
    rig.session.step()
    assert gathered == [BATCH_S] == [0.008], "a stream is gathered while no answer is awaited"


def test_a_step_ends_when_a_future_or_a_lock_may_be_due() -> None:
    rig = settled_rig(active=True, mute=True)
    wait, limits_s = rig.line.read, list[float]()

    def noted(longest_s: float, gather_s: float) -> bytes:
        limits_s.append(longest_s)
        return wait(longest_s, gather_s)

    def waiting() -> Procedure[None]:
        yield Await(Future(), 0.5)

    rig.line.read = noted  # type: ignore[method-assign]
    run = rig.started(waiting())
    began = rig.clock()
    rig.session.step(5.0)
    assert limits_s == [pytest.approx(0.002)]
    watched(rig)
    rig.step_until(lambda: rig.line.requests)
    assert rig.clock() - began == pytest.approx(0.1, abs=0.005), "then the line is free for the background"
    end_watch(rig)
    rig.end(run)
    rig.started(lock(), is_urgent=True)
    sent_at: list[float] = []
    for _ in range(40):
        before = rig.line.requests.count(LOCK)
        rig.session.step(5.0)
        sent_at += [rig.clock()] * (rig.line.requests.count(LOCK) - before)
    gaps_s = [later - sooner for sooner, later in pairwise(sent_at[1:])]
    assert gaps_s[:4] == pytest.approx(LOCK_GAPS_S[1:5], abs=1e-3)


def test_the_rest_of_a_frame_is_waited_for_only_briefly() -> None:
    rig = settled_rig()
    waited_s: list[float] = []

    def cut(longest_s: float, _gather_s: float) -> bytes:
        waited_s.append(longest_s)
        return HEARTBEAT_REPLY[:3] if len(waited_s) == 1 else b""

    rig.line.read = cut  # type: ignore[method-assign, assignment]
    rig.session.step(0.25)
    assert len(waited_s) == 2, "once for the beginning and once for the rest"
    assert waited_s[1] <= 0.002


def test_an_answer_that_came_while_the_computer_was_busy_is_in_time() -> None:
    """The driver has nothing yet, and this thread gets its turn again only a second later than it wanted."""
    rig = settled_rig()
    read, waits_s = rig.line.read, [1.5]

    def late(longest_s: float, gather_s: float) -> bytes:
        if not waits_s:
            return read(longest_s, gather_s)
        rig.clock.now_s += waits_s.pop()
        return b""

    rig.session.take_events()
    rig.line.read = late  # type: ignore[method-assign]
    assert rig.run(is_alive())
    assert not [event for event in rig.session.take_events() if isinstance(event, FellSilent | Unanswered)]


def test_the_background_goes_on_after_a_sleep_and_does_not_repeat_what_it_set(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, naps_s = settled_rig(delay_ms=50), iter((60.0,))
    watched(rig)
    stream_on = BY_NAME["serial_output"].set(True)
    rig.step_until(lambda: stream_on in rig.line.requests)
    monkeypatch.setattr(rig.session, "_asleep_s", lambda: next(naps_s, 0.0))
    rig.session.step()
    before = len(rig.line.requests)
    rig.step_for(5)
    assert len(rig.line.requests) > before + 10
    assert rig.line.requests.count(stream_on) == 1


def test_a_cancelled_procedure_ends_at_once() -> None:
    rig = settled_rig(mute=True)
    run = rig.started(read_everything())
    rig.step_for(0.1)
    run.cancel()
    rig.session.step()
    assert isinstance(run.error, Cancelled)


def test_a_cancelled_question_leaves_the_line_free_and_a_waiting_procedure_leaves_the_line_alone() -> None:
    rig = settled_rig(mute=True)
    first = rig.started(read_everything())
    rig.step_for(0.1)
    first.cancel()
    rig.started(handshake())
    rig.step_for(0.1)
    assert rig.line.requests[-1] == HEARTBEAT.query(), "it does not wait for the answer to the cancelled question"
    waiting = rig.started(read_everything())
    waiting.cancel()
    sent = len(rig.line.requests)
    rig.step_for(0.1)
    assert waiting.is_done
    assert len(rig.line.requests) == sent, "the heartbeat in flight is not sent again"


def test_the_port_is_not_set_to_the_rate_that_it_has_when_an_overtaken_procedure_goes_on() -> None:
    rig = settled_rig()
    overtaken = rig.started(read_everything())
    rig.step_for(0.002)
    rates: list[int] = []
    rig.line.use_rate = rates.append  # type: ignore[method-assign, assignment]
    rig.started(lock(), is_urgent=True)
    rig.end(overtaken)
    assert rates == [], "it would discard what is being received"


def test_a_lost_port_ends_every_procedure() -> None:
    rig = settled_rig()
    watched(rig)
    rig.step_for(3)
    run = rig.started(find_rate())
    rig.bench.unplug()
    with pytest.raises(PortError) as lost:
        rig.step_for(1)
    assert lost.value.trouble is PortTrouble.LOST
    rig.session.close(why=lost.value)
    assert run.error is lost.value
    assert rig.line.is_closed
    known = rig.session.device.view(0).values
    assert "attitude_threshold_deg" in known
    assert all(one.is_stale for one in known.values())


def test_closing_without_a_reason_says_port_lost() -> None:
    rig = settled_rig(mute=True)
    run = rig.started(handshake())
    rig.session.close()
    rig.session.close()
    assert isinstance(run.error, PortLost)


def test_a_second_procedure_waits_for_the_first() -> None:
    rig = settled_rig()
    first, second = rig.started(read_everything()), rig.started(handshake())
    rig.end(first)
    assert not second.is_done
    rig.end(second)
    assert rig.line.requests[-1] == HEARTBEAT.query()


@pytest.mark.promise("j")
def test_an_urgent_procedure_goes_first_and_the_others_go_on() -> None:
    rig = settled_rig(active=True, **{"mute-codes": "14"})
    rig.run(handshake())
    reading = rig.started(read_everything())
    rig.step_until(lambda: rig.line.requests[-1].command.name == "light")
    start_s = rig.clock.now_s
    rig.end(rig.started(lock(), is_urgent=True))
    assert rig.clock.now_s - start_s < 0.1
    assert not rig.bench.module.state.is_active
    assert list(rig.end(reading).errors) == ["light_v"]


def test_the_background_does_not_hold_up_the_foreground() -> None:
    rig = settled_rig(**{"mute-codes": "14,32,33,34"})
    watched(rig)
    rig.step_for(0.05)
    start_s = rig.clock.now_s
    assert rig.run(handshake()) is None
    assert rig.clock.now_s - start_s < 0.1


@pytest.mark.promise("k")
def test_a_bug_in_a_procedure_ends_only_that_procedure() -> None:
    def broken() -> Procedure[None]:
        yield from handshake()
        raise ZeroDivisionError

    rig = settled_rig()
    with pytest.raises(ZeroDivisionError):
        rig.run(broken())
    assert rig.run(handshake()) is None


@pytest.mark.promise("i")
def test_a_dangerous_request_never_leaves_without_an_explicit_act() -> None:
    def careless() -> Procedure[None]:
        yield Ask(BY_NAME["zero_sensor"].query())

    rig = settled_rig()
    with pytest.raises(ValueError, match="explicit act"):
        rig.run(careless())
    assert rig.line.sent == b""


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


def started(effect: object, now: float = 10.0) -> Run[Any]:
    def procedure() -> Generator[Any, Any, object]:
        return (yield effect)

    run: Run[Any] = Run(procedure())
    run.start(now)
    return run


def test_a_pause_ends_at_its_time() -> None:
    run = started(Pause(0.5))
    assert run.resume_at == 10.5
    run.tick(10.375)
    assert not run.is_done
    run.tick(10.5)
    assert (run.is_done, run.result, run.resume_at) == (True, 10.5, None)


def test_listening_returns_what_came_meanwhile() -> None:
    heard = Received(Frame(Direction.MODULE_TO_HOST, HEARTBEAT_REPLY), None, Role.STREAMED, 10.25)
    run = started(Listen(0.5))
    run.on_received(heard)
    run.tick(10.5)
    assert run.result == (heard,)
    paused = started(Pause(0.5))
    paused.on_received(heard)
    paused.tick(10.5)
    assert paused.result == 10.5


def test_waiting_ends_with_the_future_or_at_its_limit() -> None:
    slow: Future[None] = Future()
    run = started(Await(slow, 2.0))
    assert (run.waiting_since(), run.resume_at) == (10.0, None)
    run.tick(11.875)
    assert not run.is_done
    run.tick(12.0)
    assert (run.is_done, run.result, run.waiting_since()) == (True, False, None)
    quick: Future[None] = Future()
    run = started(Await(quick, 2.0))
    quick.set_result(None)
    run.tick(10.125)
    assert run.result is True
    assert started(Await(quick, 2.0)).result is True, "it is done already"


def test_a_report_does_not_hold_a_procedure_up() -> None:
    def procedure() -> Generator[Any, Any, object]:
        return (yield Report(1, 2, "Working"))

    told: list[Report] = []
    run: Run[Any] = Run(procedure(), told.append)
    run.start(10.0)
    assert (run.result, told) == (10.0, [Report(1, 2, "Working")])


@pytest.mark.parametrize(("effect", "searches"), [(UseRate(9600), True), (Pause(1.0), False)])
def test_a_run_that_wants_another_rate_searches(effect: object, searches: bool) -> None:
    run = started(effect)
    assert run.searches_rate is searches
    assert (run.pending_rate is not None) is searches
    run.resume(None, 10.0)
    assert run.is_done
    assert run.searches_rate is searches
