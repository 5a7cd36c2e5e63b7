"""One open port with its link, its device and the procedures that run on it: everything but the thread.

The way of a byte: `Line.read` -> `Link.receive` (stream, frame, message) -> `Device.apply` -> `take_events`.
`step` is called over and over by the worker's thread, or by a test with a fake line and a fake clock.

Two procedures may run: one in the foreground (what somebody asked for) and one in the background (what keeps the screen
fresh), which gets the line only while the foreground does not want it.
"""

from collections.abc import Callable
from typing import Any, Generic

from app.device import Device, Doubt
from app.identity import Expected, IdentityCheck
from app.playback import refuse_change
from app.procedure import (
    Ask,
    Cancelled,
    LinkView,
    Listen,
    Look,
    Pause,
    PortLost,
    Procedure,
    Report,
    Result,
    Sight,
    Slept,
    UseRate,
    Want,
)
from app.transport import Line
from protocol.catalogue import Hazard
from protocol.events import Answered, Event, OutcomeUnknown, Received, Unanswered, WentOffline
from protocol.link import Link
from protocol.round_trips import Timing

LONGEST_STEP_S = 0.02
GATHER_S = 0.008
"""How long to let streamed bytes pile up while no answer is awaited."""


class Run(Generic[Result]):
    """One procedure under way. `result` or `error` is set when `is_done`.

    Only the session's thread touches it, except `cancel`, which any thread may call.
    """

    def __init__(self, procedure: Procedure[Result], on_progress: Callable[[Report], None] | None = None) -> None:
        self.is_done = False
        self.result: Result | None = None
        self.error: BaseException | None = None
        self.is_cancelled = False
        self._is_told = False
        self._procedure = procedure
        self._on_progress = on_progress
        self._want: Want | None = None
        self._resume_at = 0.0
        self._heard: list[Received] = []
        self.is_started = False
        self.is_urgent = False

    def cancel(self) -> None:
        self.is_cancelled = True

    def take_cancel(self) -> bool:
        """Whether to tell it now that it is cancelled. Once only: a second time would break off its cleaning up."""
        is_news = self.is_cancelled and not self._is_told and not self.is_done
        self._is_told = self._is_told or is_news
        return is_news

    def start(self, now: float) -> None:
        self.is_started = True
        self._advance(None, now)

    @property
    def wants_to_ask(self) -> Ask | None:
        return self._want if isinstance(self._want, Ask) else None

    @property
    def wants_to_look(self) -> bool:
        return isinstance(self._want, Look)

    @property
    def wanted_rate(self) -> UseRate | None:
        return self._want if isinstance(self._want, UseRate) else None

    @property
    def resume_at(self) -> float | None:
        """When a pause or a listening ends; None while it waits for something else."""
        return self._resume_at if isinstance(self._want, Pause | Listen) else None

    def hear(self, received: Received) -> None:
        if isinstance(self._want, Listen):
            self._heard.append(received)

    def resume(self, value: object, now: float) -> None:
        self._advance(value, now)

    def tick(self, now: float) -> None:
        """End a pause or a listening that is due."""
        if self.is_done or self.resume_at is None or now < self._resume_at:
            return
        heard, self._heard = tuple(self._heard), []
        self._advance(now if isinstance(self._want, Pause) else heard, now)

    def throw(self, reason: Exception, now: float) -> None:
        """Raise `reason` where the procedure stands; it may go on with cleaning up, or end."""
        if not self.is_done:
            self._heard.clear()
            self._drive(lambda: self._procedure.throw(reason), now)

    def _advance(self, value: object, now: float) -> None:
        self._drive(lambda: self._procedure.send(value), now)

    def _drive(self, move: Callable[[], Want], now: float) -> None:
        try:
            want = move()
            while isinstance(want, Report):
                if self._on_progress is not None:
                    self._on_progress(want)
                want = self._procedure.send(now)
        except StopIteration as stop:
            self._finish(stop.value, None)
        except (Cancelled, PortLost) as error:
            self._finish(None, error)
        except Exception as error:  # noqa: BLE001  a bug in a procedure ends this run, not the session
            self._finish(None, error)
        else:
            self._want = want
            if isinstance(want, Pause | Listen):
                self._resume_at = now + want.seconds

    def _finish(self, result: Any, error: BaseException | None) -> None:
        self.is_done, self.result, self.error, self._want = True, result, error, None


class Session:
    """See the module's docstring. Every method belongs to one thread.

    `step` raises `PortError` when the port is lost; the owner then calls `close`. What had arrived before stays in
    `take_events` and in the device. `asleep_s` tells for how long the computer slept since it was last asked.

    Until `identity` is proven only questions go out, and LOCK, which no module minds.
    """

    def __init__(
        self,
        line: Line,
        clock: Callable[[], float],
        *,
        timing: Timing | None = None,
        asleep_s: Callable[[], float] = float,
        is_playback: bool = False,
        expected: Expected | None = None,
    ) -> None:
        self.line = line
        self.clock = clock
        self._asleep_s = asleep_s
        self._is_played = is_playback
        self.opened_at = clock()
        self.device = Device(line.baud_rate)
        self.identity = IdentityCheck(expected)
        self.bytes_received = 0
        self._timing = timing or Timing()
        self._link = Link(self.opened_at, timing=self._timing)
        self._foreground: list[Run[Any]] = []
        self._background: Run[Any] | None = None
        self._asking: Run[Any] | None = None
        self._overtaken_at: float | None = None
        self._events: list[Event] = []

    # Procedures

    def run(self, run: Run[Any], *, is_urgent: bool = False) -> None:
        """Queue a procedure; the first of the queue runs, the others wait for it.

        An urgent one goes before all others, in the middle of what they do; they go on after it. Either way nobody
        waits for the answer to a question of lesser rank: it is asked again later. An urgent one waits for no answer at
        all: what is in flight and must not be repeated is of unknown outcome then. Nothing dangerous that was confirmed
        before an urgent one follows it.
        """
        run.is_urgent = is_urgent
        if is_urgent:
            self._overtaken_at = self.clock()
        place = 0 if is_urgent else len(self._foreground)
        self._foreground.insert(place, run)
        if place == 0:
            self._free_line(is_urgent=is_urgent)
        if is_urgent:
            self._withhold_dangerous()
        if place == 0:
            run.start(self.clock())

    def _free_line(self, *, is_urgent: bool) -> None:
        """Wait for no answer any longer that can be asked for again; for an urgent one, for none."""
        ask = self._asking.wants_to_ask if self._asking is not None else None
        # Where nobody asks it is the link's own heartbeat; what is held back has not left yet.
        is_repeatable = ask is None or ask.request.is_repeatable or not self._link.has_left
        if is_repeatable:
            self._asking = None  # it still wants to ask, and does when it is its turn
        if is_repeatable or is_urgent:
            now = self.clock()
            self._digest(self._link.abandon(now), now)

    def _withhold_dangerous(self) -> None:
        """What is decided and waits for the line only does not go out; see `Unanswered`."""
        now = self.clock()
        for run in self._runs():
            ask = run.wants_to_ask
            if ask is not None and ask.request.hazard is Hazard.DANGEROUS and run is not self._asking:
                run.resume(Unanswered(ask.request, 0, 0.0, now), now)

    def run_in_background(self, procedure: Procedure[None]) -> None:
        self._background = Run(procedure)
        self._background.start(self.clock())

    @property
    def background(self) -> Run[Any] | None:
        return self._background

    @property
    def is_busy(self) -> bool:
        return bool(self._foreground)

    def link_view(self) -> LinkView:
        trips = self._link.round_trips
        return LinkView(self._link.counters.copy(), trips.minimum_s, trips.median_s, self.bytes_received)

    # The wheel

    def step(self, longest_s: float = LONGEST_STEP_S) -> None:
        """Wait at most `longest_s` for bytes and deal with all that is due."""
        now = self.clock()
        self._notice_sleep(now)
        self._serve(now)
        wait_s = max(0.0, min(longest_s, self._next_due() - now))
        gather_s = GATHER_S if self._link.is_idle else 0.0
        data = self.line.read(wait_s, gather_s)
        began, now = now, self.clock()
        self.bytes_received += len(data)
        slept_s = self._asleep_s()
        if slept_s:
            self._digest(self._link.receive(data, began), began)  # it may have come before the sleep
            self._wake(slept_s, now)
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
        self._asking = None
        for run in self._runs():
            run.throw(why or PortLost(), now)
            for _ in range(8):  # a procedure that cleans up learns at each of its wants that there is no port
                run.throw(PortLost(), now)
        self._foreground.clear()
        self._background = None
        self.device.doubt_everything(Doubt.LINK_LOST)
        self.line.close()

    def _runs(self) -> list[Run[Any]]:
        return self._foreground + ([self._background] if self._background is not None else [])

    def _next_due(self) -> float:
        dues = [run.resume_at for run in self._runs() if run.resume_at is not None]
        return min([self._link.next_deadline(), *dues])

    def _serve(self, now: float) -> None:
        """Advance whatever can advance without new bytes."""
        for run in self._runs():
            if run.take_cancel():
                if self._asking is run:
                    self._asking = None
                    self._digest(self._link.abandon(now), now)
                run.throw(Cancelled(), now)
            run.tick(now)
            while run.wants_to_look:
                run.resume(self._sight(now), now)
        self._drop_finished(now)
        self._let_urgent_pass()
        active = self._foreground[0] if self._foreground else self._background
        if active is None or active.is_done or self._asking is not None:
            return
        if (rate := active.wanted_rate) is not None:
            self._use_rate(rate.baud_rate, now)
            active.resume(now, now)
            self._serve(now)
            return
        ask = active.wants_to_ask
        is_refused = self._is_played or not (self.identity.is_proven or active.is_urgent)
        if ask is not None and is_refused and not ask.request.is_repeatable:
            refuse_change(active, ask.request, now, is_playback=self._is_played)
            self._serve(now)
        elif ask is not None and self._link.is_idle:
            self._send(active, ask, now)

    def _let_urgent_pass(self) -> None:
        """Two urgent ones may have come before either was sent: neither waits for the other's answer."""
        for place, run in enumerate(self._foreground):
            ask = run.wants_to_ask if run.is_urgent and run is not self._asking else None
            if place > 0 and ask is not None and not ask.request.is_repeatable:
                self._foreground.insert(0, self._foreground.pop(place))
                self._free_line(is_urgent=True)
                return

    def _notice_sleep(self, now: float) -> bool:
        slept_s = self._asleep_s()
        if slept_s:
            self._wake(slept_s, now)
        return bool(slept_s)

    def _wake(self, slept_s: float, now: float) -> None:
        """Nothing that was heard before the sleep counts, nothing that was decided before it is done.

        What is in flight counts as unanswered and is not sent again. Procedures end with `Slept`, but for what is
        urgent (LOCK) and for the background, which reads everything again as soon as the module answers.
        """
        self._overtaken_at = now
        asking, self._asking = self._asking, None
        ask = asking.wants_to_ask if asking is not None else None
        gone = self._link.abandon(now)
        self.line.use_rate(self.line.baud_rate)  # what waited in the driver may be from before the sleep
        # As if nothing had been heard for long: it asks for a sign of life at once.
        self._renew_link(now - self._timing.heartbeat_every_s)
        for event in [*gone, WentOffline(now)]:
            self._events.append(event)
            self.device.apply(event)
        self.device.note_sleep(slept_s, now)
        if asking is not None and ask is not None and (asking.is_urgent or asking is self._background):
            attempts = 1 if ask.request.is_repeatable else 0
            asking.resume(gone[0] if gone else Unanswered(ask.request, attempts, 0.0, now), now)
        for run in self._foreground:
            if not run.is_urgent:
                run.throw(Slept(slept_s), now)

    def _send(self, run: Run[Any], ask: Ask, now: float) -> None:
        if ask.request.hazard is Hazard.DANGEROUS and not ask.is_deliberate:
            raise ValueError(f"a procedure wants {ask.request.command.name} without an explicit act")
        if not ask.request.is_repeatable and self._notice_sleep(now):
            return  # decided before the sleep
        sent = self._link.ask(
            ask.request, now, waits_s=ask.waits_s, attempts=ask.attempts, is_deliberate=ask.is_deliberate
        )
        self._asking = run
        self._write_outgoing()
        self._events += sent

    def _write_outgoing(self) -> None:
        outgoing = self._link.take_outgoing()
        if outgoing:
            self.line.write(outgoing)

    def _sight(self, now: float) -> Sight:
        view = self.device.view(now)
        rate, link, is_played = self.line.baud_rate, self.link_view(), self._is_played
        return Sight(now, self.opened_at, rate, view, link, self._overtaken_at, is_played, self.identity.is_proven)

    def _use_rate(self, baud_rate: int, now: float) -> None:
        """A link of its own for each rate: nothing that came at another rate can be mistaken for an answer. What still
        comes from there can: see `answers_here`."""
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
                        run.hear(event)
                case _:
                    pass

    def _drop_finished(self, now: float) -> None:
        while self._foreground and self._foreground[0].is_done:
            del self._foreground[0]
            for following in self._foreground[:1]:
                if not following.is_started and not following.is_done:
                    following.start(now)
        if self._background is not None and self._background.is_done:
            self._background = None
