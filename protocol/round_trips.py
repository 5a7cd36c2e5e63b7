"""Measures round trips and derives the timeout."""

from collections import deque
from typing import NamedTuple


class Timing(NamedTuple):
    """Seconds, with their sources."""

    answer_s: float = 1.0
    """ "若1秒内没有收到模块答复": the vendor gives the module one second."""
    heartbeat_every_s: float = 10.0
    """ "建议上位机发送间隔时间10-30秒"."""
    probe_after_s: float = 0.1
    """From an unanswered request to a heartbeat, unless the owner asks something before."""
    offline_probe_s: float = 2.0
    """Between heartbeats while the module is offline."""
    shortest_wait_s: float = 0.15
    """The minimum: USB adapters delay bytes by 16 ms, and a busy computer by more."""
    quiet_s: float = 0.25
    """Silence that ends a frame; the pieces of a reply come with shorter pauses."""
    records_quiet_s: float = 0.5
    """Without a further trigger record for this long there are no more (E6)."""
    records_longest_s: float = 10.0
    drain_s: float = 0.03
    """Quiet to wait for between a time-out and the next attempt."""
    late_s: float = 3.0
    """A later reply no longer counts as a reply to its request."""
    repeated_s: float = 5.0
    """A bridge that repeats what it passes on has done so within this time. A later copy is taken for an answer."""
    doubled_s: float = 0.02
    """A doubled answer follows within this time; a restart's second heartbeat only after 50 ms."""
    restart_s: float = 0.3
    """Two unasked heartbeats within this time are a restart ("间隔50ms", plus the adapter's delay)."""
    silent_gap_s: float = 0.3
    """From the first unanswered question; nobody exchanges a module in less."""
    attempts: int = 3


ENOUGH_SAMPLES = 8
MAX_SAMPLES = 256


class RoundTrips:
    """The last round trips, in seconds, of requests that were sent once."""

    def __init__(self) -> None:
        self._samples: deque[float] = deque(maxlen=MAX_SAMPLES)
        self._ordered: list[float] | None = None

    def add(self, round_trip_s: float) -> None:
        self._samples.append(round_trip_s)
        self._ordered = None

    def quantile_s(self, share: float) -> float | None:
        """The quantile `share` (0 ≤ share < 1) of the samples; None without samples."""
        if not self._samples:
            return None
        if self._ordered is None:
            self._ordered = sorted(self._samples)
        return self._ordered[int(share * len(self._ordered))]

    def waits_s(self, timing: Timing) -> tuple[float, ...]:
        """How long to wait for the answer at each attempt of a question.

        The vendor's second until something is measured; then four times the 95th percentile (eight times with few
        samples), doubled at each attempt. The last attempt always gets the vendor's full second.
        """
        usual_s = self.quantile_s(0.95)
        if usual_s is None:
            return (timing.answer_s,) * timing.attempts
        caution = 1 if len(self._samples) >= ENOUGH_SAMPLES else 2
        first_s = min(timing.answer_s, caution * max(timing.shortest_wait_s, 4 * usual_s))
        growing = [min(timing.answer_s, first_s * 2**attempt) for attempt in range(timing.attempts - 1)]
        return (*growing, timing.answer_s)
