"""Reads columns of binary records from a file's bytes."""

import os
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.flight_logs.flight_log import Floats, unreadable
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


def gathered(data: bytes, places: NDArray[np.int64], kind: str) -> NDArray[Any]:
    """Values of numpy type `kind` at these offsets, which must lie within `data`."""
    wanted = np.dtype(kind)
    raw = np.frombuffer(data, np.uint8)
    found = raw[places[:, None] + np.arange(wanted.itemsize)]
    return np.ascontiguousarray(found).view(wanted).reshape(len(places))


def gathered_floats(data: bytes, places: NDArray[np.int64], kind: str, scale: float = 1.0) -> Floats:
    """Like `gathered`, as float64 times `scale`. Overflows are infinite."""
    with np.errstate(all="ignore"):
        values: Floats = gathered(data, places, kind).astype(np.float64) * scale
    return values
