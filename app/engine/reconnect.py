"""Reconnection policy after a lost port: when and where. No clock, thread or port.

- Only a port that was open and went away is opened again, and only while somebody wants it.
- Only the same adapter: by USB serial number, else by vendor, product and socket. Where several ports show the same
  (two adapters of one clone maker, two ports of one adapter) the socket and the interface must be the same too; also
  when only one of them is left, which may be the other.
- Never the bare name: another adapter may have it by now. Without an identity only an address that cannot pass to
  another adapter is tried again: a URL, or a link that somebody made, as long as no adapter has come behind it.
- It looks twice a second at first, then once: an adapter that returns is open again within two seconds.
- Nothing is sent again. What was under way has ended with the port's error; the new session reads everything again.
- A port with a name alone is that of the same adapter only while the name leads to the very same device file; else the
  module behind it counts as another one until a person decides (`app.engine.identity`).
- Which adapter it is, is looked up while the port is open: then nobody else can have its name. Where it is another than
  the one that was meant (the list was older than the name), it is closed at once, and what it said was nobody's.

The owner calls `take` for each connection it hears of, lists the ports when `is_due`, hands them to `look` if nothing
became of the connection meanwhile, and opens what that returns, or closes the port where it `is_mistaken`.
"""

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum

from app.engine.ports import PortInfo
from app.engine.transport import PortTrouble
from app.engine.worker import Connection, PortState
from protocol.translatable import marked

EAGER_S = 0.5
"""Between two looks at first; the list itself takes some 10 ms on Linux."""
EAGER_FOR_S = 30.0
PATIENT_S = 1.0
RETURN_LIMIT_S = 2.0
"""From the adapter's return to the open port: one look, one list, one opening."""
LOSSES = frozenset({PortTrouble.LOST, PortTrouble.STUCK})
"""Troubles of a port that was open."""


@dataclass(frozen=True, slots=True)
class Address:
    """Where the module was. `identity` and `location` as in `PortInfo`, empty where there are none."""

    device: str
    identity: str = ""
    location: str = ""

    @property
    def is_url(self) -> bool:
        return "://" in self.device


class Absence(Enum):
    """Why the port is not open again yet; the value is a sentence in English, translatable."""

    AWAY = marked("Plug the same adapter in again: it is connected automatically.")
    ANOTHER = marked("Another adapter is in its place and is left alone: plug the same one in again, or choose a port.")
    SEVERAL = marked("Several adapters look the same: choose the port that the module is plugged into.")
    FAILED = marked("The adapter is back, but its port does not open yet; it is tried again.")
    NAME_ONLY = marked("The port has only a name, which may be another adapter's by now: connect again by hand.")

    @property
    def is_waiting(self) -> bool:
        """It is opened by itself as soon as that is over."""
        return self is not Absence.NAME_ONLY


Node = tuple[int, int, int]


def node_of(device: str) -> Node | None:
    """Which device file it is, whatever its name: another terminal may have the name by now."""
    try:
        found = os.stat(device)  # noqa: PTH116  the one call
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino, getattr(found, "st_rdev", 0)  # Windows has none


def _behind(device: str) -> str:
    """The device that a link leads to."""
    try:
        return os.path.realpath(device)
    except OSError:  # it was taken away at this very moment
        return device


def address_of(device: str, ports: Iterable[PortInfo]) -> Address:
    """The address of `device` (a name, a link or a URL) with its identity, where it is among `ports`."""
    if "://" in device:
        return Address(device)
    target = _behind(device)
    for port in ports:
        if port.device in (device, target):
            return Address(device, port.identity, port.location)
    return Address(device)


class Reconnection:
    """See the module's docstring. One object for as long as the program runs; one thread calls it."""

    def __init__(
        self, *, is_link: Callable[[str], bool] = os.path.islink, node: Callable[[str], Node | None] = node_of
    ) -> None:
        self._is_link = is_link
        self._node_of = node
        self._node: Node | None = None
        """Of the port that was open last."""
        self._address: Address | None = None
        self._lasts = False
        self._lost_at: float | None = None
        self._next_at = 0.0
        self._is_open = False
        self._is_recognised = False
        """It was looked up which adapter is open."""
        self._is_return = False
        """What is open was lost before."""
        self.is_mistaken = False
        """The open port is not that of the adapter that was meant; true from the look that told so to its closing."""
        self._has_twin = False
        """Another port has shown the same identity."""
        self._absence = Absence.AWAY
        self._taken: Connection | None = None
        self.returns = 0
        """How often a lost port was opened again."""

    @property
    def is_waiting(self) -> bool:
        """The port was lost and is opened again when it comes back."""
        return self._lost_at is not None

    @property
    def needs_ports(self) -> bool:
        """`look` wants the list of ports; a URL needs none."""
        return self._address is not None and not self._address.is_url

    @property
    def lost_at(self) -> float | None:
        return self._lost_at

    @property
    def absence(self) -> Absence | None:
        """Why it is not open again yet; None while nothing is lost."""
        return self._absence if self.is_waiting else None

    @property
    def address(self) -> Address | None:
        """Where the module is wanted; None where nothing is."""
        return self._address

    @property
    def is_adapter_same(self) -> bool:
        """What would be opened now surely belongs to the adapter that was lost."""
        address = self._address
        if address is None or address.identity or address.is_url:
            return address is not None
        return self._node is not None and self._node_of(address.device) == self._node

    def want(self, address: Address) -> None:
        """Somebody connects to it. Call it before the port is opened: a link must be looked at while it is there."""
        self._address = address
        self._lasts = address.is_url or (not address.identity and self._is_link(address.device))
        self._lost_at = None
        self._is_open = self._has_twin = self.is_mistaken = False
        self._taken = None

    def give_up(self) -> None:
        """Somebody disconnects."""
        self._address = None
        self._lost_at = None
        self._is_open = self.is_mistaken = False

    def feed(self, connection: Connection, now: float) -> None:
        """What became of the port. The same again changes nothing."""
        if self._address is None or connection == self._taken:
            return
        self._taken = connection
        if connection.state is PortState.OPEN:
            self._is_return = self.is_waiting
            self._node = None if self._address.is_url else self._node_of(self._address.device)
            self._lost_at = None
            self._is_recognised = (self._is_recognised and self._is_open) or self._address.is_url
            self._is_open = True
            if self._is_recognised:
                self._count()
        elif connection.state is PortState.CLOSED:
            self.is_mistaken = False
            if connection.trouble is not None:
                self._take_trouble(connection.trouble.trouble, now)

    def is_due(self, now: float) -> bool:
        """Whether to list the ports now, and hand them to `look`."""
        if self._is_open:
            return not self._is_recognised
        return self.is_waiting and self._absence.is_waiting and now >= self._next_at

    def poll(self, ports: Iterable[PortInfo], now: float) -> Address | None:
        """What to open now, None for nothing. `absence` says why not."""
        address, lost_at = self._address, self._lost_at
        if self._is_open and address is not None:
            self._recognise(address, tuple(ports), now)
            return None
        if address is None or lost_at is None or not self._absence.is_waiting:
            return None
        self._next_at = now + (EAGER_S if now - lost_at < EAGER_FOR_S else PATIENT_S)
        listed = tuple(ports)
        if not address.identity:
            return self._at_lasting_address(address, listed)
        same = [port for port in listed if port.identity == address.identity]
        self._has_twin |= len(same) > 1
        if self._has_twin:
            same = [port for port in same if port.location == address.location]
        if len(same) == 1:
            return Address(same[0].device, address.identity, same[0].location)
        several = any(port.identity == address.identity for port in listed)
        self._absence = Absence.SEVERAL if several else self._away_or_another(address, listed)
        return None

    def opening(self, address: Address) -> None:
        """`address`, from `look`, is being opened: from now on it is where the module is."""
        self._address = address

    def _recognise(self, address: Address, listed: tuple[PortInfo, ...], now: float) -> None:
        found = address_of(address.device, listed)
        if address.identity and found.identity != address.identity:
            self.is_mistaken, self._is_open = True, False
            self._lost_at, self._next_at = now, now + EAGER_S
            self._absence = self._away_or_another(address, listed)
            return
        self._is_recognised = True
        self._count()
        if found.identity:
            self._address = found
            self._has_twin = sum(port.identity == found.identity for port in listed) > 1

    def _count(self) -> None:
        self.returns += self._is_return
        self._is_return = False

    def _take_trouble(self, trouble: PortTrouble, now: float) -> None:
        if self.is_waiting:
            gone_again = trouble in LOSSES or trouble is PortTrouble.MISSING
            if self._absence.is_waiting:
                self._absence = Absence.AWAY if gone_again else Absence.FAILED
        elif trouble in LOSSES:
            self._lost_at = self._next_at = now
            is_known = self._lasts or (self._address is not None and bool(self._address.identity))
            self._absence = Absence.AWAY if is_known else Absence.NAME_ONLY
        self._is_open = False

    def _at_lasting_address(self, address: Address, ports: tuple[PortInfo, ...]) -> Address | None:
        behind = _behind(address.device) if not address.is_url else ""
        if any(port.identity and port.device in (address.device, behind) for port in ports):
            self._absence = Absence.ANOTHER
            return None
        return address

    def _away_or_another(self, address: Address, ports: tuple[PortInfo, ...]) -> Absence:
        has_name = any(port.device == address.device for port in ports)
        return Absence.ANOTHER if has_name else Absence.AWAY
