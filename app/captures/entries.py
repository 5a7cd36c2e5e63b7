"""Entries of a capture."""

from enum import Enum
from typing import NamedTuple


class Way(Enum):
    """Direction of bytes on the line. The value is the character in the file."""

    OUT = ">"
    IN = "<"


class CaptureEntry(NamedTuple):
    """Bytes that were sent or received together. `at_s`: seconds since the capture began."""

    at_s: float
    way: Way
    raw: bytes
