"""The Fleet page over fake ports."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton
from pytestqt.qtbot import QtBot

from app.preflight.verdict import assess
from app.records.filing import Filed, local_now
from app.records.record import make_record
from protocol.fields import Value
from tests.support.records.preflight_rig import check
from tests.support.window.fake_ports import SETTINGS, VALUES, FakePorts, FakeWorker, fake_services, show_alone
from tests.support.window.steps import given, notice_text
from ui.pages.fleet.board import LOCK, MODULE, Board
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

    @property
    def board(self) -> Board:
        return self.page.board

    @property
    def notice(self) -> str:
        return "" if self.page.notice_bar.notice is None else notice_text(self.page.notice_bar)

    def plug_in(self, count: int, **values: Value) -> None:
        for number in range(len(self.modules), len(self.modules) + count):
            self.modules.append(self.ports.plug_in(f"/dev/port{number}", **values))
        self.settle()

    def settle(self) -> None:
        """What was said is shown."""
        QApplication.processEvents()
        self.page.refresh()

    def row(self, number: int) -> int:
        """Of the module that was plugged in as this one, by the port that its row names."""
        names = [self.board.item(row, MODULE).text().split() for row in range(self.board.rowCount())]  # type: ignore[union-attr]
        return next(row for row, words in enumerate(names) if f"port{number}" in words)

    def cell(self, number: int, column: int) -> str:
        return given(self.board.item(self.row(number), column)).text()

    def lock(self, number: int) -> QPushButton:
        holder = given(self.board.cellWidget(self.row(number), LOCK))
        return given(holder.findChild(QPushButton))

    def tick(self, number: int, *, is_ticked: bool) -> None:
        state = Qt.CheckState.Checked if is_ticked else Qt.CheckState.Unchecked
        given(self.board.item(self.row(number), MODULE)).setCheckState(state)

    def filed(self) -> Filed:
        """A NO-GO that ended now, of which everything that a fake module reports still holds."""
        case = check().assessment.case
        values = case.evidence.values | {key: value for key, value in VALUES.items() if key in case.evidence.values}
        evidence = replace(case.evidence, flags={}, ended_at=self.ports.now_s, values=values | SETTINGS)
        assessment = assess(replace(case, evidence=evidence))
        return Filed(assessment, make_record(assessment, at=local_now()), None)

    def wait(self, is_so: Callable[[], object]) -> None:
        self.qtbot.waitUntil(lambda: bool(is_so()))

    def click(self, button: QPushButton) -> None:
        self.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    def press(self, key: str) -> None:
        """A button of the notice."""
        choices = given(self.page.notice_bar.notice).choices
        next(choice for choice in choices if choice.key == key).act()
        self.settle()


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with fake_services(qapp, Storage(tmp_path)) as (ports, services):
        page = FleetPage(services)
        page.leave_wanted.connect(lambda _port, leave: leave())  # as where the window has nothing to ask
        show_alone(qtbot, services, page, 1000, 700)
        yield Desk(qtbot, ports, page, services)
        page.hide()
