"""Container of ArduPilot's DataFlash logs (`.bin`), which defines its own record formats.

Read without pymavlink, which is larger than the rest of the program: see docs/flight-logs.md.
"""

from array import array
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from app.flight_logs.flight_log import unreadable
from app.flight_logs.records import MAX_DAMAGES, MAX_WALKED, RecordField, RecordTable
from protocol.translatable import marked

MAGIC: Final = b"\xa3\x95"
_FORMAT_KIND: Final = 128
_FORMAT_BYTES: Final = 89
_HEAD_BYTES: Final = 3


class _Type(NamedTuple):
    kind: str
    scale: float = 1.0


_TYPES: Final[Mapping[str, _Type]] = {
    "a": _Type("S64"), "b": _Type("<i1"), "B": _Type("<u1"), "h": _Type("<i2"), "H": _Type("<u2"), "i": _Type("<i4"),
    "I": _Type("<u4"), "f": _Type("<f4"), "d": _Type("<f8"), "n": _Type("S4"), "N": _Type("S16"), "Z": _Type("S64"),
    "c": _Type("<i2", 0.01), "C": _Type("<u2", 0.01), "e": _Type("<i4", 0.01), "E": _Type("<u4", 0.01),
    "L": _Type("<i4", 1e-7), "M": _Type("<u1"), "q": _Type("<i8"), "Q": _Type("<u8"), "g": _Type("<f2"),
}  # fmt: skip


class DataflashFile:
    """`tables` has the tables of `wanted`, by name. Raises `UserError`."""

    def __init__(self, data: bytes, wanted: frozenset[str]) -> None:
        if not data.startswith(MAGIC):
            raise unreadable(marked("unknown kind of file"))
        self._data = data
        self._wanted = wanted
        self.tables: dict[str, RecordTable] = {}
        self.skipped_bytes = 0
        """Bytes that are not records: damage."""
        self._lengths = [0] * 256
        self._lengths[_FORMAT_KIND] = _FORMAT_BYTES
        self._places_of: list[array[int] | None] = [None] * 256
        self._walk()

    def _walk(self) -> None:
        data, lengths, places_of = self._data, self._lengths, self._places_of
        place, stop, damages = 0, len(data), 0
        for _ in range(MAX_WALKED):
            if place + _HEAD_BYTES > stop or damages > MAX_DAMAGES:
                break
            kind = data[place + 2]
            length = lengths[kind]
            if data[place] != 0xA3 or data[place + 1] != 0x95 or not length or place + length > stop:
                found = data.find(MAGIC, place + 1)
                found = stop if found < 0 else found
                self.skipped_bytes += found - place
                place = found
                damages += 1
                continue
            places = places_of[kind]
            if places is not None:
                places.append(place)
            elif kind == _FORMAT_KIND:
                self._define(data[place + _HEAD_BYTES : place + _FORMAT_BYTES])
            place += length
        self.skipped_bytes += stop - place

    def _define(self, body: bytes) -> None:
        """The first definition of a type counts."""
        kind, length = body[0], body[1]
        name, types, labels = (part.split(b"\0")[0].decode("latin-1") for part in (body[2:6], body[6:22], body[22:86]))
        if kind == _FORMAT_KIND or self._lengths[kind] or length < _HEAD_BYTES:
            return
        self._lengths[kind] = length
        fields: dict[str, RecordField] = {}
        offset = _HEAD_BYTES
        for letter, label in zip(types, labels.split(","), strict=False):
            found = _TYPES.get(letter)
            if found is None:
                return
            fields[label.strip()] = RecordField(offset, found.kind, found.scale)
            offset += np.dtype(found.kind).itemsize
        if offset > length or name not in self._wanted or name in self.tables:
            return
        table = RecordTable(name, self._data, fields)
        self.tables[name] = table
        self._places_of[kind] = table.places
