"""Surveys a capture file before it is read whole: format and duration."""

import re
from collections.abc import Iterator, Sequence
from typing import BinaryIO, Final

from protocol.catalogue import DEFAULT_BAUD_RATE

BITS_PER_BYTE: Final = 10
MAX_LINE_LENGTH: Final = 64 * 1024
MAGIC_LINE: Final = re.compile(r"#\s*DPS-S capture\s+(\d+)\s*")
ENTRY_LINE: Final = re.compile(r"(\d{1,12}(?:\.\d{1,9})?)\s+([<>])\s*(.*)")
_BLOCK_BYTES: Final = 256 * 1024
_NAME: Final = b"DPS-S capture"
_MAX_LINES: Final = 50
"""Lines at the end of a block or part that are searched for the last time."""
_FILLING: Final = b" \t\r\n,"


class CaptureProbe:
    """Format and duration of a capture, found without parsing most of its lines, which is 100 times faster."""

    def __init__(self) -> None:
        self.is_plain = True
        """None of the examined lines looks like one of a capture."""
        self._ended_parts_s = 0.0
        self._part_s = 0.0
        self._digits = 0

    @property
    def duration_s(self) -> float:
        """Exact for an undamaged capture, else approximate."""
        if self.is_plain:
            return self._digits / 2 * BITS_PER_BYTE / DEFAULT_BAUD_RATE
        return self._ended_parts_s + self._part_s

    def steps(self, file: BinaryIO) -> Iterator[None]:
        """Survey one block per step. Raises OSError."""
        rest = b""
        while block := file.read(_BLOCK_BYTES):
            text = rest + block
            end = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
            self._probe_lines(text[:end])
            rest = text[end:][:MAX_LINE_LENGTH]  # a longer line is no entry
            yield
        self._probe_lines(rest)

    def _probe_lines(self, text: bytes) -> None:
        """Examine whole lines."""
        has_name = _NAME in text
        if self.is_plain and not has_name and b"<" not in text and b">" not in text:
            self._digits += len(text.translate(None, _FILLING))
            return
        lines = text.splitlines()
        begins = 0
        for number, line in enumerate(lines) if has_name else ():
            if _NAME in line and MAGIC_LINE.fullmatch(_decoded(line)):
                self._find_time(lines[begins:number])
                self.is_plain = False
                self._ended_parts_s += self._part_s
                self._part_s = 0.0
                begins = number + 1
        self._find_time(lines[begins:])

    def _find_time(self, lines: Sequence[bytes]) -> None:
        """Find the last time; in all lines until one is of a capture."""
        examined = lines if self.is_plain else lines[-_MAX_LINES:]
        for line in reversed(examined):
            entry = ENTRY_LINE.fullmatch(_decoded(line)) if b"<" in line or b">" in line else None
            if entry is not None:
                self.is_plain = False
                self._part_s = max(self._part_s, float(entry[1]))
                return


def _decoded(line: bytes) -> str:
    return line.decode("utf-8-sig", errors="replace").strip()
