"""Acts that change the state of a module: the frame of each, and the journal.

Nothing here waits for a disk: the journal has a thread of its own. An `Entry` is durable when it is done without an
exception; only then does a dangerous frame leave. Should the program end in between, the entry without an outcome says:
intended, outcome unknown.
"""

from collections.abc import Mapping
from concurrent.futures import Future
from enum import Enum
from typing import Any

from app.engine.procedure import Procedure, wait_for
from app.text.messages import UserError
from protocol.catalogue import ACTIVATION, BY_NAME, LOCK, Request
from protocol.translatable import marked

# An intent that is not on the disk by then is taken back, and nothing is sent.
DURABLE_LIMIT_S = 1.0
# In the detail of an act: what a person said of it.
NOTE = "note"


class Act(Enum):
    """The value is the name in the audit log and in records."""

    LOCK = "lock"
    ACTIVATE = "activate"
    ZERO = "zero"
    SHUTDOWN = "shutdown"
    FORBID_DEPLOY = "forbid_deploy"
    DEPLOY = "deploy"
    CHANGE_BAUD = "change_baud"
    WRITE = "write"  # a setting other than the baud rate


TITLES: Mapping[Act, str] = {
    Act.LOCK: marked("Lock"),
    Act.ACTIVATE: marked("Activate"),
    Act.ZERO: marked("Zero the sensor"),
    Act.SHUTDOWN: marked("Shut down"),
    Act.FORBID_DEPLOY: marked("Forbid serial trigger"),
    Act.DEPLOY: marked("Deploy"),
    Act.CHANGE_BAUD: marked("Change the baud rate"),
    Act.WRITE: marked("Write a setting"),
}
# What a person is told before it is done.
EFFECTS: Mapping[Act, str] = {
    Act.ACTIVATE: marked("An active module fires when it tips over or falls."),
    Act.ZERO: marked("Takes this position as level; for small mounting errors only."),
    Act.SHUTDOWN: marked("Off until its switch (2 s) or external power."),
    Act.FORBID_DEPLOY: marked("Over serial only: it still fires by itself."),
    Act.DEPLOY: marked("Fires the parachute."),
}
# The frame of those that are one fixed frame.
REQUESTS: Mapping[Act, Request] = {
    Act.LOCK: LOCK,
    Act.ACTIVATE: ACTIVATION.set(True),
    Act.ZERO: BY_NAME["zero_sensor"].query(),
    Act.SHUTDOWN: BY_NAME["shutdown"].set(True),
    Act.FORBID_DEPLOY: BY_NAME["deploy"].set(False),
    Act.DEPLOY: BY_NAME["deploy"].set(True),
}


class Outcome(Enum):
    """Outcome of an act; the value is its name in the audit log."""

    CONFIRMED = "confirmed"  # the module reports the wanted state
    REFUSED = "refused"  # the module refused, or reports another state
    UNKNOWN = "unknown"  # sent but not confirmed: it may have been carried out
    NOT_SENT = "not sent"


# The future of an entry, done once it is durable; raises `UserError` if it could not be written.
Entry = Future[Any]


class Journal:
    """The journal of one conversation. Every method returns at once; entries are written in order.

    This one logs nothing, as there is no store: so nothing dangerous is sent. Others are made from it.
    """

    # Whether `begin` may succeed.
    is_ready = False

    def begin(self, _act: Act, _frame: bytes, _detail: Mapping[str, object], /) -> Entry:
        """Log the intent."""
        entry = Entry()
        entry.set_exception(UserError(""))
        return entry

    def settle(self, _entry: Entry, _outcome: Outcome, _result: Mapping[str, object], /) -> None:
        """Log the outcome; a missing one reads as unknown."""


def durable(entry: Entry) -> Procedure[None]:
    """Wait until the intent is on the disk. One that is not there in time is taken back; where it is just being
    written, its outcome "not sent" follows it. Raises `UserError`."""
    is_written = yield from wait_for(entry, DURABLE_LIMIT_S)
    if not is_written or entry.cancelled():
        entry.cancel()
        raise UserError(marked("The disk is too slow."))
    entry.result()
