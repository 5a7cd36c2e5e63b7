"""Audit journal interface: who did what to which module, written before and after.

Nothing here waits for a disk: the journal has a thread of its own. An `Entry` is durable when it is done without an
exception; only then does a dangerous frame leave. Should the program end in between, the entry without an outcome says:
intended, outcome unknown.
"""

from collections.abc import Mapping
from concurrent.futures import Future
from enum import Enum
from typing import Protocol

from app.engine.procedure import Await, EngineView, Inspect, Procedure
from app.safety.acts import Act
from app.text.i18n import tr

DURABLE_LIMIT_S = 5.0
"""As long as a confirmation counts: an intent that is not on disk by then is given up."""
SLOW_DISK_S = 0.1
"""After a longer wait for the disk the module is asked again before the conditions are judged again."""


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


Entry = Future[int]
"""Its number in the log, once it is durable; raises `JournalFailed` where it could not be written."""


class Journal(Protocol):
    """One for one connection to one module. Every method returns at once; what was called first is written first."""

    @property
    def is_ready(self) -> bool:
        """Whether there is any hope that `begin` succeeds."""
        ...

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        """Write the intent down."""
        ...

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object], /) -> None:
        """Write the outcome down. An outcome that is missing reads as unknown."""
        ...

    def begin_baud(self, old_rate: int, new_rate: int, /) -> Entry:
        """Write down which rates to look at after a crash."""
        ...

    def settle_baud(self, entry: Entry, outcome: str, /) -> None:
        """The module was found, or given up."""
        ...


class NoJournal:
    """Where there is no store: nothing can be written down, so nothing dangerous is sent."""

    def __init__(self, sentence: str = "") -> None:
        self._sentence = sentence

    @property
    def is_ready(self) -> bool:
        return False

    def begin(self, _act: Act, _frame: bytes, _detail: Mapping[str, object], /) -> Entry:
        return self._refused()

    def settle(self, _entry: Entry, _outcome: Outcome, _result: Mapping[str, object], /) -> None:
        return

    def begin_baud(self, _old_rate: int, _new_rate: int, /) -> Entry:
        return self._refused()

    def settle_baud(self, _entry: Entry, _outcome: str, /) -> None:
        return

    def _refused(self) -> Entry:
        entry = Entry()
        entry.set_exception(JournalFailed(self._sentence))
        return entry


def durable(entry: Entry, limit_s: float = DURABLE_LIMIT_S) -> Procedure[bool]:
    """Wait until the intent is on disk, while the line serves others; whether it took long. Raises `JournalFailed`."""
    began: EngineView = yield Inspect()
    is_written = yield Await(entry, limit_s)
    if not is_written or entry.cancelled():
        raise JournalFailed(tr("The disk is too slow."))
    entry.result()
    ended: EngineView = yield Inspect()
    return ended.now - began.now > SLOW_DISK_S
