"""Reads captures as text: those of earlier versions, those in support bundles, and hex text.

    # DPS-S capture 1
    # program: DPS-S Configurator 0.1.0
    # port: /dev/ttyUSB0
    # baud_rate: 115200
    # started: 2026-11-21T01:49:05Z
    0.000000 > 42 61 32 01 00 33
    0.002913 < 41 75 32 07 0A 00 01 44

Time in seconds since the header, direction (`>` host to module, `<` module to host), bytes. Plain hex text, without
times and directions, can be read, too. Lines that cannot be read are skipped and reported.
"""

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from io import TextIOWrapper
from typing import BinaryIO, Final

from app.captures.entries import CaptureEntry, Way
from app.captures.writer import BYTES_A_LINE, MAX_FILE_BYTES, Header
from app.text.hex_text import HexText, NotHex
from protocol.catalogue import DEFAULT_BAUD_RATE
from protocol.frame import Direction, Frame
from protocol.stream import Piece, StreamParser
from protocol.translatable import marked

BITS_PER_BYTE: Final = 10
MAX_LINE_LENGTH: Final = 64 * 1024
MAGIC_LINE: Final = re.compile(r"#\s*DPS-S capture\s+(\d+)\s*")
ENTRY_LINE: Final = re.compile(r"(\d{1,12}(?:\.\d{1,9})?)\s+([<>])\s*(.*)")
MAX_FAULTS = 100
STEP_CHARACTERS = 4096
"""Read at once from a file: about 2 ms of work."""

_FIELD = re.compile(r"#\s*([a-z_]+)\s*:\s*(.*)")
_TOO_LONG = marked("the line is too long")
_WAYS = {way.value: way for way in Way}


@dataclass(frozen=True, slots=True)
class LineFault:
    """A line that was skipped. `line` counts from 1; `text` is in English."""

    line: int
    text: str


class CaptureRefused(ValueError):
    """The file is no capture: too long, or of a later version. The message is in English."""


def read_text(file: BinaryIO, reader: "CaptureReader") -> Iterator[list[CaptureEntry]]:
    """All entries, in steps of some milliseconds of work. Raises OSError, or `CaptureRefused`."""
    if os.fstat(file.fileno()).st_size > MAX_FILE_BYTES + MAX_LINE_LENGTH:
        raise CaptureRefused(marked("the file is too long for a capture"))
    lines = TextIOWrapper(file, encoding="utf-8-sig", errors="replace")
    characters, entries = 0, list[CaptureEntry]()
    try:
        while line := lines.readline(MAX_LINE_LENGTH + 1):
            entries += reader.feed(line, goes_on=len(line) > MAX_LINE_LENGTH and not line.endswith("\n"))
            characters += len(line)
            if characters >= STEP_CHARACTERS:
                yield entries
                characters, entries = 0, []
        yield entries + reader.end()
    finally:
        lines.detach()


class CaptureReader:
    """Parses the lines of a capture one by one. Header and faults are those of the lines so far."""

    def __init__(self) -> None:
        self._is_plain: bool | None = None
        self.header = Header()
        self.faults: list[LineFault] = []
        self._number = 0
        self._is_within = False
        """The previous line continues."""
        self._hex: HexText | None = None
        """Reads the pieces of a long line of hex text, until one is invalid."""
        self._parser = StreamParser(follows_host=True)
        self._last_s = 0.0
        self._has_entries = False
        self._part_begins_s = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether it is hex text: its first line that is not empty is none of a capture."""
        return self._is_plain is True

    def feed(self, line: str, *, goes_on: bool = False) -> Sequence[CaptureEntry]:
        """Entries of the next line. With `goes_on` it is the beginning or a piece of a long line.

        Raises `CaptureRefused`.
        """
        is_within, self._is_within = self._is_within, goes_on
        if not is_within:
            self._number += 1
        if self._is_plain is None and (text := line.strip()):
            self._is_plain = not (MAGIC_LINE.fullmatch(text) or ENTRY_LINE.fullmatch(text))
        if self.is_plain:
            return self._plain(line, is_within=is_within, goes_on=goes_on)
        if is_within:
            return ()
        if goes_on:
            if not line.startswith("#"):
                self._fault(_TOO_LONG)
            return ()
        entry = self._timed(line.strip())
        if entry is None:
            return ()
        self._last_s, self._has_entries = entry.at_s, True
        return (entry,)

    def end(self) -> list[CaptureEntry]:
        """Entries that are left at the end."""
        return [_plain_entry(piece) for piece in self._parser.flush()] if self.is_plain else []

    def _timed(self, line: str) -> CaptureEntry | None:
        if not line:
            return None
        if line.startswith("#"):
            self._comment(line)
            return None
        if len(line) > MAX_LINE_LENGTH:
            self._fault(_TOO_LONG)
            return None
        found = ENTRY_LINE.fullmatch(line)
        if found is None:
            self._fault(marked("no time, direction and bytes"))
            return None
        try:
            raw = _bytes_of(found[3])
        except NotHex:
            self._fault(marked("no pairs of hex digits"))
            return None
        at_s = self._part_begins_s + float(found[1])
        if self._has_entries and at_s < self._last_s:
            self._fault(marked("the time runs backwards"))
            at_s = self._last_s
        return CaptureEntry(at_s, _WAYS[found[2]], raw) if raw else None

    def _comment(self, line: str) -> None:
        magic = MAGIC_LINE.fullmatch(line)
        if magic is not None:
            if magic[1] != "1":
                raise CaptureRefused(marked("the capture is of a later version of the program"))
            # An appended part begins where the previous one ended.
            self._part_begins_s = self._last_s
            return
        named = _FIELD.fullmatch(line)
        if named is None or self._has_entries:
            return  # a remark; the header of the first part counts
        name, value = named[1], named[2].strip()
        if name == "baud_rate":
            if value.isascii() and value.isdigit() and len(value) < 9:
                self.header = replace(self.header, baud_rate=int(value))
        elif name in ("program", "port", "started"):
            self.header = replace(self.header, **{name: value})  # type: ignore[arg-type]

    def _plain(self, text: str, *, is_within: bool, goes_on: bool) -> list[CaptureEntry]:
        """Entries of hex text: the headers of frames tell the direction; noise counts as the module's."""
        try:
            if not is_within and not goes_on:
                raw = b"" if text.lstrip().startswith("#") else _bytes_of(text)
            else:
                raw = self._piece(text, is_within=is_within, goes_on=goes_on)
        except NotHex:
            self._hex = None
            self._fault(marked("no pairs of hex digits"))
            return []
        pieces = (self._parser.feed(raw[first : first + BYTES_A_LINE]) for first in range(0, len(raw), BYTES_A_LINE))
        return [_plain_entry(piece) for some in pieces for piece in some]

    def _piece(self, text: str, *, is_within: bool, goes_on: bool) -> bytes:
        """Bytes of a piece of a long line."""
        if not is_within:
            self._hex = None if text.lstrip().startswith("#") else HexText()
        if self._hex is None:
            return b""
        raw = self._hex.feed(text)
        if not goes_on:
            self._hex.finish()
        return raw

    def _fault(self, text: str) -> None:
        if len(self.faults) < MAX_FAULTS:
            self.faults.append(LineFault(self._number, text))


def _bytes_of(text: str) -> bytes:
    try:
        return bytes.fromhex(text)  # the usual form
    except ValueError:
        reader = HexText()
        raw = reader.feed(text)
        reader.finish()
        return raw


def _plain_entry(piece: Piece) -> CaptureEntry:
    is_ours = isinstance(piece, Frame) and piece.direction is Direction.HOST_TO_MODULE
    return CaptureEntry(piece.offset * BITS_PER_BYTE / DEFAULT_BAUD_RATE, Way.OUT if is_ours else Way.IN, piece.raw)
