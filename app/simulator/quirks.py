"""Quirks: how a particular module decides what the vendor's table leaves open or contradicts.

The defaults are what the table's own frames show. Bracketed names (E2 …) are explained in `docs/protocol.md`.
"""

# ruff: noqa: RUF009  an option is a field

from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import partial
from typing import Any, NamedTuple

from protocol.translatable import marked

MILLISECONDS = ("MS", 0.0, 10_000.0)


class Group(Enum):
    """Heading in the help; the value is its English, translatable text."""

    MODULE = marked("module")
    DIALECT = marked("quirks: where the vendor's table leaves it open")
    LIES = marked("lies and defects of the module; codes and values in hexadecimal")
    FAULTS = marked("faults of the line")
    PHYSICAL = marked("physical side")


Kind = tuple[str, float, float] | dict[str, object] | str | None
"""What a value is typed as: placeholder and range of a number, words with their values, or the placeholder of what
`app.simulator.options` parses by the field's name. None: yes or no, or a member of the default's enumeration."""


def option(group: Group, default: object, text: str, kind: Kind = None) -> Any:
    """A field that is an option of the simulated module; `text` begins with the E-number where there is one."""
    return field(default=default, metadata={"group": group, "text": text, "kind": kind})


_dialect, _lie = partial(option, Group.DIALECT), partial(option, Group.LIES)


class Acknowledge(StrEnum):
    ECHO = "echo"
    ONE = "one"


class Delivery(StrEnum):
    TOGETHER = "together"
    SPACED = "spaced"
    PIECES = "pieces"


class EmptySlots(StrEnum):
    NONE = "none"
    ZEROS = "zeros"
    ONES = "ones"


class BaudChange(StrEnum):
    OLD = "old"
    NEW = "new"
    RESTART = "restart"


class Streaming(StrEnum):
    YES = "yes"
    ACKNOWLEDGED = "acknowledged"
    SILENT = "silent"


class Occasion(NamedTuple):
    """A code or a record together with the occasion: the n-th time that it is asked for."""

    what: int
    time: int

    def __str__(self) -> str:
        return f"{self.what:02X}/{self.time}"


Marks = frozenset[int | Occasion]
"""Codes or record numbers; a bare number stands for every occasion."""


class Rule(NamedTuple):
    """What a request to one code does to another one, as typed: `21:20=14/2@500`."""

    cause: int
    effect: int
    value: int | None = None
    """Byte that the effect takes; None for the one that was set, or for the true one."""
    time: int = 0
    """Only the n-th time; 0 for every time."""
    after_ms: float = 0.0

    def __str__(self) -> str:
        value = "" if self.value is None else f"={self.value:02X}"
        time = f"/{self.time}" if self.time else ""
        after = f"@{self.after_ms:g}" if self.after_ms else ""
        return f"{self.cause:02X}:{self.effect:02X}{value}{time}{after}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Quirks:
    """Frozen; use `dataclasses.replace` for another one."""

    ack: Acknowledge = _dialect(
        Acknowledge.ECHO, marked("E2: a set of 21, 22 or 24 is acknowledged by the value or by 01")
    )
    voltage_code: int = _dialect(
        0x35, marked("E3: code of the answer to the cell voltage, 34"), {"34": 0x34, "35": 0x35}
    )
    freefall_ack: int = _dialect(0x16, marked("E4: code of the acknowledgement of 17"), {"16": 0x16, "17": 0x17})
    records: Delivery = _dialect(
        Delivery.TOGETHER, marked("E6: records come in one go, one by one, or cut into pieces of seven bytes")
    )
    record_gap_ms: float = _dialect(20.0, marked("E6: pause between records or pieces"), MILLISECONDS)
    empty_slots: EmptySlots = _dialect(
        EmptySlots.ZEROS, marked("E7: slots never used are left out, sent as 00, or sent as FF")
    )
    baud_ack: BaudChange = _dialect(
        BaudChange.OLD, marked("E9: a new rate is acknowledged at the old rate, at the new, or begins at a restart")
    )
    light_inverted: bool = _dialect(False, marked("E11: more light reads lower"))
    odd_voltage: bool = _dialect(False, marked("E12: records carry 4.70 V, as the worked example does"))
    remembers: bool = _dialect(False, marked("E15: activation, trigger flags and serial output survive a restart"))
    stream: Streaming = _dialect(
        Streaming.YES, marked("serial output streams, is acknowledged without streaming, or is not answered")
    )
    stream_at_boot: bool = _dialect(False, marked("serial output is on after every start"))
    keeps: bool = _dialect(True, marked("no: acknowledges settings and does not keep them"))
    clamps: bool = _dialect(False, marked("forces settings into the vendor's advice and acknowledges what it kept"))
    refuses: bool = _dialect(False, marked("keeps the old setting and acknowledges that"))
    mute_codes: Marks = _lie(
        frozenset(), marked("commands that it does not know, such as 14,33; 35/2 from the second time on"), "CODES"
    )
    cross_talk: tuple[Rule, ...] = _lie(
        (),
        marked(
            "a set of one changes another: 21:20, with a value 16:17=01, the second time and 500 ms later "
            "21:20=14/2@500"
        ),
        "RULES",
    )
    read_changes: tuple[Rule, ...] = _lie((), marked("the same after a query: 20:20=14/2@500"), "RULES")
    revert_ms: float = _lie(0.0, marked("settings go back to what they were, this long after a set"), MILLISECONDS)
    clamp_ms: float = _lie(
        0.0, marked("settings are forced into the vendor's advice, this long after a set"), MILLISECONDS
    )
    forgets: bool = _lie(False, marked("a restart brings the default settings back"))
    silent_restart_ms: float = _lie(
        0.0, marked("restarts without heartbeats, this long after it acknowledged a change"), MILLISECONDS
    )
    restart_at_s: float = _lie(
        0.0, marked("restarts without heartbeats whenever it has run this long"), ("S", 0, 86_400)
    )
    drop_records: Marks = _lie(
        frozenset(), marked("records left out, 1 is the oldest: 3 always, 1/2 the second time"), "RECORDS"
    )
    double_codes: frozenset[int] = _lie(frozenset(), marked("commands that are answered twice, such as 01,32"), "CODES")
    double_ms: float = _lie(0.0, marked("how long after the first the second answer comes"), MILLISECONDS)
    foreign_replies: tuple[Rule, ...] = _lie(
        (),
        marked("an answer to another command comes first: 20:22, with a value 20:22=05, or 500 ms later 20:22@500"),
        "RULES",
    )
    stream_jitter_ms: float = _lie(0.0, marked("streamed status frames come up to this much late"), MILLISECONDS)
    activates: bool = _lie(True, marked("no: acknowledges the activation and stays locked"))
    locks: bool = _lie(True, marked("no: acknowledges locking and stays active"))
    active_late_ms: float = _lie(0.0, marked("reports a new activation state only this long afterwards"), MILLISECONDS)
    zeroes: bool = _lie(True, marked("no: acknowledges zeroing without effect"))
    shuts_down: bool = _lie(True, marked("no: acknowledges the shutdown and stays on"))
