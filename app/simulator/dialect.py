"""What the vendor's table leaves open or contradicts, and how one particular module may decide it.

The defaults are what the table's own frames show. Bracketed names (E2 …) are explained in `docs/protocol.md`.
"""

from dataclasses import dataclass
from enum import StrEnum


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
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
    empty_slots: EmptySlots = EmptySlots.NONE
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
    mute_codes: frozenset[int] = frozenset()
    """Commands that it does not know: no answer and no effect."""
