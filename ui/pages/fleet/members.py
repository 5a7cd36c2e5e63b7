"""Ports of the fleet board, each with its own connection, LOCK, name, recording and last check."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.engine.worker import PortState
from app.fleet.card import Card, LockState, Member, card_of
from app.fleet.verdicts import Verdicts
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.core.port_connection import PortConnection
from ui.services.context import Services
from ui.services.session_recording import SessionRecording


class FleetMembers(QObject):
    """Adds and removes ports and makes their cards. `changed`: other ports, or another one is current."""

    changed = Signal()
    replaced = Signal(object)
    """Another module, or another connection, behind this `PortConnection`."""

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector = services, services.connector
        self.verdicts = Verdicts()
        self._recordings: dict[PortConnection, SessionRecording] = {}
        self._seen: dict[PortConnection, object] = {}
        """What was adopted from the Pre-flight page."""
        self.is_checking: set[PortConnection] = set()
        self._leaving: set[PortConnection] = set()
        """To be removed once another one is current."""
        self._connector.chosen.connect(self._on_chosen)
        self._connector.added.connect(self._watch)
        self._connector.removed.connect(self._on_removed)
        for connection in self._connector.connections:
            self._watch(connection)

    @property
    def connections(self) -> tuple[PortConnection, ...]:
        """All that a person connected."""
        return tuple(one for one in self._connector.connections if one.is_requested)

    @property
    def reachable(self) -> tuple[PortConnection, ...]:
        """Those whose module answers."""
        return tuple(one for one in self.connections if one.is_open and one.device.values)

    def is_connected(self, port: PortInfo) -> bool:
        targets = [one.target for one in self.connections if one.target is not None]
        return any(port.device == one.device or (port.identity and port.identity == one.identity) for one in targets)

    def connect_port(self, target: Target) -> PortConnection:
        """Connect one more port; the first one becomes the current one."""
        for one in self.connections:
            if one.target is not None and one.target.key == target.key:
                return one
        current = self._connector.current
        if not current.is_requested and not current.is_open:
            current.connect_to(target)
            self.changed.emit()
            return current
        recording = self._services.storage.sessions.of_another_port()
        connection = self._connector.add(recording.recorded_workers())
        recording.bind(connection)
        self._recordings[connection] = recording
        name = self._services.naming.of(connection)
        name.changed.connect(lambda: recording.name_module(name.name))
        connection.connect_to(target)
        self.changed.emit()
        return connection

    def connect_all(self, ports: Iterable[PortInfo]) -> None:
        for port in ports:
            if not self.is_connected(port):
                self.connect_port(Target(port.device, DEFAULT_BAUD_RATE, port.identity, port.description))

    def disconnect_port(self, connection: PortConnection) -> None:
        """Disconnect a port; another one becomes current if this one was."""
        if connection is not self._connector.current:
            self._connector.remove(connection)
            return
        other = next((one for one in self.connections if one is not connection), None)
        if other is None:
            connection.disconnect_port()
        else:
            self._leaving.add(connection)
            self._connector.choose(other)  # `_on_chosen` removes it

    def name_of(self, connection: PortConnection) -> str:
        return self._services.naming.of(connection).name

    def card(self, connection: PortConnection) -> Card:
        now, device = self._connector.clock(), connection.device
        self._adopt_page_check(connection)
        lock = self._services.lock.of(connection)
        held = self.verdicts.held(connection, device, now, is_open=self._is_steady(connection))
        target = connection.target
        member = Member(
            port=port_text(target),
            link=replace(connection.state, port=port_text(target)),
            device=device,
            activation=connection.activation,
            name=self.name_of(connection),
            identity=connection.identity,
            verdict=held,
            is_checking=connection in self.is_checking,
            lock=LockState(sent=lock.sent, failed=lock.failed, confirmed=lock.confirmed),
            can_lock=lock.is_possible,
            is_shown=connection is self._connector.current,
        )
        return card_of(member, now, self._services.in_use)

    def _adopt_page_check(self, connection: PortConnection) -> None:
        """A check of the Pre-flight page counts here too, and so does what voids it."""
        found = connection.kept.check
        if found is None or found is self._seen.get(connection):
            return
        self._seen[connection] = found
        (filed, void), kept = found, self.verdicts.filed(connection)
        if void is None or kept is None or kept is filed:
            self.verdicts.store(connection, filed, void)

    @staticmethod
    def _is_steady(connection: PortConnection) -> bool:
        return connection.is_open and connection.connection.state is PortState.OPEN

    def _watch(self, connection: PortConnection) -> None:
        connection.changed.connect(partial(self._poll, connection))
        connection.batch.connect(lambda _batch: self._poll(connection))
        connection.invalidated.connect(partial(self._on_another_module, connection))

    def _on_another_module(self, connection: PortConnection) -> None:
        self.verdicts.remove(connection)
        self._seen.pop(connection, None)
        self.replaced.emit(connection)

    def _poll(self, connection: PortConnection) -> None:
        self._adopt_page_check(connection)
        is_open = self._is_steady(connection)
        self.verdicts.poll(connection, connection.device, self._connector.clock(), is_open=is_open)

    def _on_chosen(self) -> None:
        self._services.storage.sessions.shown = self._recordings.get(self._connector.current)
        for connection in [one for one in self._leaving if one is not self._connector.current]:
            self._leaving.discard(connection)
            self._connector.remove(connection)
        self.changed.emit()

    def _on_removed(self, connection: PortConnection) -> None:
        self.is_checking.discard(connection)
        self.verdicts.remove(connection)
        self._seen.pop(connection, None)
        self._recordings.pop(connection, None)
        self.changed.emit()


def port_text(target: Target | None) -> str:
    return "" if target is None else target.device.removeprefix("/dev/").partition("?")[0]
