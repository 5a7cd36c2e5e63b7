"""A procedure that runs in one conversation, and how far it is. The session schedules it, the worker hands it back.

A job ends with its conversation: `Interrupted` is thrown into its procedure, which may return what it has found but
sends nothing more. Two kinds of jobs go on:

    expects    the end of the conversation, for one of these reasons, is its result (shut down, change of the baud rate,
               unplugging as a test): `Interrupted` is thrown into it all the same, and afterwards it may ask questions
    outlives   it belongs to the port, not to a conversation: LOCK and the search for the baud rate
"""

import logging
import threading
from collections.abc import Callable
from typing import Any, Generic

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Await, Effect, Inspect, Listen, Pause, Procedure, Report, Result
from protocol.events import EndReason, Received

_log = logging.getLogger(__name__)


class Job(Generic[Result]):
    """See the module's docstring. `cancel`, `is_done`, `wait` and `outcome` are for any thread, the rest for the
    session's."""

    def __init__(
        self,
        procedure: Procedure[Result],
        on_progress: Callable[[Report], None] | None = None,
        *,
        conversation: int | None = None,
        expects: frozenset[EndReason] = frozenset(),
        outlives: bool = False,
    ) -> None:
        """`conversation`: the number of the one in which it was decided; in another one it ends with `Interrupted` and
        sends nothing. None: the one that goes on when it is submitted, or else the next one."""
        self.conversation = conversation
        self.expects = expects
        self.outlives = outlives
        self.is_urgent = False
        self.is_started = False
        self.has_ended = False
        """The procedure has returned or raised; `is_done` follows when the worker has handed that over."""
        self.is_free = outlives
        """It may use the line without a conversation."""
        self.asks_only = False
        """It has outlasted its conversation: it sends questions only."""
        self.activated_at: float | None = None
        """When an activation of this job left the computer."""
        self.submitted_at = 0.0
        self.effect: Effect | None = None
        self._procedure = procedure
        self._on_progress = on_progress
        self._result: Result | None = None
        self._error: BaseException | None = None
        self._is_cancelled = False
        self._is_cancel_delivered = False
        self._resume_at = 0.0
        self._awaits_since = 0.0
        self._heard: list[Received] = []
        self._done = threading.Event()

    def cancel(self) -> None:
        self._is_cancelled = True

    @property
    def is_done(self) -> bool:
        """It has ended, and the batch with all that it read was handed over."""
        return self._done.is_set()

    def wait(self, timeout_s: float) -> bool:
        """Whether it is done within `timeout_s`."""
        return self._done.wait(timeout_s)

    def outcome(self) -> Result:
        """The result of a job that has ended; raises what the procedure raised."""
        if self._error is not None:
            raise self._error
        return self._result  # type: ignore[return-value]

    # The session's thread

    @property
    def error(self) -> BaseException | None:
        return self._error

    def finish(self) -> None:
        self._done.set()

    def start(self, now: float) -> None:
        self.is_started = True
        self.resume(None, now)

    def pop_cancel(self) -> bool:
        """Whether to raise `Cancelled` in it now: only once, as a second one would interrupt its cleaning up."""
        is_news = self._is_cancelled and not self._is_cancel_delivered
        self._is_cancel_delivered |= is_news
        return is_news

    @property
    def pending_ask(self) -> Ask | None:
        return self.effect if isinstance(self.effect, Ask) else None

    @property
    def due_at(self) -> float | None:
        """When its `Pause` or `Listen` ends; None while it waits for something else."""
        return self._resume_at if isinstance(self.effect, Pause | Listen) else None

    @property
    def awaits_since(self) -> float | None:
        """Since when it waits for something other than the line (a disk)."""
        return self._awaits_since if isinstance(self.effect, Await) else None

    def hear(self, received: Received) -> None:
        if isinstance(self.effect, Listen):
            self._heard.append(received)

    def tick(self, now: float) -> None:
        """Resume it if its `Pause`, `Listen` or `Await` has ended."""
        effect = self.effect
        if isinstance(effect, Await):
            if effect.future.done() or now >= self._resume_at:
                self.resume(effect.future.done(), now)
        elif isinstance(effect, Listen) and now >= self._resume_at:
            heard, self._heard = tuple(self._heard), []
            self.resume(heard, now)
        elif isinstance(effect, Pause) and now >= self._resume_at:
            self.resume(now, now)

    def resume(self, value: object, now: float) -> None:
        """Send it the result of its effect."""
        self._drive(lambda: self._procedure.send(value), now)

    def throw(self, reason: Exception, now: float) -> None:
        """Raise `reason` at the procedure's yield. It may go on or end."""
        if self.has_ended:
            return
        self._heard.clear()
        if self.is_started:
            self._drive(lambda: self._procedure.throw(reason), now)
        else:
            self._end(None, reason)

    def interrupt(self, reason: Interrupted, now: float) -> None:
        """Its conversation is over. Whoever expected that goes on with questions; who did not ends now."""
        if reason.reason in self.expects:
            self.outlast()
            self.throw(reason, now)
        else:
            self.stop(reason, now)

    def outlast(self) -> None:
        """From now on it belongs to the port, not to a conversation."""
        self.asks_only |= not self.is_free
        self.is_free = True

    def stop(self, reason: Exception, now: float) -> None:
        """Raise `reason` in it, and end it if it wants to go on: nothing that it wants to undo may reach another
        module."""
        self.throw(reason, now)
        if not self.has_ended:
            _log.debug("%s wanted to go on: %s", self._procedure, reason)
            self._procedure.close()
            self._end(None, reason)

    def _drive(self, move: Callable[[], Effect], now: float) -> None:
        try:
            effect = move()
            while isinstance(effect, Report) or (isinstance(effect, Await) and effect.future.done()):
                if isinstance(effect, Report):
                    if self._on_progress is not None:
                        self._on_progress(effect)
                    effect = self._procedure.send(now)
                else:
                    effect = self._procedure.send(True)
        except StopIteration as stop:
            self._end(stop.value, None)
        except Exception as error:  # noqa: BLE001  a bug in a procedure ends this job, not the session
            self._end(None, error)
        else:
            self.effect = effect
            if isinstance(effect, Pause | Listen):
                self._resume_at = now + effect.seconds
            elif isinstance(effect, Await):
                self._awaits_since, self._resume_at = now, now + effect.limit_s

    def _end(self, result: Any, error: BaseException | None) -> None:
        self.has_ended, self._result, self._error, self.effect = True, result, error, None

    @property
    def is_inspecting(self) -> bool:
        return isinstance(self.effect, Inspect)
