"""The thread that owns the port, from open to close."""

from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

from app.engine.conversation import ConversationView, StatusSample
from app.engine.job import Job
from app.engine.procedure import LinkView, Procedure, Result
from app.engine.transport import PortError
from app.system.clock import Clock, steady_time
from protocol.events import Event

__all__ = ["Batch", "Connection", "Job", "OwedLock", "PortState", "Worker"]

PUBLISH_EVERY_S = 1 / 10
"""The interval of batches without news: reports of a module whose state is unchanged."""


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


class OwedLock(NamedTuple):
    """LOCK is owed to the module at this port: an act that activates it was interrupted after its frame had left, or
    LOCK was pressed while the port was not open.

    It goes first in the next conversation on the same adapter within `OWED_FOR_S`. Afterwards it is not sent any more,
    and stands until LOCK is sent.
    """

    since: float
    port: str
    """The adapter where it is known, else the port."""

    def is_due(self, now: float) -> bool:
        """Whether it is still sent."""
        return now - self.since <= OWED_FOR_S


OWED_FOR_S = 60.0


class Batch(NamedTuple):
    """What happened since the last batch. Every event and every sample is in exactly one batch.

    `conversation`: the one that goes on, or else the one that ended last. `samples` are of this one only: at the end of
    a conversation a batch is handed over before the next one begins.
    """

    at: float
    connection: Connection
    conversation: ConversationView
    link: LinkView | None
    samples: tuple[StatusSample, ...] = ()
    events: tuple[Event, ...] = ()
    finished: tuple[Job[Any], ...] = ()
    owed_lock: OwedLock | None = None


class Worker:
    """See the module's docstring. The public methods may be called from any thread and return at once."""

    def __init__(
        self,
        callback: Callable[[Batch], None],
        *,
        clock: Clock = steady_time,
        make_lock: Callable[[], Job[Any]] | None = None,
    ) -> None:
        """`make_lock` makes the job of an owed LOCK; without it none is sent."""
        self.publish_every_s = PUBLISH_EVERY_S
        """The interval of batches without news. Any thread may set it."""

    def start(self) -> None:
        raise NotImplementedError

    def open(
        self,
        port: str,
        baud_rate: int,
        background: Callable[[], Procedure[None]] | None = None,
        *,
        adapter: str = "",
    ) -> int:
        """Open `port`, closing the previous one; return the number of this opening, by which its batches are known.

        `background` makes the procedure that keeps the values fresh; it is made anew in each conversation. `adapter`
        identifies the adapter, for an owed LOCK; by default it is the port.
        """
        raise NotImplementedError

    def treat_as_another(self) -> None:
        """A person said that another module is connected now: the conversation ends with `EndReason.ANOTHER`."""
        raise NotImplementedError

    def close(self) -> None:
        """Close the port, after the background procedure has undone its changes."""
        raise NotImplementedError

    def submit(self, job: Job[Result], *, is_urgent: bool = False) -> Job[Result]:
        """Run a job; without an open port it ends at once with the port's error or `Interrupted`."""
        raise NotImplementedError

    def stop(self, deadline_s: float = 2.0) -> bool:
        """Close the port and end the thread; return whether it ended within `deadline_s`. Idempotent.

        A thread that the driver blocks for longer is left running; it is a daemon thread.
        """
        raise NotImplementedError
