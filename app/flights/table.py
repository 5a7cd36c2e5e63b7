"""Reads a table of time, attitude, acceleration, altitude and arming, as spreadsheets and loggers write one.

A line "sep=", lines of "#" and empty lines may come first, then the names of the columns, then perhaps their units.
Commas, semicolons or tabs part the cells. Every row counts: what is not read is said, and above 1 % refused.

A column is chosen by a person, or recognised by its name. A name with its unit is taken at its word. A bare name, such
as "timestamp", gets the one unit that is plausible for a flight; where none is, or more than one, the table is refused
with its columns and what to say. Nothing is guessed.
"""

import csv
import math
import re
import shlex
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from io import BytesIO, TextIOWrapper
from itertools import chain, islice
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import (
    LONGEST_LOG_S,
    SHORTEST_LOG_S,
    STANDARD_GRAVITY_M_S2,
    TIME,
    Channel,
    ChannelSource,
    Floats,
    RawLog,
    channels_of,
    force_of_axes,
    tilt_of_quaternion,
    tilt_of_roll_and_pitch,
    unreadable,
)
from app.text.messages import UserError, UserMessage, clean, message
from protocol.translatable import marked

# What a column can hold, and what makes seconds, degrees, m/s² and metres of its units. "acceleration" is the length
# of x, y and z.
_ANGLES: Final = {"deg": 1.0, "rad": 180 / np.pi}
_FORCES: Final = {"g": STANDARD_GRAVITY_M_S2, "m_s2": 1.0}
QUANTITIES: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "tilt": _ANGLES, "roll": _ANGLES, "pitch": _ANGLES,
    "qw": {"": 1.0}, "qx": {"": 1.0}, "qy": {"": 1.0}, "qz": {"": 1.0},
    "acceleration": _FORCES, "x": _FORCES, "y": _FORCES, "z": _FORCES,
    "altitude": {"m": 1.0},
    "armed": {"": 1.0},
}  # fmt: skip
_TABLE: Final = "rows"
# From which quantities the tilt in degrees and the force in g can be computed, and how. Of each the first is used whose
# columns are all there, before others what a person chose, and what has its units.
_TILTS: Final = (
    ChannelSource(_TABLE, ("tilt",), np.abs),
    ChannelSource(_TABLE, ("qw", "qx", "qy", "qz"), tilt_of_quaternion),
    ChannelSource(_TABLE, ("roll", "pitch"), tilt_of_roll_and_pitch),
)
_FORCES_G: Final = (
    ChannelSource(_TABLE, ("acceleration",), lambda length_m_s2: np.abs(length_m_s2) / STANDARD_GRAVITY_M_S2),
    ChannelSource(_TABLE, ("x", "y", "z"), force_of_axes),
)
_ALTITUDES: Final = (ChannelSource(_TABLE, ("altitude",)),)
_ARMING: Final = (ChannelSource(_TABLE, ("armed",)),)
# The word of a role on the command line, such as "time_ms".
_ROLES: Final = {
    f"{quantity}_{unit}".rstrip("_"): (quantity, unit) for quantity, units in QUANTITIES.items() for unit in units
}
# How names begin, in front of the unit, if any.
_NAMES: Final = {quantity: quantity for quantity in QUANTITIES} | {
    "timestamp": "time", "elapsed": "time", "t": "time", "q[0]": "qw", "q[1]": "qx", "q[2]": "qy", "q[3]": "qz",
    "acc_x": "x", "acc_y": "y", "acc_z": "z", "accx": "x", "accy": "y", "accz": "z", "ax": "x", "ay": "y", "az": "z",
    "accelerometer_m_s2[0]": "x", "accelerometer_m_s2[1]": "y", "accelerometer_m_s2[2]": "z",
}  # fmt: skip
# Units as they are written, and as roles end.
_UNITS: Final = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "ms": "ms", "msec": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "usec": "us", "microseconds": "us", "ns": "ns", "nanoseconds": "ns",
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad", "radian": "rad", "radians": "rad",
    "g": "g", "m/s²": "m_s2", "m/s^2": "m_s2", "m/s2": "m_s2", "m/s/s": "m_s2", "m_s2": "m_s2", "m/s**2": "m_s2",
    "m": "m", "meter": "m", "meters": "m", "metres": "m",
}  # fmt: skip


class CsvColumn(NamedTuple):
    name: str
    # As roles end; None for a bare name.
    unit: str | None


# By quantity.
CsvColumns = Mapping[str, CsvColumn]


class UnreadTable(UserError):
    """A table that cannot be read as it is; with other columns perhaps it can. `head`: the names of its columns."""

    head: tuple[str, ...] = ()


def role_words(columns: CsvColumns) -> list[str]:
    """Return the columns as they are typed: "roll_deg=ATT.Roll"."""
    return [f"{quantity}_{unit}={name}" if unit else f"{quantity}={name}" for quantity, (name, unit) in columns.items()]


def parse_choice(words: Iterable[str]) -> CsvColumns:
    """Parses words such as `roll_deg=ATT.Roll`. Raises `UserError`."""
    chosen: dict[str, CsvColumn] = {}
    for word in words:
        role, _, name = word.partition("=")
        if role not in _ROLES or not name:
            text = marked("“{word}”: ROLE=COLUMN is needed, of {roles}.")
            raise UserError(text, word=clean(word, longest=60), roles=", ".join(_ROLES))
        quantity, unit = _ROLES[role]
        if quantity in chosen:
            raise UserError(marked("Choose one column for “{quantity}”."), quantity=quantity)
        chosen[quantity] = CsvColumn(name, unit)
    return chosen


def parse_line(line: str) -> CsvColumns:
    """Parses one line as on the command line, with or without `--column`. Raises `UserError`."""
    try:
        words = shlex.split(line)
    except ValueError:  # a quote without its end
        words = line.split()
    return parse_choice(word for word in words if word != "--column")


# How a table is written

_MAX_BYTES: Final = 1 << 28
_MAX_LINE_LENGTH: Final = 1 << 18
_PARTERS: Final = "\t;,"
_FLAGS: Final = {"true": 1.0, "yes": 1.0, "on": 1.0, "armed": 1.0, "false": 0.0, "no": 0.0, "off": 0.0, "disarmed": 0.0}
# Signs of units in Windows' western encoding.
_SIGNS: Final = frozenset(b"\xb0\xb2\xb3\xb5\xa0")


class Head(NamedTuple):
    parter: str
    names: list[str]
    # Of each column, from a line of units; empty where unknown.
    units: list[str]
    # The index of the line of the first row.
    first_row: int


def read_table(data: bytes, chosen: CsvColumns | None) -> RawLog:
    """`chosen`: columns by quantity, instead of those that are recognised. Raises `UserError`."""
    if len(data) > _MAX_BYTES:
        raise unreadable(marked("too large"))
    head = _head_of(_lines_of(data))
    raw = RawLog()
    try:
        columns = _recognised(head, chosen or {})
        lines = islice(_lines_of(data), head.first_row, None)
        scaled = _in_units(head, columns, _read_rows(lines, head, columns, raw))
        time_s = scaled["time"]
        known_s = time_s[np.isfinite(time_s)]
        if (np.diff(known_s) < -1.0).any():
            # What would be left out of it may be a flight that fires.
            raise unreadable(marked("its times begin again, as of several flights in one table"))
    except UserError as error:
        unread = UnreadTable(error.message)
        unread.head = tuple(head.names)
        raise unread from error
    if len(known_s):
        raw.span_s = float(known_s.min()), float(known_s.max())

    def channels(sources: Iterable[ChannelSource]) -> list[Channel]:
        found = channels_of({_TABLE: [scaled]}, sources)
        # A row may be without a cell of a column.
        return [Channel(time_s[~np.isnan(values)], values[~np.isnan(values)]) for _, values in found]

    raw.tilts_deg, raw.forces_g = channels(_TILTS), channels(_FORCES_G)
    raw.altitudes_m, raw.armed = channels(_ALTITUDES), channels(_ARMING)
    return raw


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


def _lines_of(data: bytes) -> Iterator[str]:
    """Yields each line with its end, which a line that was cut off has not. Raises `UserError`.

    All of a large file at once would hold the interpreter, and with it the thread of the port, until the conversation
    with the module is over.
    """
    with TextIOWrapper(BytesIO(data), encoding_of(data[: 1 << 16]), errors="replace") as text:
        while line := text.readline(_MAX_LINE_LENGTH + 1):
            if len(line) > _MAX_LINE_LENGTH:
                raise unreadable(marked("unknown kind of file"))
            yield line.replace("\0", "")


def _head_of(lines: Iterator[str]) -> Head:
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
    # Else what parts the line into the most cells.
    parter = parter or max(_PARTERS, key=lambda one: len(_cells(line, one)))
    names = _cells(line, parter)
    if len(names) < 2 or any(map(_is_value, names)):
        raise unreadable(marked("no column names in the first line"))
    units = [""] * len(names)
    words = [cell.strip(" []()").lower() for line in islice(lines, 1) for cell in _cells(line, parter)]
    if any(word in _UNITS for word in words) and not any(_is_value(word) or word in _FLAGS for word in words):
        units = [_UNITS.get(word, "") for word in (*words, *units)][: len(names)]
        first_row += 1
    return Head(parter, names, units, first_row)


def _cells(line: str, parter: str) -> list[str]:
    try:
        cells = next(csv.reader([line], delimiter=parter, skipinitialspace=True), [])
    except csv.Error:
        return []
    return [cell.strip() for cell in cells]


def _is_value(cell: str) -> bool:
    """A number or a time: no name of a column."""
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return _seconds_of(cell) is not None


def _seconds_of(cell: str) -> float | None:
    """Seconds since 1970 of an ISO time ("2026-05-01T12:00:00.5Z"); None for other text."""
    try:
        moment = datetime.fromisoformat(cell.strip())
    except ValueError:
        return None
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()


# Which columns hold what, and in which unit

# The quantities of which those without a unit have the same one.
_MEASURED_TOGETHER: Final = (("time",), ("tilt", "roll", "pitch"), ("acceleration", "x", "y", "z"))
# Steps that a log may have. Where more than one unit fits, only one may make a flight of up to `_USUAL_LENGTH_S`.
_STEPS_S: Final = (0.0005, 60.0)
_USUAL_LENGTH_S: Final = 4 * 3600.0
_LARGEST_DEG: Final = 180.5
_TURN_DEG: Final = 360.0
_REST_M_S2: Final = (8.0, 12.0)
_MIN_REST: Final = 0.05
_SHOCK_M_S2: Final = 60.0
_MAX_SHOCKS: Final = 0.1


def _recognised(head: Head, by_person: CsvColumns) -> CsvColumns:
    """The columns that are used, some of them still without a unit.

    Raises `UserError` where a column that is used is not there, or twice, or has another unit than is said.
    """
    known = dict(by_person)
    # Where a quantity has several columns, the first one with a unit counts.
    for quantity, column in sorted(map(_meaning, head.names, head.units), key=lambda one: one[1].unit is None):
        known.setdefault(quantity, column)
    used = {TIME: known[TIME]} if TIME in known else {}
    for sources in (_TILTS, _FORCES_G, _ALTITUDES, _ARMING):
        whole = [source.columns for source in sources if known.keys() >= set(source.columns)]
        whole.sort(key=lambda choice: any(known[quantity].unit is None for quantity in choice))
        whole.sort(key=by_person.keys().isdisjoint)
        # What is not needed must not make the table unreadable, such as a second attitude with bad cells.
        used.update((quantity, known[quantity]) for choice in whole[:1] for quantity in choice)
    for name, unit in (*by_person.values(), *used.values()):
        shown = clean(name, longest=60)
        if name not in head.names:
            text = marked("“{name}” is unknown; the columns are {columns}.")
            raise UserError(text, name=shown, columns=_shown(head))
        if head.names.count(name) > 1:
            raise UserError(marked("“{name}” is there twice."), name=shown)
        said = head.units[head.names.index(name)]
        if unit and said and said != unit:
            raise UserError(marked("“{name}” is in {unit}."), name=shown, unit=said)
    if TIME not in used:
        why = message(marked("No column is known to hold the time."))
        raise _refusal(head, why, {"time": head.names[0]})
    if not any(source.columns[0] in used for source in (*_TILTS, *_FORCES_G)):
        why = message(marked("No column is known to hold attitude or acceleration."))
        # Another column in its place would be judged, and fire never: a person has to say which it is.
        raise _refusal(head, why, {"tilt": "COLUMN"})
    return used


def _meaning(name: str, unit: str) -> tuple[str, CsvColumn]:
    """The quantity of a column, and its unit; no quantity for a name that is unknown, or that contradicts its unit."""
    word = name.strip().lower()
    for begin, quantity in _NAMES.items():
        rest = word.removeprefix(begin).strip(" _[]()")
        if word.startswith(begin) and (not rest or rest in _UNITS):
            named_unit = _UNITS.get(rest, "") or unit
            if unit in ("", named_unit) and named_unit in QUANTITIES[quantity]:
                return quantity, CsvColumn(name, named_unit)
            if not named_unit and quantity != "altitude":  # metres or feet: nothing in it tells
                return quantity, CsvColumn(name, None)
    return "", CsvColumn(name, None)


def _in_units(head: Head, columns: CsvColumns, values: Mapping[str, Floats]) -> dict[str, Floats]:
    """The values by quantity, in the units of `QUANTITIES`; a bare column gets its unit by its values.

    Raises `UserError` where one is not certain.
    """
    units = {quantity: unit for quantity, (_, unit) in columns.items()}
    for together in _MEASURED_TOGETHER:
        bare = {quantity: columns[quantity].name for quantity in together if units.get(quantity, "") is None}
        if bare:
            quantity, name = next(iter(bare.items()))
            possible = _possible_units(quantity, [values[one] for one in bare])
            if len(possible) != 1:
                text = marked("The unit of “{name}” is not certain.")
                raise _refusal(head, message(text, name=clean(name, longest=60)), bare)
            units.update(dict.fromkeys(bare, possible[0]))
    scaled = {quantity: values[quantity] * QUANTITIES[quantity][unit or ""] for quantity, unit in units.items()}
    for quantity in scaled.keys() & {"tilt", "roll", "pitch"}:
        largest_deg = np.abs(scaled[quantity])
        if (largest_deg > _TURN_DEG).any():
            text = marked("“{name}” reaches {value:.0f}°: its unit is another.")
            name = clean(columns[quantity].name, longest=60)
            raise UserError(text, name=name, value=float(np.nanmax(largest_deg)))
    return scaled


def _refusal(head: Head, why: UserMessage, unknown: Mapping[str, str]) -> UserError:
    """Why, the columns that are there, and what to say of the unknown ones, as it has to be typed."""
    likely = {quantity: CsvColumn(name, next(iter(QUANTITIES[quantity]))) for quantity, name in unknown.items()}
    cure = " ".join(f"--column {shlex.quote(word)}" for word in role_words(likely))
    text = marked("{why} Say which column holds what, in which unit: {cure} (columns: {columns}).")
    return UserError(text, why=why, columns=_shown(head), cure=cure)


def _shown(head: Head) -> str:
    return ", ".join(clean(name, longest=40) for name in head.names[:30])


def _possible_units(quantity: str, columns: Sequence[Floats]) -> list[str]:
    """The units in which these columns, all of one kind of quantity, can be of a flight."""
    possible: list[str] = []
    known = np.isfinite(sum(columns))
    # In seconds, degrees or m/s², if their unit is this one.
    for unit, scale in QUANTITIES[quantity].items() if known.any() else ():
        values = np.array([column[known] for column in columns]) * scale
        if quantity == "time":
            steps_s = np.diff(values[0])
            is_length = SHORTEST_LOG_S <= np.ptp(values) <= LONGEST_LOG_S and (steps_s > 0).any()
            is_possible = is_length and _STEPS_S[0] <= np.median(steps_s[steps_s > 0]) <= _STEPS_S[1]
        elif quantity in ("tilt", "roll", "pitch"):
            # Degrees may be few; only an angle that is none in a unit tells, such as hundredths of degrees.
            is_possible = np.abs(values).max() <= (_TURN_DEG if unit == "deg" else _LARGEST_DEG)
        else:
            # An aircraft is at rest for a part of the time, and survives few shocks.
            force_m_s2 = np.sqrt((values * values).sum(axis=0))
            is_rest = (force_m_s2 >= _REST_M_S2[0]) & (force_m_s2 <= _REST_M_S2[1])
            is_possible = is_rest.mean() >= _MIN_REST and (force_m_s2 > _SHOCK_M_S2).mean() <= _MAX_SHOCKS
        if is_possible:
            possible.append(unit)
    if quantity == "time" and len(possible) > 1:
        length = np.ptp(columns[0][known])
        return [unit for unit in possible if length * QUANTITIES[quantity][unit] <= _USUAL_LENGTH_S]
    return possible


# The rows

# Of them the first tell whether commas are decimal ones.
_FIRST_ROWS: Final = 5000
_MAX_BAD_SHARE: Final = 0.01
_WITH_COMMA: Final = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
# Thousands, or three decimals.
_EITHER_COMMA: Final = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")


def _read_rows(lines: Iterable[str], head: Head, columns: CsvColumns, raw: RawLog) -> dict[str, Floats]:
    """The columns that are used, by quantity. `lines`: those behind the head. Raises `UserError`."""
    too_wide = marked("Line {line} has {cells} cells, the head {names}: perhaps there are commas in its numbers.")
    width = len(head.names)
    places = [head.names.index(name) for name, _ in columns.values()]
    needed = max(places) + 1
    # Row by row.
    numbers = array("d")
    bad_count, first_bad = 0, (0, "")
    reader = csv.reader(_whole(lines, head, raw), delimiter=head.parter, skipinitialspace=True)
    rows = ((head.first_row + reader.line_num, row) for row in reader if row)
    try:
        first = list(islice(rows, _FIRST_ROWS))
        is_decimal = _are_decimal(row[place] for _, row in first for place in places if place < len(row))
        for line, row in chain(first, rows):
            if len(row) > width and any(map(str.strip, row[width:])):
                raise UserError(too_wide, line=line, cells=len(row), names=width)
            bad = [""] if len(row) < needed else []
            row.extend([""] * (needed - len(row)))
            cells = [row[place] for place in places]
            # A point among numbers with decimal commas makes a cell no number.
            plain = [cell.replace(".", "?").replace(",", ".") for cell in cells] if is_decimal else cells
            try:
                values = list(map(float, plain))
            except ValueError:
                found = list(map(_value, columns, plain, cells))
                bad += [cell for cell, value in zip(cells, found, strict=True) if value is None]
                values = [math.nan if value is None else value for value in found]
            numbers.extend(values)
            if bad and not bad_count:
                first_bad = line, bad[0]
            bad_count += len(bad)
    except csv.Error as error:
        raise unreadable(marked("unknown kind of file")) from error
    table = np.array(numbers).reshape(-1, len(places))
    if not len(table):
        raise unreadable(marked("no rows"))
    if bad_count:
        line, cell = first_bad
        text = marked("Cells that are no numbers: {count}, the first in line {line}: “{cell}”.")
        raw.note(text, count=bad_count, line=line, cell=clean(cell, longest=40))
        if bad_count > _MAX_BAD_SHARE * len(table):
            raise UserError(raw.problems[-1])
    return dict(zip(columns, table.T, strict=True))


def _whole(lines: Iterable[str], head: Head, raw: RawLog) -> Iterator[str]:
    """The lines, empty where they are remarks; not the last one where it was cut off, perhaps within a number."""
    for line in lines:
        if line.endswith("\n") or len(_cells(line, head.parter)) >= len(head.names):
            yield "" if line.startswith("#") else line
        elif line.strip():
            raw.note(marked("cut off"))


def _value(quantity: str, plain: str, cell: str) -> float | None:
    """NaN for an empty cell; None for one that is no number. `plain`: the cell as Python writes numbers."""
    try:
        return float(plain)
    except ValueError:
        word = cell.strip().lower()
    if quantity == "armed" and word in _FLAGS:
        return _FLAGS[word]
    if word in ("", "null", "none"):
        return math.nan
    return _seconds_of(cell) if quantity == "time" else None


def _are_decimal(cells: Iterable[str]) -> bool:
    """Whether commas in these cells are decimal ones. Raises `UserError` where they may be thousands."""
    with_comma = [cell for cell in cells if "," in cell and _WITH_COMMA.fullmatch(cell.strip())]
    if with_comma and all(_EITHER_COMMA.fullmatch(cell.strip()) for cell in with_comma):
        cell = with_comma[0]
        text = marked("“{cell}” can be {one} or {other}.")
        raise UserError(text, cell=cell, one=cell.replace(",", "."), other=cell.replace(",", ""))
    return bool(with_comma)
