"""The Fleet page over fake ports."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton
from pytestqt.qtbot import QtBot

from tests.support.window.fake_ports import FakePorts, FakeWorker, fake_services, show_alone
from ui.pages.fleet.page import FleetPage
from ui.services.context import Services
from ui.services.storage import Storage
from ui.session.port import Port


@dataclass
class Desk:
    qtbot: QtBot
    ports: FakePorts
    page: FleetPage
    services: Services
    modules: list[tuple[Port, FakeWorker]] = field(default_factory=list)

    def plug_in(self, count: int, **values: float) -> None:
        for number in range(len(self.modules), len(self.modules) + count):
            self.modules.append(self.ports.plug_in(f"/dev/port{number}", **values))
        self.settle()

    def settle(self) -> None:
        """What was said is shown."""
        QApplication.processEvents()
        self.page.refresh()

    def card(self, connection: Port) -> object:
        return self.page._widgets[connection].card

    def wait(self, is_so: Callable[[], bool]) -> None:
        self.qtbot.waitUntil(is_so)

    def click(self, button: QPushButton) -> None:
        self.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with fake_services(qapp, Storage(tmp_path)) as (ports, services):
        page = FleetPage(services)
        page.leave_wanted.connect(lambda _port, leave: leave())  # as where the window has nothing to ask
        show_alone(qtbot, services, page, 1000, 700)
        yield Desk(qtbot, ports, page, services)
        page.hide()
