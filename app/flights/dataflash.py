"""Reads ArduPilot's DataFlash logs, binary (`.bin`) or text (`.log`): attitude, acceleration of every sensor, altitude,
arming.

Both define their own records: a binary `FMT` record, or a line `FMT`, names the columns of a table. Read without
pymavlink, which is larger than the rest of the program: see docs/flight-logs.md.
"""

import re
from array import array
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Final

import numpy as np

from app.flights.raw_log import (
    AT_ONCE,
    TIME,
    Channel,
    ChannelSource,
    Floats,
    Places,
    RawLog,
    Table,
    channels_of,
    columns_of,
    force_of_axes,
    tilt_of_roll_and_pitch,
)

MAGIC: Final = b"\xa3\x95"
TEXT_FORMAT: Final = re.compile(rb"^FMT,", re.MULTILINE)
"""A line of a log that was saved as text."""
_FORMAT_KIND: Final = 128
_FORMAT_BYTES: Final = 89
_HEAD_BYTES: Final = 3
# A definition up to the name of the table, behind the kind and the length of its records.
_FORMAT_HEAD: Final = re.compile(rb"\xa3\x95\x80..[A-Za-z0-9]{1,4}", re.DOTALL)
_TYPES: Final[Mapping[str, str]] = {
    "a": "S64", "b": "<i1", "B": "<u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4", "d": "<f8",
    "n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4", "M": "<u1",
    "q": "<i8", "Q": "<u8", "g": "<f2",
}  # fmt: skip
_SCALES: Final = {"c": 0.01, "C": 0.01, "e": 0.01, "E": 0.01, "L": 1e-7}
# Logs from before 2014 have none.
_CLOCKS: Final = {"TimeUS": 1e-6, "TimeMS": 1e-3}
# The number of the sensor; older logs have a table for each.
_SENSOR: Final = "I"
_MAX_SENSORS: Final = 6
_TILTS: Final = tuple(ChannelSource(table, ("Roll", "Pitch"), tilt_of_roll_and_pitch) for table in ("ATT", "AHR2"))
_FORCES: Final = tuple(
    ChannelSource(table, ("AccX", "AccY", "AccZ"), force_of_axes)
    for table in ("IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3")
)
# The estimator's altitude, else the barometer's.
_ALTITUDES: Final = tuple(
    ChannelSource(table, (column,))
    for table, column in (("POS", "RelHomeAlt"), ("POS", "Alt"), ("CTUN", "Alt"), ("BARO", "Alt"))
)
_ARMING: Final = (ChannelSource("ARM", ("ArmState",)),)
_EVENTS: Final = (ChannelSource("EV", ("Id",)),)
_SOURCES: Final = (*_TILTS, *_FORCES, *_ALTITUDES, *_ARMING, *_EVENTS)
_TABLES: Final = frozenset(one.table for one in _SOURCES)
_COLUMNS: Final = frozenset((*_CLOCKS, _SENSOR, *chain.from_iterable(one.columns for one in _SOURCES)))
# Numbers of events.
_EV_ARMED, _EV_DISARMED = 10, 11


def _numbers(cells: Sequence[str]) -> Floats:
    """A text, or damage, costs its own cell."""
    try:
        return np.array(cells, np.float64)
    except ValueError:
        if len(cells) == 1:
            return np.array([np.nan])
        half = len(cells) // 2
        return np.concatenate((_numbers(cells[:half]), _numbers(cells[half:])))


def _by_sensor(table: Table) -> list[Table]:
    """With seconds. Newer logs number the sensors within one table."""
    for clock, seconds in _CLOCKS.items():
        if clock in table:
            table[TIME] = table[clock] * seconds
    if _SENSOR not in table:
        return [table]
    numbers = table[_SENSOR]
    rows_of = [np.flatnonzero(numbers == number) for number in np.unique(numbers)[:_MAX_SENSORS]]
    return [{name: column[rows] for name, column in table.items()} for rows in rows_of]


class DataflashFile:
    """A log, binary or text: its tables that are asked for, by name. Damage costs the damaged record."""

    def __init__(self, data: bytes) -> None:
        # By name, one for each sensor.
        self.tables: dict[str, list[Table]] = {}
        # Bytes that are no records: damage.
        self.skipped_bytes = 0
        # Where the last record ends.
        self.read_until = 0
        if data.startswith(MAGIC):
            self._read_binary(data)
        else:
            self._read_text(data)

    def _read_binary(self, data: bytes) -> None:
        formats: dict[int, tuple[str, str, list[str]]] = {}
        # 0 where a kind is not defined.
        lengths = np.zeros(256, np.int64)
        lengths[_FORMAT_KIND] = _FORMAT_BYTES
        for format_head in _FORMAT_HEAD.finditer(data):
            body = data[format_head.start() + _HEAD_BYTES : format_head.start() + _FORMAT_BYTES]
            name, letters, columns = (
                part.split(b"\0")[0].decode("latin-1") for part in (body[2:6], body[6:22], body[22:86])
            )
            # The first definition of a kind counts.
            if len(body) == _FORMAT_BYTES - _HEAD_BYTES and body[1] >= _HEAD_BYTES and not lengths[body[0]]:
                lengths[body[0]] = body[1]
                formats[body[0]] = name, letters, [label.strip() for label in columns.split(",")]
        begins = self._records(data, lengths)
        kinds = np.frombuffer(data, np.uint8)[begins + 2]
        for kind, (name, letters, labels) in formats.items():
            is_understood = set(letters) <= _TYPES.keys() and len(set(labels)) == len(labels)
            if name in _TABLES and name not in self.tables and is_understood:
                types = dict(zip(labels, letters, strict=False))
                layout = np.dtype([(label, _TYPES[letter]) for label, letter in types.items()])
                wanted = {label: _SCALES.get(letter, 1.0) for label, letter in types.items() if label in _COLUMNS}
                if layout.itemsize + _HEAD_BYTES <= lengths[kind]:
                    table = columns_of(data, layout, begins[kinds == kind] + _HEAD_BYTES, wanted)
                    self.tables[name] = _by_sensor(table)

    def _records(self, data: bytes, lengths: Places) -> Places:
        """Where records of defined kinds begin. By chance the magic stands within others, too."""
        read = np.frombuffer(data, np.uint8)
        records = array("q")
        place = 0
        for first in range(0, len(data) - 2, AT_ONCE):
            part = read[first : first + AT_ONCE + 2]
            begins = np.flatnonzero((part[:-2] == MAGIC[0]) & (part[1:-1] == MAGIC[1])) + first
            ends = begins + lengths[read[begins + 2]]
            fits = (ends > begins) & (ends <= len(data))
            for begin, end in zip(begins[fits].tolist(), ends[fits].tolist(), strict=True):
                # Behind damage a record is believed if another one, or nothing, follows it.
                if begin == place or (begin > place and data[end : end + len(MAGIC)] in (MAGIC, b"")):
                    records.append(begin)
                    self.skipped_bytes += begin - place
                    place = end
        self.skipped_bytes += len(data) - place
        self.read_until = place
        return np.array(records, np.int64)

    def _read_text(self, data: bytes) -> None:
        """A line that is no whole record is damage."""
        # Of the tables that are asked for: the names of the columns, and each line.
        tables: dict[str, tuple[list[str], list[str]]] = {}
        names = {"FMT"}
        damaged: list[int] = []
        *lines, cut_off = data.decode("latin-1").split("\n")
        for number, line in enumerate(lines):
            name, _, rest = line.partition(",")
            if name in tables:
                labels, rows = tables[name]
                if rest.count(",") == len(labels) - 1:
                    rows.append(rest)
                else:
                    damaged.append(number)
            elif name == "FMT":
                cells = [cell.strip() for cell in rest.split(",")]
                if len(cells) >= 5:
                    names.add(cells[2])
                    if cells[2] in _TABLES:
                        tables.setdefault(cells[2], (cells[4:], []))
            elif name not in names and len(names) > 1:  # before the first format there is a heading
                damaged.append(number)
        self.skipped_bytes = len(cut_off) + sum(len(lines[number]) + 1 for number in damaged)
        self.read_until = len(data) - len(cut_off)
        while damaged and damaged[-1] == len(lines) - 1:
            damaged.pop()
            self.read_until -= len(lines.pop()) + 1
        for name, (labels, rows) in tables.items():
            table: Table = {}
            cells = ",".join(rows).split(",")
            for place, label in enumerate(labels):
                if label in _COLUMNS and rows:
                    table[label] = _numbers(cells[place :: len(labels)])
            self.tables[name] = _by_sensor(table)


def read_dataflash(data: bytes, name: str) -> RawLog:
    """Reads a binary or a text log."""
    file = DataflashFile(data)
    raw = RawLog(name=name, tilts_deg=channels_of(file.tables, _TILTS))
    raw.forces_g = channels_of(file.tables, _FORCES)[:_MAX_SENSORS]
    raw.altitudes_m = channels_of(file.tables, _ALTITUDES)
    raw.armed = [_from_the_first_change(changes) for changes in channels_of(file.tables, _ARMING)]
    for events in channels_of(file.tables, _EVENTS):
        rows = (events.values == _EV_ARMED) | (events.values == _EV_DISARMED)
        if rows.any():
            raw.armed.append(_from_the_first_change(Channel(events.time_s[rows], events.values[rows] == _EV_ARMED)))
    raw.note_damage(file.skipped_bytes, file.read_until, len(data))
    return raw


def _from_the_first_change(changes: Channel) -> Channel:
    """Each sample is a change: before the first one the flag had the opposite value."""
    before = float(changes.values[0] == 0)
    return Channel(np.append(-np.inf, changes.time_s), np.append(before, changes.values))
