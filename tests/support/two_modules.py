"""The program's own window on ports without threads, with what two modules report, for what is one module's only."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLineEdit, QPlainTextEdit, QTabBar, QWidget
from pytestqt.qtbot import QtBot

from app.engine.procedure import LinkView
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Sent
from protocol.fields import Value
from tests.support.patience import PATIENCE_S
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker, fake_window
from tests.support.window.spoken import texts_of
from ui.help.help_actions import explain
from ui.main import Assembly
from ui.services.job_notice import JobNotice
from ui.session.ports import Ports
from ui.style.theme import Meaning

NAME_A: Final = "ALPHA"
PORT_A, PORT_B = Target("/dev/ttyONE", 115200), Target("/dev/ttyTWO", 115200)
A: Final[dict[str, Value]] = {
    "tilt_deg": 47, "acceleration_g": 1.7, "cell_voltage_v": 3.79, "light_v": 4.7, "boot_count": 147,
    "light_threshold_v": 7.9, "attitude_threshold_deg": 79, "freefall_acceleration_g": 0.9, "freefall_time_s": 1.79,
}  # fmt: skip
B: Final[dict[str, Value]] = {
    "tilt_deg": 2, "acceleration_g": 1.0, "cell_voltage_v": 4.02, "light_v": 0.2, "boot_count": 22,
    "light_threshold_v": 2.2, "attitude_threshold_deg": 62, "freefall_acceleration_g": 0.2, "freefall_time_s": 1.22,
}  # fmt: skip


@dataclass
class Rig:
    """The window on fake ports; `worker` is that of the port that A is on."""

    assembly: Assembly
    ports: FakePorts

    def __post_init__(self) -> None:
        self.connector: Ports = self.assembly.ports
        self.pages: dict[str, Any] = self.assembly.window._pages

    @property
    def worker(self) -> FakeWorker:
        return self.ports.workers[self.connector.all.index(self.connector.current)]

    def settle(self) -> None:
        for _ in range(3):
            QApplication.processEvents()
            self.pages["diagnosis"].bundle._making.wait(PATIENCE_S)  # beside the window

    def answer(self, values: dict[str, Value]) -> None:
        """The module on the current port answers all that it was asked."""
        self.ports.now_s += 1.0
        self.worker.values.clear()
        self.worker.say(**VALUES | values)
        self.settle()

    def show_a(self) -> None:
        """A, with its name, ten thousand requests and a message in every place for messages."""
        self.connector.before_new = lambda begin: begin()  # a person discards the edits
        self.connector.connect_to(PORT_A)
        self.connector._switch()  # what was chosen before is not waited for
        self.answer(A)
        self.assembly.ports.current.module.choose(NAME_A)
        self.worker.hand_over(link=LinkView(Counters(sent=9518), 0.0, 0.0))
        request = BY_NAME["light_threshold"].set(7.9)
        self.worker.hand_over(events=(Sent(request.encode(), request, 1, self.ports.now_s),))
        self.pages["flights"]._try({"attitude_threshold_deg": 79, "attitude_trigger": False}, None, bool)
        self.connector.current.kept.as_found = Snapshot(settings={"light_threshold_v": 7.9})
        for notice in self.assembly.window.findChildren(JobNotice):
            if notice.is_of_module:
                notice.notify(Meaning.DANGER, "Said of it")
        self.assembly.window.show_message("Said of it")
        self.settle()

    def texts(self, key: str) -> Iterator[tuple[str, str]]:
        """Everything in sight on a page and around it, hidden views of tabs too."""
        window, page = self.assembly.window, self.pages[key]
        window.panel.hide()
        window.go_to(key)
        bars = page.findChildren(QTabBar)
        for number in range(max(1, *(bar.count() for bar in bars)) if bars else 1):
            for bar in bars:
                bar.setCurrentIndex(number)
            self.settle()
            yield from ((f"{key}: {where}", text) for where, text in self._visible())

    def _visible(self) -> Iterator[tuple[str, str]]:
        cards = self.pages["fleet"]._widgets
        others = [card for port, card in cards.items() if port is not self.connector.current]
        if len(self.connector.all) > 1:
            others.append(self.pages["fleet"].panel)  # a column for each module
        roots = QApplication.topLevelWidgets()
        # Another module's card shows that one's, under its name.
        for widget in [one for root in roots for one in _in_sight(root, others)]:
            where = widget.objectName() or type(widget).__name__
            explain(widget)  # as a person who asks what this is
            for role, text in (*texts_of(widget), *_state(widget)):
                yield f"{where} {role}", text


def _in_sight(widget: QWidget, left_out: list[QWidget]) -> Iterator[QWidget]:
    if widget.isVisible() and widget not in left_out:
        yield widget
        for child in widget.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly):
            if not child.isWindow():
                yield from _in_sight(child, left_out)


def _state(widget: QWidget) -> Iterator[tuple[str, str]]:
    yield "is enabled", str(widget.isEnabled())
    match widget:
        case QAbstractButton():
            yield "is checked", str(widget.isChecked())
        case QComboBox():
            yield "chosen", widget.currentText()
        case QLineEdit():
            yield "typed", widget.text()
        case QPlainTextEdit():
            yield "typed", widget.toPlainText()


@contextmanager
def two_modules(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[Rig]:
    with fake_window(qapp, folder) as (ports, assembly):
        assembly.window.setUpdatesEnabled(False)  # texts are asked for, and painting takes most of the time
        qtbot.waitUntil(lambda: assembly.window._maker.is_done)
        yield Rig(assembly, ports)
