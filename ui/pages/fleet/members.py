"""The ports of the fleet."""

from collections.abc import Callable
from functools import partial
from typing import Final

from PySide6.QtWidgets import QMenu, QToolButton

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.fleet.card import Card
from app.limits.limits import last_cell_outside
from app.text.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.files.file_dialogs import AskText, ask_text
from ui.services.context import Services
from ui.session.port import Port
from ui.style.icons import Icon
from ui.widgets.controls import control, named, without_key

SIMULATED: Final = "sim://module-{number}?lifelike"


class FleetMembers:
    """Adds and removes ports, and makes their cards."""

    def __init__(self, services: Services) -> None:
        self._services, self._ports = services, services.ports
        # Checks and profiles leave these out.
        self.unticked: set[Port] = set()

    @property
    def connections(self) -> tuple[Port, ...]:
        """All that a person connected, in that order."""
        return tuple(port for port in self._ports.all if port.is_requested)

    @property
    def ticked(self) -> tuple[Port, ...]:
        return tuple(port for port in self.connections if port not in self.unticked)

    @property
    def reachable(self) -> tuple[Port, ...]:
        """Those that are ticked and whose module answers."""
        return tuple(port for port in self.ticked if port.is_open and port.module.is_going)

    @property
    def unconnected(self) -> tuple[PortInfo, ...]:
        """What the system lists and nobody connected."""
        targets = [port.target for port in self.connections if port.target is not None]
        taken = {target.device for target in targets} | {target.identity for target in targets if target.identity}
        return tuple(one for one in self._ports.watcher.ports if not {one.device, one.identity} & taken)

    def connect_port(self, target: Target) -> Port:
        """Connect one more port; the first one becomes the current one."""
        there = next((port for port in self.connections if port.target and port.target.key == target.key), None)
        if there is not None:
            return there
        free = (port for port in (self._ports.current, *self._ports.all) if not port.is_requested and not port.is_open)
        port = next(free, None) or self._ports.add()
        port.connect_to(target)
        return port

    def connect_all(self) -> None:
        for listed in self.unconnected:
            self.connect_port(target_of(listed))

    def now(self) -> float:
        """By the clock of the engine."""
        return self._ports.clock()

    def card(self, port: Port) -> Card:
        module = port.module
        return Card(
            port=port_text(port.target),
            link=port.state,
            conversation=module.view,
            activation=module.activation,
            may_have_fired=module.may_have_fired,
            name=module.name,
            expected=port.last_name,
            check=module.check_state,
            lock_sent=port.lock.sent,
            lock_failed=port.lock.failed,
            is_shown=port is self._ports.current,
            cell_outside=last_cell_outside(module.view, self.now(), self._services.in_use.profile),
        )


class AddPort(QToolButton):
    """Offers the ports that are there, and any other that Connect takes."""

    def __init__(self, members: FleetMembers, refresh_ports: Callable[[], object]) -> None:
        super().__init__()
        control(self, "fleet_add", text=tr("Add port"), picture=Icon.PLUG)
        self._members, self._refresh_ports = members, refresh_ports
        self.ask_text: AskText = ask_text
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._menu = named(QMenu(self), "fleet_add_menu")
        self._menu.aboutToShow.connect(self._fill)
        self.setMenu(self._menu)

    def _fill(self) -> None:
        self._menu.clear()
        for listed in self._members.unconnected:
            name = f"{listed.device.removeprefix('/dev/')} {listed.description}".strip()
            self._offer(without_key(name), partial(self._members.connect_port, target_of(listed)))
        if not self._menu.isEmpty():
            self._offer(tr("Connect all ports"), self._members.connect_all)
            self._menu.addSeparator()
        taken = [port.target.device for port in self._members.connections if port.target is not None]
        simulated = next(name for n in range(1, 100) if (name := SIMULATED.format(number=n)) not in taken)
        self._offer(tr("Simulated module"), partial(self._connect, simulated))
        ask = partial(self.ask_text, self, tr("Other port…"), tr("device or socket://host:port"), self._connect)
        self._offer(tr("Other port…"), ask)
        self._refresh_ports()

    def _offer(self, text: str, act: Callable[[], object]) -> None:
        self._menu.addAction(text).triggered.connect(lambda _is_checked: act())

    def _connect(self, address: str) -> None:
        if address.strip():
            self._members.connect_port(Target(address.strip(), DEFAULT_BAUD_RATE))


def target_of(port: PortInfo) -> Target:
    return Target(port.device, DEFAULT_BAUD_RATE, port.identity)


def port_text(target: Target | None) -> str:
    return "" if target is None else target.device.removeprefix("/dev/").partition("?")[0]
