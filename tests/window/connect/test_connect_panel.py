"""Choosing a port, connecting, errors; after a lost port only the same adapter is opened, also under another name."""

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.captures.traffic import entries_of
from app.diagnosis.causes import NextStep
from app.diagnosis.link_state import Phase, link_state
from app.diagnosis.silence import Silence
from app.engine.conversation import ConversationView
from app.engine.ports import NOT_LISTED, PortInfo
from app.engine.reconnect import Absence
from app.engine.target import Target
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from app.procedures.read import READABLE
from app.text.messages import UserError
from protocol.events import Received, Sent
from protocol.messages import Direction
from tests.module.module import Module
from tests.support.window.desk import desk
from tests.support.window.fakes_ui import (
    ADAPTER,
    SECOND_ADAPTER,
    ListedPorts,
    page_entries,
    simulated,
    wait_online,
    window,
)
from tests.support.window.rig import Rig
from tests.support.window.steps import given, notice_text, press
from ui.core.preferences import LastPort, Preferences
from ui.main import Assembly


def rows(assembly: Assembly) -> dict[str, str]:
    """The rows of the port list: device -> title."""
    return {row.device: row.title for row in assembly.window.panel.rows}


def phase(assembly: Assembly) -> Phase:
    return assembly.ports.current.state.phase


# What is said

OPEN = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)


def test_each_trouble_has_its_sentence_and_its_next_step() -> None:
    for trouble in PortErrorKind:
        refused = OPEN._replace(state=PortState.CLOSED, trouble=PortError(trouble, OPEN.port, "driver's"))
        said = link_state(refused, ConversationView(), None, is_finding=False)
        assert (said.phase, said.step) == (Phase.FAILED, NextStep.CONNECT_AGAIN)
        assert said.what
        assert said.next_step
        assert "driver's" not in said.what
    silent = {silence: link_state(OPEN, ConversationView(), silence, is_finding=False) for silence in Silence}
    assert {said.phase for said in silent.values()} == {Phase.SILENT}
    assert len({said.what for said in silent.values()}) == len(Silence)
    assert silent[Silence.GARBAGE].step is NextStep.FIND_RATE


# The panel


def test_a_port_plugged_in_meanwhile_is_listed(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    ports = ListedPorts(ADAPTER)
    with window(qapp, tmp_path, listed=ports) as assembly:
        panel = assembly.window.panel
        qtbot.waitUntil(lambda: ADAPTER.device in rows(assembly))
        spoken = panel.list.item(0).data(Qt.ItemDataRole.AccessibleTextRole)
        assert all(part in spoken for part in ("ttyUSB0", "CP2102", "Silicon Labs", "0001"))
        assert given(panel.chosen).device == ADAPTER.device  # the only adapter
        ports.now.append(SECOND_ADAPTER)
        qtbot.waitUntil(lambda: SECOND_ADAPTER.device in rows(assembly))
        assert given(panel.chosen).device == ADAPTER.device, "it stays chosen"


def test_by_a_click_on_the_simulated_module_and_by_keyboard_alone(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("demo"), simulated("typed"), window(qapp, tmp_path) as assembly:
        panel = assembly.window.panel
        qtbot.waitUntil(lambda: panel.list.count() == 1)
        qtbot.waitUntil(lambda: "Plug the adapter in" in panel.empty.text())
        assert panel.empty.isVisible()
        assert not panel.connect_button.isEnabled()
        qtbot.keyClick(panel.list, Qt.Key.Key_Escape)
        assert panel.isHidden()
        qtbot.keyClick(assembly.window, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
        assert panel.isVisible()
        qtbot.keyClicks(panel.other, "sim://typed")
        qtbot.keyClick(panel.other, Qt.Key.Key_Return)
        wait_online(qtbot, assembly)
        qtbot.waitUntil(panel.isHidden)
        qtbot.keyClick(assembly.window, Qt.Key.Key_D, Qt.KeyboardModifier.ControlModifier)
        qtbot.waitUntil(lambda: phase(assembly) is Phase.CLOSED)
        panel.show()
        where = panel.list.visualItemRect(panel.list.item(0)).center()
        qtbot.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=where)
        qtbot.mouseClick(panel.connect_button, Qt.MouseButton.LeftButton)
        wait_online(qtbot, assembly)
        qtbot.waitUntil(panel.isHidden)
        assert assembly.window.top_bar.port.accessibleName() == "Port Simulated module: Connected"


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
        qtbot.waitUntil(lambda: missing in notice_text(assembly.window.notice_bar))
        assert "Traceback" not in notice_text(assembly.window.notice_bar)
        assert assembly.window.notice_bar.button("connect_again") is not None


@pytest.mark.module(baud=57600, is_connected=False)
def test_the_wrong_rate_is_found_with_one_click(one: Rig) -> None:
    one.port.connect_to(Target(one.url, 115200))
    one.until(lambda: one.window.notice_bar.button("find_rate") is not None)
    press(one.qtbot, one.window.notice_bar.button("find_rate"))
    assert phase(one.assembly) is Phase.FINDING
    one.until(lambda: phase(one.assembly) is Phase.ONLINE)
    assert one.port.connection.baud_rate == 57600


# Loss and return


def test_the_panel_names_the_port_and_the_rate_that_are_in_use(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    """It showed 115200 while connected at 57600, and "the module answers" below another port's row."""
    listed = ListedPorts(ADAPTER, SECOND_ADAPTER)
    with desk(qtbot, qapp, tmp_path, listed=listed, is_connected=False, baud=57600) as one:
        panel, rate, (module,) = one.window.panel, 57600, (Module(now=one.clock()),)
        module.rate = rate
        one.devices[SECOND_ADAPTER.device] = (module,)
        panel.prefer(LastPort(ADAPTER.device, ADAPTER.identity, 115200))
        one.until(lambda: len(rows(one.assembly)) == 3)
        one.port.connect_to(Target(SECOND_ADAPTER.device, rate, SECOND_ADAPTER.identity))
        one.until(lambda: phase(one.assembly) is Phase.ONLINE)
        for _ in range(2):
            panel.show()
            one.until(panel.isVisible)
            assert given(panel.chosen).device == SECOND_ADAPTER.device
            assert panel.rate.currentData() == rate
            assert panel.state_label.text() == f"ttyACM0 · {rate} baud: The module answers."
            panel.choose(ADAPTER.identity)  # another one may be chosen
            panel.rate.setCurrentIndex(panel.rate.findData(9600))
            panel.refresh()
            assert given(panel.chosen).device == ADAPTER.device
            assert panel.rate.currentData() == 9600
            assert panel.state_label.text() == f"ttyACM0 · {rate} baud: The module answers."  # not that of the row
            panel.hide()


class Listed(ListedPorts):
    """A list that can fail."""

    is_listable = True

    def poll(self, deadline_s: float) -> list[PortInfo]:
        ports = super().poll(deadline_s)
        if not self.is_listable:
            raise UserError(NOT_LISTED)
        return ports


@pytest.mark.parametrize("identity", [ADAPTER.identity, ""], ids=["chosen from the list", "typed"])
def test_only_the_same_adapter_is_opened_again_also_under_another_name(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, identity: str
) -> None:
    listed = Listed(ADAPTER)
    with desk(qtbot, qapp, tmp_path, listed=listed, is_connected=False) as one:
        port, bar, module = one.port, one.window.notice_bar, Module(now=one.clock())
        one.devices |= {ADAPTER.device: (module,), "/dev/ttyUSB5": (module,)}
        port.connect_to(Target(ADAPTER.device, 115200, identity))
        one.until(lambda: phase(one.assembly) is Phase.ONLINE)
        one.until(lambda: not port._return.is_due(0.0))  # while it is open it is learnt which adapter it is
        whose = port.key

        def look(times: int = 3) -> None:
            """The list of ports is read again so many times."""
            looks = listed.looks
            one.until(lambda: listed.looks >= looks + times, limit_s=10_000.0)

        listed.is_listable = False
        one.unplug(port)
        one.until(lambda: phase(one.assembly) is Phase.LOST)
        one.until(lambda: Absence.AWAY.value in notice_text(bar))
        assert not port.module.is_going
        look()  # the last list, which still has it, says nothing
        listed.now, listed.is_listable = [SECOND_ADAPTER._replace(device=ADAPTER.device)], True
        look()  # another one has its name
        assert (phase(one.assembly), len(one.lines)) == (Phase.LOST, 1)
        listed.now = [ADAPTER._replace(device="/dev/ttyUSB5"), SECOND_ADAPTER]
        one.until(lambda: phase(one.assembly) is Phase.ONLINE, limit_s=10_000.0)
        assert ([line.port for line in one.lines], port.key) == ([ADAPTER.device, "/dev/ttyUSB5"], whose)


@pytest.mark.module(baud=57600, is_connected=False)
def test_it_comes_back_at_the_rate_at_which_it_answered_and_nothing_is_sent_again(one: Rig) -> None:
    one.port.connect_to(Target(one.url, 115200))
    one.until(lambda: one.port.is_open)
    one.port.find_rate()
    one.until(lambda: one.port.module.is_read)
    one.bench.unplug()
    one.until(lambda: phase(one.assembly) is Phase.LOST)
    one.requests.clear()
    one.bench.plug()
    one.until(lambda: phase(one.assembly) is Phase.ONLINE and one.port.module.is_read)
    assert one.port.connection.baud_rate == 57600
    assert one.acts == []
    assert {command.query() for command in READABLE} <= set(one.requests)


def test_no_page_misses_data_of_a_port_that_is_chosen_early(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    entries = page_entries("live", "settings", "fleet", "diagnosis")
    with simulated("early"), window(qapp, tmp_path, entries=entries) as assembly:
        connector, batches = assembly.ports, list[Batch]()
        connector.current.batch.connect(batches.append)
        assembly.window.connect_to(Target("sim://early", 115200))
        assert not connector.current.is_requested  # the pages are not there yet
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: connector.module.is_read)
        pages: dict[str, Any] = assembly.window._pages
        events = [event for batch in batches for event in batch.events]
        sent = [event.raw for event in events if isinstance(event, Sent)]
        received = [event.frame.raw for event in events if isinstance(event, Received)]
        model = pages["diagnosis"].traffic.model
        kept = list(entries_of([*model.rows, *model.new], 0.0))
        assert b"".join(one.raw for one in kept if one.direction is Direction.HOST_TO_MODULE) == b"".join(sent)
        assert b"".join(one.raw for one in kept if one.direction is Direction.MODULE_TO_HOST) == b"".join(received)
        assert len(sent) > 5 < len(received)
        assert pages["live"].data.has_samples
        assert connector.module.is_going
        assert [connection.target for connection in pages["fleet"].members.connections] == [connector.current.target]
