"""What the simulated module remembers: settings, boot count and trigger records; and what a restart resets."""

import random
from collections import deque
from dataclasses import dataclass, field

from app.flights.judge import TriggerLimits
from protocol.catalogue import BAUD, CENTISECOND, INVERTED, MAX_RECORDS, QUERY, RECORD_CODE, TENTH_G
from protocol.frame import encode_long
from protocol.messages import Source, encode_record_data


@dataclass(slots=True, kw_only=True)
class Memory:
    """What survives a restart; bytes as on the wire. `records`: their eleven data bytes (D4 … D14), oldest first."""

    light_threshold: int = 0x12
    attitude_threshold: int = 60
    freefall_acceleration: int = 5
    freefall_time: int = 160
    baud_code: int = 6
    boot_count: int = 0
    zero_tilt_deg: float = 0.0
    records: deque[bytes] = field(default_factory=lambda: deque(maxlen=MAX_RECORDS))

    @property
    def baud_rate(self) -> int:
        return BAUD.values[self.baud_code]


@dataclass(slots=True, kw_only=True)
class ModuleState:
    """What a restart resets. A module begins locked, with both triggers enabled."""

    is_active: bool = False
    attitude_is_enabled: bool = True
    freefall_is_enabled: bool = True
    serial_output_is_on: bool = False
    # After `11 00` nothing fires until `11 01`, `10` or a restart; the table names no end (E15).
    is_forbidden: bool = False


def limits(memory: Memory, state: ModuleState) -> TriggerLimits:
    """Return the thresholds by which the module fires, in the units of the judge."""
    return TriggerLimits(
        attitude_threshold_deg=memory.attitude_threshold,
        freefall_acceleration_g=memory.freefall_acceleration / TENTH_G.per_unit,
        freefall_time_s=memory.freefall_time / CENTISECOND.per_unit,
        attitude_is_enabled=state.attitude_is_enabled,
        freefall_is_enabled=state.freefall_is_enabled,
    )


def record_data(
    memory: Memory, *, uptime_s: float, sources: Source, is_connected: bool, is_charging: bool, light: int, voltage: int
) -> bytes:
    """Return D4 … D14 of a trigger record; `light` and `voltage` are bytes."""
    return encode_record_data(
        {
            "boot_count": memory.boot_count,
            "uptime_s": min(0xFFFF, int(uptime_s)),  # "最高记录65535秒"
            "sources": sources.value,
            "attitude_threshold_deg": memory.attitude_threshold,
            "freefall_acceleration_g": memory.freefall_acceleration,
            "freefall_time_s": memory.freefall_time,
            "serial_connected": INVERTED.encode(is_connected),
            "charging": INVERTED.encode(is_charging),
            "light_v": light,
            "cell_voltage_v": voltage,
        }
    )


def record_frame(data: bytes) -> bytes:
    return encode_long(RECORD_CODE, bytes((QUERY,)) + data)


# Together they have every source, alone and with others.
_PAST_SOURCES = (
    Source.ATTITUDE, Source.FREEFALL, Source.SERIAL, Source.ATTITUDE | Source.FREEFALL, Source.PWM, Source.ATTITUDE,
    Source.SERIAL | Source.PWM, Source.FREEFALL, Source.ATTITUDE | Source.PWM | Source.FREEFALL,
)  # fmt: skip


def invent_records(memory: Memory, count: int, *, seed: int) -> None:
    """Add `count` (0 … 9) plausible records of earlier boots; the same ones for the same seed."""
    source = random.Random(seed)  # noqa: S311 (variety, not secrets)
    boots = sorted(source.randrange(max(1, memory.boot_count)) for _ in range(count))
    for boot, sources in zip(boots, _PAST_SOURCES[:count], strict=True):
        data = record_data(
            Memory(boot_count=boot, attitude_threshold=source.choice((55, 60, 65)), freefall_time=160),
            uptime_s=source.randrange(20, 5400),
            sources=sources,
            is_connected=Source.SERIAL in sources or source.random() < 0.5,
            is_charging=False,
            light=source.randrange(2, 5),
            voltage=source.randrange(182, 208),
        )
        memory.records.append(data)
