"""What stays of the conversations that ended at one port, as notices, until a person closes them.

There is one notice of the interruptions themselves, however many there were. Beside it stays what a person must not
miss, each by itself: the report of what was interrupted, a TRIGGERED that was seen, and the drafts that were not
written.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from PySide6.QtCore import QObject, Signal

from app.text.messages import UserMessage
from protocol.events import EndReason
from protocol.fields import Value

# A person ends these on purpose, so nobody has to be told.
UNTOLD = frozenset({EndReason.CLOSED, EndReason.RATE_CHANGED, EndReason.ANOTHER})


class RemainderKind(Enum):
    REPORT = "report"
    TRIGGERED = "triggered"
    DRAFTS = "drafts"


@dataclass(frozen=True, slots=True, eq=False)
class Remainder:
    """What stays of one conversation. `module`: its name, or ""; `at`: when it was kept, in seconds since 1970."""

    kind: RemainderKind
    module: str
    at: float = 0.0
    text: UserMessage | None = None
    drafts: Mapping[str, Value] | None = None
    """By the setting's key, as they stood when the conversation ended; not written."""
    mistyped: Mapping[str, str] = field(default_factory=dict)
    """What stood in a field and cannot be sent, by the setting's key."""


class Interruptions(QObject):
    """Of one port. Belongs to the window's thread."""

    changed = Signal()

    def __init__(self, wall_clock: Callable[[], float], *, parent: QObject) -> None:
        super().__init__(parent)
        self._wall_clock = wall_clock
        self.count = 0
        """How often a conversation ended since the notice was closed."""
        self.first_at = 0.0
        """When the first of these ended, in seconds since 1970."""
        self.last_at = 0.0
        self.last: UserMessage | None = None
        """Why the last one ended."""
        self.remainders: tuple[Remainder, ...] = ()

    def note(self, reason: EndReason, text: UserMessage) -> None:
        """A conversation that had begun is over."""
        if reason in UNTOLD:
            return
        self.last_at = self._wall_clock()
        if self.count == 0:
            self.first_at = self.last_at
        self.count += 1
        self.last = text
        self.changed.emit()

    def keep(self, remainder: Remainder) -> None:
        self.remainders += (replace(remainder, at=self._wall_clock()),)
        self.changed.emit()

    def close(self) -> None:
        """A person has read of the interruptions."""
        self.count, self.last = 0, None
        self.changed.emit()

    def count_drafts(self) -> int:
        """Settings that were edited, are kept here and are not written."""
        return sum(len(one.drafts or ()) + len(one.mistyped) for one in self.remainders)

    def discard_drafts(self) -> None:
        """A person does not want them."""
        self.remainders = tuple(one for one in self.remainders if one.drafts is None)
        self.changed.emit()

    def close_remainder(self, remainder: Remainder) -> None:
        self.remainders = tuple(one for one in self.remainders if one is not remainder)
        self.changed.emit()
