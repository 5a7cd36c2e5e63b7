"""The button that adds one more port to the board, with a menu of those that are there."""

from functools import partial
from typing import Final

from PySide6.QtWidgets import QMenu, QToolButton

from app.engine.target import Target
from app.text.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.core.port_watcher import PortWatcher
from ui.files.file_dialogs import AskText, ask_text
from ui.pages.fleet.members import FleetMembers, target_of
from ui.style.icons import Icon
from ui.widgets.controls import control, named, without_key

SIMULATED: Final = "sim://module-{number}?lifelike"


class AddPort(QToolButton):
    """Any port that Connect takes."""

    def __init__(self, watcher: PortWatcher, members: FleetMembers) -> None:
        super().__init__()
        control(self, "fleet_add", text=tr("Add port"), picture=Icon.PLUG)
        self._watcher, self._members = watcher, members
        self.ask_text: AskText = ask_text
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = named(QMenu(self), "fleet_add_menu")
        menu.aboutToShow.connect(partial(self._fill, menu))
        self.setMenu(menu)

    def _fill(self, menu: QMenu) -> None:
        menu.clear()
        for port in self._watcher.ports:
            if not self._members.is_connected(port):
                name = f"{port.device.removeprefix('/dev/')} {port.description}".strip()
                menu.addAction(without_key(name)).triggered.connect(
                    partial(self._members.connect_port, target_of(port))
                )
        if not menu.isEmpty():
            menu.addAction(tr("Connect all ports")).triggered.connect(self._members.connect_all)
            menu.addSeparator()
        taken = {connection.target.device for connection in self._members.connections if connection.target is not None}
        number = next(n for n in range(1, 100) if SIMULATED.format(number=n) not in taken)
        menu.addAction(tr("Simulated module")).triggered.connect(
            partial(self._connect, SIMULATED.format(number=number))
        )
        menu.addAction(tr("Other port…")).triggered.connect(self._ask)
        self._watcher.refresh()

    def _ask(self) -> None:
        self.ask_text(self, tr("Other port…"), tr("device or socket://host:port"), self._connect)

    def _connect(self, address: str) -> None:
        if address.strip():
            self._members.connect_port(Target(address.strip(), DEFAULT_BAUD_RATE))
