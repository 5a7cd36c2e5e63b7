"""Acts that change the state of a module, and the frame of each."""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType

from protocol.catalogue import ACTIVATION, BY_NAME, Request
from protocol.translatable import marked


class Act(Enum):
    """The value is its name in the audit log and in evidence."""

    LOCK = "lock"
    ACTIVATE = "activate"
    ZERO = "zero"
    SHUTDOWN = "shutdown"
    FORBID_DEPLOY = "forbid_deploy"
    DEPLOY = "deploy"
    CHANGE_BAUD = "change_baud"
    WRITE = "write"
    """A setting other than the baud rate."""


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
    Act.LOCK: marked("LOCK puts the module into standby. Until it reports LOCKED, treat it as ready to fire."),
    Act.ACTIVATE: marked("An active module fires when it tips over or falls."),
    Act.ZERO: marked("The module takes its present position as level. For small mounting errors only."),
    Act.SHUTDOWN: marked("The module switches off. It comes back by its switch, held for 2 s, or by external power."),
    Act.FORBID_DEPLOY: marked("Forbids deploying over serial only; for how long, the vendor does not say."),
    Act.DEPLOY: marked("The module fires the parachute."),
    Act.CHANGE_BAUD: marked("The serial line gets another speed. The vendor advises not to change it."),
    Act.WRITE: marked("The module gets another value for this setting."),
})  # fmt: skip

REQUESTS: Mapping[Act, Request] = MappingProxyType({
    Act.LOCK: ACTIVATION.set(False),
    Act.ACTIVATE: ACTIVATION.set(True),
    Act.ZERO: BY_NAME["zero_sensor"].query(),
    Act.SHUTDOWN: BY_NAME["shutdown"].set(True),
    Act.FORBID_DEPLOY: BY_NAME["deploy"].set(False),
    Act.DEPLOY: BY_NAME["deploy"].set(True),
})  # fmt: skip
"""The acts that are one fixed frame."""
