"""Link statistics over time: round trips, loss, rejected bytes by reason, restarts.

Bounded: the last ten minutes by the second, and the totals of this connection.
"""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from app.engine.worker import Batch, PortState
from protocol.events import Answered, Counters, Event, Received, Rejected, Sent

MAX_SECONDS = 600
MAX_TRIPS = 4096


class Slice(NamedTuple):
    """One second; seconds without a batch have none. `begins_s`: monotonic seconds, whole."""

    begins_s: float
    counters: Counters
    losses: int = 0
    slowest_s: float | None = None


class LinkStatistics:
    """Link statistics of one connection, over its automatic reconnections. Belongs to one thread."""

    def __init__(self) -> None:
        self._slices: deque[Slice] = deque(maxlen=MAX_SECONDS)
        self._last = Counters()
        self._was_open = False
        self._trips_s: deque[float] = deque(maxlen=MAX_TRIPS)
        self.totals = Counters()
        """Since the connection began."""
        self.losses = 0
        self.last_frame_at: float | None = None
        self.last_invalid_at: float | None = None

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        if batch.connection.state is not PortState.OPEN:
            lost = int(self._was_open and batch.connection.trouble is not None)
            self._was_open = False
            self._add(batch.at, _counted(batch.events), lost, [])  # the last events, which are in no totals
            self._last = Counters()
            return
        self._was_open = True
        before = self._last
        self._last = totals = before if batch.link is None else batch.link.counters
        # After the port was reopened they start at zero.
        goes_on = totals.bytes_received >= before.bytes_received and totals.sent >= before.sent
        grown = totals - before if goes_on else totals
        if grown.frames:
            self.last_frame_at = batch.at
        if grown.rejected:
            self.last_invalid_at = batch.at
        trips_s = [event.round_trip_s for event in batch.events if isinstance(event, Answered)]
        self._add(batch.at, grown, 0, [trip for trip in trips_s if trip is not None])

    @property
    def seconds(self) -> tuple[Slice, ...]:
        """The last ten minutes, oldest first."""
        return tuple(self._slices)

    def quantile_s(self, share: float) -> float | None:
        """Quantile (`share` 0 … 1) of the last 4,096 round trips; None without any."""
        ordered = sorted(self._trips_s)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None

    def _add(self, now: float, grown: Counters, losses: int, trips_s: list[float]) -> None:
        if not self._slices or now // 1 > self._slices[-1].begins_s:
            self._slices.append(Slice(now // 1, Counters()))
        begins_s, counters, former, slowest_s = self._slices[-1]
        if trips_s:
            slowest_s = max(slowest_s or 0.0, *trips_s)
        self._slices[-1] = Slice(begins_s, counters + grown, former + losses, slowest_s)
        self._trips_s += trips_s
        self.totals += grown
        self.losses += losses


def _counted(events: Iterable[Event]) -> Counters:
    grown = Counters()
    for event in events:
        match event:
            case Sent():
                grown.sent += 1
            case Received(frame=frame, role=role):
                grown.frames += 1
                grown.by_role[role] += 1
                grown.bytes_received += len(frame.raw)
            case Rejected(noise=noise):
                grown.rejected_bytes[noise.reason] += len(noise.raw)
                grown.bytes_received += len(noise.raw)
            case _:
                pass
    return grown
