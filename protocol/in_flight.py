"""Request in flight."""

from typing import NamedTuple

from protocol.catalogue import Request
from protocol.messages import Message


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
