"""Measures round trips and derives the timeout."""

from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Timing:
    """Seconds, and where each comes from."""

    answer_s: float = 1.0
    """ "若1秒内没有收到模块答复": the vendor gives the module one second."""
    heartbeat_every_s: float = 10.0
    """ "建议上位机发送间隔时间10-30秒"."""
    probe_after_s: float = 0.1
    """After an unanswered request, if the owner asks nothing else before: is anybody there?"""
    offline_probe_s: float = 2.0
    """Between heartbeats while the module is offline, so that its return is seen soon."""
    shortest_wait_s: float = 0.15
    """Never less: USB adapters hold bytes back for 16 ms, and a busy computer for longer."""
    quiet_s: float = 0.25
    """A line that has been silent this long has ended its frame; replies come in pieces with shorter pauses."""
    records_quiet_s: float = 0.5
    """No further trigger record within this time: that was all of them (E6)."""
    records_longest_s: float = 10.0
    """Collecting records ends here even if they never stop."""
    drain_s: float = 0.03
    """Quiet to wait for between a time-out and the next attempt."""
    late_s: float = 3.0
    """A reply that is later than this no longer counts as a reply to what was asked."""
    doubled_s: float = 0.02
    """A second copy of an answer follows at once; a restart's second heartbeat only after 50 ms."""
    restart_s: float = 0.3
    """Two unasked heartbeats within it are a restart ("间隔50ms"), with room for a late adapter."""
    attempts: int = 3


ENOUGH_SAMPLES = 8


class RoundTrips:
    """The last round trips, in seconds, of answers that belong to exactly one request."""

    def __init__(self, kept: int = 256) -> None:
        self._samples: deque[float] = deque(maxlen=kept)
        self._ordered: list[float] | None = None

    def __len__(self) -> int:
        return len(self._samples)

    def add(self, round_trip_s: float) -> None:
        self._samples.append(round_trip_s)
        self._ordered = None

    @property
    def minimum_s(self) -> float | None:
        return self.quantile_s(0.0)

    @property
    def median_s(self) -> float | None:
        return self.quantile_s(0.5)

    def quantile_s(self, share: float) -> float | None:
        """The sample that `share` (0 … 1) of all samples do not exceed; None without samples."""
        if not self._samples:
            return None
        if self._ordered is None:
            self._ordered = sorted(self._samples)
        ordered = self._ordered
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))]

    def waits_s(self, timing: Timing) -> tuple[float, ...]:
        """How long to wait at each attempt of a question.

        The vendor's second until something is measured; then four times the 95th percentile (eight times while that
        stands on few samples), doubled at each attempt. The last attempt always gets the vendor's full second: only
        then is "no answer" said.
        """
        usual_s = self.quantile_s(0.95)
        if usual_s is None:
            return (timing.answer_s,) * timing.attempts
        caution = 1 if len(self._samples) >= ENOUGH_SAMPLES else 2
        first_s = min(timing.answer_s, caution * max(timing.shortest_wait_s, 4 * usual_s))
        growing = [min(timing.answer_s, first_s * 2**attempt) for attempt in range(timing.attempts - 1)]
        return (*growing, timing.answer_s)
