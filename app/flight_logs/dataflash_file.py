"""Container of ArduPilot's DataFlash logs (`.bin`), which defines its own record formats.

Read without pymavlink, which is larger than the rest of the program: see docs/flight-logs.md.
"""

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flight_logs.flight_log import Floats, unreadable
from app.flight_logs.record_chain import MAX_CHAINS, STEPS_BEFORE, RecordChain, merge_places, positions
from app.flight_logs.records import MAX_DAMAGES, MAX_WALKED, gathered, gathered_floats
from protocol.translatable import marked

MAGIC: Final = b"\xa3\x95"
MAX_TEXTS: Final = 1000
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


class DataflashField(NamedTuple):
    """Offset of a value in a record, its numpy type and its factor."""

    offset: int
    kind: str
    scale: float


@dataclass(slots=True)
class DataflashTable:
    """All records of one name."""

    name: str
    fields: Mapping[str, DataflashField]
    places: "array[int]" = field(default_factory=lambda: array("q"))
    """Offsets of the records."""

    def has(self, *names: str) -> bool:
        return len(self.places) > 0 and all(name in self.fields for name in names)


class DataflashFile:
    """`tables` has the tables of `wanted`, by name. Raises `UserError`."""

    def __init__(self, data: bytes, wanted: frozenset[str]) -> None:
        if not data.startswith(MAGIC):
            raise unreadable(marked("unknown kind of file"))
        self._data = data
        self._wanted = wanted
        self.tables: dict[str, DataflashTable] = {}
        self.skipped_bytes = 0
        """Bytes that are not records: damage."""
        self._lengths = [0] * 256
        self._lengths[_FORMAT_KIND] = _FORMAT_BYTES
        self._table_of: list[array[int] | None] = [None] * 256
        self._chains = 0
        self._kinds = np.empty(0, np.uint8)
        """Record types of the candidates of the current chain."""
        self._walk()

    def column(self, table: DataflashTable, name: str) -> Floats:
        """A column in the unit of its format."""
        offset, kind, scale = table.fields[name]
        if kind.startswith("S"):
            return np.full(len(table.places), np.nan)
        return gathered_floats(self._data, self._places(table) + offset, kind, scale)

    def texts(self, table: DataflashTable, name: str) -> list[str]:
        """The first thousand texts, up to the first NUL of each."""
        offset, kind, _ = table.fields[name]
        if not kind.startswith("S"):
            return []
        found = gathered(self._data, self._places(table)[:MAX_TEXTS] + offset, kind)
        return [one.split(b"\0")[0].decode("latin-1") for one in found.tolist()]

    def _places(self, table: DataflashTable) -> NDArray[np.int64]:
        return np.frombuffer(table.places, np.int64)

    def _walk(self) -> None:
        data, lengths, table_of = self._data, self._lengths, self._table_of
        place, stop, damages, steps = 0, len(data), 0, 0
        chain: RecordChain | None = None
        for _ in range(MAX_WALKED):
            if place + _HEAD_BYTES > stop or damages > MAX_DAMAGES:
                break
            steps += 1
            if chain is not None:
                place = chain.skip(place)
            elif steps > STEPS_BEFORE and self._chains < MAX_CHAINS:
                chain = self._chain()
            kind = data[place + 2]
            length = lengths[kind]
            if data[place] != 0xA3 or data[place + 1] != 0x95 or not length or place + length > stop:
                found = data.find(MAGIC, place + 1)
                found = stop if found < 0 else found
                self.skipped_bytes += found - place
                place = found
                damages += 1
                continue
            places = table_of[kind]
            if places is not None:
                places.append(place)
            elif kind == _FORMAT_KIND and self._define(data[place + _HEAD_BYTES : place + _FORMAT_BYTES]):
                self._collect(chain)
                chain, steps = None, 0
            place += length
        self.skipped_bytes += stop - place
        self._collect(chain)

    def _chain(self) -> RecordChain | None:
        """A chain of all that begins like a record of a known type; definitions are read one by one."""
        self._chains += 1
        starts = positions(self._data, 0, len(self._data), *MAGIC)
        if starts is None:
            self._chains = MAX_CHAINS
            return None
        starts = starts[starts + _HEAD_BYTES <= len(self._data)]
        kinds = np.frombuffer(self._data, np.uint8)[starts + 2]
        lengths = np.array(self._lengths, np.int64)
        lengths[_FORMAT_KIND] = 0
        is_known = lengths[kinds] > 0
        starts, kinds = starts[is_known], kinds[is_known]
        ends = starts + lengths[kinds]
        self._kinds = kinds[ends <= len(self._data)]
        return RecordChain(starts[ends <= len(self._data)], ends[ends <= len(self._data)])

    def _collect(self, chain: RecordChain | None) -> None:
        """Adds the records that the chain skipped over to their tables."""
        if chain is None:
            return
        records = chain.records
        for kind, places in enumerate(self._table_of):
            if places is not None:
                merge_places(places, chain.starts[records[self._kinds[records] == kind]])

    def _define(self, body: bytes) -> bool:
        """Whether it is a new definition; the first definition of a type counts."""
        kind, length = body[0], body[1]
        name, types, labels = (part.split(b"\0")[0].decode("latin-1") for part in (body[2:6], body[6:22], body[22:86]))
        if kind == _FORMAT_KIND or self._lengths[kind] or length < _HEAD_BYTES:
            return False
        self._lengths[kind] = length
        fields: dict[str, DataflashField] = {}
        offset = _HEAD_BYTES
        for letter, label in zip(types, labels.split(","), strict=False):
            found = _TYPES.get(letter)
            if found is None:
                return True
            fields[label.strip()] = DataflashField(offset, found.kind, found.scale)
            offset += np.dtype(found.kind).itemsize
        if offset > length or name not in self._wanted or name in self.tables:
            return True
        table = DataflashTable(name, fields)
        self.tables[name] = table
        self._table_of[kind] = table.places
        return True
