"""What a simulated module and its line are like: one table for the command line, the query of `sim://` and the panel.

The defaults follow the frames in the vendor's table. Names in brackets (E2 …) are explained in `docs/protocol.md`.
"""

# ruff: noqa: RUF009  an option is a field

from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import partial
from typing import Any

from protocol.translatable import marked

MILLISECONDS = ("MS", 0.0, 10_000.0)
SHARE = ("SHARE", 0.0, 1.0)


class Group(Enum):
    """Heading in the help and on the panel; the value is its text."""

    MODULE = marked("Module")
    QUIRKS = marked("Protocol differences")
    DEFECTS = marked("Module faults")
    FAULTS = marked("Line faults")
    PHYSICAL = marked("Physics")


Kind = tuple[str, float, float] | dict[str, object] | str | None
"""Form of a value: placeholder and range of a number; words with their values; or the placeholder of what
`app.simulator.options` parses by the field's name. None: yes or no, or a member of the default's enumeration."""


def option(group: Group, default: object, text: str, kind: Kind = None) -> Any:
    """A field that is an option of the simulated module: `text` names it in the help and on the panel."""
    return field(default=default, metadata={"group": group, "text": text, "kind": kind})


_module, _quirk, _defect, _fault, _physical = (partial(option, group) for group in Group)


Acknowledge = StrEnum("Acknowledge", ["ECHO", "ONE"])
Delivery = StrEnum("Delivery", ["TOGETHER", "SPACED", "PIECES"])
EmptySlots = StrEnum("EmptySlots", ["NONE", "ZEROS", "ONES"])
BaudChange = StrEnum("BaudChange", ["OLD", "NEW", "RESTART"])
Streaming = StrEnum("Streaming", ["YES", "ACKNOWLEDGED", "SILENT"])


class FaultDirection(StrEnum):
    """Direction in which drop, lose, corrupt, garbage and double apply."""

    TO_HOST = "to-host"
    TO_MODULE = "to-module"
    BOTH = "both"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Initial state, behaviour and line of one module. Shares are 0 … 1."""

    rate: float = _quirk(50.0, marked("Stream rate"), ("HZ", 1, 1440))
    baud: int = _module(115200, marked("Baud rate"), "RATE")
    active: bool = _module(False, marked("Active"))
    boots: int = _module(37, marked("Boot count"), ("N", 0, 255))
    uptime: float = _module(60.0, marked("After power-on"), ("S", 0, 65535))
    """With 0 the two heartbeats after power-on are sent."""
    pwm_after: float = _module(0.0, marked("PWM trigger after"), ("S", 0, 86_400))
    """It fires then if it is active; 0 for never."""
    history: int = _module(0, marked("Trigger records"), ("N", 0, 9))
    seed: int = _module(1, marked("Random seed"), ("N", 0, 2**31))
    tilt: float = _physical(0.0, marked("Tilt"), ("DEG", -180, 180))
    cell: float = _physical(3.9, marked("Cell voltage"), ("V", 0, 5))
    drain: float = _physical(0.05, marked("Cell drain per hour"), ("V", 0, 100))
    bay_open: bool = _physical(False, marked("Parachute bay open"))
    charger: bool = _physical(False, marked("External power"))
    noise: float = _physical(0.0, marked("Sensor noise"), ("N", 0, 100))
    """1 is typical."""
    lifelike: bool = _physical(False, marked("Wobbles"))
    ack: Acknowledge = _quirk(Acknowledge.ECHO, marked("E2: acknowledgement"))
    voltage_code: int = _quirk(0x35, marked("E3: voltage code"), {"34": 0x34, "35": 0x35})
    freefall_ack: int = _quirk(0x16, marked("E4: code for 17"), {"16": 0x16, "17": 0x17})
    records: Delivery = _quirk(Delivery.TOGETHER, marked("E6: record delivery"))
    record_gap_ms: float = _quirk(20.0, marked("E6: record gap"), MILLISECONDS)
    empty_slots: EmptySlots = _quirk(EmptySlots.NONE, marked("E7: empty slots"))
    baud_ack: BaudChange = _quirk(BaudChange.OLD, marked("E9: baud-rate change"))
    light_inverted: bool = _quirk(False, marked("E11: inverted light"))
    odd_voltage: bool = _quirk(False, marked("E12: 4.70 V records"))
    remembers: bool = _quirk(False, marked("E15: keeps state"))
    stream: Streaming = _quirk(Streaming.YES, marked("Serial output"))
    stream_at_boot: bool = _quirk(False, marked("Streams after start"))
    keeps: bool = _quirk(True, marked("Keeps settings"))
    clamps: bool = _quirk(False, marked("Clamps settings"))
    refuses: bool = _quirk(False, marked("Refuses settings"))
    mute_codes: frozenset[int] = _defect(frozenset(), marked("Ignored commands"), "CODE,…")
    forgets: bool = _defect(False, marked("Restart loses settings"))
    restart_at_s: float = _defect(0.0, marked("Silent restart every"), ("S", 0, 86_400))
    drop: float = _fault(0.0, marked("Lost frames"), SHARE)
    lose: float = _fault(0.0, marked("Lost bytes"), SHARE)
    corrupt: float = _fault(0.0, marked("Bit errors"), SHARE)
    garbage: float = _fault(0.0, marked("Garbage"), SHARE)
    double: float = _fault(0.0, marked("Duplicate replies"), SHARE)
    direction: FaultDirection = _fault(FaultDirection.TO_HOST, marked("Direction of faults"))
    delay_ms: float = _fault(0.0, marked("Delay"), MILLISECONDS)
    jitter_ms: float = _fault(0.0, marked("Jitter"), MILLISECONDS)
    split_ms: float = _fault(0.0, marked("Split, pause"), MILLISECONDS)
    echo: bool = _fault(False, marked("Echo"))
    mute: bool = _fault(False, marked("Mute"))
    lag_ms: float = _fault(0.0, marked("Wireless lag"), MILLISECONDS)
    paced: bool = _fault(True, marked("Baud-rate timing"))
