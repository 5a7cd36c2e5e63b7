"""The request in flight and the states of the link: (state, input) -> state. A missing key is a bug."""

from enum import Enum, auto
from typing import NamedTuple

from protocol.catalogue import Request
from protocol.messages import Message


class Exchange(Enum):
    IDLE = auto()
    FENCING = auto()
    """The fence was sent; the request waits for its answer."""
    WAITING = auto()
    DRAINING = auto()
    """Unanswered; waiting for the line to fall quiet before the next attempt."""
    PROBING = auto()


class Step(Enum):
    ASK = auto()
    ASK_BEHIND_FENCE = auto()
    PROBE = auto()
    ANSWER = auto()
    TIME_OUT = auto()
    QUIET = auto()
    GIVE_UP = auto()
    ABANDON = auto()
    """The owner no longer wants the answer."""


EXCHANGE: dict[tuple[Exchange, Step], Exchange] = {
    (Exchange.IDLE, Step.ASK): Exchange.WAITING,
    (Exchange.IDLE, Step.ASK_BEHIND_FENCE): Exchange.FENCING,
    (Exchange.IDLE, Step.PROBE): Exchange.PROBING,
    (Exchange.FENCING, Step.ANSWER): Exchange.WAITING,
    (Exchange.FENCING, Step.TIME_OUT): Exchange.FENCING,
    (Exchange.FENCING, Step.GIVE_UP): Exchange.IDLE,
    (Exchange.WAITING, Step.ANSWER): Exchange.IDLE,
    (Exchange.WAITING, Step.TIME_OUT): Exchange.DRAINING,
    (Exchange.WAITING, Step.GIVE_UP): Exchange.IDLE,
    (Exchange.DRAINING, Step.QUIET): Exchange.WAITING,
    (Exchange.DRAINING, Step.ANSWER): Exchange.IDLE,
    (Exchange.DRAINING, Step.GIVE_UP): Exchange.IDLE,
    (Exchange.PROBING, Step.ANSWER): Exchange.IDLE,
    (Exchange.PROBING, Step.GIVE_UP): Exchange.IDLE,
    (Exchange.IDLE, Step.ABANDON): Exchange.IDLE,
    (Exchange.FENCING, Step.ABANDON): Exchange.IDLE,
    (Exchange.WAITING, Step.ABANDON): Exchange.IDLE,
    (Exchange.DRAINING, Step.ABANDON): Exchange.IDLE,
    (Exchange.PROBING, Step.ABANDON): Exchange.IDLE,
}


class Presence(Enum):
    UNKNOWN = "unknown"
    ONLINE = "online"
    OFFLINE = "offline"


class Flight(NamedTuple):
    request: Request
    waits_s: tuple[float, ...]
    attempt: int = 0
    sent_at: float = 0.0
    deadline: float = 0.0
    held_until: float | None = None
    """Not sent before this time, nor before the line is ready; None once the attempt has been sent."""
    received_before: int = 0
    """Bytes received when it was first sent: a frame that began among them is not its answer."""
    messages: tuple[Message, ...] = ()
    collects_until: float = 0.0
