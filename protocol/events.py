"""Events of the link: traffic, outcomes of requests, beginning and end of a conversation.

Times (`at`) are the `now` of the link's caller: monotonic seconds.
"""

from collections import Counter
from enum import Enum
from typing import Any, NamedTuple

from protocol.catalogue import Request
from protocol.messages import Frame, Message, Noise, Reading, Reason
from protocol.translatable import marked


class Role(Enum):
    ANSWER = "answer"
    STREAMED = "streamed"  # a status nobody asked for: the serial output is on
    LATE = "late"  # a reply to a request that was given up. Never used as a value, because it may be old.
    DUPLICATE = "doubled"  # a second answer to a request
    UNSOLICITED = "unasked"
    ECHO = "echo"  # our own bytes come back: a half-duplex adapter, or receive and transmit are shorted


class Sent(NamedTuple):
    """Bytes for the wire, as they are among those of `take_outgoing`. `attempt` counts from 1."""

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


class Rejected(NamedTuple):
    noise: Noise
    at: float


class Answered(NamedTuple):
    """The request's answer: one message, or all trigger records in the order in which they came (E6).

    `round_trip_s` is None where a repeated request makes it ambiguous which one was answered (Karn's rule). `rejected`
    and `strays`: bytes rejected, and frames doubled, unasked, or records that came late, since the answer before.
    """

    request: Request
    messages: tuple[Message, ...]
    attempts: int
    round_trip_s: float | None
    at: float
    rejected: int = 0
    strays: int = 0


class Unanswered(NamedTuple):
    """No answer after `attempts` attempts, although the module is there; `waited_s` since the first one.

    `attempts` is 0 where the request was never sent: it was not allowed, or what was asked before it was not answered.
    """

    request: Request
    attempts: int
    waited_s: float
    at: float

    @property
    def may_be_done(self) -> bool:
        """Whether it is a set or an act that was sent, so that it may have been carried out. It is never repeated."""
        return self.attempts > 0 and not self.request.is_repeatable


class EndReason(Enum):
    """Why a conversation ended: English, translatable. The first four are told by the link, the others by its owner."""

    RESTARTED = marked("The module restarted.")
    # Nothing valid came although something was asked: the module may have been exchanged meanwhile.
    SILENT = marked("The module was silent for a moment.")
    # Something that does not change by itself was answered differently than before, or by two modules.
    CONTRADICTED = marked("Contradictory answers. Two modules on this line?")
    SLEPT = marked("The computer slept.")  # or the program stood still for seconds
    PORT_LOST = marked("The port was lost.")
    CLOSED = marked("The port was closed.")
    ANOTHER = marked("Another module was said to be connected.")  # by a person
    RATE_CHANGED = marked("The baud rate of the port was changed.")


class Contradiction(NamedTuple):
    """Two different answers to one question, of which neither was set in between."""

    before: Reading
    after: Reading


class Began(NamedTuple):
    boot_count: int
    at: float


class Ended(NamedTuple):
    """The conversation is over, and with it everything that was known of the module."""

    reason: EndReason
    at: float
    contradiction: Contradiction | None = None  # what was told differently, where that is the reason


Reply = Answered | Unanswered
Event = Sent | Received | Rejected | Reply | Began | Ended


class Counters:
    """Totals since the port was opened."""

    def __init__(self, **counted: Any) -> None:
        self.sent = self.frames = self.time_outs = self.restarts = self.bytes_received = 0
        self.by_role: Counter[Role] = Counter()
        self.rejected_bytes: Counter[Reason] = Counter()
        vars(self).update(counted)

    @property
    def rejected(self) -> int:
        return self.rejected_bytes.total()

    def copy(self) -> "Counters":
        return self + Counters()

    def __add__(self, other: "Counters") -> "Counters":
        return Counters(**{name: value + vars(other)[name] for name, value in vars(self).items()})

    def __sub__(self, earlier: "Counters") -> "Counters":
        return Counters(**{name: value - vars(earlier)[name] for name, value in vars(self).items()})
