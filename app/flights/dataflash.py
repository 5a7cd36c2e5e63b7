"""Reads ArduPilot's DataFlash logs, binary (`.bin`) or text (`.log`), which define their own record formats: attitude,
acceleration of every sensor, altitude, arming, landing.

Read without pymavlink, which is larger than the rest of the program: see docs/flight-logs.md.
"""

from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Protocol

import numpy as np

from app.flights.flight_log import Floats, unreadable
from app.flights.raw_log import Channel, FlagChannel, RawLog, force_of_axes, tilt_of_roll_and_pitch
from app.flights.records import MAX_DAMAGES, MAX_WALKED, RecordField, RecordTable, read_bytes
from app.text.messages import message
from protocol.translatable import marked

MAGIC: Final = b"\xa3\x95"
_FORMAT_KIND: Final = 128
_FORMAT_BYTES: Final = 89
_HEAD_BYTES: Final = 3


_TYPES: Final[Mapping[str, tuple[str, float]]] = {
    "a": ("S64", 1), "b": ("<i1", 1), "B": ("<u1", 1), "h": ("<i2", 1), "H": ("<u2", 1), "i": ("<i4", 1),
    "I": ("<u4", 1), "f": ("<f4", 1), "d": ("<f8", 1), "n": ("S4", 1), "N": ("S16", 1), "Z": ("S64", 1),
    "c": ("<i2", 0.01), "C": ("<u2", 0.01), "e": ("<i4", 0.01), "E": ("<u4", 0.01),
    "L": ("<i4", 1e-7), "M": ("<u1", 1), "q": ("<i8", 1), "Q": ("<u8", 1), "g": ("<f2", 1),
}  # fmt: skip


class DataflashTable(Protocol):
    """All records of one name."""

    def has(self, *names: str) -> bool: ...

    def column(self, name: str) -> Floats: ...


class DataflashTables(Protocol):
    """A file, whether binary or text."""

    size: int
    """In bytes."""
    skipped_bytes: int
    """Bytes that are not records: damage."""
    lost_end_bytes: int
    """Those of them at the end of the file."""

    @property
    def tables(self) -> Mapping[str, DataflashTable]:
        """Those of `TABLES` in the file, by name."""


class DataflashFile:
    """A binary file. `tables` has those of `TABLES` in it, by name."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.size = len(data)
        self.tables: dict[str, RecordTable] = {}
        self.skipped_bytes = 0
        self.lost_end_bytes = 0
        self._lengths = [0] * 256
        self._lengths[_FORMAT_KIND] = _FORMAT_BYTES
        self._places_of: list[array[int] | None] = [None] * 256
        self._walk()

    def _walk(self) -> None:
        data, lengths, places_of = self._data, self._lengths, self._places_of
        place, stop, damages = 0, len(data), 0
        for _ in range(MAX_WALKED):
            if place + _HEAD_BYTES > stop or damages > MAX_DAMAGES:
                break
            kind = data[place + 2]
            length = lengths[kind]
            if data[place] != 0xA3 or data[place + 1] != 0x95 or not length or place + length > stop:
                next_place = data.find(MAGIC, place + 1)
                next_place = stop if next_place < 0 else next_place
                self.skipped_bytes += next_place - place
                self.lost_end_bytes += next_place - place
                place = next_place
                damages += 1
                continue
            self.lost_end_bytes = 0
            places = places_of[kind]
            if places is not None:
                places.append(place)
            elif kind == _FORMAT_KIND:
                self._define(data[place + _HEAD_BYTES : place + _FORMAT_BYTES])
            place += length
        self.skipped_bytes += stop - place
        self.lost_end_bytes += stop - place

    def _define(self, body: bytes) -> None:
        """The first definition of a type counts."""
        kind, length = body[0], body[1]
        name, types, labels = (part.split(b"\0")[0].decode("latin-1") for part in (body[2:6], body[6:22], body[22:86]))
        if kind == _FORMAT_KIND or self._lengths[kind] or length < _HEAD_BYTES:
            return
        self._lengths[kind] = length
        fields: dict[str, RecordField] = {}
        offset = _HEAD_BYTES
        for letter, label in zip(types, labels.split(","), strict=False):
            field_type = _TYPES.get(letter)
            if field_type is None:
                return
            fields[label.strip()] = RecordField(offset, *field_type)
            offset += np.dtype(field_type[0]).itemsize
        if offset > length or name not in TABLES or name in self.tables:
            return
        table = RecordTable(name, self._data, fields)
        self.tables[name] = table
        self._places_of[kind] = table.places


TABLES: Final = frozenset({
    "ATT", "AHR2", "IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3", "EV", "ARM", "BARO", "CTUN", "POS",
})  # fmt: skip
EVENT_ARMED, EVENT_DISARMED, EVENT_LANDED, EVENT_NOT_LANDED = 10, 11, 18, 28
_CLOCKS: Final = (("TimeUS", 1e-6), ("TimeMS", 1e-3))
_SENSORS: Final = ("IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3")
_MAX_SENSORS: Final = 6


def read_dataflash(path: Path) -> RawLog:
    """Raises `UserError`, OSError."""
    return raw_log_of(DataflashFile(read_bytes(path)), str(path))


def raw_log_of(file: DataflashTables, name: str) -> RawLog:
    """Raises `UserError`."""
    raw = RawLog(name=name)
    for label in ("ATT", "AHR2"):
        table = file.tables.get(label)
        if table is not None and table.has("Roll", "Pitch"):
            tilt_deg = tilt_of_roll_and_pitch(table.column("Roll"), table.column("Pitch"))
            raw.tilts_deg.append(Channel(_times(table), tilt_deg))
    for label in _SENSORS:
        table = file.tables.get(label)
        if table is not None:
            raw.forces_g += _forces(table)
    raw.forces_g = raw.forces_g[:_MAX_SENSORS]
    raw.altitude_m = _altitude(file)
    _read_events(file, raw)
    if file.skipped_bytes:
        raw.problems.append(message(marked("Damaged; bytes left out: {count}."), count=f"{file.skipped_bytes:,}"))
        raw.lost_end_s = raw.seconds_of(file.lost_end_bytes, file.size)
    return raw


def _times(table: DataflashTable) -> Floats:
    """Raises `UserError` for logs from before 2014, whose records have no times."""
    for label, scale in _CLOCKS:
        if table.has(label):
            return table.column(label) * scale
    raise unreadable(marked("no times: from before 2014"))


def _forces(table: DataflashTable) -> list[Channel]:
    """One channel per sensor; newer logs number the sensors within one table."""
    if not table.has("AccX", "AccY", "AccZ"):
        return []
    time_s = _times(table)
    force_g = force_of_axes(*(table.column(label) for label in ("AccX", "AccY", "AccZ")))
    if not table.has("I"):
        return [Channel(time_s, force_g)]
    numbers = table.column("I")
    return [
        Channel(time_s[numbers == number], force_g[numbers == number]) for number in np.unique(numbers)[:_MAX_SENSORS]
    ]


def _altitude(file: DataflashTables) -> Channel | None:
    """The estimator's altitude, else the barometer's."""
    for name, labels in (("POS", ("RelHomeAlt", "Alt")), ("CTUN", ("Alt", "BarAlt")), ("BARO", ("Alt",))):
        table = file.tables.get(name)
        label = next((name for name in labels if table is not None and table.has(name)), None)
        if table is not None and label is not None and any(table.has(clock) for clock, _ in _CLOCKS):
            time_s, altitude_m = _times(table), table.column(label)
            if table.has("I"):
                is_first = table.column("I") == 0
                time_s, altitude_m = time_s[is_first], altitude_m[is_first]
            return Channel(time_s, altitude_m)
    return None


def _read_events(file: DataflashTables, raw: RawLog) -> None:
    events, arming = file.tables.get("EV"), file.tables.get("ARM")
    if events is not None and events.has("Id") and any(events.has(clock) for clock, _ in _CLOCKS):
        time_s, numbers = _times(events), events.column("Id")
        raw.armed = _switched(time_s, numbers, EVENT_ARMED, EVENT_DISARMED)
        raw.on_ground = _switched(time_s, numbers, EVENT_LANDED, EVENT_NOT_LANDED)
    if arming is not None and arming.has("TimeUS", "ArmState"):
        raw.armed = FlagChannel(_times(arming), arming.column("ArmState") != 0, is_changes=True)


def _switched(time_s: Floats, numbers: Floats, turns_on: int, turns_off: int) -> FlagChannel | None:
    rows = np.isin(numbers, (turns_on, turns_off))
    return FlagChannel(time_s[rows], numbers[rows] == turns_on, is_changes=True) if rows.any() else None
