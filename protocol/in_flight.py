"""Request in flight."""

from dataclasses import dataclass

from protocol.catalogue import Request
from protocol.messages import Message


@dataclass(frozen=True, slots=True)
class Flight:
    """The request in flight and how far it is."""

    request: Request
    waits_s: tuple[float, ...]
    attempt: int = 0
    sent_at: float = 0.0
    deadline: float = 0.0
    held_until: float | None = None
    """Not sent before this moment, and not before the line is ready; None once the attempt is under way."""
    heard_before: int = 0
    """Bytes that had been heard when it first went out: a frame that began among them is no answer."""
    messages: tuple[Message, ...] = ()
    collects_until: float = 0.0
