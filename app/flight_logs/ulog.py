"""Reads PX4's ULog: attitude, acceleration of every sensor, altitude, arming, landing, modes."""

from pathlib import Path
from typing import Final

import numpy as np

from app.flight_logs.flight_log import Floats, LogFormat, ModeChange
from app.flight_logs.raw_log import MAX_MODES, Channel, FlagChannel, RawLog, force_of_axes, tilt_of_quaternion
from app.flight_logs.records import read_bytes
from app.flight_logs.ulog_file import UlogFile, UlogTopic
from app.text.messages import message
from protocol.translatable import marked

TOPICS: Final = frozenset(
    {
        "vehicle_attitude", "sensor_combined", "vehicle_acceleration", "vehicle_imu", "sensor_accel",
        "vehicle_local_position", "vehicle_air_data", "vehicle_status", "vehicle_land_detected",
    }
)  # fmt: skip
ARMED: Final = 2
"""vehicle_status.arming_state."""
NAV_STATES: Final = {
    0: "MANUAL", 1: "ALTCTL", 2: "POSCTL", 3: "MISSION", 4: "LOITER", 5: "RTL", 10: "ACRO", 12: "DESCEND",
    13: "TERMINATION", 14: "OFFBOARD", 15: "STAB", 17: "TAKEOFF", 18: "LAND", 19: "FOLLOW", 20: "PRECLAND", 21: "ORBIT",
}  # fmt: skip
_MICROSECOND: Final = 1e-6
_MAX_SENSORS: Final = 6


def read_ulog(path: Path) -> RawLog:
    """Raises `UserError`, OSError."""
    file = UlogFile(read_bytes(path), TOPICS)
    raw = RawLog(name=str(path), format=LogFormat.ULOG)
    for topic in sorted(file.topics, key=lambda one: one.instance):
        if topic.has("timestamp"):
            _read_topic(topic, raw)
    raw.forces_g = [*_forces(file)][:_MAX_SENSORS]
    if file.skipped_bytes:
        raw.problems.append(message(marked("Damaged; bytes left out: {count}."), count=f"{file.skipped_bytes:,}"))
    if file.dropout_s:
        raw.problems.append(message(marked("Nothing logged for {seconds:.2f} s."), seconds=file.dropout_s))
    return raw


def _read_topic(topic: UlogTopic, raw: RawLog) -> None:
    time_s = _times(topic)
    match topic.name:
        case "vehicle_attitude" if topic.has("q[0]", "q[1]", "q[2]", "q[3]"):
            tilt_deg = tilt_of_quaternion(*(topic.column(f"q[{one}]") for one in range(4)))
            raw.tilts_deg.append(Channel(time_s, tilt_deg))
        case "vehicle_local_position" if topic.has("z"):
            raw.altitude_m = Channel(time_s, -topic.column("z"))
        case "vehicle_air_data" if topic.has("baro_alt_meter") and raw.altitude_m is None:
            raw.altitude_m = Channel(time_s, topic.column("baro_alt_meter"))
        case "vehicle_land_detected" if topic.has("landed"):
            raw.on_ground = FlagChannel(time_s, topic.column("landed") != 0)
        case "vehicle_status":
            if topic.has("arming_state"):
                raw.armed = FlagChannel(time_s, topic.column("arming_state") == ARMED)
            if topic.has("nav_state"):
                raw.modes = _modes(time_s, topic.column("nav_state"))
        case _:
            pass


def _times(topic: UlogTopic) -> Floats:
    return topic.column("timestamp") * _MICROSECOND


def _forces(file: UlogFile) -> list[Channel]:
    """The estimator's acceleration first, then each sensor."""
    found: list[Channel] = []
    for name, labels in (
        ("sensor_combined", [f"accelerometer_m_s2[{one}]" for one in range(3)]),
        ("vehicle_acceleration", [f"xyz[{one}]" for one in range(3)]),
        ("vehicle_imu", [f"delta_velocity[{one}]" for one in range(3)]),
        ("sensor_accel", ["x", "y", "z"]),
    ):
        topics = [one for one in file.topics if one.name == name and one.has("timestamp", *labels)]
        if found and name == "vehicle_acceleration":
            continue  # the same sensor, filtered
        if name == "sensor_accel" and len(found) > 1:
            continue  # vehicle_imu has them all
        for topic in sorted(topics, key=lambda one: one.instance):
            axes = [topic.column(label) for label in labels]
            if name == "vehicle_imu":
                axes = _over_time(topic, axes)
            found.append(Channel(_times(topic), force_of_axes(*axes)))
    return found


def _over_time(topic: UlogTopic, axes: list[Floats]) -> list[Floats]:
    """Acceleration from changes of velocity; NaN where their duration is unknown."""
    if not topic.has("delta_velocity_dt"):
        return [np.full_like(one, np.nan) for one in axes]
    took_s = topic.column("delta_velocity_dt") * _MICROSECOND
    took_s[took_s <= 0] = np.nan
    return [one / took_s for one in axes]


def _modes(time_s: Floats, states: Floats) -> list[ModeChange]:
    changes = np.flatnonzero(np.diff(states, prepend=-1.0) != 0)[:MAX_MODES]
    return [
        ModeChange(float(time_s[one]), NAV_STATES.get(int(states[one]), f"mode {int(states[one])}")) for one in changes
    ]
