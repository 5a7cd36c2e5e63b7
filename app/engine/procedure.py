"""Procedures: generators that yield an effect, are resumed with its result, and return their own.

They hold no port, clock or thread, so the same one runs in the window, on the command line and, in microseconds, in
tests.

    effect       resumed with
    Ask          Answered | Unanswered
    Pause        the time (seconds of the session's clock)
    UseRate      the time; the port runs at the new rate and its buffers are empty
    Inspect      EngineView: what is known, at once
    Report       the time, at once

A `Job` is a procedure that runs in one conversation, and how far it is. When the conversation ends `Interrupted` is
raised at its yield: it may return what it has found, but not yield, so that nothing that it wants to undo reaches the
module that answers next. So no procedure asks whether the module is still the same one. Two kinds of jobs go on: one
that expects the end of the conversation for this reason, which is its result (plug test, batch), and may ask questions
afterwards; and one of the port, not of a conversation: LOCK, and whatever searches the baud rate.

`Cancelled` is raised at a yield when a person cancels. After it a procedure may yield to undo what it changed.
"""

import logging
import threading
from collections.abc import Callable, Generator
from concurrent.futures import Future
from math import inf
from typing import Any, Generic, NamedTuple, TypeVar

from app.engine.conversation import ConversationView, Interrupted, StatusSample
from protocol.catalogue import STATUS, Command, Request
from protocol.events import Answered, EndReason, Reply
from protocol.fields import Value
from protocol.messages import Acknowledgement, Reading, Status
from protocol.stale_replies import FlagAnswers, LastingValues
from protocol.translatable import marked

_log = logging.getLogger(__name__)
AWAIT_POLL_S = 0.002
# They differ, so that they do not fall into step with a stream on a half-duplex line.
LOCK_GAPS_S = (0.101, 0.127, 0.149, 0.113, 0.163, 0.137, 0.179, 0.151)
MAX_LOCKS = 50
# From the first one, including the time without a port or in a search for the baud rate.
LOCKS_FOR_S = 10.0
# Said where `ConversationView.is_shared`, and where it `is_slow`: only questions and LOCK are sent.
SHARED = marked("Shared, read-only: only questions and LOCK are sent.")
TOO_SLOW = marked("This line is too slow for commands; use the cable.")


class LockRepeat:
    """How often LOCK was sent and when it is sent next; shared by the procedure, the session and the display."""

    def __init__(self) -> None:
        self.until = inf  # not sent after this time; set when it is first sent
        self.sent = 0
        self.next_at = 0.0

    def is_due(self, now: float) -> bool:
        return self.is_repeating(now) and now >= self.next_at

    def is_repeating(self, now: float) -> bool:
        return self.sent < MAX_LOCKS and now < self.until

    def note_sent(self, now: float) -> None:
        if not self.sent:
            self.until = now + LOCKS_FOR_S
        self.next_at = now + LOCK_GAPS_S[self.sent % len(LOCK_GAPS_S)]
        self.sent += 1


class Ask(NamedTuple):
    """One exchange; see `Link.ask`, which decides how often a question is repeated and how long is waited.

    `limit_s`: give up after this time; for LOCK, which waits for no answer.
    `repeat`: LOCK is sent whenever it is due while the answer is awaited.
    """

    request: Request
    is_fenced: bool = False
    is_deliberate: bool = False
    limit_s: float = inf
    repeat: LockRepeat | None = None


class Pause(NamedTuple):
    """`frees_line`: the background may use the line meanwhile."""

    seconds: float
    frees_line: bool = False


class UseRate(NamedTuple):
    """Ends the conversation at the old rate. For jobs of the port only."""

    baud_rate: int


class Inspect:
    pass


class Report(NamedTuple):
    """Progress: `done` of `total` steps, and what is being done now (English, marked for translation)."""

    done: int
    total: int
    doing: str
    values: tuple[tuple[str, object], ...] = ()


class EngineView(NamedTuple):
    """The answer to `Inspect`. `baud_rate` is the port's; `conversation` the one that goes on, or else the last one."""

    now: float
    baud_rate: int
    conversation: ConversationView
    proven_rate: int | None  # at which a conversation last began
    is_rate_in_doubt: bool  # the module may be at any rate: it was told to change it, or the rate is searched
    overtaken_at: float  # when LOCK last overtook the rest: confirmations before it no longer count
    sets_rate: bool  # False: the port's baud rate is set at its other end
    flags: FlagAnswers  # when 16 and 17 may be set, and whether their answers count
    lasting: LastingValues  # whether something is answered twice
    rejected_bytes: int  # since the port was opened


Effect = Ask | Pause | UseRate | Inspect | Report
Result = TypeVar("Result")
Answer = TypeVar("Answer", Acknowledgement, Reading, Status)
Procedure = Generator[Effect, Any, Result]


class Cancelled(Exception):
    """A person cancelled the procedure."""


class Job(Generic[Result]):
    """See the module's docstring. `cancel`, `is_done`, `wait` and `outcome` are for any thread, the rest for the
    session's."""

    def __init__(
        self,
        procedure: Procedure[Result],
        on_progress: Callable[[Report], None] | None = None,
        *,
        conversation: int | None,
        expects: frozenset[EndReason] = frozenset(),
    ) -> None:
        """`conversation`: the number of the one in which it was decided; in another one it ends with `Interrupted` and
        sends nothing. None: it is a job of the port, which may use the line without one."""
        self.conversation = conversation
        self.is_urgent = False
        self.is_started = False
        # The procedure has returned or raised; `is_done` follows when the worker has handed that over.
        self.has_ended = False
        # It has outlasted its conversation: it sends questions only.
        self.asks_only = False
        # An activation of this job left the computer.
        self.has_activated = False
        self.submitted_at = 0.0
        self.effect: Effect | None = None
        self.pauses_until = inf
        self.error: BaseException | None = None
        self._expects = expects
        self._procedure = procedure
        self._on_progress = on_progress
        self._result: Result | None = None
        self._is_cancelled = self._is_cancel_delivered = False
        self._done = threading.Event()

    def cancel(self) -> None:
        self._is_cancelled = True

    @property
    def is_done(self) -> bool:
        """It has ended, and the batch with all that it read was handed over."""
        return self._done.is_set()

    def wait(self, timeout_s: float) -> bool:
        return self._done.wait(timeout_s)

    def outcome(self) -> Result:
        """The result of a job that has ended; raises what the procedure raised."""
        if self.error is not None:
            raise self.error
        return self._result  # type: ignore[return-value]

    def finish(self) -> None:
        self._done.set()

    @property
    def pending_ask(self) -> Ask | None:
        return self.effect if isinstance(self.effect, Ask) else None

    @property
    def frees_line(self) -> bool:
        return isinstance(self.effect, Pause) and self.effect.frees_line

    # How it goes on

    def start(self, now: float, look: Callable[[float], EngineView]) -> None:
        """`look` answers `Inspect`."""
        self.is_started, self._look = True, look
        self.resume(None, now)

    def tick(self, now: float) -> None:
        if now >= self.pauses_until:
            self.resume(now, now)

    def resume(self, value: object, now: float) -> None:
        self._drive(lambda: self._procedure.send(value), now)

    def throw(self, reason: Exception, now: float) -> None:
        """Raise `reason` at the procedure's yield. It may go on or end."""
        if self.is_started and not self.has_ended:
            self._drive(lambda: self._procedure.throw(reason), now)
        elif not self.has_ended:
            self._end(None, reason)

    def pop_cancel(self) -> bool:
        """Whether to raise `Cancelled` in it now: only once, as a second one would interrupt its cleaning up."""
        is_news = self._is_cancelled and not self._is_cancel_delivered
        self._is_cancel_delivered |= is_news
        return is_news

    def interrupt(self, reason: Interrupted, now: float) -> None:
        """End it, as its conversation is over. Whoever expected that goes on with questions; who did not ends now."""
        if reason.reason in self._expects:
            self.conversation, self.asks_only = None, True
            self.throw(reason, now)
        else:
            self.stop(reason, now)

    def stop(self, reason: Exception, now: float) -> None:
        """Raise `reason` in it, and end it if it wants to go on."""
        self.throw(reason, now)
        if not self.has_ended:
            _log.debug("%s wanted to go on: %s", self._procedure, reason)
            self._procedure.close()
            self._end(None, reason)

    def _drive(self, move: Callable[[], Effect], now: float) -> None:
        try:
            effect = move()
            while not isinstance(effect, Ask | Pause | UseRate):
                if isinstance(effect, Report) and self._on_progress is not None:
                    self._on_progress(effect)
                effect = self._procedure.send(self._look(now) if isinstance(effect, Inspect) else now)
        except StopIteration as stop:
            self._end(stop.value, None)
        except Exception as error:  # noqa: BLE001  a bug in a procedure ends this job, not the session
            self._end(None, error)
        else:
            self.effect = effect
            self.pauses_until = now + effect.seconds if isinstance(effect, Pause) else inf

    def _end(self, result: Any, error: BaseException | None) -> None:
        self.has_ended, self._result, self.error = True, result, error
        self.effect, self.pauses_until = None, inf


def wait_for(future: Future[Any], limit_s: float) -> Procedure[bool]:
    """Wait for something other than the line (a disk, a person), at most `limit_s`. Whether it is done."""
    view: EngineView = yield Inspect()
    now, ends_at = view.now, view.now + limit_s
    while not future.done() and now < ends_at:
        now = yield Pause(AWAIT_POLL_S, frees_line=True)
    return future.done()


# One question and its answer


def answer_in(outcome: Reply, kind: type[Answer]) -> Answer | None:
    """The answer, if there is one of this kind."""
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return answer if isinstance(answer, kind) else None


def is_accepted(outcome: Reply) -> bool:
    """Whether the module acknowledged a set or an act with what was sent, or with 01, "understood" (E2)."""
    answer = answer_in(outcome, Acknowledgement)
    return answer is not None and answer.is_accepted


def ask_value(command: Command, *, is_fenced: bool = False) -> Procedure[Value | None]:
    """Query a value; None if the module is there and does not answer it."""
    answer = answer_in((yield Ask(command.query(), is_fenced=is_fenced)), Reading)
    return None if answer is None else answer.value


def ask_report(*, is_fenced: bool = False) -> Procedure[StatusSample | None]:
    """Query the status; None if the module is there and does not answer it. It may be a streamed one."""
    outcome = yield Ask(STATUS.query(), is_fenced=is_fenced)
    status = answer_in(outcome, Status)
    return None if status is None else StatusSample(outcome.at, *status)
