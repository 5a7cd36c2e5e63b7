"""Commit log of a recording: valid length of each file, with checksums."""

import mmap
import os
import struct
import zlib
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from app.recordings.file_layout import COLUMNS, COMMITS, DATA_FILES, JOURNAL, LINE, Opening, is_time
from app.system.gil_yield import GilYield

COMMIT: Final = struct.Struct("<d5Q4L")
"""The fields of `Extents`, CRC-32 of the data since the previous commit, reserved, CRC-32 of the commit itself."""
_COUNTS: Final = ("status_rows", "cell_rows", "light_rows", "line_bytes", "journal_bytes")
_CRC_AT: Final = 52
_OWN_BYTES: Final = COMMIT.size - 4
_UNSYNCED_S: Final = 120.0
"""Longer than between two syncs: damage at the end of a cut-off recording is what a power failure leaves."""


class Extents(NamedTuple):
    """Valid length of each file."""

    at_s: float
    status_rows: int
    cell_rows: int
    light_rows: int
    line_bytes: int
    journal_bytes: int
    is_last: bool
    """The recording was closed properly."""

    def length(self, name: str) -> int:
        """Valid bytes of a data file."""
        return int(getattr(self, _count_of(name))) * _width(name)


def _count_of(name: str) -> str:
    """Name of the count of a data file."""
    return {LINE: "line_bytes", JOURNAL: "journal_bytes"}.get(name) or f"{name.partition('.')[0]}_rows"


def _width(name: str) -> int:
    """Bytes per counted unit of a data file."""
    kind = COLUMNS.get(name.partition(".")[0], {}).get(name)
    return 1 if kind is None else np.dtype(kind).itemsize


def encoded_commit(extents: Extents, data_crc32: int) -> bytes:
    head = COMMIT.pack(*extents, data_crc32, 0, 0)[:_OWN_BYTES]
    return head + zlib.crc32(head).to_bytes(4, "little")


def _decoded(raw: bytes) -> Extents | None:
    if zlib.crc32(raw[:_OWN_BYTES]).to_bytes(4, "little") != raw[_OWN_BYTES:]:
        return None
    at_s, status, cell, light, line, journal, is_last, _crc, _reserved, _own = COMMIT.unpack(raw)
    return Extents(at_s, status, cell, light, line, journal, is_last=bool(is_last)) if is_time(at_s) else None


def _data_crc(raw: bytes) -> int:
    return int.from_bytes(raw[_CRC_AT : _CRC_AT + 4], "little")


def nothing(opening: Opening) -> Extents:
    """The extents before the first commit."""
    return Extents(opening.start_s, 0, 0, 0, 0, 0, is_last=False)


def read_extents(folder: Path, opening: Opening) -> Extents:
    """Valid length of each file by the last valid commit; the data is not verified. Raises OSError."""
    sizes = {name: (folder / name).stat().st_size for name in DATA_FILES}
    with (folder / COMMITS).open("rb") as file:
        for number in range(os.fstat(file.fileno()).st_size // COMMIT.size - 1, -1, -1):
            file.seek(number * COMMIT.size)
            found = _decoded(file.read(COMMIT.size))
            if found is not None and all(found.length(name) <= size for name, size in sizes.items()):
                return found
    return nothing(opening)


class Damaged(NamedTuple):
    """A piece of a recording that differs from what was committed."""

    first: Extents
    """Extents before the piece."""
    last: Extents


def verified(folder: Path, opening: Opening, found: Extents) -> tuple[Extents, tuple[Damaged, ...]]:
    """Verifies every checksum up to `found`; adjacent pieces are joined. A recording that was cut off ends before the
    first damage of its last two minutes. Raises OSError."""
    raw = (folder / COMMITS).read_bytes()
    commits = COMMIT.iter_unpack(raw[: len(raw) // COMMIT.size * COMMIT.size])
    pieces: list[Damaged] = []
    last, end = nothing(opening), found[1:6]
    before: Sequence[int] = last[1:6]
    is_gap, pace = False, GilYield()
    with ExitStack() as stack:
        files = [
            (_COUNTS.index(_count_of(name)), _width(name), _mapped(folder / name, found.length(name), stack))
            for name in DATA_FILES
        ]
        for number, (at_s, *now, _is_last, data_crc, _reserved, own_crc) in enumerate(commits):
            pace.checkpoint()
            place = number * COMMIT.size
            is_whole = zlib.crc32(raw[place : place + _OWN_BYTES]) == own_crc and is_time(at_s)
            if not is_whole or any(not one <= other <= most for one, other, most in zip(before, now, end, strict=True)):
                is_gap = True
                continue
            crc = 0
            for count, width, data in files:
                if now[count] != before[count]:
                    crc = zlib.crc32(data[before[count] * width : now[count] * width], crc)
            here = Extents._make((at_s, *now, False))
            if is_gap or crc != data_crc:
                if not found.is_last and at_s >= found.at_s - _UNSYNCED_S:
                    return last, tuple(pieces)
                first = pieces.pop().first if pieces and pieces[-1].last == last else last
                pieces.append(Damaged(first, here))
            last, before, is_gap = here, now, False
    return found, tuple(pieces)


def _mapped(path: Path, length: int, stack: ExitStack) -> memoryview:
    if not length:
        return memoryview(b"")
    with path.open("rb") as file:
        data = memoryview(stack.enter_context(mmap.mmap(file.fileno(), length, access=mmap.ACCESS_READ)))
    stack.callback(data.release)  # before the file is unmapped
    return data
