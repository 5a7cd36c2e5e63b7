"""What screen readers are told: each state once; what ticks only when they ask."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import MappingProxyType
from unittest.mock import patch

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView, How, Known, StatusSample
from app.engine.target import Target
from app.engine.worker import Batch, Connection, PortState
from app.safety.last_known import keep_away
from protocol.link_states import Presence
from tests.support.line.sim_line import FakeClock
from tests.support.window.fake_ports import VALUES, FakePorts
from tests.support.window.fakes_ui import window
from tests.support.window.screen_reader import NameChanges, name_of
from ui.main import PAGES, Assembly
from ui.services.announcer import announcer
from ui.services.port import Ports
from ui.shell.state_announcer import announce_states

USB = "/dev/ttyUSB0"
EACH_PAGE_S = 4
LONGEST_TICK_MS = 2000
MAX_CHANGES = 3
"""A state or two may change in so long a time."""


class Session:
    """A module that answers ten times a second, each time a little different, on a clock that the test moves."""

    def __init__(self, assembly: Assembly, clock: FakeClock) -> None:
        self._clock = clock
        self._connector = assembly.connector
        self._connection = assembly.connector.current
        self._connection._worker.open = lambda *_, **__: 1  # type: ignore[method-assign]
        self._connection.bridge.batch.disconnect()  # what the worker says would come by the computer's clock
        self._connector.connect_to(Target(USB, 115200))

    def hear(self) -> None:
        self._clock.now_s += 0.1
        now_s = self._clock.now_s
        noise = round(now_s * 10) % 7
        values = VALUES | {"tilt_deg": noise, "acceleration_g": 1 + noise / 10, "light_v": noise / 10}
        values["cell_voltage_v"] = 4 + noise / 100
        known = {key: Known(value, How.READ, now_s) for key, value in values.items()}
        known["attitude_threshold_deg"] = Known(60, How.READ, 1000.0)  # its age grows
        view = DeviceView(MappingProxyType(known), Presence.ONLINE, 1000.0, True, 10.0)
        sample = StatusSample(now_s, noise, 1 + noise / 10, False, False)
        opened = Connection(PortState.OPEN, USB, 115200, opening=1)
        self._connection._on_batch(Batch(now_s, opened, view, None, (sample,)))


def test_nothing_that_ticks_is_told(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    clock = FakeClock()
    with patch("ui.main.Ports", partial(Ports, clock=clock)), window(qapp, tmp_path, entries=PAGES) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.stack.count() == len(PAGES))
        session, changes = Session(assembly, clock), NameChanges(main)
        for entry in PAGES:
            main.go_to(entry.key)
            for tick in range(EACH_PAGE_S * 10):
                session.hear()
                if tick % 5 == 0:
                    for timer in main.findChildren(QTimer):  # as each would in that time
                        if timer.isActive() and not timer.isSingleShot() and timer.interval() <= LONGEST_TICK_MS:
                            timer.timeout.emit()
                    QApplication.processEvents()
                    changes.look(counts=tick > 10)  # what a page shows at first is no change
        assert len(changes.found) <= MAX_CHANGES, "\n".join(changes.found)
        assert "4.0" in name_of(main.top_bar.cell)  # who asks is told


USB0, USB1 = "/dev/ttyUSB0", "/dev/ttyUSB1"


class Listener:
    """What was announced since it was last asked: the urgent ones end with "!"."""

    def __init__(self, ports: FakePorts) -> None:
        self.ports = ports
        self._said: list[str] = []
        announcer().announced.connect(self._take)

    def _take(self, text: str, is_urgent: bool) -> None:
        self._said.append(f"{text}!" if is_urgent else text)

    def heard(self, qtbot: QtBot, count: int) -> list[str]:
        qtbot.waitUntil(lambda: len(self._said) >= count)
        qtbot.wait(0)  # what else waits is said now
        said, self._said = self._said, []
        return said


@pytest.fixture
def listener(qtbot: QtBot) -> Iterator[Listener]:
    window = QWidget()
    qtbot.addWidget(window)
    window.show()
    ports = FakePorts()
    made = Listener(ports)
    announce_states(ports.connector)
    yield made
    announcer().announced.disconnect(made._take)
    ports.stop()


def test_each_state_is_told_once_when_it_becomes_so(qtbot: QtBot, listener: Listener) -> None:
    _, module = listener.ports.plug_in(USB0)
    assert listener.heard(qtbot, 1) == ["LOCKED"]
    module.say(active=True)
    assert listener.heard(qtbot, 1) == ["ACTIVE"]
    for second in range(1, 31):  # values and ages change all the time
        listener.ports.now_s += 1
        module.say(active=True, triggered=False, tilt_deg=second, cell_voltage_v=4 - second / 100, light_v=0.1)
    module.say(triggered=True)
    assert listener.heard(qtbot, 1) == ["TRIGGERED!"]
    module.say(triggered=True, active=False)
    assert listener.heard(qtbot, 1) == ["LOCKED"]


def test_a_lost_link_is_told_with_what_it_means_and_the_state_again_afterwards(
    qtbot: QtBot, listener: Listener
) -> None:
    connection, module = listener.ports.plug_in(USB0, active=True)
    assert listener.heard(qtbot, 1) == ["ACTIVE"]
    module.unplug()
    (lost,) = listener.heard(qtbot, 1)
    assert lost.endswith(f"treat it as ready to fire. {keep_away()}!")
    connection.connect_to(connection.target)  # type: ignore[arg-type]
    module.say(active=True, triggered=True)
    assert listener.heard(qtbot, 2) == ["TRIGGERED!", "ACTIVE"]


def test_with_several_ports_it_says_of_which(qtbot: QtBot, listener: Listener) -> None:
    listener.ports.plug_in(USB0)
    assert listener.heard(qtbot, 1) == ["LOCKED"]
    _, second = listener.ports.plug_in(USB1)
    second.say(triggered=True)
    assert listener.heard(qtbot, 2) == [f"{USB1}: TRIGGERED!", f"{USB1}: LOCKED"]


def test_a_disconnection_that_was_asked_for_is_no_loss(qtbot: QtBot, listener: Listener) -> None:
    connection, module = listener.ports.plug_in(USB0)
    assert listener.heard(qtbot, 1) == ["LOCKED"]
    connection.disconnect_port()
    module.hand_over()
    connection.connect_to(connection.target)  # type: ignore[arg-type]
    module.say(active=True)
    assert listener.heard(qtbot, 1) == ["ACTIVE"]
