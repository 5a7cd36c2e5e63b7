"""Quirks: how a particular module behaves where the vendor's table leaves it open or contradicts itself.

The defaults follow the frames in the table. Names in brackets (E2 …) are explained in `docs/protocol.md`.
"""

# ruff: noqa: RUF009  an option is a field

from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import partial
from typing import Any

from protocol.translatable import marked

MILLISECONDS = ("MS", 0.0, 10_000.0)


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


_quirk, _defect = partial(option, Group.QUIRKS), partial(option, Group.DEFECTS)


Acknowledge = StrEnum("Acknowledge", ["ECHO", "ONE"])
Delivery = StrEnum("Delivery", ["TOGETHER", "SPACED", "PIECES"])
EmptySlots = StrEnum("EmptySlots", ["NONE", "ZEROS", "ONES"])
BaudChange = StrEnum("BaudChange", ["OLD", "NEW", "RESTART"])
Streaming = StrEnum("Streaming", ["YES", "ACKNOWLEDGED", "SILENT"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Quirks:
    """Behaviour of one module."""

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
