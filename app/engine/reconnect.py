"""When and where a lost port is opened again. No clock, thread or port.

- Only a port that was open and was lost is opened again, until the user disconnects.
- Only the same adapter: by its USB serial number, else by vendor, product and socket. Where two ports have or had the
  same identity (two adapters of a clone maker) a person chooses.
- Never by name alone: another adapter may have the name by now. Without an identity only an address that cannot belong
  to another adapter is opened again: a URL, or a symbolic link.
- Nothing is sent again: another conversation begins, as at the first opening.

The owner calls `feed` for each change of the connection, lists the ports when `is_due` (if `needs_ports`), passes them
to `poll`, and opens what it returns.
"""

from collections.abc import Iterable
from enum import Enum
from pathlib import Path

from app.engine.ports import PortInfo, port_named
from app.engine.target import Target
from app.engine.transport import PortErrorKind
from app.engine.worker import Connection, PortState
from protocol.translatable import marked

# Listing them takes about 10 ms on Linux.
LIST_EVERY_S = 0.5


class Absence(Enum):
    """Why a lost port is not open again; the value is a sentence in English, translatable."""

    AWAY = marked("It is connected again as soon as the same adapter is back.")
    UNCLEAR = marked("It cannot be told which adapter is the same: choose the port.")


class Reconnection:
    """For one thread."""

    def __init__(self) -> None:
        # Where the user wants to be connected.
        self.target: Target | None = None
        self.is_lost = False
        # The address cannot belong to another adapter.
        self._lasts = False
        # Another port had the same identity.
        self._has_twin = False
        # It is open, so no other adapter can have its name: the time to learn its identity.
        self._is_to_identify = False
        self._next_at = 0.0

    def request(self, target: Target | None) -> None:
        """The user connects, or disconnects (None). To be called before the port is opened, while a symbolic link
        exists."""
        self.target, self.is_lost = target, False
        is_bare = target is not None and not target.identity
        self._lasts = target is not None and (not self.needs_ports or (is_bare and Path(target.device).is_symlink()))
        self._has_twin = self._is_to_identify = False

    @property
    def is_waiting(self) -> bool:
        """Whether the lost port is opened again by itself."""
        has_identity = self.target is not None and bool(self.target.identity)
        return self.is_lost and (self._lasts or (has_identity and not self._has_twin))

    @property
    def absence(self) -> Absence | None:
        """Why the lost port is not open again yet; None while none is lost."""
        if not self.is_lost:
            return None
        return Absence.AWAY if self.is_waiting else Absence.UNCLEAR

    @property
    def needs_ports(self) -> bool:
        """Whether `poll` needs the list of ports."""
        return self.target is not None and "://" not in self.target.device

    def feed(self, connection: Connection, now: float) -> None:
        if self.target is None:
            return
        if connection.state is PortState.OPEN:
            self.is_lost = False
            self._is_to_identify = self.needs_ports
        elif connection.state is PortState.CLOSED:
            self._is_to_identify = False
            trouble = connection.trouble
            if not self.is_lost and trouble is not None and trouble.kind is PortErrorKind.LOST:
                self.is_lost = True
                self._next_at = now

    def is_due(self, now: float) -> bool:
        """Whether to list the ports now and pass them to `poll`."""
        return self._is_to_identify or (self.is_waiting and now >= self._next_at)

    def poll(self, ports: Iterable[PortInfo], now: float) -> str | None:
        """Return the device to open now, or None; `absence` says why."""
        target, listed = self.target, tuple(ports)
        if target is None:
            return None
        if self._is_to_identify:
            self._is_to_identify = False
            found = port_named(target.device, listed)
            if found is not None and found.identity:
                target = self.target = target._replace(identity=found.identity)
        same = [port for port in listed if target.identity and port.identity == target.identity]
        self._has_twin |= len(same) > 1
        if not self.is_waiting:
            return None
        self._next_at = now + LIST_EVERY_S
        if target.identity and not same:
            return None
        device = same[0].device if same else target.device
        self.target = target._replace(device=device)
        return device
