"""Stores the entries of a capture compactly: a capture has millions of them."""

from array import array
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple, overload


class Way(Enum):
    """Direction of bytes on the line. The value is the character in the file."""

    OUT = ">"
    IN = "<"


class CaptureEntry(NamedTuple):
    """Bytes that were sent or received together. `at_s`: seconds since the capture began."""

    at_s: float
    way: Way
    raw: bytes


class Entries(Sequence[CaptureEntry]):
    """A sequence of entries in 17 bytes each plus their bytes, without objects for the garbage collector."""

    def __init__(self, entries: Iterable[CaptureEntry] = ()) -> None:
        self._at_s = array("d")
        self._is_out = bytearray()
        self._ends = array("Q")
        self._raw = bytearray()
        for entry in entries:
            self.append(entry)

    def append(self, entry: CaptureEntry) -> None:
        self._at_s.append(entry.at_s)
        self._is_out.append(entry.way is Way.OUT)
        self._raw += entry.raw
        self._ends.append(len(self._raw))

    def __len__(self) -> int:
        return len(self._at_s)

    def __iter__(self) -> Iterator[CaptureEntry]:
        return (self._at(place) for place in range(len(self)))

    @overload
    def __getitem__(self, place: int) -> CaptureEntry: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[CaptureEntry, ...]: ...
    def __getitem__(self, place: int | slice) -> CaptureEntry | tuple[CaptureEntry, ...]:
        places = range(len(self))[place]
        return self._at(places) if isinstance(places, int) else tuple(self._at(one) for one in places)

    def _at(self, place: int) -> CaptureEntry:
        begins = self._ends[place - 1] if place else 0
        way = Way.OUT if self._is_out[place] else Way.IN
        return CaptureEntry(self._at_s[place], way, bytes(self._raw[begins : self._ends[place]]))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence) or len(other) != len(self):
            return NotImplemented if not isinstance(other, Sequence) else False
        return all(mine == theirs for mine, theirs in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]  # it grows
