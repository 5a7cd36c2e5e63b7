"""The thread that owns the port, from open to close.

It takes orders from a queue and reports through one callback, in batches: at once where something changed, else every
`publish_every_s`, as a signal for each frame of a stream would cost more than the stream. Nothing else touches the
port. `stop` waits for it until a deadline.
"""

import queue
import threading
import time
from collections.abc import Callable
from enum import Enum
from typing import Any, Generic, NamedTuple

from app.engine.device import Device, DeviceView, StatusSample
from app.engine.identity import NO_EXPECTATION, UNKNOWN, Expected, Identity, IdentityEvidence
from app.engine.procedure import LinkView, PortLost, Procedure, Report, Result
from app.engine.session import BATCH_S, Run, Session
from app.engine.transport import PortError, SerialLine, open_line
from app.system.sleep_detector import Clock, SleepDetector, sleepless_clock
from app.system.uncaught import report_uncaught_error
from protocol.events import Answered, Event, Received, Rejected, Sent
from protocol.messages import Reading, Status

PUBLISH_EVERY_S = 1 / 10
"""The interval of batches without news: reports of a module whose state is unchanged."""
MAX_STEP_S = 0.05
"""An order ends it earlier; see `SerialLine.interrupt`."""
MAX_BATCH_S = 0.025
"""How long a stream is gathered where batches are published a few times a second only."""
CLOSING_LIMIT_S = 0.3
"""How long the procedures may take to undo what they changed (stream off) before the port closes."""
ABORT_AFTER_S = 0.33
"""`stop` then interrupts a blocked write."""
SLEEPLESS = sleepless_clock()


class PortState(Enum):
    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"


class Connection(NamedTuple):
    """`trouble`: why the port is not open, unless it was closed on purpose. `opening`: the number of the `Worker.open`
    or `treat_as_new` that it belongs to, from 1."""

    state: PortState = PortState.CLOSED
    port: str = ""
    baud_rate: int = 0
    trouble: PortError | None = None
    opening: int = 0


class Batch(NamedTuple):
    """What happened since the last batch. Every event and every sample is in exactly one batch."""

    at: float
    connection: Connection
    device: DeviceView
    link: LinkView | None
    samples: tuple[StatusSample, ...] = ()
    events: tuple[Event, ...] = ()
    finished: tuple["Job[Any]", ...] = ()
    identity: Identity = NO_EXPECTATION


class Job(Generic[Result]):
    """A procedure for the worker. The command line calls `wait`; the window finds it in `Batch.finished`."""

    def __init__(self, procedure: Procedure[Result], on_progress: Callable[[Report], None] | None = None) -> None:
        self.run = Run(procedure, on_progress)
        self._done = threading.Event()

    def cancel(self) -> None:
        self.run.cancel()

    @property
    def is_done(self) -> bool:
        return self._done.is_set()

    def finish(self) -> None:
        self._done.set()

    def wait(self, timeout_s: float) -> bool:
        """Whether it ended within `timeout_s`."""
        return self._done.wait(timeout_s)

    def outcome(self) -> Result:
        """The result of a finished job; raises what the procedure raised."""
        if self.run.error is not None:
            raise self.run.error
        return self.run.result  # type: ignore[return-value]


class _Pending:
    def __init__(self) -> None:
        self.samples: list[StatusSample] = []
        self.events: list[Event] = []
        self.finished: list[Job[Any]] = []
        self.is_urgent = False


class Worker:
    """See the module's docstring. The public methods may be called from any thread and return at once."""

    def __init__(
        self,
        callback: Callable[[Batch], None],
        *,
        clock: Clock = time.monotonic,
        with_sleep: Clock | None = SLEEPLESS,
    ) -> None:
        self._callback = callback
        self._clock = clock
        self._with_sleep = with_sleep
        self._orders: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        """What other threads want done in this one."""
        self._thread = threading.Thread(target=self._work, name="dps-s worker", daemon=True)
        self._session: Session | None = None
        self._line: SerialLine | None = None
        self._device = Device()
        self._connection = Connection()
        self._openings = 0
        self._identity = NO_EXPECTATION
        self._jobs: list[Job[Any]] = []
        self._pending = _Pending()
        self._published_at = 0.0
        self._reported: tuple[bool, bool] | None = None
        """Triggered and active, by the last report."""
        self._read: dict[str, int] = {}
        self._is_stopping = False
        self.publish_every_s = PUBLISH_EVERY_S
        """The interval of batches without news. Any thread may set it."""

    def start(self) -> None:
        self._thread.start()

    def open(
        self,
        port: str,
        baud_rate: int,
        background: Callable[[], Procedure[None]] | None = None,
        is_another: bool = False,
        expected: Expected | None = None,
        is_attended: bool = False,
    ) -> int:
        """Open `port`, closing the previous one; return the number of this opening, by which its batches are known.
        `background` makes the procedure that keeps the device fresh.

        `expected`: the module expected there; until its identity is settled only questions are sent. `is_attended`: a
        person can be asked about it.

        `is_another`: another module is expected, so the values of the previous one are discarded at once; else they
        stay, as stale, until the port is open.
        """
        self._openings += 1
        connection = Connection(PortState.OPENING, port, baud_rate, opening=self._openings)

        def enter() -> None:
            self._close_in_order()
            self._read.clear()
            if is_another:
                self._device = Device()
            self._set_connection(connection)
            line = self._line = open_line(port, baud_rate)
            asleep_s = SleepDetector(self._clock, self._with_sleep).poll
            self._session = Session(line, self._clock, asleep_s=asleep_s, expected=expected, is_attended=is_attended)
            self._device = self._session.device
            self._set_connection(connection._replace(state=PortState.OPEN))
            if background is not None:
                self._session.run_in_background(background())

        self._order(enter)
        return connection.opening

    def confirm_identity(
        self, seen: Identity | None = None, *, is_named: bool | None = None, before: IdentityEvidence = UNKNOWN
    ) -> None:
        """Accept the module because a person said which it is; see `IdentityCheck.confirm`."""
        self._decide(lambda session: session.confirm_identity(seen, is_named=is_named, before=before))

    def treat_as_new(self, *, is_named: bool, before: IdentityEvidence = UNKNOWN) -> int:
        """A person said that it is another module; return the number by which the batches from then on are known."""
        self._openings += 1
        self._decide(lambda session: session.treat_as_new(is_named=is_named, before=before))
        return self._openings

    def _decide(self, decide: Callable[[Session], None]) -> None:
        number = self._openings

        def act() -> None:
            self._connection = self._connection._replace(opening=number)
            if self._session is not None:
                decide(self._session)

        self._order(act)

    def close(self) -> None:
        """Close the port, after the background procedure has undone its changes."""
        self._order(self._close_in_order)

    def submit(self, job: Job[Result], *, is_urgent: bool = False) -> Job[Result]:
        """Run a procedure; without an open port it ends at once with the port's error or `PortLost`."""
        self._order(lambda: self._run(job, is_urgent=is_urgent))
        return job

    def stop(self, deadline_s: float = 2.0) -> bool:
        """Close the port and end the thread; return whether it ended within `deadline_s`. Idempotent.

        A thread that the driver blocks for longer is left running; it is a daemon thread.
        """
        if not self._thread.is_alive():
            return True
        self._order(self._end)
        self._thread.join(min(deadline_s, ABORT_AFTER_S))
        line = self._line
        if self._thread.is_alive() and line is not None:
            line.abort()
        self._thread.join(max(0.0, deadline_s - ABORT_AFTER_S))
        return not self._thread.is_alive()

    def _order(self, order: Callable[[], None]) -> None:
        self._orders.put(order)
        line = self._line
        if line is not None:
            line.interrupt()  # else the order would wait for the read to end

    def _work(self) -> None:
        while not self._is_stopping:
            try:
                self._turn()
            except PortError as error:
                self._lose_port(error)
            except Exception as error:  # noqa: BLE001  the one place: a bug closes the port instead of ending the thread
                self._lose_port(error)
                report_uncaught_error(error)
            self._publish()
        self._end_session(PortLost())
        self._pending.is_urgent = True
        self._publish()

    def _turn(self) -> None:
        session = self._session
        try:
            order = self._orders.get(block=session is None)
        except queue.Empty:
            pass
        else:
            order()
            self._pending.is_urgent = True
            return
        if session is not None:
            session.batch_s = max(BATCH_S, min(MAX_BATCH_S, self.publish_every_s / 10))
            session.step(MAX_STEP_S)
            self._collect_batch(session)
            self._collect_finished()

    def _collect_batch(self, session: Session) -> None:
        events, samples = session.take_events(), session.device.take_samples()
        self._pending.events += events
        self._pending.samples += samples
        for event in events:
            self._pending.is_urgent |= self._has_changed(event)
        for sample in samples:
            if (sample.triggered, sample.active) != self._reported:
                self._reported = sample.triggered, sample.active
                self._pending.is_urgent = True

    def _has_changed(self, event: Event) -> bool:
        """Whether it may change more than the numbers of the last report."""
        match event:
            case Received(message=Reading(command=command, raw=raw)):
                before, self._read[command.key] = self._read.get(command.key), raw
                return raw != before
            case Answered(messages=messages):
                return not all(isinstance(message, Reading | Status) for message in messages)  # seen as `Received`
            case Received(message=Status()) | Sent() | Rejected():
                return False
        return True

    def _run(self, job: Job[Any], *, is_urgent: bool) -> None:
        self._jobs.append(job)
        if self._session is None:
            job.run.throw(self._connection.trouble or PortLost(), self._clock())
            self._collect_finished()
        else:
            self._session.run(job.run, is_urgent=is_urgent)

    def _end(self) -> None:
        self._close_in_order()
        self._is_stopping = True

    def _close_in_order(self) -> None:
        """Close the port after urgent procedures (LOCK) have run and the background has undone its changes."""
        session = self._session
        if session is None:
            return
        if session.background is not None:
            session.background.cancel()
        for job in self._jobs:
            if not job.run.is_urgent:
                job.cancel()
        deadline = self._clock() + CLOSING_LIMIT_S
        try:
            while (session.background is not None or session.is_busy) and self._clock() < deadline:
                session.step()
        except PortError as error:
            self._lose_port(error)
            return
        self._end_session(PortLost())
        self._set_connection(self._connection._replace(state=PortState.CLOSED))

    def _end_session(self, why: Exception) -> None:
        if self._session is not None:
            self._session.close(why=why)
            self._line = None
            self._collect_batch(self._session)
            self._session = None
        self._collect_finished()

    def _lose_port(self, error: Exception) -> None:
        self._end_session(error)
        trouble = error if isinstance(error, PortError) else None
        self._set_connection(self._connection._replace(state=PortState.CLOSED, trouble=trouble))

    def _set_connection(self, connection: Connection) -> None:
        self._connection = connection
        self._pending.is_urgent = True
        self._publish()

    def _collect_finished(self) -> None:
        for job in [job for job in self._jobs if job.run.is_done]:
            self._jobs.remove(job)
            self._pending.finished.append(job)
            self._pending.is_urgent = True

    def _publish(self) -> None:
        now = self._clock()
        if not self._pending.is_urgent and now - self._published_at < self.publish_every_s:
            return
        pending, self._pending = self._pending, _Pending()
        self._published_at = now
        link = None
        if self._session is not None:
            link, self._identity = self._session.link_view(), self._session.identity.identity
            self._connection = self._connection._replace(baud_rate=self._session.line.baud_rate)
        batch = Batch(
            now,
            self._connection,
            self._device.view(now),
            link,
            tuple(pending.samples),
            tuple(pending.events),
            tuple(pending.finished),
            self._identity,
        )
        try:
            self._callback(batch)
        finally:
            for job in pending.finished:
                job.finish()  # whoever waits for it has the batch with all that it read
