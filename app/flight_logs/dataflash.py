"""Reads ArduPilot's DataFlash logs: attitude, acceleration of every sensor, altitude, arming, landing, modes."""

from pathlib import Path
from typing import Final

import numpy as np

from app.flight_logs.dataflash_file import DataflashFile
from app.flight_logs.flight_log import Floats, LogFormat, ModeChange, unreadable
from app.flight_logs.raw_log import MAX_MODES, Channel, FlagChannel, RawLog, force_of_axes, tilt_of_roll_and_pitch
from app.flight_logs.records import RecordTable, read_bytes
from app.text.messages import message
from protocol.translatable import marked

TABLES: Final = frozenset({
    "ATT", "AHR2", "IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3", "EV", "ARM", "MODE", "BARO", "CTUN", "POS",
    "MSG",
})  # fmt: skip
EVENT_ARMED, EVENT_DISARMED, EVENT_LANDED, EVENT_NOT_LANDED = 10, 11, 18, 28
COPTER_MODES: Final = {
    0: "STABILIZE", 1: "ACRO", 2: "ALT_HOLD", 3: "AUTO", 4: "GUIDED", 5: "LOITER", 6: "RTL", 7: "CIRCLE", 9: "LAND",
    11: "DRIFT", 13: "SPORT", 14: "FLIP", 15: "AUTOTUNE", 16: "POSHOLD", 17: "BRAKE", 18: "THROW", 21: "SMART_RTL",
}  # fmt: skip
_CLOCKS: Final = (("TimeUS", 1e-6), ("TimeMS", 1e-3))
_SENSORS: Final = ("IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3")
_MAX_SENSORS: Final = 6


def read_dataflash(path: Path) -> RawLog:
    """Raises `UserError`, OSError."""
    file = DataflashFile(read_bytes(path), TABLES)
    raw = RawLog(name=str(path), format=LogFormat.DATAFLASH)
    for name in ("ATT", "AHR2"):
        table = file.tables.get(name)
        if table is not None and table.has("Roll", "Pitch"):
            tilt_deg = tilt_of_roll_and_pitch(table.column("Roll"), table.column("Pitch"))
            raw.tilts_deg.append(Channel(_times(table), tilt_deg))
    for name in _SENSORS:
        table = file.tables.get(name)
        if table is not None:
            raw.forces_g += _forces(table)
    raw.forces_g = raw.forces_g[:_MAX_SENSORS]
    raw.altitude_m = _altitude(file)
    _read_events(file, raw)
    _read_modes(file, raw)
    if file.skipped_bytes:
        raw.problems.append(message(marked("Damaged; bytes left out: {count}."), count=f"{file.skipped_bytes:,}"))
    return raw


def _times(table: RecordTable) -> Floats:
    """Raises `UserError` for logs from before 2014, whose records have no times."""
    for label, scale in _CLOCKS:
        if table.has(label):
            return table.column(label) * scale
    raise unreadable(marked("no times: from before 2014"))


def _forces(table: RecordTable) -> list[Channel]:
    """One channel per sensor; newer logs number the sensors within one table."""
    if not table.has("AccX", "AccY", "AccZ"):
        return []
    time_s = _times(table)
    force_g = force_of_axes(*(table.column(label) for label in ("AccX", "AccY", "AccZ")))
    if not table.has("I"):
        return [Channel(time_s, force_g)]
    numbers = table.column("I")
    return [Channel(time_s[numbers == one], force_g[numbers == one]) for one in np.unique(numbers)[:_MAX_SENSORS]]


def _altitude(file: DataflashFile) -> Channel | None:
    """The estimator's altitude, else the barometer's."""
    for name, labels in (("POS", ("RelHomeAlt", "Alt")), ("CTUN", ("Alt", "BarAlt")), ("BARO", ("Alt",))):
        table = file.tables.get(name)
        label = next((one for one in labels if table is not None and table.has(one)), None)
        if table is not None and label is not None and any(table.has(clock) for clock, _ in _CLOCKS):
            time_s, altitude_m = _times(table), table.column(label)
            if table.has("I"):
                is_first = table.column("I") == 0
                time_s, altitude_m = time_s[is_first], altitude_m[is_first]
            return Channel(time_s, altitude_m)
    return None


def _read_events(file: DataflashFile, raw: RawLog) -> None:
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


def _read_modes(file: DataflashFile, raw: RawLog) -> None:
    table, messages = file.tables.get("MODE"), file.tables.get("MSG")
    if table is None or not table.has("Mode") or not any(table.has(clock) for clock, _ in _CLOCKS):
        return
    said_texts = messages.texts("Message") if messages is not None and messages.has("Message") else []
    is_copter = any("copter" in text.lower() for text in said_texts)
    names = COPTER_MODES if is_copter else {}
    numbers = table.column("Mode")
    raw.modes = [
        ModeChange(float(at_s), names.get(int(number), f"mode {int(number)}"))
        for at_s, number in zip(_times(table)[:MAX_MODES], numbers[:MAX_MODES], strict=True)
        if np.isfinite(number)
    ]
