"""One line, one conversation after another, sans I/O: bytes and `now` in, bytes and events out."""

from protocol.catalogue import Request
from protocol.contradictions import ToldValues
from protocol.events import Counters, EndReason, Event
from protocol.flag_answers import FlagAnswers
from protocol.round_trips import RoundTrips, Timing


class LinkMisused(RuntimeError):
    """A bug in the caller: a second request while one is in flight, or a dangerous one without an explicit act."""


class Link:
    def __init__(self, now: float, before: "Link | None" = None) -> None:
        """`before`: the link on the same port at another rate, which this one replaces."""
        self.timing = Timing()
        self.counters: Counters = Counters() if before is None else before.counters
        self.flags: FlagAnswers = FlagAnswers(now, self.timing) if before is None else before.flags
        self.told = ToldValues(self.timing)
        self.round_trips = RoundTrips()
        self.is_begun = False

    @property
    def is_idle(self) -> bool:
        raise NotImplementedError

    @property
    def has_left(self) -> bool:
        raise NotImplementedError

    @property
    def lag_s(self) -> float | None:
        raise NotImplementedError

    @property
    def is_slow(self) -> bool:
        raise NotImplementedError

    @property
    def silence_s(self) -> float:
        raise NotImplementedError

    def ask(
        self,
        request: Request,
        now: float,
        *,
        is_fenced: bool = False,
        is_deliberate: bool = False,
        limit_s: float | None = None,
    ) -> list[Event]:
        raise NotImplementedError

    def abandon(self, now: float) -> list[Event]:
        raise NotImplementedError

    def lock_again(self, now: float, attempt: int) -> list[Event]:
        raise NotImplementedError

    def end(self, reason: EndReason, now: float) -> list[Event]:
        raise NotImplementedError

    def take_outgoing(self) -> bytes:
        raise NotImplementedError

    def receive(self, data: bytes, now: float) -> list[Event]:
        raise NotImplementedError

    def tick(self, now: float) -> list[Event]:
        raise NotImplementedError

    def next_deadline(self) -> float:
        raise NotImplementedError
