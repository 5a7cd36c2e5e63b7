"""What stays of the conversations that ended at one port, as notices, until a person closes them.

There is one notice of the interruptions themselves, however many there were. Beside it stays what a person must not
miss, each by itself: the report of what was interrupted, a TRIGGERED that was seen, and the drafts that were not
written.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from PySide6.QtCore import QObject, Signal

from app.text.messages import UserMessage
from protocol.events import EndReason
from protocol.fields import Value

# A person ends these on purpose, so nobody has to be told.
UNTOLD = frozenset({EndReason.CLOSED, EndReason.RATE_CHANGED, EndReason.ANOTHER})


@dataclass(frozen=True, slots=True, eq=False)
class Remainder:
    """What stays of one conversation: a report, drafts, or, with neither, a TRIGGERED that was seen."""

    # The module's name, or "".
    module: str
    text: UserMessage | None = None
    # By the setting's key, as they stood when the conversation ended; not written.
    drafts: Mapping[str, Value] | None = None
    # What stood in a field and cannot be sent, by the setting's key.
    mistyped: Mapping[str, str] = field(default_factory=dict)
    # When it was kept, in seconds since 1970.
    at: float = field(default_factory=time.time)

    @property
    def is_trigger(self) -> bool:
        return self.text is None and self.drafts is None


class Interruptions(QObject):
    """Of one port. Belongs to the window's thread."""

    changed = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        # How often a conversation ended since the notice was closed; when the first and the last of these did, in
        # seconds since 1970, and why the last one did.
        self.count = 0
        self.first_at = self.last_at = 0.0
        self.last: UserMessage | None = None
        self.remainders: tuple[Remainder, ...] = ()

    def note(self, reason: EndReason, text: UserMessage) -> None:
        """A conversation that had begun is over."""
        if reason in UNTOLD:
            return
        self.last, self.last_at = text, time.time()
        self.first_at = self.first_at if self.count else self.last_at
        self.count += 1
        self.changed.emit()

    def close(self) -> None:
        """A person has read of the interruptions."""
        self.count, self.last = 0, None
        self.changed.emit()

    def keep(self, remainder: Remainder) -> None:
        self.remainders += (remainder,)
        self.changed.emit()

    def close_remainder(self, remainder: Remainder) -> None:
        self.remainders = tuple(one for one in self.remainders if one is not remainder)
        self.changed.emit()

    def count_drafts(self) -> int:
        """Settings that were edited, are kept here and are not written."""
        return sum(len(one.drafts or ()) + len(one.mistyped) for one in self.remainders)

    def discard_drafts(self) -> None:
        """A person does not want them."""
        self.remainders = tuple(one for one in self.remainders if one.drafts is None)
        self.changed.emit()
