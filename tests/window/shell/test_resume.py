"""Reconnecting after a lost port, on pseudo-terminals: only the same adapter, also under another name."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.captures.traffic import Way, entries_of
from app.diagnosis.link_state import Phase
from app.engine.ports import NOT_LISTED, PortInfo
from app.engine.reconnect import Absence
from app.engine.target import Target
from app.engine.worker import Batch
from app.procedures.read import READABLE
from app.safety.journal import Act
from app.text.messages import UserError
from protocol.catalogue import SERIAL_OUTPUT, Request
from protocol.events import EndReason, Received, Sent
from tests.support.module_apart import ModuleApart, module_apart
from tests.support.terminals import taken
from tests.support.window.fake_ports import fake_window
from tests.support.window.fakes_ui import ADAPTER, ListedPorts, page_entries, simulated, wait_online, window
from tests.support.window.steps import given
from ui.acts.confirm import Confirm
from ui.main import Assembly

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")

KEYS = {command.key for command in READABLE[3:]}


class Desk:
    """A module on a pseudo-terminal that is listed as an adapter, wherever it is plugged in; and what was sent."""

    def __init__(self, link: Path, module: ModuleApart) -> None:
        self.link, self.module = link, module
        self.adapter = ADAPTER
        self.others: list[PortInfo] = []
        self.is_listable = True
        self.looks = 0
        self.sent: list[Request] = []

    @property
    def name(self) -> str:
        return os.path.realpath(self.link)

    def poll(self, _deadline_s: float) -> list[PortInfo]:
        self.looks += 1
        if not self.is_listable:
            raise UserError(NOT_LISTED)
        mine = [self.adapter._replace(device=self.name)] if self.link.exists() else []
        return [*mine, *self.others]

    def on_batch(self, batch: Batch) -> None:
        self.sent += [event.request for event in batch.events if isinstance(event, Sent)]


class DeskPorts(ListedPorts):
    """What the fixture of the window wants."""

    def __init__(self, desk: Desk) -> None:
        super().__init__()
        self._desk = desk

    def poll(self, deadline_s: float) -> list[PortInfo]:
        return self._desk.poll(deadline_s)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    link = tmp_path / "adapter"
    with module_apart(link) as module:
        yield Desk(link, module)


@contextmanager
def connected(qtbot: QtBot, qapp: QApplication, folder: Path, desk: Desk, identity: str) -> Iterator[Assembly]:
    """The window, online at the desk's module."""
    with window(qapp, folder, listed=DeskPorts(desk)) as assembly:
        assembly.ports.current.batch.connect(desk.on_batch)
        assembly.ports.connect_to(Target(desk.name, 115200, identity))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: fresh(assembly) == KEYS)
        qtbot.waitUntil(lambda: not assembly.ports.current._return.is_due(0.0))
        yield assembly


def fresh(assembly: Assembly) -> set[str]:
    connector = assembly.ports
    return {key for key in KEYS if connector.current.module.view.fresh(key, connector.clock()) is not None}


def phase(assembly: Assembly) -> Phase:
    return assembly.ports.current.state.phase


def wait_back(qtbot: QtBot, assembly: Assembly) -> None:
    qtbot.waitUntil(lambda: phase(assembly) is Phase.ONLINE)


def wait_said(qtbot: QtBot, assembly: Assembly, text: str) -> None:
    def is_said() -> bool:
        notice = assembly.window.notice_bar.notice
        return notice is not None and text in notice.text

    qtbot.waitUntil(is_said)


@pytest.mark.parametrize("identity", [ADAPTER.identity, ""], ids=["chosen from the list", "typed"])
def test_it_comes_back_under_another_name(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, desk: Desk, identity: str
) -> None:
    first_name = desk.name
    with connected(qtbot, qapp, tmp_path, desk, identity) as assembly:
        connector, whose = assembly.ports, assembly.ports.current.key
        desk.module.tell("unplug")
        qtbot.waitUntil(lambda: phase(assembly) is Phase.LOST)
        assert not connector.module.is_going
        wait_said(qtbot, assembly, Absence.AWAY.value)
        desk.sent.clear()
        with taken(first_name):
            desk.module.tell("plug")
            qtbot.waitUntil(lambda: connector.current.is_open)
        assert connector.current.connection.port not in (first_name, str(desk.link))
        assert connector.current.key == whose
        qtbot.waitUntil(lambda: fresh(assembly) == KEYS)
        assert {request for request in desk.sent if not request.is_repeatable} <= {SERIAL_OUTPUT.set(True)}
        assert {command.query() for command in READABLE} <= set(desk.sent)


def test_a_failed_list_of_ports_opens_nothing(qtbot: QtBot, qapp: QApplication, tmp_path: Path, desk: Desk) -> None:
    with connected(qtbot, qapp, tmp_path, desk, ADAPTER.identity) as assembly:
        desk.is_listable = False
        desk.module.tell("unplug")
        qtbot.waitUntil(lambda: phase(assembly) is Phase.LOST)
        desk.module.tell("plug")
        looks = desk.looks
        qtbot.waitUntil(lambda: desk.looks >= looks + 3)
        assert phase(assembly) is Phase.LOST
        desk.is_listable = True
        wait_back(qtbot, assembly)


def test_it_comes_back_at_the_rate_at_which_it_answered(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("slow", baud=57600) as bench, window(qapp, tmp_path) as assembly:
        assembly.ports.connect_to(Target("sim://slow", 115200))
        qtbot.waitUntil(lambda: assembly.ports.current.is_open)
        assembly.ports.current.find_rate()
        wait_online(qtbot, assembly)
        bench.unplug()
        qtbot.waitUntil(lambda: phase(assembly) is Phase.LOST)
        bench.plug()
        wait_back(qtbot, assembly)
        assert assembly.ports.current.connection.baud_rate == 57600


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
        kept = list(entries_of(pages["diagnosis"].traffic.model.events, 0.0))
        assert b"".join(one.raw for one in kept if one.way is Way.OUT) == b"".join(sent)
        assert b"".join(one.raw for one in kept if one.way is Way.IN) == b"".join(received)
        assert len(sent) > 5 < len(received)
        assert pages["live"].data.has_samples
        assert connector.module.is_going
        assert [connection.target for connection in pages["fleet"].members.connections] == [connector.current.target]


def test_the_end_of_the_conversation_withdraws_confirmations(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        _port, worker = ports.plug_in("/dev/one")
        qtbot.waitUntil(lambda: assembly.ports.module.is_going)
        question = Confirm("night", ask="Zero", go="Zero now")
        question.setParent(assembly.window)
        question.ask.click()
        assembly.window._services.armed.act = Act.DEPLOY
        worker.end(EndReason.SLEPT)
        qtbot.waitUntil(lambda: assembly.window._services.armed.act is None)
        assert not question.is_asking
        assert "The computer slept." in given(assembly.ports.current.interruptions.last).translated()
