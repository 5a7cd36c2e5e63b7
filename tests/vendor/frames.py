"""The frames printed in the vendor's table of 2019-04-30, with their meaning; one with the note "computed" is added."""

from typing import NamedTuple

Plain = bool | int | float | str | list[str]


class Vector(NamedTuple):
    """One frame.

    `means` is what `dps-s decode --json` prints except offset and direction, or None if the frame must be rejected;
    `while_asked` is the pending request that decides the meaning.
    """

    id: str
    hex: str
    means: dict[str, Plain] | None
    while_asked: str | None = None
    note: str = ""

    @property
    def raw(self) -> bytes:
        return bytes.fromhex(self.hex)

    @property
    def is_from_host(self) -> bool:
        return self.raw.startswith(b"Ba")

    @property
    def is_set(self) -> bool:
        return self.is_from_host and self.raw[3] == 0x02

    @property
    def command(self) -> str:
        return "" if self.means is None else str(self.means["command"])


_RECORD: dict[str, Plain] = {
    "command": "trigger_records",
    "boot_count": 0,
    "uptime_s": 108,
    "sources": ["attitude"],
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "freefall_time_s": 1.6,
    "serial_connected": True,
    "charging": False,
    "light_v": 1.2,
}


def _voltage(frame: str, volts: float) -> Vector:
    code = frame.split()[2]
    note = {"34": "E3: the code one would expect", "35": "E3: the table answers with code 35"}[code]
    means: dict[str, Plain] = {"command": "cell_voltage", "cell_voltage_v": volts}
    return Vector(f"cell-voltage-reply-{code}-{volts}V", frame, means, "cell_voltage", note)


def _flag(name: str, frame: str, note: str = "") -> Vector:
    command = f"{name.partition('-')[0]}_trigger"
    return Vector(name, frame, {"command": command, "enabled": "enable" in name.split("-")}, command, note)


VECTORS: tuple[Vector, ...] = (
    Vector("heartbeat", "42 61 01 A5 5A 00", {"command": "heartbeat"}),
    Vector("heartbeat-reply", "41 75 01 A5 5A 00", {"command": "heartbeat"}),
    Vector("activate", "42 61 10 02 01 13", {"command": "activation", "set": True}),
    Vector("activate-ack", "41 75 10 01 01 12", {"command": "activation", "active": True}),
    Vector("lock", "42 61 10 02 00 12", {"command": "activation", "set": False}),
    Vector("lock-ack", "41 75 10 01 00 11", {"command": "activation", "active": False}),
    Vector("deploy", "42 61 11 02 01 14", {"command": "deploy", "set": True}),
    Vector("deploy-forbid", "42 61 11 02 00 13", {"command": "deploy", "set": False}),
    Vector("deploy-ack", "41 75 11 01 01 13", {"command": "deploy", "deployed": True}),
    Vector("deploy-forbid-ack", "41 75 11 01 00 12", {"command": "deploy", "deployed": False}),
    Vector("shutdown", "42 61 12 02 01 15", {"command": "shutdown"}),
    Vector("shutdown-ack", "41 75 12 01 01 14", {"command": "shutdown"}),
    Vector("serial-output-on", "42 61 13 02 01 16", {"command": "serial_output", "set": True}),
    Vector("serial-output-on-ack", "41 75 13 01 01 15", {"command": "serial_output", "on": True}),
    Vector("serial-output-off", "42 61 13 02 00 15", {"command": "serial_output", "set": False}),
    Vector("serial-output-off-ack", "41 75 13 01 00 14", {"command": "serial_output", "on": False}),
    Vector("light-query", "42 61 14 01 01 16", {"command": "light"}),
    Vector("light-threshold-set-1.8V", "42 61 15 02 12 29", {"command": "light_threshold", "set_v": 1.8}),
    Vector("light-threshold-query", "42 61 15 01 00 16", {"command": "light_threshold"}),
    Vector("light-threshold-reply-1.8V", "41 75 15 01 12 28", {"command": "light_threshold", "value_v": 1.8}),
    Vector("attitude-threshold-set-60", "42 61 20 02 3C 5E", {"command": "attitude_threshold", "set_deg": 60}),
    Vector("attitude-threshold-ack-60", "41 75 20 01 3C 5D", {"command": "attitude_threshold", "value_deg": 60}),
    Vector("attitude-threshold-query", "42 61 20 01 00 21", {"command": "attitude_threshold"}),
    Vector(
        "attitude-threshold-reply-misprint", "41 75 20 01 3C 50", None, note="E1: printed checksum 50, the sum is 5d"
    ),
    Vector("freefall-acceleration-set-0.5g", "42 61 21 02 05 28", {"command": "freefall_acceleration", "set_g": 0.5}),
    Vector(
        "freefall-acceleration-reply-0.5g",
        "41 75 21 01 05 27",
        {"command": "freefall_acceleration", "value_g": 0.5},
        note="E2: also the acknowledgement of the set",
    ),
    Vector("freefall-acceleration-query", "42 61 21 01 00 22", {"command": "freefall_acceleration"}),
    Vector("freefall-time-set-1.6s", "42 61 22 02 A0 C4", {"command": "freefall_time", "set_s": 1.6}),
    Vector("freefall-time-reply-1.6s", "41 75 22 01 A0 C3", {"command": "freefall_time", "value_s": 1.6}, note="E2"),
    Vector("freefall-time-query", "42 61 22 01 00 23", {"command": "freefall_time"}),
    Vector("boot-count-query", "42 61 23 01 00 24", {"command": "boot_count"}),
    Vector("baud-set-115200", "42 61 24 02 06 2C", {"command": "baud_rate", "set_baud": 115200}),
    Vector("baud-ack-115200", "41 75 24 01 06 2B", {"command": "baud_rate", "value_baud": 115200}, note="E2, E9"),
    Vector("active-query", "42 61 30 01 00 31", {"command": "active"}),
    Vector("active-no", "41 75 30 01 00 31", {"command": "active", "active": False}),
    Vector("active-yes", "41 75 30 01 01 32", {"command": "active", "active": True}),
    Vector("triggered-query", "42 61 31 01 00 32", {"command": "triggered"}),
    Vector("triggered-no", "41 75 31 01 00 32", {"command": "triggered", "triggered": False}),
    Vector("triggered-yes", "41 75 31 01 01 33", {"command": "triggered", "triggered": True}),
    Vector("status-query", "42 61 32 01 00 33", {"command": "status"}),
    Vector(
        "status-example",
        "41 75 32 07 0A 00 01 44",
        {"command": "status", "tilt_deg": 7, "acceleration_g": 1.0, "triggered": False, "active": True},
    ),
    Vector("charging-query", "42 61 33 01 00 34", {"command": "charging"}),
    Vector("charging-no", "41 75 33 01 00 34", {"command": "charging", "charging": False}),
    Vector("charging-yes", "41 75 33 01 01 35", {"command": "charging", "charging": True}),
    Vector("cell-voltage-query", "42 61 34 01 00 35", {"command": "cell_voltage"}),
    _voltage("41 75 34 01 BE F3", 3.8),
    _voltage("41 75 34 01 C8 FD", 4.0),
    _voltage("41 75 34 01 D2 07", 4.2),
    _voltage("41 75 35 01 BE F4", 3.8),
    _voltage("41 75 35 01 C8 FE", 4.0),
    _voltage("41 75 35 01 D2 08", 4.2),
    Vector("trigger-records-query", "42 61 35 01 00 36", {"command": "trigger_records"}),
    Vector(
        "trigger-record-example",
        "41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E",
        _RECORD | {"boot_count": 1, "cell_voltage_v": 4.7},
        while_asked="trigger_records",
        note="E12: 4.70 V is implausible without external power",
    ),
    Vector(
        "trigger-record-that-begins-like-a-voltage",
        "41 75 35 01 CA 00 6C 02 3C 05 A0 00 01 0C C8 24",
        _RECORD | {"boot_count": 202, "cell_voltage_v": 4.0},
        while_asked="trigger_records",
        note="E3: computed, not from the table; its first six bytes are a valid six-byte frame",
    ),
    Vector("attitude-trigger-disable", "42 61 16 02 01 19", {"command": "attitude_trigger", "set_enabled": False}),
    _flag("attitude-trigger-disable-ack", "41 75 16 01 01 18"),
    Vector("freefall-trigger-disable", "42 61 17 02 01 1A", {"command": "freefall_trigger", "set_enabled": False}),
    _flag("freefall-trigger-disable-ack-16", "41 75 16 01 01 18", "E4: the table answers with code 16"),
    _flag("freefall-trigger-disable-ack-17", "41 75 17 01 01 19", "E4: the code one would expect"),
    Vector("attitude-trigger-enable", "42 61 16 02 00 18", {"command": "attitude_trigger", "set_enabled": True}),
    _flag("attitude-trigger-enable-ack", "41 75 16 01 00 17"),
    Vector("freefall-trigger-enable", "42 61 17 02 00 19", {"command": "freefall_trigger", "set_enabled": True}),
    _flag("freefall-trigger-enable-ack-16", "41 75 16 01 00 17", "E4: the table answers with code 16"),
    _flag("freefall-trigger-enable-ack-17", "41 75 17 01 00 18", "E4: the code one would expect"),
    Vector("zero-sensor", "42 61 25 01 00 26", {"command": "zero_sensor"}),
    Vector("zero-sensor-ack", "41 75 25 01 01 27", {"command": "zero_sensor"}),
)

VALID = tuple(vector for vector in VECTORS if vector.means is not None)
FROM_HOST = tuple(vector for vector in VALID if vector.is_from_host)
FROM_MODULE = tuple(vector for vector in VALID if not vector.is_from_host)
BY_ID = {vector.id: vector for vector in VECTORS}
