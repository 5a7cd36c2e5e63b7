"""Reconnection policy after a lost port: when and where. No clock, thread or port.

- Only a port that was open and was lost is opened again, until the user disconnects.
- Only the same adapter: by USB serial number, else by vendor, product and socket. Where several ports have the same
  identity (two adapters of a clone maker, two ports of one adapter) the socket and the interface must match too, even
  when only one of them is left.
- Never by name alone: another adapter may have the name by now. Without an identity only an address that cannot belong
  to another adapter is opened again: a URL, or a symbolic link, unless it leads to an adapter with an identity.
- The ports are listed twice a second at first, then once: a returning adapter is opened within two seconds.
- Nothing is sent again: the procedures ended with the port's error, and the new session reads everything.
- A port known by name alone is the same only while the name leads to the same device file; else the module counts as
  another one until a person decides (`app.engine.identity`).
- The adapter is identified while the port is open, as no other adapter can have its name then. If it is another than
  expected (the list of ports was out of date), the port is closed at once and everything received is discarded.

The owner calls `feed` for each change of the connection, lists the ports when `is_due`, passes them to `poll` unless
the connection changed meanwhile, and opens the address that `poll` returns, or closes the port if `is_mistaken`.
"""

import os
from collections.abc import Callable, Iterable
from enum import Enum
from typing import NamedTuple

from app.engine.address_lock import is_network_address
from app.engine.identity import UNKNOWN, Expected, Identity
from app.engine.ports import PortInfo
from app.engine.transport import PortTrouble
from app.engine.worker import Connection, PortState
from protocol.translatable import marked

EAGER_S = 0.5
"""The first interval between two lists of ports; listing takes about 10 ms on Linux."""
EAGER_FOR_S = 30.0
PATIENT_S = 1.0
LOSSES = frozenset({PortTrouble.LOST, PortTrouble.STUCK})
"""Troubles of a port that was open."""


class Address(NamedTuple):
    """Where the module is connected. `identity` and `location` as in `PortInfo`, or empty."""

    device: str
    identity: str = ""
    location: str = ""

    @property
    def is_url(self) -> bool:
        return "://" in self.device


class Absence(Enum):
    """Why the port is not open again yet; the value is a sentence in English, translatable."""

    AWAY = marked("Plug the same adapter in again: it is connected automatically.")
    NO_ANSWER = marked("It is connected again when the address answers.")
    ANOTHER = marked("Another adapter is in its place: plug the same one in again, or choose a port.")
    SEVERAL = marked("Several adapters look the same: choose the module's port.")
    FAILED = marked("The port does not open yet; it is tried again.")
    NAME_ONLY = marked("The port's name may be another adapter's by now: connect again by hand.")

    @property
    def is_waiting(self) -> bool:
        """Whether it is opened automatically once that is over."""
        return self is not Absence.NAME_ONLY


Node = tuple[int, int, int]


def node_of(device: str) -> Node | None:
    """Identifies the device file, because another terminal may have its name later."""
    try:
        status = os.stat(device)  # noqa: PTH116  the one call
    except (OSError, ValueError):
        return None
    return status.st_dev, status.st_ino, getattr(status, "st_rdev", 0)  # not on Windows


def _behind(device: str) -> str:
    """The device to which a symbolic link leads."""
    try:
        return os.path.realpath(device)
    except OSError:  # it was removed meanwhile
        return device


def address_of(device: str, ports: Iterable[PortInfo]) -> Address:
    """The address of `device` (a name, a link or a URL), with its identity if it is among `ports`."""
    if "://" in device:
        return Address(device)
    target = _behind(device)
    for port in ports:
        if port.device in (device, target):
            return Address(device, port.identity, port.location)
    return Address(device)


class PortStage(Enum):
    IDLE = "idle"
    """Nothing was lost: the port is not wanted, not open yet, or was closed on purpose."""
    UNKNOWN = "unknown"
    """Open; the adapter is not identified yet."""
    KNOWN = "known"
    """Open, on the adapter that was expected."""
    MISTAKEN = "mistaken"
    """Open, on another adapter than expected: to be closed."""
    LOST = "lost"
    """Lost; opened again when the same adapter returns."""


class Reconnection:
    """See the module's docstring. One object for the program's lifetime, used by one thread."""

    def __init__(
        self, *, is_link: Callable[[str], bool] = os.path.islink, node: Callable[[str], Node | None] = node_of
    ) -> None:
        self._is_link = is_link
        self._node_of = node
        self._node: Node | None = None
        """The device file of the port that was open last."""
        self.address: Address | None = None
        self._lasts = False
        """The address cannot belong to another adapter."""
        self._is_ambiguous = False
        """Another port had the same identity."""
        self._stage = PortStage.IDLE
        self._lost_at: float | None = None
        """Until its adapter is identified again."""
        self._next_at = 0.0
        self._absence = Absence.AWAY
        self.returns = 0
        """The number of lost ports that were opened again."""

    @property
    def is_mistaken(self) -> bool:
        """Whether the open port belongs to another adapter than expected and has to be closed."""
        return self._stage is PortStage.MISTAKEN

    @property
    def is_waiting(self) -> bool:
        """Whether a port was lost and the same adapter is awaited."""
        return self._stage in (PortStage.LOST, PortStage.MISTAKEN)

    @property
    def needs_ports(self) -> bool:
        """Whether `poll` needs the list of ports: not for a URL without an identity."""
        return self.address is not None and (bool(self.address.identity) or not self.address.is_url)

    @property
    def absence(self) -> Absence | None:
        """Why the lost port is not open again yet; None while none is lost."""
        return self._absence if self.is_waiting else None

    @property
    def is_adapter_same(self) -> bool:
        """Whether the address certainly belongs to the adapter that was lost."""
        address = self.address
        if address is None or address.identity or address.is_url:
            return address is not None
        return self._node is not None and self._node_of(address.device) == self._node

    def expected(self, lost: Identity) -> Expected | None:
        """The lost module; None if nothing was read of it to compare with."""
        is_same = self.is_adapter_same
        if lost.before is not None:
            return Expected(lost.before, is_same and lost.is_adapter_same, is_named=lost.is_named)
        if is_same and lost.now == UNKNOWN and not lost.is_named:
            return None
        return Expected(lost.now, is_same, is_named=lost.is_named)

    def request(self, address: Address) -> None:
        """The user connects. To be called before the port is opened, while a symbolic link exists."""
        self.give_up()
        self.address = address
        self._lasts = address.is_url or (not address.identity and self._is_link(address.device))
        self._is_ambiguous = False

    def give_up(self) -> None:
        """The user disconnects."""
        self.address = None
        self._enter(PortStage.IDLE)

    def feed(self, connection: Connection, now: float) -> None:
        """Take in the state of the connection; the same state again changes nothing."""
        if self.address is None:
            return
        if connection.state is PortState.OPEN:
            self._node = None if self.address.is_url else self._node_of(self.address.device)
            if self.address.is_url:
                self._enter(PortStage.KNOWN)
            elif self._stage in (PortStage.IDLE, PortStage.LOST):
                self._enter(PortStage.UNKNOWN)
        elif connection.state is PortState.CLOSED:
            if connection.trouble is not None:
                self._note(connection.trouble.trouble, now)
            self._enter(PortStage.LOST if self.is_waiting else PortStage.IDLE)

    def is_due(self, now: float) -> bool:
        """Whether to list the ports now and pass them to `poll`."""
        if self._stage is PortStage.LOST:
            return self._absence.is_waiting and now >= self._next_at
        return self._stage is PortStage.UNKNOWN

    def poll(self, ports: Iterable[PortInfo], now: float) -> Address | None:
        """Return the address to open now, which is kept open from then on, or None; `absence` says why."""
        address, listed = self.address, tuple(ports)
        if self._stage is PortStage.UNKNOWN and address is not None:
            self._recognise(address, listed, now)
        if self._stage is not PortStage.LOST or address is None or not self._absence.is_waiting:
            return None
        is_eager = self._lost_at is not None and now - self._lost_at < EAGER_FOR_S
        self._next_at = now + (EAGER_S if is_eager else PATIENT_S)
        if not address.identity:
            return self._at_same_address(address, listed)
        same = [port for port in listed if port.identity == address.identity]
        self._is_ambiguous |= len(same) > 1
        if self._is_ambiguous:
            same = [port for port in same if port.location == address.location]
        if len(same) == 1:
            self.address = Address(same[0].device, address.identity, same[0].location)
            return self.address
        several = any(port.identity == address.identity for port in listed)
        self._absence = Absence.SEVERAL if several else self._absence_of(address, listed)
        return None

    def _enter(self, stage: PortStage) -> None:
        self._stage = stage
        self.returns += stage is PortStage.KNOWN and self._lost_at is not None
        if stage in (PortStage.KNOWN, PortStage.IDLE):
            self._lost_at = None

    def _recognise(self, address: Address, listed: tuple[PortInfo, ...], now: float) -> None:
        current = address_of(address.device, listed)
        if address.identity and current.identity != address.identity:
            self._lose(now, self._absence_of(address, listed))
            self._next_at = now + EAGER_S
            self._enter(PortStage.MISTAKEN)
            return
        self._enter(PortStage.KNOWN)
        if current.identity:
            self.address = current
            self._is_ambiguous = sum(port.identity == current.identity for port in listed) > 1

    def _lose(self, now: float, absence: Absence) -> None:
        self._lost_at = self._next_at = now
        self._absence = absence

    def _note(self, trouble: PortTrouble, now: float) -> None:
        """The trouble with which the port was closed, or could not be opened."""
        if self.is_waiting:
            is_gone = trouble in LOSSES or trouble is PortTrouble.MISSING
            if self._absence.is_waiting:
                self._absence = self._away() if is_gone else Absence.FAILED
        elif trouble in LOSSES:
            is_known = self._lasts or (self.address is not None and bool(self.address.identity))
            self._lose(now, self._away() if is_known else Absence.NAME_ONLY)
            self._enter(PortStage.LOST)

    def _away(self) -> Absence:
        is_network = self.address is not None and is_network_address(self.address.device)
        return Absence.NO_ANSWER if is_network else Absence.AWAY

    def _at_same_address(self, address: Address, ports: tuple[PortInfo, ...]) -> Address | None:
        behind = _behind(address.device) if not address.is_url else ""
        if any(port.identity and port.device in (address.device, behind) for port in ports):
            self._absence = Absence.ANOTHER
            return None
        return address

    def _absence_of(self, address: Address, ports: tuple[PortInfo, ...]) -> Absence:
        has_name = any(port.device == address.device for port in ports)
        return Absence.ANOTHER if has_name else Absence.AWAY
