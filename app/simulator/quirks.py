"""Quirks: how a particular module behaves where the vendor's table leaves it open or contradicts itself.

The defaults follow the frames in the table. Names in brackets (E2 …) are explained in `docs/protocol.md`.
"""

# ruff: noqa: RUF009  an option is a field

from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import partial
from typing import Any, NamedTuple

from protocol.translatable import marked

MILLISECONDS = ("MS", 0.0, 10_000.0)
RULES = "CODE:CODE[=HEX][/N][@MS],…"
"""A request to the first code changes or sends the second: with this value, the n-th time, after this delay."""


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


class Occasion(NamedTuple):
    """A code or a record number, and the n-th time that it is asked for."""

    what: int
    time: int

    def __str__(self) -> str:
        return f"{self.what:02X}/{self.time}"


Marks = frozenset[int | Occasion]
"""Codes or record numbers; a plain number means every time."""


class Rule(NamedTuple):
    """Effect of a request to one code on another, in the form `21:20=14/2@500`."""

    cause: int
    effect: int
    value: int | None = None
    """Byte of the effect; None for the one that was set, or for the true one."""
    time: int = 0
    """The n-th time only; 0 for every time."""
    after_ms: float = 0.0

    def __str__(self) -> str:
        value = "" if self.value is None else f"={self.value:02X}"
        time = f"/{self.time}" if self.time else ""
        after = f"@{self.after_ms:g}" if self.after_ms else ""
        return f"{self.cause:02X}:{self.effect:02X}{value}{time}{after}"


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
    mute_codes: Marks = _defect(frozenset(), marked("Ignored commands"), "CODE[/N],…")
    cross_talk: tuple[Rule, ...] = _defect((), marked("Set changes another"), RULES)
    read_changes: tuple[Rule, ...] = _defect((), marked("Query changes another"), RULES)
    revert_ms: float = _defect(0.0, marked("Settings revert after"), MILLISECONDS)
    clamp_ms: float = _defect(0.0, marked("Clamps settings"), MILLISECONDS)
    forgets: bool = _defect(False, marked("Restart loses settings"))
    silent_restart_ms: float = _defect(0.0, marked("Silent restart after"), MILLISECONDS)
    restart_at_s: float = _defect(0.0, marked("Silent restart every"), ("S", 0, 86_400))
    drop_records: Marks = _defect(frozenset(), marked("Missing records"), "RECORD[/N],…")
    double_codes: frozenset[int] = _defect(frozenset(), marked("Duplicate replies"), "CODE,…")
    double_ms: float = _defect(0.0, marked("Repeated after"), MILLISECONDS)
    foreign_replies: tuple[Rule, ...] = _defect((), marked("Foreign replies"), RULES)
    stream_jitter_ms: float = _defect(0.0, marked("Jitter"), MILLISECONDS)
    activates: bool = _defect(True, marked("Activate"))
    locks: bool = _defect(True, marked("Lock"))
    active_late_ms: float = _defect(0.0, marked("Reports active late"), MILLISECONDS)
    zeroes: bool = _defect(True, marked("Zero the sensor"))
    shuts_down: bool = _defect(True, marked("Shut down"))
