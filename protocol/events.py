"""Events of the link: traffic, outcomes of requests, changes of state.

Times (`at`) are the `now` of the link's caller: monotonic seconds.
"""

import operator
from collections import Counter
from enum import Enum
from math import inf
from typing import NamedTuple

from protocol.catalogue import Request
from protocol.frame import Frame, Noise, Reason
from protocol.messages import Message, Reading


class Role(Enum):
    ANSWER = "answer"
    STREAMED = "streamed"
    """A status nobody asked for: the serial output is on."""
    LATE = "late"
    """A reply to a request that was given up. Never used as a value, because it may be old."""
    DUPLICATE = "doubled"
    """A second answer to a request."""
    UNSOLICITED = "unasked"
    ECHO = "echo"
    """Our own bytes come back: a half-duplex adapter, or receive and transmit are shorted."""


class Sent(NamedTuple):
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
    sent_after: float = -inf
    """The earliest time at which the module can have sent it; see `protocol.lag`."""


class Rejected(NamedTuple):
    noise: Noise
    at: float


class Answered(NamedTuple):
    """The request's answer: one message, or all trigger records in the order in which they came (E6).

    `round_trip_s` is None where a repeated request makes it ambiguous which one was answered (Karn's rule).
    """

    request: Request
    messages: tuple[Message, ...]
    attempts: int
    round_trip_s: float | None
    at: float


class Unanswered(NamedTuple):
    """No answer after `attempts` attempts; the last wait was `waited_s`.

    `attempts` is 0 where the fence was not answered and the request was therefore never sent.
    """

    request: Request
    attempts: int
    waited_s: float
    at: float


class OutcomeUnknown(NamedTuple):
    """A set or an act without an answer. It may have been carried out; it is never repeated."""

    request: Request
    waited_s: float
    at: float


class Restarted(NamedTuple):
    """The module has just been switched on: everything known about it is stale.

    Certain with two unasked heartbeats. A single one counts as a restart too, as the other may have been lost: not
    noticing a restart would show old values as current.
    """

    is_certain: bool
    at: float


class FellSilent(NamedTuple):
    """Questions go, or went, unanswered for `Timing.silent_gap_s` or longer: the module may have been exchanged."""

    at: float
    lasted_s: float
    """Until now."""


class Contradicted(NamedTuple):
    """Two different answers to one question: two modules on this line, or another one than before."""

    before: Reading
    after: Reading
    at: float


class WentOnline(NamedTuple):
    at: float


class WentOffline(NamedTuple):
    """A heartbeat went unanswered."""

    at: float


Outcome = Answered | Unanswered | OutcomeUnknown
Event = Sent | Received | Rejected | Outcome | Restarted | FellSilent | Contradicted | WentOnline | WentOffline
BREAKS = (FellSilent, Restarted, Contradicted, WentOffline)
"""Events after which another module may answer."""


class Counters:
    """Totals since the port was opened."""

    def __init__(
        self,
        sent: int = 0,
        frames: int = 0,
        by_role: Counter[Role] | None = None,
        rejected_bytes: Counter[Reason] | None = None,
        time_outs: int = 0,
        retries: int = 0,
        restarts: int = 0,
        bytes_received: int = 0,
    ) -> None:
        # In the order of the arguments, on which the sums depend.
        self.sent, self.frames = sent, frames
        self.by_role = Counter() if by_role is None else by_role
        self.rejected_bytes = Counter() if rejected_bytes is None else rejected_bytes
        self.time_outs, self.retries, self.restarts = time_outs, retries, restarts
        self.bytes_received = bytes_received

    @property
    def rejected(self) -> int:
        """Bytes rejected for any reason."""
        return self.rejected_bytes.total()

    def copy(self) -> "Counters":
        return self + Counters()

    def __add__(self, other: "Counters") -> "Counters":
        return Counters(*map(operator.add, vars(self).values(), vars(other).values()))

    def __sub__(self, earlier: "Counters") -> "Counters":
        """What was counted since."""
        return Counters(*map(operator.sub, vars(self).values(), vars(earlier).values()))
