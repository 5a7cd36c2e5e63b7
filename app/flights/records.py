"""Columns of binary records, read from a file's bytes."""

import os
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import Floats, unreadable
from protocol.translatable import marked

MAX_BYTES: Final = 1 << 30
MAX_WALKED: Final = 100_000_000
"""Records of all types; later ones are not read."""
MAX_DAMAGES: Final = 1_000_000
"""Places without an expected record; what follows is not read."""


def read_bytes(path: Path) -> bytes:
    """The whole file. Raises `UserError` for one of more than 1 GiB, OSError."""
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MAX_BYTES:
            raise unreadable(marked("too large"))
        return file.read(size)


class RecordField(NamedTuple):
    """Offset of a value in a record, its numpy type and its factor."""

    offset: int
    kind: str
    scale: float = 1.0


@dataclass(slots=True)
class RecordTable:
    """All records of one name. `places`: their offsets in `data`, within which every field lies."""

    name: str
    data: bytes = field(repr=False)
    fields: Mapping[str, RecordField]
    places: "array[int]" = field(default_factory=lambda: array("q"))

    def has(self, *names: str) -> bool:
        return len(self.places) > 0 and all(name in self.fields for name in names)

    def column(self, name: str) -> Floats:
        """A column in the unit of its format; overflows are infinite, and texts are no numbers."""
        offset, kind, scale = self.fields[name]
        if kind.startswith("S"):
            return np.full(len(self.places), np.nan)
        places, dtype = np.frombuffer(self.places, np.int64) + offset, np.dtype(kind)
        raw = np.frombuffer(self.data, np.uint8)[places[:, None] + np.arange(dtype.itemsize)]
        with np.errstate(all="ignore"):
            values: Floats = np.ascontiguousarray(raw).view(dtype).reshape(len(places)).astype(np.float64) * scale
        return values
