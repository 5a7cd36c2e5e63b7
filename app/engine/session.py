"""One open port with its link, its device and its running procedures: everything but the thread.

A byte goes through `Line.read`, `Link.receive` (stream, frame, message), `Device.apply` and `take_events`.
`step` is called in a loop by the worker's thread, or by a test with a fake line and a fake clock.

Two procedures may run: one in the foreground (what somebody asked for) and one in the background (which keeps the
values fresh). The background has the line only while the foreground does not need it.
"""

import logging
from collections.abc import Callable
from typing import Any

from app.engine.device import Device, Sleep, StaleReason
from app.engine.identity import UNKNOWN, Expected, Identity, IdentityCheck, IdentityEvidence
from app.engine.procedure import Ask, Cancelled, EngineView, LinkView, PortLost, Procedure, Slept, TwoModules
from app.engine.run import Run
from app.engine.transport import Line
from protocol.catalogue import LOCK, Hazard, Layout
from protocol.events import Answered, Contradicted, Event, OutcomeUnknown, Received, Unanswered, WentOffline, WentOnline
from protocol.link import Link
from protocol.round_trips import Timing

__all__ = ["Run", "Session"]
_log = logging.getLogger(__name__)
MAX_STEP_S = 0.02
BATCH_S = 0.008
"""How long to gather a stream while no answer is awaited, if at least a frame arrives in this time."""
BATCH_FRAME_S = 0.002
_FRAME = Layout.STATUS.value
AWAIT_POLL_S = 0.002
AWAIT_GRACE_S = 0.1
"""After waiting for a disk for this long the foreground leaves the line to the background."""


class Session:
    """See the module's docstring. Every method belongs to one thread.

    `step` raises `PortError` when the port is lost; the owner then calls `close`. Everything received before stays in
    `take_events` and in the device. `asleep_s` returns for how long the computer slept since the last call.

    Until `identity` is settled only questions and LOCK are sent; see `IdentityCheck` for `is_attended`.
    """

    def __init__(
        self,
        line: Line,
        clock: Callable[[], float],
        *,
        asleep_s: Callable[[], float] = float,
        expected: Expected | None = None,
        is_attended: bool = False,
    ) -> None:
        self.line = line
        self.clock = clock
        self._asleep_s = asleep_s
        self.opened_at = clock()
        self.identity = IdentityCheck(expected, is_attended=is_attended)
        self._received_at = self.opened_at
        self.batch_s = BATCH_S
        self._is_fast = True
        self._timing = Timing()
        self._link = Link(self.opened_at, timing=self._timing)
        self.device = Device(line.baud_rate, self._link.lag, self._link.flags)
        self._foreground: list[Run[Any]] = []
        self.background: Run[Any] | None = None
        self._asking: Run[Any] | None = None
        self._overtaken_at: float | None = None
        self._rate_before: int | None = None
        """The port's rate when an urgent procedure overtook another one, which continues at it."""
        self._proven_rate: int | None = None
        self._counted_before = self._link.counters.copy()
        """Of the former module."""
        self._events: list[Event] = []

    def run(self, run: Run[Any], *, is_urgent: bool = False) -> None:
        """Queue a procedure; the first of the queue runs, the others wait for it.

        An urgent one (LOCK) interrupts all others, which continue after it. A question of the background or of an
        interrupted procedure is abandoned and repeated later. An urgent procedure waits for no answer at all: the
        outcome of a set or an act in flight is unknown then. Dangerous requests confirmed before it are not sent after
        it. A second urgent one replaces the first.
        """
        run.is_urgent = is_urgent
        if is_urgent:
            for job in self._foreground:
                if job.is_urgent:
                    job.cancel()
            self._overtaken_at = self.clock()
            self._rate_before = self._rate_before or self.line.baud_rate
        place = 0 if is_urgent else len(self._foreground)
        self._foreground.insert(place, run)
        if place == 0:
            self._free_line(is_urgent=is_urgent)
        if is_urgent:
            self._withhold_dangerous()
        if place == 0:
            run.start(self.clock())

    def _free_line(self, *, is_urgent: bool) -> None:
        """Abandon the request in flight if it can be repeated, or for an urgent procedure."""
        ask = self._asking.pending_ask if self._asking is not None else None
        # Without a procedure it is the link's own heartbeat; a request behind a fence was not sent yet.
        is_repeatable = ask is None or ask.request.is_repeatable or not self._link.has_left
        if is_repeatable:
            self._asking = None  # it asks again when it is its turn
        if is_repeatable or is_urgent:
            now = self.clock()
            self._digest(self._link.abandon(now), now)

    def _withhold_dangerous(self) -> None:
        """Dangerous requests that wait for the line are not sent; see `Unanswered`."""
        now = self.clock()
        for run in self._runs():
            ask = run.pending_ask
            if ask is not None and ask.request.hazard is Hazard.DANGEROUS and run is not self._asking:
                run.resume(Unanswered(ask.request, 0, 0.0, now), now)

    def confirm_identity(self, seen: Identity | None, *, is_named: bool | None, before: IdentityEvidence) -> None:
        """A person said which module it is; see `IdentityCheck.confirm`."""
        self.identity.confirm(seen, is_named=is_named, before=before)
        self.identity.on_device(self.device, self.clock())

    def treat_as_new(self, *, is_named: bool, before: IdentityEvidence = UNKNOWN) -> None:
        """A person said that it is another module than before."""
        self.device.forget(self.identity.since)
        self._link.begin_again()
        self._counted_before = self._link.counters.copy()
        self.confirm_identity(None, is_named=is_named, before=before)

    def run_in_background(self, procedure: Procedure[None]) -> None:
        self.background = Run(procedure)
        self.background.start(self.clock())

    @property
    def is_busy(self) -> bool:
        return bool(self._foreground)

    def link_view(self) -> LinkView:
        trip_s, lag_s = self._link.round_trips.quantile_s, self._link.lag.seconds(self.clock())
        return LinkView(self._link.counters - self._counted_before, trip_s(0.0), trip_s(0.5), lag_s)

    def step(self, longest_s: float = MAX_STEP_S) -> None:
        """Wait at most `longest_s` for bytes, and do what is due."""
        now = self.clock()
        self._notice_sleep(now)
        self._serve(now)
        wait_s = max(0.0, min(longest_s, self._next_due(now) - now))
        data = self.line.read(wait_s, self.batch_s if self._link.is_idle and self._is_fast else 0.0)
        while self._link.is_idle and 0 < len(data) < _FRAME and (rest := self.line.read(BATCH_FRAME_S, 0.0)):
            data += rest
        began, now = now, self.clock()
        if not data and now - began > wait_s:
            data = self.line.read(0.0, 0.0)  # in time, though this thread was kept waiting after the driver had nothing
        if data:
            self._is_fast = len(data) * self.batch_s > _FRAME * (now - self._received_at)
            self._received_at = now
        slept_s = self._asleep_s()
        if slept_s:
            self._digest(self._link.receive(data, began), began)  # it may be from before the sleep
            self._on_resume(slept_s, now)
            data = b""
        self._digest(self._link.receive(data, now) + self._link.tick(now), now)
        self.identity.on_device(self.device, now)
        self._write_outgoing()
        self._serve(now)

    def take_events(self) -> list[Event]:
        """What happened since the last call, in order."""
        events, self._events = self._events, []
        return events

    def close(self, *, why: Exception | None = None) -> None:
        """End all procedures and close the port. Idempotent, never raises."""
        now = self.clock()
        self._return_unsent(now)
        for run in self._runs():
            run.throw(why or PortLost(), now)
            for _ in range(8):  # its cleaning up may yield several times
                run.throw(PortLost(), now)
        self._foreground.clear()
        self.background = None
        self.device.mark_all_stale(StaleReason.LINK_LOST)
        self.line.close()

    def _return_unsent(self, now: float) -> None:
        """A set or an act that waits for a quiet line is not sent any more, and its procedure knows it."""
        run = self._asking
        ask = run.pending_ask if run is not None else None
        if run is not None and ask is not None and not (ask.request.is_repeatable or self._link.has_left):
            self._asking = None
            self._link.abandon(now)
            run.resume(Unanswered(ask.request, 0, 0.0, now), now)

    def _runs(self) -> list[Run[Any]]:
        return self._foreground + ([self.background] if self.background is not None else [])

    def _next_due(self, now: float) -> float:
        dues = [self._link.next_deadline()]
        for run in self._runs():
            if run.waiting_since() is not None:
                dues.append(now + AWAIT_POLL_S)
            elif (resume_at := run.resume_at) is not None:
                dues.append(resume_at)
        locking = self._locking(now)
        repeat = locking[1].repeat if locking is not None else None
        if repeat is not None and repeat.is_repeating(now):
            dues.append(repeat.next_at)
        return min(dues)

    def _serve(self, now: float) -> None:
        """Advance the procedures that need no new bytes, and send the next request."""
        for run in self._runs():
            if run.pop_cancel():
                if self._asking is run:
                    self._return_unsent(now)
                    self._asking = None
                    self._digest(self._link.abandon(now), now)
                run.throw(Cancelled(), now)
            run.tick(now)
            while run.is_inspecting:
                run.resume(self._view(now), now)
        self._drop_finished(now)
        self._repeat_lock(now)
        active = self._next_run(now)
        if active is None or active.is_done or self._asking is not None:
            return
        if (rate := active.pending_rate) is not None:
            self._use_rate(rate.baud_rate, now)
            active.resume(now, now)
            self._serve(now)
            return
        ask = active.pending_ask
        if ask is None:
            return
        is_refused = not (self.identity.identity.is_settled or ask.request == LOCK)
        if is_refused and not ask.request.is_repeatable:
            active.resume(Unanswered(ask.request, 0, 0.0, now), now)  # who wanted the stream continues by polling
            self._serve(now)
        elif self._link.is_idle:
            self._send(active, ask, now)

    def _next_run(self, now: float) -> Run[Any] | None:
        """The run that has the line: the background also while the foreground waits for a slow disk."""
        first = self._foreground[0] if self._foreground else None
        since = first.waiting_since() if first is not None else None
        is_slow = since is not None and now - since > AWAIT_GRACE_S
        return self.background if first is None or is_slow else first

    def _locking(self, now: float) -> tuple[Run[Any], Ask] | None:
        """The run whose request may repeat LOCK: it is in flight, or waits for the link's own heartbeat."""
        run = self._asking or (None if self._link.is_idle else self._next_run(now))
        ask = run.pending_ask if run is not None else None
        return (run, ask) if run is not None and ask is not None else None

    def _repeat_lock(self, now: float) -> None:
        """Send LOCK if it is due, without waiting for the answer to the request in flight."""
        locking = self._locking(now)
        if locking is None:
            return
        run, ask = locking
        repeat = ask.repeat
        if repeat is None or not repeat.is_due(now):
            return
        repeat.note_sent(now)
        self._events += self._link.lock_again(now, repeat.sent)
        self._write_outgoing()
        if self._asking is None and ask.request == LOCK:
            run.resume(OutcomeUnknown(LOCK, 0.0, now), now)  # it has left; the module is asked next

    def _notice_sleep(self, now: float) -> bool:
        slept_s = self._asleep_s()
        if slept_s:
            self._on_resume(slept_s, now)
        return bool(slept_s)

    def _on_resume(self, slept_s: float, now: float) -> None:
        """Values read before the sleep are stale, and nothing decided before it is done.

        The request in flight is unanswered and not repeated. Procedures end with `Slept`, except urgent ones (LOCK) and
        the background, which reads everything again as soon as the module answers.
        """
        self._return_unsent(now)
        asking, gone = self._give_up_question(now)
        self.line.use_rate(self.line.baud_rate)  # bytes in the driver may be from before the sleep
        # As after a long silence: it sends a heartbeat at once.
        self._renew_link(now - self._timing.heartbeat_every_s)
        for event in [*gone, WentOffline(now)]:
            self._events.append(event)
            self.identity.on_event(event, self.device, now)
            self.device.apply(event)
        self.device.note_sleep(Sleep(now, slept_s))
        self._interrupt(Slept(slept_s), asking, gone, now)

    def _give_up_question(self, now: float) -> tuple[Run[Any] | None, list[Event]]:
        """What asked, and what became of a set or an act that had left."""
        asking, self._asking = self._asking, None
        return asking, self._link.abandon(now)

    def _interrupt(self, why: Exception, asking: Run[Any] | None, gone: list[Event], now: float) -> None:
        """Nothing decided before is done: procedures end, but for urgent ones (LOCK) and the background."""
        ask = asking.pending_ask if asking is not None else None
        if asking is not None and ask is not None and (asking.is_urgent or asking is self.background):
            asking.resume(gone[0] if gone else Unanswered(ask.request, 0, 0.0, now), now)
        for run in self._foreground:
            if not run.is_urgent:
                run.throw(why, now)

    def _send(self, run: Run[Any], ask: Ask, now: float) -> None:
        if ask.request.hazard is Hazard.DANGEROUS and not ask.is_deliberate:
            raise ValueError(f"a procedure wants {ask.request.command.name} without an explicit act")
        if not ask.request.is_repeatable and self._notice_sleep(now):
            return  # decided before the sleep
        sent = self._link.ask(
            ask.request, now, waits_s=ask.waits_s, attempts=ask.attempts, is_deliberate=ask.is_deliberate,
            is_fenced=ask.is_fenced,
        )  # fmt: skip
        self._asking = run
        self._write_outgoing()
        self._digest(sent, now)
        if ask.repeat is not None and ask.request == LOCK:
            ask.repeat.note_sent(now)

    def _write_outgoing(self) -> None:
        outgoing = self._link.take_outgoing()
        if outgoing:
            self.line.write(outgoing)

    def _view(self, now: float) -> EngineView:
        view = self.device.view(now)
        return EngineView(
            now,
            self.opened_at,
            self.line.baud_rate,
            view,
            self.link_view(),
            proven_rate=self._proven_rate,
            is_rate_searched=any(run.searches_rate and not run.is_urgent for run in self._foreground),
            overtaken_at=self._overtaken_at,
            is_settled=self.identity.identity.is_settled,
            sets_rate=self.line.sets_rate,
            flags=self._link.flags,
            told=self._link.told,
        )

    def _use_rate(self, baud_rate: int, now: float) -> None:
        """Each rate has its own link: bytes received at another rate cannot be mistaken for an answer. For bytes that
        are still to come see `answers_here`."""
        self.line.use_rate(baud_rate)
        self._renew_link(now)
        self.device.use_rate(baud_rate)

    def _renew_link(self, now: float) -> None:
        self._link = Link(now, timing=self._timing, before=self._link)

    def _digest(self, events: list[Event], now: float) -> None:
        self._events += events
        for event in events:
            self.identity.on_event(event, self.device, now)
            self.device.apply(event)
            match event:
                case Answered() | Unanswered() | OutcomeUnknown():
                    run, self._asking = self._asking, None
                    if run is not None:
                        run.resume(event, now)
                case Received():
                    for run in self._runs():
                        run.on_received(event)
                case Contradicted():
                    _log.debug("contradicted: %s", event)
                    asking, gone = self._give_up_question(now)
                    self._interrupt(TwoModules(event), asking, gone, now)
                case WentOnline():
                    self._proven_rate = self.line.baud_rate
                case _:
                    pass

    def _drop_finished(self, now: float) -> None:
        while self._foreground and self._foreground[0].is_done:
            del self._foreground[0]
            rate = self._rate_before
            if rate is not None and not any(job.is_urgent for job in self._foreground):
                self._rate_before = None
                if rate != self.line.baud_rate and any(job.is_started for job in self._foreground):
                    self._use_rate(rate, now)
            for following in self._foreground[:1]:
                if not following.is_started and not following.is_done:
                    following.start(now)
        if self.background is not None and self.background.is_done:
            self.background = None
