"""The thread that owns the port, from open to close.

It takes orders from a queue and reports through one callback, in batches: at once where something changed, else every
`publish_every_s`, as a signal for each frame of a stream would cost more than the stream. Nothing else touches the
port. `stop` waits for it until a deadline.
"""

import logging
import queue
import sys
import threading
from collections.abc import Callable
from enum import Enum
from math import inf
from typing import Any, NamedTuple

from app.engine.conversation import ConversationView, Interrupted, StatusSample
from app.engine.procedure import Job, Procedure, Result
from app.engine.session import Session
from app.engine.transport import PortError, SerialLine, open_line
from app.system.clock import Clock, steady_time
from app.system.uncaught import report_uncaught_error
from protocol.catalogue import LOCK
from protocol.events import Answered, Began, Counters, Ended, EndReason, Event, Sent, Unanswered
from protocol.messages import Acknowledgement

_log = logging.getLogger(__name__)
# The interval of batches without news.
PUBLISH_EVERY_S = 1 / 10
# How long the procedures may take to undo what they changed (stream off) before the port closes.
CLOSING_LIMIT_S = 0.3
# How long another thread that computes keeps this one waiting for the interpreter. With Python's own 5 ms the longest
# turn, while logs are read, is half as long again.
SWITCH_S = 0.001
# How long an owed LOCK is sent.
OWED_FOR_S = 60.0


class PortState(Enum):
    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"


class Connection(NamedTuple):
    """`trouble`: why the port is not open, unless it was closed on purpose. `opening`: the number of the `Worker.open`
    that it belongs to, from 1."""

    state: PortState = PortState.CLOSED
    port: str = ""
    baud_rate: int = 0
    trouble: PortError | None = None
    opening: int = 0


class Batch(NamedTuple):
    """What happened since the last one. Every event and every sample is in exactly one batch. `conversation` is the one
    that goes on, or else the one that ended last; `samples` are of this one only: at the end of a conversation a batch
    is handed over before the next one begins."""

    at: float
    connection: Connection
    conversation: ConversationView
    counters: Counters | None  # of the link, since the port was opened; None while it is not open
    samples: tuple[StatusSample, ...] = ()
    events: tuple[Event, ...] = ()
    finished: tuple[Job[Any], ...] = ()
    is_lock_owed: bool = False
    noise: bytes = b""  # the last rejected bytes


class Worker:
    """The public methods may be called from any thread and return at once."""

    def __init__(
        self,
        callback: Callable[[Batch], None],
        *,
        clock: Clock = steady_time,
        make_lock: Callable[[], Job[Any]] | None = None,
    ) -> None:
        """`make_lock` makes the job of an owed LOCK; without it none is sent."""
        self._callback = callback
        self._clock = clock
        self._make_lock = make_lock
        # What other threads want done in this one.
        self._orders: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        # A daemon: a driver may block it for ever, and the program must end all the same.
        self._thread = threading.Thread(target=self._work, name="dps-s worker", daemon=True)
        self._session: Session | None = None
        self._line: SerialLine | None = None
        self._connection = Connection()
        self._adapter = ""
        self._openings = 0
        self._conversation = ConversationView()
        # Since when and at which adapter LOCK is owed: an activation was interrupted after its frame had left, or LOCK
        # itself was, or it was pressed while the port was not open. It goes first in the next conversation there. Later
        # than `OWED_FOR_S` it is not sent any more, and stands until LOCK is sent for another reason.
        self._owed_lock: tuple[float, str] | None = None
        self._jobs: list[Job[Any]] = []
        # What the next batch has, and whether that is news.
        self._samples: list[StatusSample] = []
        self._events: list[Event] = []
        self._finished: list[Job[Any]] = []
        self._is_urgent = False
        self._published_at = 0.0
        # Triggered and active, by the last report.
        self._reported: tuple[bool, bool] | None = None
        self._is_stopping = False
        # The interval of batches without news. Any thread may set it, and the limit.
        self.publish_every_s, self.closing_limit_s = PUBLISH_EVERY_S, CLOSING_LIMIT_S

    def start(self) -> None:
        """Also sets how often the threads of the program take turns."""
        sys.setswitchinterval(SWITCH_S)
        self._thread.start()

    def open(
        self,
        port: str,
        baud_rate: int,
        background: Callable[[], Procedure[None]] | None = None,
        *,
        adapter: str = "",
    ) -> int:
        """Open `port`, closing the previous one; return the number of this opening, by which its batches are known.
        `background`: see `Session`. `adapter`: where LOCK may be owed; by default it is the port."""
        self._openings += 1
        connection = Connection(PortState.OPENING, port, baud_rate, opening=self._openings)

        def enter() -> None:
            self._close_in_order()
            self._adapter = adapter or port
            self._set_connection(connection)
            self._line = open_line(port, baud_rate)
            self._session = Session(self._line, self._clock, background=background, last=self._conversation)
            self._set_connection(connection._replace(state=PortState.OPEN))

        self._order(enter)
        return connection.opening

    def treat_as_another(self) -> None:
        """A person said that another module is connected now: the conversation ends with `EndReason.ANOTHER`."""

        def end() -> None:
            if self._session is not None:
                self._session.treat_as_another()

        self._order(end)

    def close(self) -> None:
        """Close the port, after the background procedure has undone its changes."""
        self._order(self._close_in_order)

    def submit(self, job: Job[Result], *, is_urgent: bool = False) -> Job[Result]:
        """Run a job; without an open port it ends at once with the port's error or `Interrupted`, and an urgent one
        (LOCK) is owed."""
        self._order(lambda: self._run(job, is_urgent=is_urgent))
        return job

    def stop(self, deadline_s: float = 2.0) -> bool:
        """Close the port and end the thread; return whether it ended within `deadline_s`. Idempotent."""
        if self._thread.is_alive():
            self._order(self._end)
            self._thread.join(deadline_s)
        return not self._thread.is_alive()

    # The thread

    def _order(self, order: Callable[[], None]) -> None:
        self._orders.put(order)
        line = self._line
        if line is not None:
            line.interrupt()  # else the order would wait for the read to end

    def _work(self) -> None:
        while not self._is_stopping:
            self._turn()

    def _turn(self) -> None:
        """Carry out one order, or else do one step on the port; then hand over what happened."""
        try:
            try:
                order = self._orders.get(block=self._session is None)
            except queue.Empty:
                if self._session is not None:
                    self._session.step()
            else:
                order()
                self._is_urgent = True
            self._collect()
        except PortError as error:
            self._close_at_once(EndReason.PORT_LOST, error)
        except Exception as error:  # noqa: BLE001  the one place: a bug closes the port instead of ending the thread
            self._close_at_once(EndReason.PORT_LOST)
            report_uncaught_error(error)
        self._publish()

    def _run(self, job: Job[Any], *, is_urgent: bool) -> None:
        self._jobs.append(job)
        if self._session is not None:
            self._session.run(job, is_urgent=is_urgent)
            return
        if is_urgent and self._adapter:
            self._owe_lock()
        job.stop(self._connection.trouble or Interrupted(EndReason.CLOSED), self._clock())

    def _owe_lock(self) -> None:
        _log.debug("LOCK is owed at %s", self._adapter)
        self._owed_lock = self._clock(), self._adapter

    def _pay_owed_lock(self) -> None:
        since, adapter = self._owed_lock or (-inf, "")
        is_due = adapter == self._adapter and self._clock() - since <= OWED_FOR_S
        if is_due and self._make_lock is not None:
            self._run(self._make_lock(), is_urgent=True)

    # What is handed over

    def _collect(self) -> None:
        """Take what happened on the port, and the jobs that ended. The batch goes at once where more than the numbers
        of the last report may have changed."""
        session = self._session
        if session is not None:
            events, samples = session.events, session.samples
            session.events, session.samples = [], []
            for event in events:
                self._events.append(event)
                match event:
                    case Began():
                        self._is_urgent = True
                        if session.is_going:  # else the port was lost at once
                            self._pay_owed_lock()
                    case Ended() | Answered(messages=(Acknowledgement(),)) | Unanswered():
                        self._is_urgent = True
                    case Sent(request=request) if request == LOCK:
                        self._owed_lock = None
                        self._is_urgent = True
            for sample in samples:
                self._samples.append(sample)
                if (sample.triggered, sample.active) != self._reported:
                    self._reported = (sample.triggered, sample.active)
                    self._is_urgent = True
            if session.owes_lock:
                session.owes_lock = False
                self._owe_lock()
            self._connection = self._connection._replace(baud_rate=session.line.baud_rate)
        for job in [job for job in self._jobs if job.has_ended]:
            self._jobs.remove(job)
            self._finished.append(job)
            self._is_urgent = True

    def _publish(self) -> None:
        now = self._clock()
        if not self._is_urgent and now - self._published_at < self.publish_every_s:
            return
        self._published_at = now
        session = self._session
        if session is not None:
            self._conversation = session.conversation_view(now)
        batch = Batch(
            now,
            self._connection,
            self._conversation,
            None if session is None else session.counters,
            tuple(self._samples),
            tuple(self._events),
            tuple(self._finished),
            self._owed_lock is not None,
            b"" if session is None else session.noise,
        )
        self._samples, self._events, self._finished, self._is_urgent = [], [], [], False
        try:
            self._callback(batch)
        finally:
            for job in batch.finished:
                job.finish()  # whoever waits for it has the batch with all that it read

    # Ends

    def _end(self) -> None:
        self._is_stopping = True
        self._close_in_order()

    def _close_in_order(self) -> None:
        # Close the port after urgent jobs (LOCK) have run and the background has undone its changes.
        session = self._session
        if session is None:
            return
        session.cancel_all()
        deadline = self._clock() + self.closing_limit_s
        try:
            while session.is_busy and self._clock() < deadline:
                session.step()
                self._collect()
                self._publish()
        except PortError as error:
            self._close_at_once(EndReason.PORT_LOST, error)
        else:
            self._close_at_once(EndReason.CLOSED)

    def _close_at_once(self, reason: EndReason, trouble: PortError | None = None) -> None:
        # `trouble`: None also for a bug, after which nothing is known of the port either.
        session = self._session
        if session is not None:
            session.close(reason)
            self._collect()
            self._conversation = session.conversation_view(self._clock())
            self._session = self._line = None
        self._set_connection(self._connection._replace(state=PortState.CLOSED, trouble=trouble))

    def _set_connection(self, connection: Connection) -> None:
        _log.debug("%s: %s, %s", connection.port, connection.state.value, connection.trouble)
        self._connection = connection
        self._is_urgent = True
        self._publish()
