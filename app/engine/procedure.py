"""Effects that a procedure may yield, and the results it is sent.

A procedure is a generator: it yields one of these, is resumed with what came of it, and returns its result. It holds no
port, clock or thread, so the same one runs in the window, on the command line and, in microseconds, in tests.

    want         resumed with
    Ask          Answered | Unanswered | OutcomeUnknown
    Pause        the time (monotonic seconds)
    Await        whether the future is done; the line serves others meanwhile
    Listen       tuple[Received, ...]: the frames that came meanwhile
    UseRate      the time; the port runs at the new rate and its buffers are empty
    Look         Sight: what the link and the device know, at once
    Report       the time, at once

It is cancelled by `Cancelled` raised at a yield, and learns of a lost port by `PortLost` there. After `Cancelled`
it may still yield to put right what it changed, within the session's closing time.
"""

from collections.abc import Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from app.engine.device import DeviceView
from protocol.catalogue import Request
from protocol.events import Counters

if TYPE_CHECKING:
    from concurrent.futures import Future

LOCK_GAPS_S = (0.101, 0.127, 0.149, 0.113, 0.163, 0.137, 0.179, 0.151)
LOCKS_MOST = 50
LOCKS_FOR_S = 10.0
"""From the first one, also while the port is lost or a baud rate is searched."""


@dataclass(slots=True)
class LockRepeat:
    """How often LOCK has left, and when it leaves again: shared by the procedure, the session, which sends, and whoever
    shows it.

    The gaps differ, so that none of them falls into step with a stream that occupies the line.
    """

    until: float | None = None
    """Not sent any more after this; set when it is first sent."""
    sent: int = 0
    next_at: float = 0.0

    def is_due(self, now: float) -> bool:
        return self.is_going_on(now) and now >= self.next_at

    def is_going_on(self, now: float) -> bool:
        return self.sent < LOCKS_MOST and (self.until is None or now < self.until)

    def note_sent(self, now: float) -> None:
        if self.until is None:
            self.until = now + LOCKS_FOR_S
        self.next_at = now + LOCK_GAPS_S[self.sent % len(LOCK_GAPS_S)]
        self.sent += 1


@dataclass(frozen=True, slots=True)
class Ask:
    """One exchange. `waits_s`: seconds to wait at each attempt, else as measured; `attempts`: at most so many of
    them; `is_fenced`: behind another question. See `Link.ask`. `repeat`: LOCK leaves whenever it is due while the
    answer is awaited."""

    request: Request
    waits_s: tuple[float, ...] | None = None
    attempts: int | None = None
    is_deliberate: bool = False
    repeat: LockRepeat | None = None
    is_fenced: bool = False


@dataclass(frozen=True, slots=True)
class Pause:
    seconds: float


@dataclass(frozen=True, slots=True)
class Await:
    """Until `future` is done, at most `limit_s`. Slow work elsewhere (a disk) never blocks the line."""

    future: "Future[Any]"
    limit_s: float


@dataclass(frozen=True, slots=True)
class Listen:
    seconds: float


@dataclass(frozen=True, slots=True)
class UseRate:
    baud_rate: int


@dataclass(frozen=True, slots=True)
class Inspect:
    pass


@dataclass(frozen=True, slots=True)
class LinkView:
    """Figures of the link at one moment."""

    counters: Counters
    round_trip_minimum_s: float | None
    round_trip_median_s: float | None
    bytes_received: int
    lag_s: float | None = None
    """How long what the module says takes to come, now; None before the first answer. See `protocol.lag`."""


@dataclass(frozen=True, slots=True)
class EngineView:
    """What `Inspect` shows. `baud_rate` is the port's."""

    now: float
    opened_at: float
    baud_rate: int
    device: DeviceView
    link: LinkView
    proven_rate: int | None = None
    """At which the module last answered since the port was opened."""
    is_rate_searched: bool = False
    """Another procedure changes the port's rate: the module may be at any."""
    overtaken_at: float | None = None
    """When something urgent (LOCK) last went before everything else: what was confirmed before it no longer counts."""
    is_playback: bool = False
    """A capture is played; there is no module."""
    is_proven: bool = True
    """Else it may be another module than the one that is meant: only questions are sent. See `app.engine.identity`."""


@dataclass(frozen=True, slots=True)
class Report:
    """Progress: `done` of `total` steps, and what is being done now (English, marked for translation)."""

    done: int
    total: int
    doing: str
    values: tuple[tuple[str, object], ...] = ()


Effect = Ask | Pause | Await | Listen | UseRate | Inspect | Report
Result = TypeVar("Result")
Procedure = Generator[Effect, Any, Result]


class Cancelled(Exception):
    """Somebody no longer wants the procedure."""


class PortLost(Exception):
    """The port went away or was closed while the procedure ran."""


class Slept(Cancelled):
    """The computer slept while the procedure ran: what it had found out may not be so any more."""

    def __init__(self, slept_s: float) -> None:
        super().__init__(f"the computer slept for {slept_s:.0f} s")
        self.slept_s = slept_s
