"""Cells of a table as numbers: as spreadsheets, loggers and people write them. What is not certain is not a number."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import Enum, auto
from typing import Final

from app.text.messages import UserMessage, clean, message
from app.text.user_error import UserError
from protocol.translatable import marked

UNITS: Final[Mapping[str, str]] = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "ms": "ms", "msec": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "usec": "us", "microseconds": "us", "ns": "ns", "nanoseconds": "ns",
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad", "radian": "rad", "radians": "rad",
    "g": "g", "m/s²": "m_s2", "m/s^2": "m_s2", "m/s2": "m_s2", "m/s/s": "m_s2", "m_s2": "m_s2", "m/s**2": "m_s2",
    "m": "m", "meter": "m", "meters": "m", "metres": "m",
}  # fmt: skip
"""Units as they are written, and as the names of the roles end."""
FLAGS: Final[Mapping[str, float]] = {
    "true": 1.0, "yes": 1.0, "on": 1.0, "armed": 1.0, "false": 0.0, "no": 0.0, "off": 0.0, "disarmed": 0.0,
}  # fmt: skip
_EMPTY: Final = frozenset(("", "nan", "null", "none"))
"""Cells that say that there is no value."""
_EXPONENT: Final = r"(?:[eE][+-]?\d+)?"
_GROUP: Final = "['\u2019 \u00a0\u202f]"
"""What parts thousands in any notation."""
_WITH_UNIT: Final = re.compile(
    r"(?P<number>[+-]?[\d.,'\u2019 \u00a0\u202f]*\d\.?(?:[eE][+-]?\d+)?)\s*(?P<unit>[^\d\s].*)"
)
_COMMA_DECIMAL: Final = re.compile(
    rf"[+-]?(?:\d+|\d{{1,3}}(?:[.]\d{{3}})+|\d{{1,3}}(?:{_GROUP}\d{{3}})+)?,\d+{_EXPONENT}"
)
_COMMA_THOUSANDS: Final = re.compile(rf"[+-]?\d{{1,3}}(?:,\d{{3}})+(?:\.\d*)?{_EXPONENT}")
_POINT_THOUSANDS: Final = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+")
_OTHER_THOUSANDS: Final = re.compile(rf"[+-]?\d{{1,3}}(?:{_GROUP}\d{{3}})+(?:\.\d*)?{_EXPONENT}")
_ONE_COMMA: Final = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""Thousands, or three decimals."""
_INTEGER: Final = re.compile(rf"[+-]?\d+{_EXPONENT}")
_CLOCK: Final = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:\.\d+)?)")
_DATED: Final = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}.*")


class Commas(Enum):
    """What a comma within a number means."""

    UNKNOWN = auto()
    """No cell told yet."""
    DECIMAL = auto()
    THOUSANDS = auto()


@dataclass(slots=True)
class CommaEvidence:
    """What the cells of a table tell of its commas; each has the first such cell."""

    decimal: str = ""
    thousands: str = ""
    either: str = ""

    def note(self, cell: str) -> None:
        if _ONE_COMMA.fullmatch(cell):
            self.either = self.either or cell
        elif _COMMA_THOUSANDS.fullmatch(cell) and not cell.lstrip("+-").startswith("0"):
            self.thousands = self.thousands or cell
        elif _COMMA_DECIMAL.fullmatch(cell):
            self.decimal = self.decimal or cell

    def commas(self) -> Commas:
        """Raises `UserError` where the cells contradict each other, or do not tell."""
        if self.decimal and self.thousands:
            text = marked("“{one}” and “{other}”: a comma means two things.")
            raise UserError(text, one=clean(self.decimal, longest=30), other=clean(self.thousands, longest=30))
        if self.either and not self.decimal and not self.thousands:
            point, plain = self.either.replace(",", "."), self.either.replace(",", "")
            raise UserError(marked("“{cell}” can be {one} or {other}."), cell=self.either, one=point, other=plain)
        if self.decimal:
            return Commas.DECIMAL
        return Commas.THOUSANDS if self.thousands else Commas.UNKNOWN


def number_of(cell: str, commas: Commas, unit: str = "") -> float | None:
    """The number in a cell, NaN in an empty one; None where it is not certainly a number.

    `unit`: which all cells of the column have behind the number.
    """
    text = cell.strip()
    if text.lower() in _EMPTY:
        return math.nan
    if unit:
        match = _WITH_UNIT.fullmatch(text)
        if match is not None:
            if UNITS.get(match["unit"].strip().lower()) != unit:
                return None
            text = match["number"].strip()
    plain = _plain(text, commas)
    try:
        return None if plain is None else float(plain)
    except ValueError:
        return None


def _plain(text: str, commas: Commas) -> str | None:
    """The number as Python writes it."""
    if commas is Commas.DECIMAL:
        if _COMMA_DECIMAL.fullmatch(text):
            return re.sub(rf"[.]|{_GROUP}", "", text).replace(",", ".")
        if _POINT_THOUSANDS.fullmatch(text):
            return text.replace(".", "")
        return text if _INTEGER.fullmatch(text) else None
    if _OTHER_THOUSANDS.fullmatch(text):
        return re.sub(_GROUP, "", text)
    if "," in text:
        return text.replace(",", "") if commas is Commas.THOUSANDS and _COMMA_THOUSANDS.fullmatch(text) else None
    return None if "_" in text else text


def unit_of(cell: str) -> str:
    """The unit behind the number in a cell, as roles end; empty without one, or with one that is unknown."""
    match = _WITH_UNIT.fullmatch(cell.strip())
    return "" if match is None else UNITS.get(match["unit"].strip().lower(), "")


def seconds_of(cell: str) -> float | None:
    """Seconds of an ISO time ("2026-05-01T12:00:00.5Z") or of a time of day ("12:00:00.5"); None for other text."""
    text = cell.strip()
    clock = _CLOCK.fullmatch(text)
    if clock is not None:
        return int(clock[1]) * 3600 + int(clock[2]) * 60 + float(clock[3])
    if not _DATED.fullmatch(text):
        return None
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()


@dataclass(slots=True)
class BadCells:
    """Cells that are no numbers: counted, with the first of them."""

    count: int = 0
    line: int = 0
    cell: str = ""

    def note(self, line: int, cell: str) -> None:
        if not self.count:
            self.line, self.cell = line, cell
        self.count += 1

    def message(self) -> UserMessage:
        return message(
            marked("Cells that are no numbers: {count}, the first in line {line}: “{cell}”."),
            count=self.count, line=self.line, cell=clean(self.cell, longest=40),
        )  # fmt: skip
