"""Ports of the fleet board, each with its own connection, LOCK, name, recording and last check."""

import logging
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Final

from PySide6.QtCore import QObject, Signal

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.fleet.card import Card, card_of
from app.modules.service import service_due
from app.records.filing import local_now
from app.store.fact_store import Facts, Store
from app.text.messages import UserMessage
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.port import Port

_log = logging.getLogger(__name__)
DUE_EVERY_S: Final = 10.0
Due = Mapping[str, tuple[UserMessage, ...]]
"""What is due, by the module's name."""


class FleetMembers(QObject):
    """Adds and removes ports and makes their cards. `changed`: other ports, or another one is current."""

    changed = Signal()
    replaced = Signal(object)
    """Another module, or another connection, behind this `Port`."""

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector = services, services.connector
        self._due: Due = {}
        self._due_of: object = None
        self._reading: BackgroundTask[Due] = BackgroundTask("dps-s due", self)
        self._connector.chosen.connect(self.changed)
        self._connector.added.connect(self._watch)
        self._connector.removed.connect(self.changed)
        for connection in self._connector.connections:
            self._watch(connection)

    @property
    def connections(self) -> tuple[Port, ...]:
        """All that a person connected."""
        return tuple(connection for connection in self._connector.connections if connection.is_requested)

    @property
    def reachable(self) -> tuple[Port, ...]:
        """Those whose module answers."""
        return tuple(connection for connection in self.connections if connection.is_open and connection.device.values)

    def is_connected(self, port: PortInfo) -> bool:
        targets = [connection.target for connection in self.connections if connection.target is not None]
        return any(
            port.device == target.device or (port.identity and port.identity == target.identity) for target in targets
        )

    def connect_port(self, target: Target) -> Port:
        """Connect one more port; the first one becomes the current one."""
        for existing in self.connections:
            if existing.target is not None and existing.target.key == target.key:
                return existing
        current = self._connector.current
        is_free = not current.is_requested and not current.is_open
        port = current if is_free else self._connector.add()
        port.connect_to(target)
        self.changed.emit()
        return port

    def connect_all(self) -> None:
        for port in self._connector.ports.ports:
            if not self.is_connected(port):
                self.connect_port(target_of(port))

    def disconnect_port(self, connection: Port) -> None:
        """Disconnect a port; a person is asked first where edits would be lost or an ACTIVE module be left."""
        self._connector.before_leaving(connection, partial(self._disconnect, connection))

    def _disconnect(self, connection: Port) -> None:
        """Another one becomes current if this one was."""
        if connection is not self._connector.current:
            self._connector.remove(connection)
            return
        other = next((other for other in self.connections if other is not connection), None)
        if other is None:
            connection.disconnect_port()
        else:
            self._connector.choose(other, then=partial(self._connector.remove, connection))

    def read_due(self) -> None:
        """Reads what is due in the store's thread: for other names at once, else every ten seconds."""
        names = {connection.module.name for connection in self.connections} - {""}
        due_of = (names, self._connector.clock() // DUE_EVERY_S)
        if not names or due_of == self._due_of:
            return
        self._due_of, store = due_of, self._services.storage.store
        if isinstance(store, Store):
            self._reading.run_in(
                store, partial(_due_by_name, names=names), self._show_due,
                lambda trouble: _log.warning("What is due of the modules cannot be read: %s", trouble),
            )  # fmt: skip

    def _show_due(self, due: Due) -> None:
        is_new, self._due = due != self._due, due
        if is_new:
            self.changed.emit()

    def card(self, connection: Port) -> Card:
        now, device = self._connector.clock(), connection.device
        lock, check = connection.lock, connection.check
        port = port_text(connection.target)
        card = Card(
            port=port,
            link=connection.state._replace(port=port),
            device=device,
            activation=connection.activation,
            name=connection.module.name,
            expected=connection.module.expected_name,
            identity=connection.identity,
            verdict=None if check is None else check.held,
            is_checking=connection.is_checking,
            lock_sent=lock.sent,
            lock_failed=lock.failed,
            can_lock=lock.is_possible,
            is_shown=connection is self._connector.current,
            due=self._due.get(connection.module.name, ()),
        )
        return card_of(card, now, self._services.in_use)

    def _watch(self, connection: Port) -> None:
        connection.invalidated.connect(partial(self.replaced.emit, connection))


def _due_by_name(facts: Facts, names: Iterable[str]) -> Due:
    at = local_now()
    return {name: tuple(service.text for service in service_due(facts, name, at)) for name in names}


def target_of(port: PortInfo) -> Target:
    return Target(port.device, DEFAULT_BAUD_RATE, port.identity)


def port_text(target: Target | None) -> str:
    return "" if target is None else target.device.removeprefix("/dev/").partition("?")[0]
