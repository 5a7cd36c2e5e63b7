"""Quirks: how a particular module decides what the vendor's table leaves open or contradicts.

The defaults are what the table's own frames show. Bracketed names (E2 …) are explained in `docs/protocol.md`.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple


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

    ack: Acknowledge = Acknowledge.ECHO
    """E2: what acknowledges a set of 21, 22, 24."""
    voltage_code: int = 0x35
    """E3: code of the reply to 34."""
    freefall_ack: int = 0x16
    """E4: code of the acknowledgement of 17."""
    records: Delivery = Delivery.TOGETHER
    """E6: how several records come back to one query."""
    record_gap_ms: float = 20.0
    """E6: pause between records or pieces."""
    empty_slots: EmptySlots = EmptySlots.ZEROS
    """E7: what is sent for a slot that was never used."""
    baud_ack: BaudChange = BaudChange.OLD
    """E9: rate of the acknowledgement of 24, and when the new rate begins."""
    light_inverted: bool = False
    """E11: more light reads lower."""
    odd_voltage: bool = False
    """E12: records carry EB (4.70 V) as in the worked example."""
    remembers: bool = False
    """E15: activation, flags 16 and 17 and serial output survive a restart."""
    keeps: bool = True
    """False: acknowledges settings and does not keep them."""
    clamps: bool = False
    """Forces settings into the vendor's advice and acknowledges what it kept."""
    refuses: bool = False
    """Keeps the old setting and acknowledges that."""
    stream: Streaming = Streaming.YES
    """Whether serial output streams, is only acknowledged, or is not even answered."""
    stream_at_boot: bool = False
    """Serial output is on after every power-up."""
    mute_codes: Marks = frozenset()
    """Commands that it does not know, or not any more from the n-th request on: no answer and no effect."""
    # Lies and defects, which no table explains.
    cross_talk: tuple[Rule, ...] = ()
    """A set of one setting changes another one."""
    read_changes: tuple[Rule, ...] = ()
    """A setting changes after something was read."""
    revert_ms: float = 0.0
    """Settings go back this long after a set; 0 never."""
    clamp_ms: float = 0.0
    """Settings are forced into the vendor's advice this long after a set; 0 never."""
    forgets: bool = False
    """A restart brings the vendor's defaults back."""
    silent_restart_ms: float = 0.0
    """Restarts without heartbeats this long after it acknowledged a change; 0 never."""
    restart_at_s: float = 0.0
    """Restarts without heartbeats whenever it has run for this long; 0 never."""
    drop_records: Marks = frozenset()
    """Records (1 is the oldest) that are left out, always or the n-th time that they are asked for."""
    double_codes: frozenset[int] = frozenset()
    """Replies to these commands come twice."""
    double_ms: float = 0.0
    """How long after the first the second one comes."""
    foreign_replies: tuple[Rule, ...] = ()
    """A reply of another command is inserted: before the true one, or this long after it."""
    stream_jitter_ms: float = 0.0
    """Streamed status frames come up to this much late."""
    activates: bool = True
    """False: acknowledges the activation and stays locked."""
    locks: bool = True
    """False: acknowledges locking and stays active."""
    active_late_ms: float = 0.0
    """Reports a new activation state only this long afterwards."""
    zeroes: bool = True
    """False: acknowledges zeroing without effect."""
    shuts_down: bool = True
    """False: acknowledges the shutdown and stays on."""
