"""Events of the link: traffic, outcomes of requests, changes of state.

Times (`at`) are the monotonic seconds that the owner handed in.
"""

from collections import Counter
from dataclasses import dataclass, field, fields
from enum import Enum
from math import inf
from typing import NamedTuple

from protocol.catalogue import Request
from protocol.frame import Frame, Noise, Reason
from protocol.messages import Message


class Role(Enum):
    """Why a frame came."""

    ANSWER = "answer"
    STREAMED = "streamed"
    """A status nobody asked for: the serial output is on."""
    LATE = "late"
    """Answers a request that had been given up. Older than it looks: never used as a value."""
    DOUBLED = "doubled"
    """A second answer to a request that was answered."""
    UNASKED = "unasked"
    ECHO = "echo"
    """Our own bytes come back: half-duplex adapter, or receive and transmit shorted."""


@dataclass(frozen=True, slots=True)
class Sent:
    """Bytes for the wire. `attempt` counts from 1."""

    raw: bytes
    request: Request
    attempt: int
    at: float


class Received(NamedTuple):
    """One valid frame with its meaning; None for an echo."""

    frame: Frame
    message: Message | None
    role: Role
    at: float
    said_after: float = -inf
    """The module said it after this moment, as far as that is proven: see `protocol.lag`."""


@dataclass(frozen=True, slots=True)
class Rejected:
    noise: Noise
    at: float


@dataclass(frozen=True, slots=True)
class Answered:
    """The request's answer: one message, or all trigger records in the order in which they came (E6).

    `round_trip_s` is None where a repeated request makes it ambiguous which one was answered (Karn's rule).
    """

    request: Request
    messages: tuple[Message, ...]
    attempts: int
    round_trip_s: float | None
    at: float


@dataclass(frozen=True, slots=True)
class Unanswered:
    """No answer, asked `attempts` times; the last wait was `waited_s`.

    `attempts` is 0 where not even the fence was answered, so that the request itself, question or set, never went out.
    """

    request: Request
    attempts: int
    waited_s: float
    at: float


@dataclass(frozen=True, slots=True)
class OutcomeUnknown:
    """A set or an act that got no answer. It may have been carried out; it is never sent again by itself."""

    request: Request
    waited_s: float
    at: float


@dataclass(frozen=True, slots=True)
class Restarted:
    """The module says that it has just been switched on: whatever was known about it is stale.

    Certain with two unasked heartbeats; a single one (its twin lost on the way) is taken as a restart too, because
    the other mistake would show old values as current.
    """

    is_certain: bool
    at: float


@dataclass(frozen=True, slots=True)
class WentOnline:
    at: float


@dataclass(frozen=True, slots=True)
class WentOffline:
    """A heartbeat went unanswered."""

    at: float


Event = Sent | Received | Rejected | Answered | Unanswered | OutcomeUnknown | Restarted | WentOnline | WentOffline
Outcome = Answered | Unanswered | OutcomeUnknown


@dataclass(slots=True)
class Counters:
    """Totals since the port was opened."""

    sent: int = 0
    frames: int = 0
    by_role: Counter[Role] = field(default_factory=Counter)
    rejected_bytes: Counter[Reason] = field(default_factory=Counter)
    time_outs: int = 0
    retries: int = 0
    restarts: int = 0

    @property
    def rejected(self) -> int:
        """Bytes, all reasons together."""
        return self.rejected_bytes.total()

    def copy(self) -> "Counters":
        """The same totals, which stay as they are."""
        return Counters(
            self.sent, self.frames, self.by_role.copy(), self.rejected_bytes.copy(), self.time_outs, self.retries,
            self.restarts,
        )  # fmt: skip

    def __add__(self, other: "Counters") -> "Counters":
        return Counters(*(getattr(self, one.name) + getattr(other, one.name) for one in fields(self)))

    def __sub__(self, earlier: "Counters") -> "Counters":
        """What was counted since; a role or a reason never below zero."""
        return Counters(*(getattr(self, one.name) - getattr(earlier, one.name) for one in fields(self)))
