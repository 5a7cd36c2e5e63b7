"""Link statistics of one connection: requests, loss, rejected bytes by reason, restarts, round trips."""

from collections import deque
from collections.abc import Iterable

from app.engine.worker import Batch, PortState
from protocol.events import Answered, Counters, Event, Received, Rejected, Sent

MAX_TRIPS = 4096


class LinkStatistics:
    """Of one connection, over its automatic reconnections. Belongs to one thread."""

    def __init__(self) -> None:
        self._last = Counters()
        self._was_open = False
        self._trips_s: deque[float] = deque(maxlen=MAX_TRIPS)
        # Since the connection began; `losses` of the port.
        self.totals = Counters()
        self.losses = 0
        self.last_frame_at: float | None = None
        self.last_invalid_at: float | None = None

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        if batch.connection.state is not PortState.OPEN:
            if self._was_open and batch.connection.trouble is not None:
                self.losses += 1
            self._was_open = False
            self.totals += _counted(batch.events)  # the last events, which are in no totals of the link
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
        self.totals += grown
        for event in batch.events:
            if isinstance(event, Answered) and event.round_trip_s is not None:
                self._trips_s.append(event.round_trip_s)

    def quantile_s(self, share: float) -> float | None:
        """Quantile (`share` 0 … 1) of the last 4,096 round trips; None without any."""
        ordered = sorted(self._trips_s)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None


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
