"""Reads a table of time, attitude, acceleration, altitude and arming, as spreadsheets and loggers write one.

A line "sep=", lines of "#" and empty lines may come first, then the names of the columns, then perhaps their units.
Commas, semicolons or tabs part the cells. Every row counts: what is not read is said, and above 1 % refused.
"""

import csv
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from io import BytesIO, TextIOWrapper
from itertools import chain
from typing import Final, NamedTuple

import numpy as np

from app.flights.columns import ATTITUDES, FORCES, UNITS, CsvColumns, recognise, resolve
from app.flights.raw_log import (
    STANDARD_GRAVITY_M_S2,
    Channel,
    Floats,
    RawLog,
    force_of_axes,
    kept_apart,
    tilt_of_quaternion,
    tilt_of_roll_and_pitch,
    unreadable,
)
from app.recordings.excerpt import HEAD
from app.recordings.markers import STATE_LOST, Marker
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_COLUMNS: Final = 2000
MAX_BYTES: Final = 1 << 28
MAX_LINE_LENGTH: Final = 1 << 18
ROWS_AT_ONCE: Final = 5000
MAX_BAD_SHARE: Final = 0.01
LARGEST_STEP_BACK_S: Final = 1.0
_PARTERS: Final = "\t;,"
_FLAGS: Final = {
    "true": 1.0, "yes": 1.0, "on": 1.0, "armed": 1.0, "false": 0.0, "no": 0.0, "off": 0.0, "disarmed": 0.0,
}  # fmt: skip
_EMPTY: Final = frozenset(("", "null", "none"))
# How the characters of a number are read. An underscore, which Python takes for nothing, makes a cell no number.
_PLAIN: Final = str.maketrans({"_": "?"})
_DECIMAL: Final = str.maketrans({"_": "?", ",": ".", ".": ","})
_WITH_COMMA: Final = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
# Thousands, or three decimals.
_EITHER_COMMA: Final = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
# Signs of units in Windows' western encoding.
_SIGNS: Final = frozenset(b"\xb0\xb2\xb3\xb5\xa0")
_VALUES: Final[Mapping[tuple[str, ...], Callable[..., Floats]]] = {
    ATTITUDES[0]: np.abs,
    ATTITUDES[1]: tilt_of_quaternion,
    ATTITUDES[2]: tilt_of_roll_and_pitch,
    FORCES[0]: lambda length_m_s2: np.abs(length_m_s2) / STANDARD_GRAVITY_M_S2,
    FORCES[1]: force_of_axes,
}
"""The tilt in degrees, and the force in g, by the quantities of which they are computed."""
_RESETS: Final = {kind.value: kind for kind in STATE_LOST}


class UnreadTable(UserError):
    """A table that cannot be read as it is; with other columns perhaps it can. `head`: the names of its columns."""

    head: tuple[str, ...] = ()


def read_table(data: bytes, name: str, chosen: CsvColumns | None = None) -> RawLog:
    """`chosen`: columns by quantity, instead of those that are recognised. Raises `UserError`.

    The rows of an export of this program are reports of a module.
    """
    if len(data) > MAX_BYTES:
        raise unreadable(marked("too large"))
    encoding = encoding_of(data[: 1 << 16])
    text = TextIOWrapper(BytesIO(data), encoding, errors="replace").read()
    lines = text.replace("\0", "").split("\n")
    if max(map(len, lines)) > MAX_LINE_LENGTH:
        raise unreadable(marked("unknown kind of file"))
    head = read_head(lines)
    try:
        return _read_rows(lines, head, RawLog(name=name), chosen)
    except UserError as error:
        unread = UnreadTable(error.message)
        unread.head = tuple(head.names)
        raise unread from error


def encoding_of(start: bytes) -> str:
    """The encoding of a text by its first bytes."""
    if start.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    try:
        start.decode("utf-8")
    except UnicodeDecodeError as error:
        if len(start) - error.start > 3:  # not only a character that the end cuts
            return "cp1252" if {byte for byte in start if byte > 0x7F} <= _SIGNS else "gb18030"
    return "utf-8-sig"


class Head(NamedTuple):
    """How a table is written."""

    parter: str
    names: list[str]
    # Of each column, from a line of units; empty where unknown.
    units: list[str]
    # The index of the line of the first row.
    first_row: int

    @property
    def is_export(self) -> bool:
        """This program wrote it; its first column had another name before, and its last is the event."""
        return self.names[1:] == HEAD.split(",")[1:]


def read_head(lines: Sequence[str]) -> Head:
    """Raises `UserError`."""
    parter = line = ""
    first_row = 0
    for line in lines:
        first_row += 1
        text = line.strip().strip('"')
        if text.lower().startswith("sep=") and len(text) <= 5:
            parter = text[4:] or "\t"
        elif text and not text.startswith("#"):
            break
    parter = parter or _parter_of(line)
    names = _cells(line, parter)
    if not 2 <= len(names) <= MAX_COLUMNS or any(map(_is_value, names)):
        raise unreadable(marked("no column names in the first line"))
    units = [""] * len(names)
    words = [cell.strip(" []()").lower() for line in lines[first_row : first_row + 1] for cell in _cells(line, parter)]
    if any(word in UNITS for word in words) and not any(_is_value(word) or word in _FLAGS for word in words):
        units = [UNITS.get(word, "") for word in (*words, *units)][: len(names)]
        first_row += 1
    return Head(parter, names, units, first_row)


def _parter_of(line: str) -> str:
    """What parts a line into the most cells."""
    return max(_PARTERS, key=lambda parter: len(_cells(line, parter)))


def _cells(line: str, parter: str) -> list[str]:
    try:
        cells = next(csv.reader([line], delimiter=parter, skipinitialspace=True), [])
    except csv.Error:
        return []
    return [cell.strip() for cell in cells]


def _read_rows(lines: Sequence[str], head: Head, raw: RawLog, chosen: CsvColumns | None) -> RawLog:
    columns = recognise(head.names, head.units, chosen)
    rows = _Rows(head, columns)
    scaled = resolve(head.names, columns, rows.read(lines, raw))
    time_s = scaled["time"]
    known_s = time_s[np.isfinite(time_s)]
    if (np.diff(known_s) < -LARGEST_STEP_BACK_S).any():
        # What would be left out of it may be a flight that fires.
        raise unreadable(marked("its times begin again, as of several flights in one table"))
    if head.is_export and chosen is None:
        raw.is_of_module = True
        raw.resets = tuple(Marker(float(time_s[row]), _RESETS[word]) for row, word in rows.events if word in _RESETS)
        time_s = kept_apart(time_s)
    elif len(known_s):
        raw.span_s = float(known_s.min()), float(known_s.max())

    def channels(*choices: tuple[str, ...]) -> list[Channel]:
        """Without the rows in which a cell is empty."""
        found: list[Channel] = []
        for quantities in choices:
            if all(quantity in scaled for quantity in quantities):
                of = _VALUES.get(quantities, np.positive)(*(scaled[quantity] for quantity in quantities))
                found.append(Channel(time_s[~np.isnan(of)], of[~np.isnan(of)]))
        return found

    raw.tilts_deg, raw.forces_g = channels(*ATTITUDES), channels(*FORCES)
    raw.altitudes_m, raw.armed = channels(("altitude",)), channels(("armed",))
    return raw


class _Rows:
    """The columns that are used, by quantity."""

    def __init__(self, head: Head, columns: CsvColumns) -> None:
        self._head = head
        self._places = {quantity: head.names.index(name) for quantity, (name, _) in columns.items()}
        self._parts: dict[str, list[Floats]] = {quantity: [] for quantity in columns}
        self._has_decimal_commas = False
        # Of an export: the row of each event, and its word.
        self.events: list[tuple[int, str]] = []
        self._count = 0
        # Cells that are no numbers: how many, and the first of them with its line.
        self._bad_count = 0
        self._first_bad = (0, "")

    def read(self, lines: Sequence[str], raw: RawLog) -> dict[str, Floats]:
        """Raises `UserError`."""
        *whole, cut_off = lines[self._head.first_row :] or [""]
        if len(_cells(cut_off, self._head.parter)) >= len(self._head.names):
            whole.append(cut_off)
        elif cut_off.strip():
            raw.note(marked("cut off"))
        if any(line.startswith("#") for line in whole):
            whole = ["" if line.startswith("#") else line for line in whole]
        reader = csv.reader(whole, delimiter=self._head.parter, skipinitialspace=True)
        rows: list[list[str]] = []
        numbers: list[int] = []
        try:
            for row in reader:
                if row:
                    rows.append(row)
                    numbers.append(self._head.first_row + reader.line_num)
                if len(rows) == ROWS_AT_ONCE:
                    self._take(rows, numbers)
                    rows, numbers = [], []
        except csv.Error as error:
            raise unreadable(marked("unknown kind of file")) from error
        if rows:
            self._take(rows, numbers)
        if not self._count:
            raise unreadable(marked("no rows"))
        if self._bad_count:
            line, cell = self._first_bad
            text = marked("Cells that are no numbers: {count}, the first in line {line}: “{cell}”.")
            raw.note(text, count=self._bad_count, line=line, cell=clean(cell, longest=40))
            if self._bad_count > MAX_BAD_SHARE * self._count:
                raise UserError(raw.problems[-1])
        return {quantity: np.concatenate(parts) for quantity, parts in self._parts.items()}

    def _take(self, rows: list[list[str]], numbers: Sequence[int]) -> None:
        """`numbers`: of the line of each row."""
        width, needed = len(self._head.names), max(self._places.values()) + 1
        for number, row in zip(numbers, rows, strict=True):
            if len(row) > width and any(map(str.strip, row[width:])):
                text = marked(
                    "Line {line} has {cells} cells, the head {names}: perhaps there are commas in its numbers."
                )
                raise UserError(text, line=number, cells=len(row), names=width)
            if len(row) < needed:
                self._note_bad(number, "")
                row.extend([""] * (needed - len(row)))
        if self._head.is_export:
            words = [row[-1].partition(":")[0].strip().lower() for row in rows]
            self.events += enumerate(words, self._count)
        cells_of = {quantity: [row[place] for row in rows] for quantity, place in self._places.items()}
        if not self._count:
            self._has_decimal_commas = are_decimal(chain(*cells_of.values()))
        self._count += len(rows)
        for quantity, cells in cells_of.items():
            self._parts[quantity].append(self._read_cells(quantity, self._as_written_in_python(cells), cells, numbers))

    def _as_written_in_python(self, cells: Sequence[str]) -> Sequence[str]:
        if "" in cells:
            cells = [cell or "nan" for cell in cells]
        if self._has_decimal_commas:
            return "\n".join(cells).translate(_DECIMAL).split("\n")
        return "\n".join(cells).translate(_PLAIN).split("\n") if "_" in "".join(cells) else cells

    def _read_cells(self, quantity: str, plain: Sequence[str], cells: Sequence[str], numbers: Sequence[int]) -> Floats:
        """All at once, where all are numbers; else in halves, to find those that are none.

        `plain`: the cells as Python writes numbers.
        """
        try:
            return np.array(plain, np.float64)
        except ValueError:
            if len(plain) > 1:
                half = len(plain) // 2
                first = self._read_cells(quantity, plain[:half], cells[:half], numbers[:half])
                return np.concatenate((first, self._read_cells(quantity, plain[half:], cells[half:], numbers[half:])))
        word = cells[0].strip().lower()
        if word in _EMPTY:
            return np.array([np.nan])
        if quantity == "armed" and word in _FLAGS:
            return np.array([_FLAGS[word]])
        if quantity == "time" and seconds_of(cells[0]) is not None:
            return np.array([seconds_of(cells[0])])
        self._note_bad(numbers[0], cells[0])
        return np.array([np.nan])

    def _note_bad(self, line: int, cell: str) -> None:
        if not self._bad_count:
            self._first_bad = (line, cell)
        self._bad_count += 1


def _is_value(cell: str) -> bool:
    """A number or a time: no name of a column."""
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return seconds_of(cell) is not None


def are_decimal(cells: Iterable[str]) -> bool:
    """Whether commas in these cells are decimal ones. Raises `UserError` where they may be thousands."""
    with_comma = [cell for cell in cells if "," in cell and _WITH_COMMA.fullmatch(cell.strip())]
    if with_comma and all(_EITHER_COMMA.fullmatch(cell.strip()) for cell in with_comma):
        cell = with_comma[0]
        text = marked("“{cell}” can be {one} or {other}.")
        raise UserError(text, cell=cell, one=cell.replace(",", "."), other=cell.replace(",", ""))
    return bool(with_comma)


def seconds_of(cell: str) -> float | None:
    """Seconds since 1970 of an ISO time ("2026-05-01T12:00:00.5Z"); None for other text."""
    try:
        moment = datetime.fromisoformat(cell.strip())
    except ValueError:
        return None
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()
