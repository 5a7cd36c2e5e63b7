"""Choosing a port, connecting, errors, and reconnecting."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.causes import NextStep
from app.diagnosis.link_state import LinkState, LinkText, Phase, link_state, link_text
from app.engine.conversation import ConversationView
from app.engine.target import Target
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Connection, PortState
from app.procedures.find import Silence
from tests.support.window.fake_ports import VALUES, fake_window
from tests.support.window.fakes_ui import (
    ADAPTER,
    EMPTY_PAGE,
    SECOND_ADAPTER,
    ListedPorts,
    connect,
    simulated,
    wait_online,
    window,
)
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, press
from ui.connect.connect_panel import SIMULATED_PORT
from ui.core.preferences import LastPort, Preferences
from ui.main import Assembly

OPEN, EMPTY = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200), ConversationView()


def rows(assembly: Assembly) -> dict[str, str]:
    """The rows of the port list: device -> title."""
    ports = assembly.window.panel.list
    return {choice.device: choice.title for choice in map(ports.choice_at, range(ports.count()))}


def phase(assembly: Assembly) -> Phase:
    return assembly.ports.current.state.phase


# What is said


def said_of(
    connection: Connection = OPEN, conversation: ConversationView = EMPTY, silence: Silence | None = None
) -> tuple[LinkState, LinkText]:
    state = link_state(connection, conversation, silence, is_finding=False)
    return state, link_text(state, 22.0)


def test_each_trouble_has_its_sentence_and_its_next_step() -> None:
    for trouble in PortTrouble:
        state, said = said_of(OPEN._replace(state=PortState.CLOSED, trouble=PortError(trouble, OPEN.port, "driver's")))
        assert (state.phase, said.step) == (Phase.FAILED, NextStep.CONNECT_AGAIN)
        assert said.what
        assert said.next_step
        assert "driver's" not in said.what
    silent = {silence: said_of(silence=silence) for silence in Silence}
    assert {state.phase for state, _said in silent.values()} == {Phase.SILENT}
    assert len({said.what for _state, said in silent.values()}) == len(Silence)
    assert silent[Silence.GARBAGE][1].step is NextStep.FIND_RATE


# The panel


def test_a_port_plugged_in_meanwhile_is_listed(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    ports = ListedPorts(ADAPTER)
    with window(qapp, tmp_path, listed=ports) as assembly:
        listed = assembly.window.panel.list
        qtbot.waitUntil(lambda: ADAPTER.device in rows(assembly))
        spoken = listed.item(0).data(Qt.ItemDataRole.AccessibleTextRole)
        assert all(part in spoken for part in ("ttyUSB0", "CP2102", "Silicon Labs", "0001"))
        assert given(listed.chosen).device == ADAPTER.device  # the only adapter
        assert listed.choice_at(1).device == SIMULATED_PORT
        ports.now.append(SECOND_ADAPTER)
        qtbot.waitUntil(lambda: SECOND_ADAPTER.device in rows(assembly))


def test_a_click_connects_to_the_simulated_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("demo"), window(qapp, tmp_path) as assembly:
        panel = assembly.window.panel
        qtbot.waitUntil(lambda: panel.list.count() == 1)
        qtbot.waitUntil(lambda: "Plug the adapter in" in panel.empty.text())
        assert panel.empty.isVisible()
        assert not panel.connect_button.isEnabled()
        where = panel.list.visualItemRect(panel.list.item(0)).center()
        qtbot.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=where)
        qtbot.mouseClick(panel.connect_button, Qt.MouseButton.LeftButton)
        wait_online(qtbot, assembly)
        qtbot.waitUntil(panel.isHidden)
        assert assembly.window.top_bar.port.accessibleName() == "Port Simulated module: Connected"


def test_by_keyboard_alone(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("typed"), window(qapp, tmp_path) as assembly:
        panel = assembly.window.panel
        qtbot.waitUntil(panel.isVisible)
        qtbot.keyClick(panel.list, Qt.Key.Key_Escape)
        assert panel.isHidden()
        qtbot.keyClick(assembly.window, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
        assert panel.isVisible()
        qtbot.keyClicks(panel.other, "sim://typed")
        qtbot.keyClick(panel.other, Qt.Key.Key_Return)
        wait_online(qtbot, assembly)
        qtbot.keyClick(assembly.window, Qt.Key.Key_D, Qt.KeyboardModifier.ControlModifier)
        qtbot.waitUntil(lambda: phase(assembly) is Phase.CLOSED)


def test_the_last_adapter_is_chosen_whatever_its_name_is_now(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    preferences = Preferences(tmp_path / "window.ini")
    preferences.last_port = LastPort("/dev/ttyUSB7", SECOND_ADAPTER.identity, 57600)
    preferences.save()
    with window(qapp, tmp_path, listed=ListedPorts(ADAPTER, SECOND_ADAPTER)) as assembly:
        panel = assembly.window.panel
        qtbot.waitUntil(lambda: panel.list.count() == 3)
        assert panel.chosen_target() == Target(SECOND_ADAPTER.device, 57600, SECOND_ADAPTER.identity)


# Failures


def test_a_missing_port_is_shown_in_a_notice(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    missing = str(tmp_path / "ttyNONE")
    with window(qapp, tmp_path) as assembly:
        assembly.ports.connect_to(Target(missing, 115200))
        assert phase(assembly) is Phase.OPENING  # at once
        qtbot.waitUntil(lambda: phase(assembly) is Phase.FAILED)
        qtbot.waitUntil(lambda: assembly.window.notice_bar.notice is not None)
        notice = given(assembly.window.notice_bar.notice)
        assert missing in notice.text
        assert "Traceback" not in notice.text
        assert assembly.window.notice_bar.button("connect_again") is not None
        assert missing in assembly.window.panel.state_label.text() or assembly.window.panel.isHidden()


def test_the_wrong_rate_is_found_with_one_click(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "rate", EMPTY_PAGE, baud=57600) as one:
        assembly = one.assembly
        assembly.ports.connect_to(Target("sim://rate", 115200))
        one.until(lambda: assembly.window.notice_bar.button("find_rate") is not None)
        press(qtbot, assembly.window.notice_bar.button("find_rate"))
        assert phase(assembly) is Phase.FINDING
        one.until(lambda: phase(assembly) is Phase.ONLINE)
        assert assembly.ports.current.connection.baud_rate == 57600


# Loss and return


def test_after_disconnect_it_stays_disconnected(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("gone") as bench, window(qapp, tmp_path) as assembly:
        connect(qtbot, assembly, "sim://gone")
        bench.unplug()
        qtbot.waitUntil(lambda: phase(assembly) is Phase.LOST)
        assembly.window.disconnect_port()
        bench.plug()
        qtbot.waitUntil(lambda: phase(assembly) is Phase.CLOSED)
        assert not assembly.ports.current.is_requested


def test_the_panel_names_the_port_and_the_rate_that_are_in_use(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    """It showed 115200 while connected at 57600, and "the module answers" below another port's row."""
    with fake_window(qapp, tmp_path, ADAPTER, SECOND_ADAPTER) as (ports, assembly):
        panel, rate = assembly.window.panel, 57600
        panel.prefer(LastPort(ADAPTER.device, ADAPTER.identity, 115200))
        qtbot.waitUntil(lambda: len(rows(assembly)) == 3)
        port = assembly.ports.current
        port.connect_to(Target(SECOND_ADAPTER.device, rate, SECOND_ADAPTER.identity))
        ports.workers[0].say(**VALUES)
        qtbot.waitUntil(lambda: port.is_open and port.module.is_going)
        for _ in range(2):
            panel.show()
            qtbot.waitUntil(panel.isVisible)
            assert given(panel.list.chosen).device == SECOND_ADAPTER.device
            assert panel.rate.currentData() == rate
            assert panel.state_label.text() == f"ttyACM0 · {rate} baud: The module answers."
            panel.list.choose(ADAPTER.identity)  # another one may be chosen
            panel.rate.setCurrentIndex(panel.rate.findData(9600))
            panel.refresh()
            assert given(panel.list.chosen).device == ADAPTER.device
            assert panel.rate.currentData() == 9600
            assert panel.state_label.text() == f"ttyACM0 · {rate} baud: The module answers."  # not that of the row
            panel.hide()
