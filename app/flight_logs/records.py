"""Columns of binary records: gathered from where they stand in the file, without copying the rest."""

import os
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.flight_logs.flight_log import Floats, LogUnreadable
from app.text.messages import said
from protocol.translatable import marked

MOST_BYTES: Final = 1 << 30
MOST_WALKED: Final = 100_000_000
"""Records of all kinds; what comes after them is not read."""
MOST_DAMAGES: Final = 1_000_000
"""Places at which a record was expected and none was; what comes after them is not read."""


def read_bytes(path: Path) -> bytes:
    """The whole file. Raises `LogUnreadable` for one of more than 1 GiB, OSError."""
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MOST_BYTES:
            raise LogUnreadable(said(marked("Too large.")))
        return file.read(size)


def gathered(data: bytes, places: NDArray[np.int64], kind: str) -> NDArray[Any]:
    """The values of type `kind` at these places of `data`; all of them have to lie within it."""
    wanted = np.dtype(kind)
    raw = np.frombuffer(data, np.uint8)
    found = raw[places[:, None] + np.arange(wanted.itemsize)]
    return np.ascontiguousarray(found).view(wanted).reshape(len(places))


def gathered_floats(data: bytes, places: NDArray[np.int64], kind: str, scale: float = 1.0) -> Floats:
    """Like `gathered`, as floating point, times `scale`. What overflows is infinite."""
    with np.errstate(all="ignore"):
        values: Floats = gathered(data, places, kind).astype(np.float64) * scale
    return values
