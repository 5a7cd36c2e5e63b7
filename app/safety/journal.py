"""Acts that change the state of a module: the frame of each, and the journal.

Nothing here waits for a disk: the journal has a thread of its own. An `Entry` is durable when it is done without an
exception; only then does a dangerous frame leave. Should the program end in between, the entry without an outcome says:
intended, outcome unknown.
"""

from collections.abc import Mapping
from concurrent.futures import Future
from enum import Enum
from types import MappingProxyType

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


# Title, effect, and the frame of those that are one fixed frame.
_ACTS: Mapping[Act, tuple[str, str, Request | None]] = {
    Act.LOCK: (marked("Lock"), marked("Treat it as ready to fire until it reports LOCKED."), LOCK),
    Act.ACTIVATE: (
        marked("Activate"),
        marked("An active module fires when it tips over or falls."),
        ACTIVATION.set(True),
    ),
    Act.ZERO: (
        marked("Zero the sensor"),
        marked("Takes this position as level; for small mounting errors only."),
        BY_NAME["zero_sensor"].query(),
    ),
    Act.SHUTDOWN: (
        marked("Shut down"),
        marked("Off until its switch (2 s) or external power."),
        BY_NAME["shutdown"].set(True),
    ),
    Act.FORBID_DEPLOY: (
        marked("Forbid serial trigger"),
        marked("Over serial only: it still fires by itself."),
        BY_NAME["deploy"].set(False),
    ),
    Act.DEPLOY: (marked("Deploy"), marked("Fires the parachute."), BY_NAME["deploy"].set(True)),
    Act.CHANGE_BAUD: (marked("Change the baud rate"), marked("The vendor advises not to change it."), None),
    Act.WRITE: (marked("Write a setting"), marked("Write a setting"), None),
}
TITLES = MappingProxyType({act: title for act, (title, _, _) in _ACTS.items()})
EFFECTS = MappingProxyType({act: effect for act, (_, effect, _) in _ACTS.items()})
REQUESTS = MappingProxyType({act: request for act, (_, _, request) in _ACTS.items() if request is not None})


class Outcome(Enum):
    """Outcome of an act; the value is its name in the audit log."""

    CONFIRMED = "confirmed"  # the module reports the wanted state
    REFUSED = "refused"  # the module refused, or reports another state
    UNKNOWN = "unknown"  # sent but not confirmed: it may have been carried out
    NOT_SENT = "not sent"


# The future of the entry's id, done once it is durable; raises `UserError` if it could not be written.
Entry = Future[str]


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
