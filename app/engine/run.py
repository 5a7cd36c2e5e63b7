"""One running procedure: its pending effect and the result to resume it with. The session schedules it."""

from collections.abc import Callable
from typing import Any, Generic

from app.engine.procedure import Ask, Await, Effect, Inspect, Listen, Pause, Procedure, Report, Result, UseRate
from protocol.events import Received


class Run(Generic[Result]):
    """A running procedure. `result` or `error` is set when `is_done`.

    Only the session's thread touches it, except `cancel`, which any thread may call.
    """

    def __init__(self, procedure: Procedure[Result], on_progress: Callable[[Report], None] | None = None) -> None:
        self.is_done = False
        self.result: Result | None = None
        self.error: BaseException | None = None
        self.is_cancelled = False
        self._is_cancel_delivered = False
        self._procedure = procedure
        self._on_progress = on_progress
        self._effect: Effect | None = None
        self._resume_at = self._awaits_since = 0.0
        self._heard: list[Received] = []
        self.is_started = False
        self.is_urgent = False
        self._has_used_rate = False

    def cancel(self) -> None:
        self.is_cancelled = True

    def pop_cancel(self) -> bool:
        """Whether to raise `Cancelled` in it now: only once, as a second one would interrupt its cleaning up."""
        is_news = self.is_cancelled and not self._is_cancel_delivered
        self._is_cancel_delivered = self._is_cancel_delivered or is_news
        return is_news

    def start(self, now: float) -> None:
        self.is_started = True
        self.resume(None, now)

    @property
    def pending_ask(self) -> Ask | None:
        return self._effect if isinstance(self._effect, Ask) else None

    @property
    def is_inspecting(self) -> bool:
        return isinstance(self._effect, Inspect)

    @property
    def pending_rate(self) -> UseRate | None:
        return self._effect if isinstance(self._effect, UseRate) else None

    @property
    def searches_rate(self) -> bool:
        """Whether it has changed the port's rate, or is about to."""
        return self._has_used_rate or self.pending_rate is not None

    @property
    def resume_at(self) -> float | None:
        """When its `Pause` or `Listen` ends; None while it waits for something else."""
        return self._resume_at if isinstance(self._effect, Pause | Listen) else None

    def on_received(self, received: Received) -> None:
        if isinstance(self._effect, Listen):
            self._heard.append(received)

    def waiting_since(self) -> float | None:
        """Since when it waits for something other than the line (a disk)."""
        return self._awaits_since if isinstance(self._effect, Await) else None

    def tick(self, now: float) -> None:
        """Resume it if its `Pause`, `Listen` or `Await` has ended."""
        if isinstance(self._effect, Await):
            if self._effect.future.done() or now >= self._resume_at:
                self.resume(self._effect.future.done(), now)
            return
        if self.resume_at is None or now < self._resume_at:
            return
        heard, self._heard = tuple(self._heard), []
        self.resume(now if isinstance(self._effect, Pause) else heard, now)

    def throw(self, reason: Exception, now: float) -> None:
        """Raise `reason` at the procedure's yield; it may clean up, or end."""
        if not self.is_done:
            self._heard.clear()
            self._drive(lambda: self._procedure.throw(reason), now)

    def resume(self, value: object, now: float) -> None:
        """Send it the result of its effect."""
        self._drive(lambda: self._procedure.send(value), now)

    def _drive(self, move: Callable[[], Effect], now: float) -> None:
        try:
            want = move()
            while isinstance(want, Report) or (isinstance(want, Await) and want.future.done()):
                if isinstance(want, Report) and self._on_progress is not None:
                    self._on_progress(want)
                want = self._procedure.send(now if isinstance(want, Report) else True)
        except StopIteration as stop:
            self._finish(stop.value, None)
        except Exception as error:  # noqa: BLE001  a bug in a procedure ends this run, not the session
            self._finish(None, error)
        else:
            self._effect = want
            self._has_used_rate |= isinstance(want, UseRate)
            if isinstance(want, Pause | Listen):
                self._resume_at = now + want.seconds
            elif isinstance(want, Await):
                self._awaits_since, self._resume_at = now, now + want.limit_s

    def _finish(self, result: Any, error: BaseException | None) -> None:
        self.is_done, self.result, self.error, self._effect = True, result, error, None
