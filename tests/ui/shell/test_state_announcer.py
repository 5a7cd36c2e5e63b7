"""What a screen reader says by itself: what happens to a module, once, and nothing that ticks."""

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from app.safety.last_known import keep_away
from tests.support.window.fake_ports import FakePorts
from ui.services.announcer import announcer
from ui.shell.state_announcer import announce_states

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
