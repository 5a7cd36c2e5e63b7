"""Acts that change the state of a module, and the frame of each."""

from collections.abc import Iterable, Mapping
from enum import Enum
from types import MappingProxyType

from protocol.catalogue import ACTIVATION, BY_NAME, LOCK, Request
from protocol.events import Event, Sent
from protocol.translatable import marked


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


TITLES: Mapping[Act, str] = MappingProxyType({
    Act.LOCK: marked("Lock"),
    Act.ACTIVATE: marked("Activate"),
    Act.ZERO: marked("Zero the sensor"),
    Act.SHUTDOWN: marked("Shut down"),
    Act.FORBID_DEPLOY: marked("Forbid serial trigger"),
    Act.DEPLOY: marked("Deploy"),
    Act.CHANGE_BAUD: marked("Change the baud rate"),
    Act.WRITE: marked("Write a setting"),
})  # fmt: skip

EFFECTS: Mapping[Act, str] = MappingProxyType({
    Act.LOCK: marked("Treat it as ready to fire until it reports LOCKED."),
    Act.ACTIVATE: marked("An active module fires when it tips over or falls."),
    Act.ZERO: marked("Takes this position as level; for small mounting errors only."),
    Act.SHUTDOWN: marked("Off until its switch (2 s) or external power."),
    Act.FORBID_DEPLOY: marked("Over serial only: it still fires by itself."),
    Act.DEPLOY: marked("Fires the parachute."),
    Act.CHANGE_BAUD: marked("The vendor advises not to change it."),
    Act.WRITE: marked("Write a setting"),
})  # fmt: skip

# The acts that are one fixed frame.
REQUESTS: Mapping[Act, Request] = MappingProxyType({
    Act.LOCK: LOCK,
    Act.ACTIVATE: ACTIVATION.set(True),
    Act.ZERO: BY_NAME["zero_sensor"].query(),
    Act.SHUTDOWN: BY_NAME["shutdown"].set(True),
    Act.FORBID_DEPLOY: BY_NAME["deploy"].set(False),
    Act.DEPLOY: BY_NAME["deploy"].set(True),
})  # fmt: skip


def is_deploy_in(events: Iterable[Event]) -> bool:
    """Whether a deploy left the computer, which nobody can take back, confirmed or not."""
    deploy = REQUESTS[Act.DEPLOY].encode()
    return any(isinstance(event, Sent) and event.raw == deploy for event in events)
