"""Reads a CSV file with a head line: time, attitude, acceleration, altitude, arming."""

import csv
import math
import os
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, TextIO

import numpy as np

from app.flights.assembly import assembled, flight_of_reports
from app.flights.columns import ATTITUDES, FORCES, TIMES, CsvColumns, CsvRole, recognised
from app.flights.flight_log import NO_PROGRESS, FlightLog, Floats, Progress, unreadable
from app.flights.raw_log import Channel, FlagChannel, RawLog
from app.recordings.excerpt import HEAD
from app.recordings.markers import STATE_LOST, Marker
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_COLUMNS: Final = 2000
MAX_CELLS: Final = 100_000_000
MAX_LINE_LENGTH: Final = 256 * 1024
ROWS_AT_ONCE: Final = 5000
"""Read in about 20 ms: how often progress is reported."""
PAUSE_S: Final = 1.0
"""Between the recordings of one table: longer than what is judged across."""
_FLAGS: Final = {"true": 1.0, "false": 0.0}
_RESETS: Final = {kind: float(number) for number, kind in enumerate(STATE_LOST, start=1)}
_EXPORTED: Final = HEAD.split(",")[1:]
"""The columns of an export of this program behind the first one, which had another name before; "event" is the last."""


def read_head(path: Path) -> list[str]:
    """Names of the columns. Raises `UserError`, OSError."""
    with path.open("r", encoding="utf-8-sig", errors="replace", newline="") as file:
        line = file.readline(MAX_LINE_LENGTH)
    return _head_of(line)


def read_csv(path: Path, columns: CsvColumns | None = None, on_progress: Progress = NO_PROGRESS) -> FlightLog:
    """`columns`: None recognises them by name. Raises `UserError`, OSError, and what `on_progress` raises.

    An export of this program is read report by report; any other file is resampled at the module's report rate.
    """
    raw = RawLog(name=str(path))
    with path.open("r", encoding="utf-8-sig", errors="replace", newline="") as file:
        first = file.readline(MAX_LINE_LENGTH)
        head = _head_of(first)
        chosen = recognised(head) if columns is None else columns
        places = _places(head, chosen)
        is_export = columns is None and head[1:] == _EXPORTED
        columns_read = [*places.values(), *([len(_EXPORTED)] if is_export else [])]
        words = _FLAGS | ({kind.value: number for kind, number in _RESETS.items()} if is_export else {})
        numbers = _numbers(file, _separator(first), columns_read, words, on_progress)
    values = dict(zip(places, numbers, strict=False))
    scale = next((role for role in TIMES if role in values), CsvRole.TIME_S)
    time_s = values[scale] * TIMES[scale]
    if is_export:
        time_s = _one_after_the_other(time_s)
        is_report = ~(np.isnan(values[CsvRole.TILT_DEG]) | np.isnan(values[CsvRole.ACCELERATION_G]))
        tilt_deg, acceleration_g = (values[role][is_report] for role in (CsvRole.TILT_DEG, CsvRole.ACCELERATION_G))
        resets = [Marker(at_s, kind) for kind, number in _RESETS.items() for at_s in time_s[numbers[-1] == number]]
        resets.sort(key=lambda reset: reset.time_s)
        return flight_of_reports(raw.name, time_s[is_report], tilt_deg, acceleration_g, [], resets)
    if chosen.attitude:
        raw.tilts_deg.append(_known(time_s, ATTITUDES[chosen.attitude](*map(values.get, chosen.attitude))))
    if chosen.force:
        raw.forces_g.append(_known(time_s, FORCES[chosen.force](*map(values.get, chosen.force))))
    if CsvRole.ALTITUDE_M in values:
        raw.altitude_m = _known(time_s, values[CsvRole.ALTITUDE_M])
    if CsvRole.ARMED in values:
        known = _known(time_s, values[CsvRole.ARMED])
        raw.armed = FlagChannel(known.time_s, known.values != 0)
    return assembled(raw)


def _one_after_the_other(time_s: Floats) -> Floats:
    """The times of each recording in the table begin again: here it follows the one before, after a pause."""
    shifted = time_s.copy()
    rows = np.flatnonzero(np.isfinite(time_s))
    known_s = time_s[rows]
    begins = np.flatnonzero((np.diff(known_s, prepend=known_s[:1]) < 0) & (known_s <= known_s[:1]))
    if len(begins):
        ends_s = np.maximum.reduceat(known_s, [0, *begins])
        shifts_s = np.cumsum(ends_s[:-1] + PAUSE_S - known_s[begins])
        shifted[rows] += np.concatenate(((0.0,), shifts_s))[np.searchsorted(begins, np.arange(len(rows)), "right")]
    return shifted


def _known(time_s: Floats, values: Floats) -> Channel:
    """Without the rows in which the cell is empty."""
    is_known = ~np.isnan(values)
    return Channel(time_s[is_known], values[is_known])


def _separator(line: str) -> str:
    return max(",;\t", key=line.count)


def _head_of(line: str) -> list[str]:
    try:
        head = next(csv.reader([line], delimiter=_separator(line)), [])
    except csv.Error:
        head = []
    head = [name.strip() for name in head]
    if not 2 <= len(head) <= MAX_COLUMNS:
        raise unreadable(marked("no column names in the first line"))
    return head


def _places(head: list[str], columns: CsvColumns) -> dict[CsvRole, int]:
    roles = [role for role in CsvRole if role in columns.names]
    places = {}
    for role in roles:
        name = columns.names[role]
        if name not in head:
            raise UserError(marked("“{name}” is unknown."), name=clean(name, longest=60))
        places[role] = head.index(name)
    return places


def _numbers(
    file: TextIO, separator: str, columns: Sequence[int], words: Mapping[str, float], on_progress: Progress
) -> list[Floats]:
    """The columns as numbers; NaN for other cells than numbers and these words."""
    pieces = iter(lambda: file.readline(MAX_LINE_LENGTH), "")  # bounds the length of a line
    lines = csv.reader((line.replace("\0", "") for line in pieces), delimiter=separator)
    cells, size = array("d"), max(os.fstat(file.fileno()).st_size, 1)
    try:
        for number, row in enumerate(lines):
            if number % ROWS_AT_ONCE == 0:
                on_progress(min(file.buffer.tell() / size, 1.0))
            cells.extend([_number(row[place], words) if place < len(row) else math.nan for place in columns])
            if len(cells) > MAX_CELLS:
                raise unreadable(marked("too large"))
    except csv.Error as error:
        raise unreadable(marked("unknown kind of file")) from error
    return list(np.frombuffer(cells).reshape(-1, len(columns)).T)


def _number(cell: str, words: Mapping[str, float]) -> float:
    """NaN for an empty cell and for other text. What follows a colon does not count: "connected: /dev/ttyUSB0"."""
    try:
        return float(cell)
    except ValueError:
        return words.get(cell.partition(":")[0].strip().lower(), math.nan)
