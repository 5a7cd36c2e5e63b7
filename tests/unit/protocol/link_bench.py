"""A link on a fake clock, a scripted module at its other end, and the frames that its tests share."""

from typing import TypeVar

from protocol.catalogue import BOOT_COUNT, BY_NAME, HEARTBEAT, Command, Request
from protocol.events import Began, Ended, EndReason, Event, Received, Role, Sent, Unanswered
from protocol.link import Link
from protocol.messages import Status, encode_reply
from protocol.stale_replies import FENCES
from tests.vendor.frames import BY_ID

Told = TypeVar("Told")

PULSE = bytes.fromhex("41 75 01 A5 5A 00")
RECORD = BY_ID["trigger-record-example"].raw
TRAP = BY_ID["trigger-record-that-begins-like-a-voltage"].raw
STREAMED = Status(7, 1.0, False, True).encode()
BOOTS = BOOT_COUNT.query()
BOOTED = 37
AGAIN = encode_reply(0x23, BOOTED)
"""The answer to the question for the boot count."""
REPLY_S = 0.003


class Bench:
    """A link and a module that answers what the link asks for by itself: boot count, heartbeat and fences.

    What a test asks is answered by the test, with `hear`.
    """

    def __init__(self, *, is_there: bool = True, reply_s: float = REPLY_S) -> None:
        self.now = 100.0
        self.link = Link(self.now)
        self.events: list[Event] = []
        self.answers: dict[bytes, bytes] = {BOOTS.encode(): AGAIN, HEARTBEAT.query().encode(): PULSE}
        self.answers |= {fence.encode(): encode_reply(fence.command.code, 0) for fence in FENCES[1:4]}
        """What the module answers by itself."""
        self.is_there = is_there
        self.reply_s = reply_s
        self._due: list[tuple[float, bytes]] = []
        self._asked: Request | None = None
        self._asked_after = 0
        self._delivered: Sent | None = None

    def begun(self) -> "Bench":
        """In a conversation, of which the round trips are known; nothing happened yet."""
        self.wait(0.5)
        while not self.link.is_begun:
            self.wait(0.1)
        self.events.clear()
        return self

    def ask(self, request: Request, **options: object) -> bytes:
        """Ask, and let the time pass until the request has left: after the link's own question, a fence and a pause.
        Return what left."""
        before = len(self.taken(Sent))
        self.begin_to_ask(request, **options)
        while not (self.link.is_idle or self.link.is_own or self.has_left):
            self.wait(0.0005)
        return b"".join(sent.raw for sent in self.taken(Sent)[before:])

    def begin_to_ask(self, request: Request, **options: object) -> bytes:
        """Ask, after the link's own question. Return what leaves at once."""
        ends_at = self.now + 2.0
        while self.link.is_own and self.now < ends_at:
            self.wait(0.0005)
        if self.link.is_own:  # on a slow line it asks again and again
            self.events += self.link.abandon(self.now)
        before = len(self.taken(Sent))
        self._asked, self._asked_after = request, len(self.events)
        self.events += self.link.ask(request, self.now, **options)  # type: ignore[arg-type]
        self._deliver()
        return b"".join(sent.raw for sent in self.taken(Sent)[before:])

    @property
    def has_left(self) -> bool:
        """Whether what was last asked for was sent; it may still wait for a fence or for a quiet line."""
        since = self.events[self._asked_after :]
        return any(isinstance(event, Sent) and event.request == self._asked for event in since)

    def hear(self, *frames: bytes, after_s: float = 0.003) -> bytes:
        """Return what leaves because of these frames, as well as in the time before."""
        before = len(self.taken(Sent))
        self.wait(after_s)
        for raw in frames:
            self.events += self.link.receive(raw, self.now)
        self.events += self.link.tick(self.now)
        self._deliver()
        return b"".join(sent.raw for sent in self.taken(Sent)[before:])

    def wait(self, seconds: float) -> bytes:
        """Advance the clock, ticking the link at its deadlines; return what it sent."""
        before, end = len(self.taken(Sent)), self.now + seconds
        while True:
            due = self._due[0][0] if self._due else end
            due = max(self.now, min(due, self.link.next_deadline(self.now)))
            if due > end:
                break
            self.now = due
            while self._due and self._due[0][0] <= self.now:
                self.events += self.link.receive(self._due.pop(0)[1], self.now)
            self.events += self.link.tick(self.now)
            self._deliver()
            if due == end and self.link.next_deadline(self.now) > end and not (self._due and self._due[0][0] <= end):
                break
        self.now = end
        return b"".join(sent.raw for sent in self.taken(Sent)[before:])

    def _deliver(self) -> None:
        """What the link has written reaches the module."""
        sent = self.taken(Sent)
        delivered = [number for number, one in enumerate(sent, start=1) if one is self._delivered]
        for one in sent[max(delivered, default=0) :]:
            answer = self.answers.get(one.raw)
            if answer is not None and self.is_there:
                self._due.append((self.now + self.reply_s, answer))
            self._delivered = one

    # What came of it

    def taken(self, kind: type[Told]) -> list[Told]:
        return [event for event in self.events if isinstance(event, kind)]

    def unknown(self) -> list[Unanswered]:
        """What may have been carried out."""
        return [event for event in self.taken(Unanswered) if event.may_be_done]

    def roles(self) -> list[Role]:
        """Of what the test let the link hear."""
        own = (AGAIN, PULSE)
        return [event.role for event in self.events if isinstance(event, Received) and event.frame.raw not in own]

    def sent(self, request: Request) -> int:
        """How often it left."""
        return [event.request for event in self.taken(Sent)].count(request)

    @property
    def begins(self) -> int:
        return len(self.taken(Began))

    @property
    def reasons(self) -> list[EndReason]:
        """Why conversations ended."""
        return [ended.reason for ended in self.taken(Ended)]


def named(name: str) -> Command:
    return BY_NAME[name]
