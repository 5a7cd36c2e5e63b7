"""Audit journal interface: acts on a module, logged before and after they are sent.

Nothing here waits for a disk: the journal has a thread of its own. An `Entry` is durable when it is done without an
exception; only then does a dangerous frame leave. Should the program end in between, the entry without an outcome says:
intended, outcome unknown.
"""

from collections.abc import Mapping
from concurrent.futures import Future
from enum import Enum
from typing import Protocol

from app.engine.procedure import Await, Procedure
from app.safety.acts import Act
from app.text.user_error import UserError
from protocol.translatable import marked

# An intent that is not on the disk by then is taken back, and nothing is sent.
DURABLE_LIMIT_S = 1.0
# In the detail of an act: what a person said of it.
NOTE = "note"


class Outcome(Enum):
    """Outcome of an act; the value is its name in the audit log."""

    CONFIRMED = "confirmed"  # the module reports the wanted state
    REFUSED = "refused"  # the module refused, or reports another state
    UNKNOWN = "unknown"  # sent but not confirmed: it may have been carried out
    NOT_SENT = "not sent"


# The future of the entry's id, done once it is durable; raises `UserError` if it could not be written.
Entry = Future[str]


class Journal(Protocol):
    """The journal of one conversation. Every method returns at once; entries are written in order."""

    @property
    def is_ready(self) -> bool:
        """False if `begin` cannot succeed."""
        ...

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        """Log the intent."""
        ...

    def settle(self, entry: Entry, outcome: Outcome, result: Mapping[str, object], /) -> None:
        """Log the outcome; a missing one reads as unknown."""
        ...


class NoJournal:
    """Without a store nothing can be logged, so nothing dangerous is sent."""

    @property
    def is_ready(self) -> bool:
        return False

    def begin(self, _act: Act, _frame: bytes, _detail: Mapping[str, object], /) -> Entry:
        entry = Entry()
        entry.set_exception(UserError(""))
        return entry

    def settle(self, _entry: Entry, _outcome: Outcome, _result: Mapping[str, object], /) -> None:
        return


def durable(entry: Entry) -> Procedure[None]:
    """Wait until the intent is on the disk. One that is not there in time is taken back; where it is just being
    written, its outcome "not sent" follows it. Raises `UserError`."""
    is_written = yield Await(entry, DURABLE_LIMIT_S)
    if not is_written or entry.cancelled():
        entry.cancel()
        raise UserError(marked("The disk is too slow."))
    entry.result()
