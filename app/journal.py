"""Who did what to which module, written down before it is done and after: what the procedures need of the store.

`begin` is durable when it returns; only then does a dangerous frame leave. Should the program end in between, the
entry without an outcome says: intended, outcome unknown.
"""

from collections.abc import Mapping
from enum import Enum
from typing import Protocol

from app.acts import Act


class Outcome(Enum):
    """What became of an act; the value is its name in the audit log."""

    CONFIRMED = "confirmed"
    """The module reports that it is so."""
    REFUSED = "refused"
    """The module says no, or reports that it is not so."""
    UNKNOWN = "unknown"
    """Sent, and not confirmed: it may have been carried out."""
    NOT_SENT = "not sent"


class JournalFailed(Exception):
    """The intent could not be written down. `sentence` is for people."""

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence


class Journal(Protocol):
    """One for one connection to one module."""

    @property
    def is_ready(self) -> bool:
        """Whether there is any hope that `begin` succeeds."""
        ...

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> int:
        """Write the intent down; the number of the entry. Raises `JournalFailed`."""
        ...

    def settle(self, entry: int, outcome: Outcome, result: Mapping[str, object], /) -> None:
        """Write the outcome down. Never raises: an outcome that is missing reads as unknown."""
        ...

    def begin_baud(self, old_rate: int, new_rate: int, /) -> int:
        """Write down which rates to look at after a crash. Raises `JournalFailed`."""
        ...

    def settle_baud(self, entry: int, outcome: str, /) -> None:
        """The module was found, or given up. Never raises."""
        ...


class NoJournal:
    """Where there is no store: nothing can be written down, so nothing dangerous is sent."""

    def __init__(self, sentence: str = "") -> None:
        self._sentence = sentence

    @property
    def is_ready(self) -> bool:
        return False

    def begin(self, _act: Act, _frame: bytes, _detail: Mapping[str, object], /) -> int:
        raise JournalFailed(self._sentence)

    def settle(self, _entry: int, _outcome: Outcome, _result: Mapping[str, object], /) -> None:
        return

    def begin_baud(self, _old_rate: int, _new_rate: int, /) -> int:
        raise JournalFailed(self._sentence)

    def settle_baud(self, _entry: int, _outcome: str, /) -> None:
        return


def begin_if_possible(journal: Journal, act: Act, frame: bytes, detail: Mapping[str, object]) -> int | None:
    """For what is not dangerous: done also where it cannot be written down."""
    try:
        return journal.begin(act, frame, detail)
    except JournalFailed:
        return None
