"""Link statistics over time: round trips, loss, rejected bytes by reason, restarts.

Bounded: the last ten minutes by the second, and the totals of this connection.
"""

from bisect import bisect_left
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import groupby
from typing import NamedTuple

from app.captures.entries import Way
from app.captures.explained import Explained
from app.engine.procedure import LinkView
from app.engine.worker import Batch, PortState
from protocol.events import Answered, Counters, Event, Received, Rejected, Sent
from protocol.frame import Noise, Reason

MAX_SECONDS = 600
BOUNDS_MS: tuple[float, ...] = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 100, 150, 250, 500, 1000)
"""Upper bounds of the round-trip histogram; a last class has no bound."""
MAX_TRIPS = 4096


@dataclass(frozen=True, slots=True)
class Slice:
    """Counts of one second; seconds without a batch have none. `begins_s`: monotonic seconds, whole."""

    begins_s: float
    sent: int = 0
    frames: int = 0
    time_outs: int = 0
    retries: int = 0
    restarts: int = 0
    losses: int = 0
    """How often the port was lost."""
    bytes_received: int = 0
    rejected: tuple[tuple[Reason, int], ...] = ()
    """Bytes by reason, most first."""
    slowest_s: float | None = None
    """The longest round trip."""

    @property
    def rejected_bytes(self) -> int:
        return sum(count for _, count in self.rejected)


@dataclass(frozen=True, slots=True)
class TripClass:
    """A class of the round-trip histogram; `up_to_ms` None: no upper bound."""

    up_to_ms: float | None
    count: int


class _Seen(NamedTuple):
    """Totals of the link in a batch that are not added up yet."""

    at: float
    link: LinkView


class _Growth(NamedTuple):
    counters: Counters
    bytes_received: int


def _counted(events: Iterable[Event]) -> _Growth:
    """Counts of these events."""
    grown, byte_count = Counters(), 0
    for event in events:
        match event:
            case Sent():
                grown.sent += 1
            case Received(frame=frame, role=role):
                grown.frames += 1
                grown.by_role[role] += 1
                byte_count += len(frame.raw)
            case Rejected(noise=noise):
                grown.rejected_bytes[noise.reason] += len(noise.raw)
                byte_count += len(noise.raw)
            case _:
                pass
    return _Growth(grown, byte_count)


@dataclass(slots=True)
class _Sum:
    """A slice that is not complete."""

    begins_s: float
    counters: Counters = field(default_factory=Counters)
    bytes_received: int = 0
    losses: int = 0
    slowest_s: float | None = None

    def add(self, grown: Counters, byte_count: int, losses: int, trips_s: Iterable[float]) -> None:
        self.counters += grown
        self.bytes_received += byte_count
        self.losses += losses
        self.slowest_s = max([*trips_s, *([self.slowest_s] if self.slowest_s is not None else [])], default=None)

    def closed(self) -> Slice:
        counted = self.counters
        rejected = tuple((reason, count) for reason, count in counted.rejected_bytes.most_common() if count)
        return Slice(
            self.begins_s, counted.sent, counted.frames, counted.time_outs, counted.retries, counted.restarts,
            self.losses, self.bytes_received, rejected, self.slowest_s,
        )  # fmt: skip


def _goes_on(seen: _Seen, at: float, link: LinkView) -> bool:
    """Whether `link` includes the counts of `seen`: same second, same opening of the port."""
    is_same_opening = link.bytes_received >= seen.link.bytes_received and link.counters.sent >= seen.link.counters.sent
    return is_same_opening and at // 1 == seen.at // 1


class LinkStatistics:
    """Link statistics of one connection, over its automatic reconnections. Belongs to one thread.

    The link's totals are added up once a second and when a property is read.
    """

    def __init__(self) -> None:
        self._done: deque[Slice] = deque(maxlen=MAX_SECONDS - 1)
        self._open: _Sum | None = None
        self._last = Counters()
        self._last_bytes = 0
        self._was_open = False
        self._pending: _Seen | None = None
        self._trips_s: deque[float] = deque(maxlen=MAX_TRIPS)
        self._classes: Counter[int] = Counter()
        self._totals = Counters()
        self._bytes_received = 0
        self.losses = 0

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        pending = self._pending
        is_open, link = batch.connection.state is PortState.OPEN, batch.link
        if pending is not None and not (is_open and link is not None and _goes_on(pending, batch.at, link)):
            self._settle()
        if not is_open:
            lost = int(self._was_open and batch.connection.trouble is not None)
            self._was_open = False
            self._add(batch.at, *_counted(batch.events), lost, ())  # the last events, which are in no totals
            self._last, self._last_bytes = Counters(), 0
            return
        self._was_open = True
        trips = [event.round_trip_s for event in batch.events if isinstance(event, Answered)]
        trips_s = [trip for trip in trips if trip is not None]
        if link is None:
            self._add(batch.at, Counters(), 0, 0, trips_s)
            return
        self._pending = _Seen(batch.at, link)
        if trips_s:
            self._settle(trips_s)

    def count(self, rows: Iterable[Explained]) -> None:
        """Adds what was recorded, in order of time: frames and bytes. What only a link knows is not in it."""
        for second, group in groupby(rows, key=lambda row: row.at_s // 1):
            grown, byte_count = Counters(), 0
            for row in group:
                if isinstance(row.piece, Noise):
                    grown.rejected_bytes[row.piece.reason] += len(row.piece.raw)
                elif row.way is Way.OUT:
                    grown.sent += 1
                else:
                    grown.frames += 1
                byte_count += len(row.piece.raw) if row.way is Way.IN else 0
            self._add(second, grown, byte_count, 0, ())

    def _settle(self, trips_s: Iterable[float] = ()) -> None:
        """Adds the pending totals of the link."""
        pending, self._pending = self._pending, None
        if pending is not None:
            self._add(pending.at, *self._growth(pending.link), 0, trips_s)

    @property
    def totals(self) -> Counters:
        """Since the connection began."""
        self._settle()
        return self._totals

    @property
    def bytes_received(self) -> int:
        """Since the connection began."""
        self._settle()
        return self._bytes_received

    @property
    def seconds(self) -> tuple[Slice, ...]:
        """The last ten minutes, oldest first."""
        self._settle()
        return (*self._done, *(() if self._open is None else (self._open.closed(),)))

    def round_trips(self) -> tuple[TripClass, ...]:
        """All round trips since the connection began, by duration."""
        bounds: tuple[float | None, ...] = (*BOUNDS_MS, None)
        return tuple(TripClass(bound, self._classes[index]) for index, bound in enumerate(bounds))

    def quantile_s(self, share: float) -> float | None:
        """Quantile (`share` 0 … 1) of the last 4,096 round trips; None without any."""
        ordered = sorted(self._trips_s)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None

    def _growth(self, link: LinkView) -> _Growth:
        if link.bytes_received < self._last_bytes or link.counters.sent < self._last.sent:
            self._last, self._last_bytes = Counters(), 0  # the port was reopened
        grown = link.counters - self._last
        byte_count = link.bytes_received - self._last_bytes
        self._last, self._last_bytes = link.counters, link.bytes_received
        return _Growth(grown, byte_count)

    def _add(self, now: float, grown: Counters, byte_count: int, losses: int, trips_s: Iterable[float]) -> None:
        trips_s = tuple(trips_s)
        if self._open is None or now // 1 > self._open.begins_s:
            if self._open is not None:
                self._done.append(self._open.closed())
            self._open = _Sum(now // 1)
        self._open.add(grown, byte_count, losses, trips_s)
        for trip_s in trips_s:
            self._trips_s.append(trip_s)
            self._classes[bisect_left(BOUNDS_MS, round(trip_s * 1000, 6))] += 1
        self._totals += grown
        self._bytes_received += byte_count
        self.losses += losses
