"""Commit log of a recording: valid length of each file, with checksums."""

import mmap
import os
import struct
import zlib
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Final, NamedTuple

import numpy as np

from app.recordings.file_layout import COLUMNS, COMMITS, DATA_FILES, JOURNAL, LINE, Opening, is_time
from app.system.gil_yield import GilYield

COMMIT: Final = struct.Struct("<d5Q4L")
"""The fields of `Extents`, CRC-32 of the data since the previous commit, reserved, CRC-32 of the commit itself."""
_COUNTS: Final = ("status_rows", "cell_rows", "light_rows", "line_bytes", "journal_bytes")
_CRC_AT: Final = 52
_OWN_BYTES: Final = COMMIT.size - 4
_CHECKED_COMMITS: Final = 240
"""Commits of a cut-off recording whose checksums are verified: two minutes, longer than between two syncs."""


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


class _Commits:
    """The commits of a folder, read on demand."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._sizes = {name: (folder / name).stat().st_size for name in DATA_FILES}
        self._file = (folder / COMMITS).open("rb")
        self.count = os.fstat(self._file.fileno()).st_size // COMMIT.size

    def _raw(self, number: int) -> bytes:
        self._file.seek(number * COMMIT.size)
        return self._file.read(COMMIT.size)

    def extents(self, number: int) -> Extents | None:
        """None where the commit is damaged or exceeds the files."""
        found = _decoded(self._raw(number))
        if found is None or any(found.length(name) > size for name, size in self._sizes.items()):
            return None
        return found

    def newest(self, before: int | None = None) -> int | None:
        """Number of the last valid commit, before this number."""
        first = self.count if before is None else before
        return next((n for n in range(first - 1, -1, -1) if self.extents(n) is not None), None)

    def first_mismatch(self, first: int, stop: int) -> int | None:
        """First of these commits whose checksum does not match the data since the previous one."""
        with ExitStack() as stack:
            files = {name: stack.enter_context((self._folder / name).open("rb")) for name in DATA_FILES}
            before = self.extents(first - 1) if first else None
            for number in range(first, stop):
                now = self.extents(number)
                if now is None or (number and before is None) or not self._matches(number, before, now, files):
                    return number
                before = now
        return None

    def _matches(self, number: int, before: Extents | None, now: Extents, files: Mapping[str, IO[bytes]]) -> bool:
        crc = 0
        for name, file in files.items():
            start = before.length(name) if before is not None else 0
            length = now.length(name) - start
            if length < 0:
                return False
            if length:
                file.seek(start)
                crc = zlib.crc32(file.read(length), crc)
        return crc == _data_crc(self._raw(number))

    def close(self) -> None:
        self._file.close()


def read_extents(folder: Path, opening: Opening, *, is_checked: bool) -> Extents:
    """Valid length of each file. Raises OSError.

    `is_checked`: verifies the checksums of the last two minutes of a recording that was cut off.
    """
    commits = _Commits(folder)
    try:
        newest = commits.newest()
        if newest is None:
            return nothing(opening)
        found = commits.extents(newest)
        if is_checked and found is not None and not found.is_last:
            first = max(0, newest - _CHECKED_COMMITS)
            bad = commits.first_mismatch(first, newest + 1)
            if bad is not None:
                newest = commits.newest(bad)
                found = commits.extents(newest) if newest is not None else None
        return found or nothing(opening)
    finally:
        commits.close()


class Damaged(NamedTuple):
    """A piece of a recording that differs from what was committed."""

    first: Extents
    """Extents before the piece."""
    last: Extents


def damaged_pieces(folder: Path, opening: Opening, found: Extents) -> tuple[Damaged, ...]:
    """Verifies every checksum up to `found`; adjacent pieces are joined. Raises OSError."""
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
                first = pieces.pop().first if pieces and pieces[-1].last == last else last
                pieces.append(Damaged(first, here))
            last, before, is_gap = here, now, False
    return tuple(pieces)


def _mapped(path: Path, length: int, stack: ExitStack) -> memoryview:
    if not length:
        return memoryview(b"")
    with path.open("rb") as file:
        data = memoryview(stack.enter_context(mmap.mmap(file.fileno(), length, access=mmap.ACCESS_READ)))
    stack.callback(data.release)  # before the file is unmapped
    return data
