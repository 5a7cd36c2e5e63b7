"""Reads a table of time, attitude, acceleration, altitude and arming, as spreadsheets and loggers write one.

A line "sep=", lines of "#" and empty lines may come first, then the names of the columns, then perhaps their units.
Commas, semicolons, tabs or bars part the cells. Every row counts: what is not read is said, and above 1 % refused.
"""

import csv
import os
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TextIO

import numpy as np

from app.flights.assembly import assembled, flight_of_reports
from app.flights.cells import FLAGS, UNITS, BadCells, CommaEvidence, Commas, number_of, seconds_of, unit_of
from app.flights.columns import ATTITUDES, FORCES, TIMES, CsvColumns, CsvRole, Recognised
from app.flights.flight_log import NO_PROGRESS, FlightLog, Floats, Progress, unreadable
from app.flights.raw_log import Channel, FlagChannel, RawLog
from app.recordings.excerpt import HEAD
from app.recordings.markers import STATE_LOST, Marker
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_COLUMNS: Final = 2000
MAX_CELLS: Final = 100_000_000
MAX_LINE_LENGTH: Final = 256 * 1024
MAX_LINES_BEFORE: Final = 1000
"""Of comments and empty lines."""
ROWS_AT_ONCE: Final = 5000
"""Read in about 20 ms: how often progress is reported."""
MAX_BAD_SHARE: Final = 0.01
PAUSE_S: Final = 1.0
"""Between the flights of one table: longer than what is judged across."""
_PARTERS: Final = "\t;,|"
_COUNTER: Final = 2.0**32
"""At which counters of microseconds and milliseconds begin again."""
_SIGNS: Final = frozenset(b"\xb0\xb2\xb3\xb5\xa0")
"""Signs of units in Windows' western encoding."""
_RESETS: Final = {kind: float(number) for number, kind in enumerate(STATE_LOST, start=1)}
_EVENTS: Final = {kind.value: number for kind, number in _RESETS.items()}
_EXPORTED: Final = HEAD.split(",")[1:]
"""The columns of an export of this program behind the first one, which had another name before; "event" is the last."""
_EVENT: Final = _EXPORTED[-1]


def encoding_of(start: bytes) -> str:
    """The encoding of a text by its first bytes: with a mark, by its zeros, or by what can be decoded."""
    if start.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if len(start) > 3 and not any(start[1:64:2]):
        return "utf-16-le"
    if len(start) > 3 and not any(start[0:64:2]):
        return "utf-16-be"
    try:
        start.decode("utf-8")
    except UnicodeDecodeError as error:
        if len(start) - error.start > 3:  # not only a character that the end cuts
            high = {byte for byte in start if byte > 0x7F}
            return "cp1252" if high <= _SIGNS else "gb18030"
    return "utf-8-sig"


@dataclass(slots=True, kw_only=True)
class Dialect:
    """How the table is written, found from its first lines."""

    encoding: str
    parter: str
    head: list[str]
    units: list[str]
    """Of each column, from a line of units or from the first cells; empty where unknown."""
    has_cell_units: list[bool]
    first_row: int
    """Number of the line of the first row, from 1."""


def read_dialect(path: Path) -> Dialect:
    """Raises `UserError`, OSError."""
    with path.open("rb") as file:
        encoding = encoding_of(file.read(1 << 16))
    with path.open("r", encoding=encoding, errors="replace", newline="") as file:
        parter = comment = ""
        number = 0
        while number < MAX_LINES_BEFORE:
            line = file.readline(MAX_LINE_LENGTH)
            number += 1
            text = line.strip().strip('"')
            if not line:
                break
            if text.lower().startswith("sep=") and len(text) == 5:
                parter = text[4]
            elif text.startswith("#"):
                comment = text.lstrip("# ")
            elif text or "\t" in line:
                break
        if line.lower().startswith("sep=\t"):
            parter, line = "\t", file.readline(MAX_LINE_LENGTH)
            number += 1
        parter = parter or _parter_of(line)
        head, first_row = _cells(line, parter), number + 1
        if any(map(_is_value, head)) and comment:
            # The names stand in the last comment, as numpy writes them.
            parter = _parter_of(comment)
            head, first_row = _cells(comment, parter), number
            rows = [_cells(line, parter)]
        else:
            rows = []
        if not 2 <= len(head) <= MAX_COLUMNS or any(map(_is_value, head)):
            raise unreadable(marked("no column names in the first line"))
        rows += [_cells(file.readline(MAX_LINE_LENGTH), parter) for _ in range(2)]
    units = [""] * len(head)
    if _is_line_of_units(rows[0]):
        units = [UNITS.get(cell.strip(" []()").lower(), "") for cell in (rows[0] + units)[: len(head)]]
        first_row += 1
        rows.pop(0)
    in_cells = [unit_of(cell) for cell in (rows[0] + [""] * len(head))[: len(head)]]
    both = zip(units, in_cells, strict=True)
    if any(unit and in_cell and unit != in_cell for unit, in_cell in both):
        raise unreadable(marked("the line of units and the cells contradict each other"))
    return Dialect(
        encoding=encoding, parter=parter, head=head, first_row=first_row,
        units=[unit or in_cell for unit, in_cell in zip(units, in_cells, strict=True)],
        has_cell_units=[bool(in_cell) for in_cell in in_cells],
    )  # fmt: skip


def _parter_of(line: str) -> str:
    """What parts a line into the most cells."""
    return max(_PARTERS, key=lambda parter: len(_cells(line, parter)))


def _cells(line: str, parter: str) -> list[str]:
    try:
        cells = next(csv.reader([line], delimiter=parter, skipinitialspace=True), [])
    except csv.Error:
        return []
    return [cell.strip() for cell in cells]


def _is_value(cell: str) -> bool:
    """A number, with or without a unit, or a time: no name of a column."""
    number = number_of(cell, Commas.UNKNOWN, unit_of(cell))
    return (number is not None and np.isfinite(number)) or seconds_of(cell) is not None


def _is_line_of_units(cells: Sequence[str]) -> bool:
    words = [cell.strip(" []()").lower() for cell in cells]
    return any(word in UNITS for word in words) and not any(map(_is_value, cells)) and not any(
        word in FLAGS for word in words
    )  # fmt: skip


ReadWord = Callable[[str], float | None]
_WORDS_OF: Final[Mapping[str, ReadWord]] = {
    "time": seconds_of,
    "armed": lambda cell: FLAGS.get(cell.lower()),
}
"""How a cell of a quantity is read that is no number."""


class _Rows:
    """The numbers of some columns, read with one meaning of commas."""

    def __init__(
        self, path: Path, dialect: Dialect, recognised: Recognised, names: Sequence[str], event: str | None
    ) -> None:
        self._path, self._dialect = path, dialect
        self._places = [dialect.head.index(name) for name in names]
        self._reads = [_WORDS_OF.get(recognised.quantity_of(name)) for name in names]
        self._units = [dialect.units[place] if dialect.has_cell_units[place] else "" for place in self._places]
        self._event = -1 if event is None else dialect.head.index(event)
        self._cells = array("d")
        self.count = 0
        self.evidence = CommaEvidence()
        self.bad = BadCells()
        self.is_cut_off = False

    def read(self, commas: Commas, on_progress: Progress) -> list[Floats]:
        """NaN for a cell that is empty or no number; the events of an export come last. Raises `UserError`, OSError."""
        dialect = self._dialect
        with self._path.open("r", encoding=dialect.encoding, errors="replace", newline="") as opened:
            file: TextIO = opened
            for _ in range(dialect.first_row - 1):
                file.readline(MAX_LINE_LENGTH)
            size = max(os.fstat(file.fileno()).st_size, 1)
            reader = csv.reader(self._lines(file), delimiter=dialect.parter, skipinitialspace=True)
            try:
                for row in reader:
                    if self.count % ROWS_AT_ONCE == 0:
                        on_progress(min(file.buffer.tell() / size, 1.0))
                    if row:
                        self._take(row, dialect.first_row + reader.line_num - 1, commas)
            except csv.Error as error:
                raise unreadable(marked("unknown kind of file")) from error
        width = len(self._places) + (self._event >= 0)
        return list(np.frombuffer(self._cells).reshape(-1, width).T)

    def _lines(self, file: TextIO) -> Iterator[str]:
        """Without comments, and without a last line that was cut off."""
        while line := file.readline(MAX_LINE_LENGTH):
            if line.startswith("#"):
                yield "\n"  # so that the numbers of the lines stay
                continue
            if not line.endswith(("\n", "\r")) and len(_cells(line, self._dialect.parter)) < len(self._dialect.head):
                self.is_cut_off = True
                return
            yield line.replace("\0", "")

    def _take(self, row: list[str], line: int, commas: Commas) -> None:
        if len(row) > len(self._dialect.head) and any(map(str.strip, row[len(self._dialect.head) :])):
            raise UserError(
                marked("Line {line} has {cells} cells, the head {names}: perhaps there are commas in its numbers."),
                line=line, cells=len(row), names=len(self._dialect.head),
            )  # fmt: skip
        self.count += 1
        if len(self._cells) > MAX_CELLS:
            raise unreadable(marked("too large"))
        if commas is not Commas.DECIMAL and self._event < 0 and "_" not in "".join(row):
            try:  # as most rows are
                self._cells.extend([float(row[place]) for place in self._places])
                return
            except (ValueError, IndexError):
                pass
        for place, unit, read_word in zip(self._places, self._units, self._reads, strict=True):
            if place < len(row):
                self._cells.append(self._number(row[place], unit, read_word, line, commas))
            else:
                self._cells.append(np.nan)
                self.bad.note(line, "")
        if self._event >= 0:
            word = row[self._event].partition(":")[0].strip().lower() if self._event < len(row) else ""
            self._cells.append(_EVENTS.get(word, np.nan))

    def _number(self, cell: str, unit: str, read_word: ReadWord | None, line: int, commas: Commas) -> float:
        number = number_of(cell, commas, unit)
        if number is None and read_word is not None:
            number = read_word(cell.strip())
        if number is None:
            self.evidence.note(cell.strip())
            self.bad.note(line, cell)
            return np.nan
        return number


def read_table(path: Path, chosen: CsvColumns | None = None, on_progress: Progress = NO_PROGRESS) -> FlightLog:
    """`chosen`: columns by role, instead of those that are recognised. Raises `UserError`, OSError, and what
    `on_progress` raises.

    An export of this program is read report by report; any other table is resampled at the module's report rate.
    """
    dialect = read_dialect(path)
    recognised = Recognised(dialect.head, dialect.units, chosen)
    is_export = chosen is None and dialect.head[1:] == _EXPORTED
    names = list(dict.fromkeys((*recognised.names.values(), *recognised.bare.values())))
    if not names:
        raise recognised.refusal_of_time()
    event = _EVENT if is_export else None
    rows = _Rows(path, dialect, recognised, names, event)
    numbers = rows.read(Commas.UNKNOWN, on_progress)
    commas = rows.evidence.commas()
    if commas is not Commas.UNKNOWN:
        rows = _Rows(path, dialect, recognised, names, event)
        numbers = rows.read(commas, on_progress)
    if not rows.count:
        raise unreadable(marked("no rows"))
    problems = []
    if rows.bad.count:
        if rows.bad.count > MAX_BAD_SHARE * rows.count:
            raise UserError(rows.bad.message())
        problems.append(rows.bad.message())
    if rows.is_cut_off:
        problems.append(message(marked("cut off")))
    values = dict(zip(names, numbers, strict=False))
    for name in (recognised.bare.get("time"), *(recognised.names.get(role) for role in TIMES)):
        if name is not None:
            values[name] = _without_wraps(values[name])
    columns = recognised.resolve(values)
    raw = RawLog(name=str(path), problems=problems)
    scaled = [values[columns.names[role]] * scale for role, scale in TIMES.items() if role in columns.names]
    time_s, raw.joins_s = _one_after_the_other(scaled[0])
    if is_export:
        return _export(raw, columns, values, time_s, numbers[-1])
    _fill(raw, columns, values, time_s)
    return assembled(raw)


def _export(raw: RawLog, columns: CsvColumns, values: dict[str, Floats], time_s: Floats, events: Floats) -> FlightLog:
    """A table that this program wrote: each row with both values is a report of the module."""
    tilt_deg = values[columns.names[CsvRole.TILT_DEG]]
    force_g = values[columns.names[CsvRole.ACCELERATION_G]]
    is_report = ~(np.isnan(tilt_deg) | np.isnan(force_g))
    resets = [Marker(at_s, kind) for kind, number in _RESETS.items() for at_s in time_s[events == number]]
    resets.sort(key=lambda reset: reset.time_s)
    return flight_of_reports(
        raw.name, time_s[is_report], tilt_deg[is_report], force_g[is_report], raw.problems, resets, joins_s=raw.joins_s
    )


def _fill(raw: RawLog, columns: CsvColumns, values: dict[str, Floats], time_s: Floats) -> None:
    def of(roles: Sequence[CsvRole]) -> list[Floats]:
        return [values[columns.names[role]] for role in roles]

    known_s = time_s[np.isfinite(time_s)]
    if len(known_s):
        raw.span_s = float(known_s.min()), float(known_s.max())
    if columns.attitude:
        raw.tilts_deg.append(_known(time_s, ATTITUDES[columns.attitude](*of(columns.attitude))))
    if columns.force:
        raw.forces_g.append(_known(time_s, FORCES[columns.force](*of(columns.force))))
    if CsvRole.ALTITUDE_M in columns.names:
        raw.altitude_m = _known(time_s, *of([CsvRole.ALTITUDE_M]))
    if CsvRole.ARMED in columns.names:
        known = _known(time_s, *of([CsvRole.ARMED]))
        raw.armed = FlagChannel(known.time_s, known.values != 0)


def _known(time_s: Floats, values: Floats) -> Channel:
    """Without the rows in which the cell is empty."""
    is_known = ~np.isnan(values)
    return Channel(time_s[is_known], values[is_known])


def _without_wraps(values: Floats) -> Floats:
    """A counter of 32 bits that begins again goes on."""
    known = values[np.isfinite(values)]
    if not len(known) or known.min() < 0 or known.max() >= _COUNTER:
        return values
    wraps = np.cumsum(np.diff(known, prepend=known[:1]) < -0.9 * _COUNTER)
    unwrapped = values.copy()
    unwrapped[np.isfinite(values)] = known + wraps * _COUNTER
    return unwrapped


def _one_after_the_other(time_s: Floats) -> tuple[Floats, Floats]:
    """The times of each flight in the table begin again: here it follows the one before, after a pause.

    Also returns the times at which another flight begins.
    """
    shifted = time_s.copy()
    rows = np.flatnonzero(np.isfinite(time_s))
    known_s = time_s[rows]
    begins = np.flatnonzero((np.diff(known_s, prepend=known_s[:1]) < 0) & (known_s <= known_s[:1]))
    if len(begins):
        ends_s = np.maximum.reduceat(known_s, [0, *begins])
        shifts_s = np.cumsum(ends_s[:-1] + PAUSE_S - known_s[begins])
        shifted[rows] += np.concatenate(((0.0,), shifts_s))[np.searchsorted(begins, np.arange(len(rows)), "right")]
    return shifted, shifted[rows[begins]]
