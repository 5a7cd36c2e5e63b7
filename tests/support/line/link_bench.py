"""A link on a fake clock, and the frames that its tests share."""

from typing import TypeVar

from protocol.catalogue import BY_NAME, HEARTBEAT, Command, Request
from protocol.events import Event, Received, Role
from protocol.link import Link
from protocol.messages import Status
from tests.vendor.frames import BY_ID

Told = TypeVar("Told")

PULSE = bytes.fromhex("41 75 01 A5 5A 00")
RECORD = BY_ID["trigger-record-example"].raw
TRAP = BY_ID["trigger-record-that-begins-like-a-voltage"].raw
STREAMED = Status(7, 1.0, False, True).encode()


class Bench:
    """A link on a fake clock."""

    def __init__(self) -> None:
        self.now = 100.0
        self.link = Link(self.now)
        self.events: list[Event] = []

    def ask(self, request: Request, **options: object) -> bytes:
        self.events += self.link.ask(request, self.now, **options)  # type: ignore[arg-type]
        return self.link.take_outgoing() or self._let_leave()

    def hear(self, *frames: bytes, after_s: float = 0.003) -> bytes:
        self.wait(after_s)
        for raw in frames:
            self.events += self.link.receive(raw, self.now)
        return self.link.take_outgoing() or self._let_leave()

    def _let_leave(self) -> bytes:
        """Wait until a request that is held back for a quiet line is sent; return it."""
        flight = self.link._flight
        if flight is None or flight.attempt or flight.held_until is None:
            return b""
        return self.wait(flight.deadline - self.now)

    def wait(self, seconds: float) -> bytes:
        """Advance the clock, ticking the link at its deadlines; return what it sent."""
        end = self.now + seconds
        sent = b""
        while (due := self.link.next_deadline()) <= end:
            self.now = max(self.now, due)
            self.events += self.link.tick(self.now)
            sent += self.link.take_outgoing()
        self.now = end
        return sent

    def warm_up(self, count: int = 8) -> None:
        for _ in range(count):
            self.ask(HEARTBEAT.query())
            self.hear(PULSE)
            self.wait(0.4)  # so that the next heartbeat is not taken for a duplicate or for a restart
        self.events.clear()

    def taken(self, kind: type[Told]) -> list[Told]:
        return [event for event in self.events if isinstance(event, kind)]

    def roles(self) -> list[Role]:
        return [event.role for event in self.events if isinstance(event, Received)]


def named(name: str) -> Command:
    return BY_NAME[name]
