"""Bytes on the line as a few large objects, in memory and in a session file."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from heapq import merge
from operator import itemgetter
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from app.captures.entries import CaptureEntry, Way

NANOSECONDS: Final = 1_000_000_000
_COUNT: Final = np.dtype("<u4")
_MAX_OFFSET_NS: Final = 0xFFFFFFFF


@dataclass(frozen=True, slots=True)
class LinePart:
    """Bytes of one direction. `times_ns`, `lengths`: of the reads or writes that they came in."""

    times_ns: NDArray[np.int64]
    lengths: NDArray[np.int64]
    raw: bytes

    @classmethod
    def of(cls, entries: Iterable[tuple[int, bytes]]) -> Self:
        times, raws = zip(*entries, strict=True) if (entries := list(entries)) else ((), ())
        return cls(np.array(times, np.int64), np.array([len(raw) for raw in raws], np.int64), b"".join(raws))

    @classmethod
    def read(cls, messages: Iterable[tuple[int, bytes]]) -> Self:
        """Joins what `messages` gave; a message that contradicts itself is left out."""
        whole = [
            (log_ns, count, data)
            for log_ns, data in messages
            if (count := int.from_bytes(data[:4], "little")) and len(data) > 4 + 8 * count
        ]
        if not whole:
            return cls.of(())
        counts = np.array([count for _, count, _ in whole])
        lengths = np.frombuffer(b"".join(data[4 + 4 * n : 4 + 8 * n] for _, n, data in whole), _COUNT).astype(np.int64)
        totals = np.add.reduceat(lengths, np.cumsum(counts) - counts)
        is_good = totals == [len(data) - 4 - 8 * count for _, count, data in whole]
        if not is_good.all():
            return cls.read((at, data) for (at, _, data), good in zip(whole, is_good.tolist(), strict=True) if good)
        offsets = np.frombuffer(b"".join(data[4 : 4 + 4 * n] for _, n, data in whole), _COUNT)
        times = np.repeat(np.array([log_ns for log_ns, _, _ in whole], np.int64), counts) + offsets
        return cls(times, lengths, b"".join(data[4 + 8 * n :] for _, n, data in whole))

    def messages(self) -> Iterator[tuple[int, bytes]]:
        """Log times and data of messages in a session file; usually it is one."""
        ends = self.lengths.cumsum()
        first = begins = 0
        while first < len(ends):
            at_ns = int(self.times_ns[first])
            stop = int(np.searchsorted(self.times_ns, at_ns + _MAX_OFFSET_NS, "right"))
            columns = np.array((self.times_ns[first:stop] - at_ns, self.lengths[first:stop]), _COUNT)
            count = np.array(stop - first, _COUNT)
            yield at_ns, count.tobytes() + columns.tobytes() + self.raw[begins : ends[stop - 1]]
            first, begins = stop, int(ends[stop - 1])

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        begins = 0
        for at_ns, end in zip(self.times_ns.tolist(), self.lengths.cumsum().tolist(), strict=True):
            yield at_ns, self.raw[begins:end]
            begins = end


@dataclass(frozen=True, slots=True)
class LineBytes:
    """Bytes of both directions, in order of time."""

    received: LinePart
    sent: LinePart

    @classmethod
    def of(cls, entries: Iterable[CaptureEntry], offset_ns: int = 0, *, after_ns: int = -1) -> Self:
        """`offset_ns` is added to the times. They begin behind `after_ns` and increase by at least 1 ns, so that the
        order of both directions is kept."""
        parts: dict[Way, list[tuple[int, bytes]]] = {way: [] for way in Way}
        for at_s, way, raw in entries:
            after_ns = max(after_ns + 1, round(at_s * NANOSECONDS) + offset_ns)
            parts[way].append((after_ns, raw))
        return cls(LinePart.of(parts[Way.IN]), LinePart.of(parts[Way.OUT]))

    def entries(self, start_ns: int = 0) -> Iterator[CaptureEntry]:
        """Their times count from `start_ns`."""
        received = ((at, Way.IN, raw) for at, raw in self.received)
        sent = ((at, Way.OUT, raw) for at, raw in self.sent)
        for at_ns, way, raw in merge(received, sent, key=itemgetter(0)):
            yield CaptureEntry((at_ns - start_ns) / NANOSECONDS, way, raw)

    def __len__(self) -> int:
        return len(self.received.lengths) + len(self.sent.lengths)

    @property
    def end_ns(self) -> int:
        """Time of the last entry; 0 without any."""
        return max((int(part.times_ns[-1]) for part in (self.received, self.sent) if len(part.times_ns)), default=0)
