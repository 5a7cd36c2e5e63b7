"""The Diagnosis page: causes and next steps, sharing of the port, statistics, support bundle, traffic."""

import logging
import socket
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QAbstractItemModel, Qt
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import ConversationView
from app.engine.target import Target
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from app.safety.left_active import LeftActive
from app.simulator.bench import SimulatedBench
from app.system.clock import steady_time
from app.system.logs import Log
from protocol.catalogue import ACTIVATION, BOOT_COUNT, BY_NAME, HEARTBEAT, LOCK, STATUS
from protocol.events import Answered, Counters, Event, Received, Rejected, Role, Sent
from protocol.messages import Direction, Frame, Heartbeat, Reason, Status, decode
from protocol.stream import StreamParser
from tests.support.line.frames import at_each_frame, echo
from tests.support.window.desk import desk
from tests.support.window.fakes_ui import page_entries, simulated, window
from tests.support.window.rig import Rig
from tests.support.window.steps import choosing, find, given, press
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.traffic import MAX_ROWS, Column, Filter, TrafficModel, TrafficView
from ui.pages.diagnosis.why import SharingCard


@pytest.fixture
def page(one: Rig) -> DiagnosisPage:
    return one.find(DiagnosisPage)


def cause_of(page: DiagnosisPage) -> str | None:
    page.why.refresh()
    return None if page.why.diagnosis is None else page.why.diagnosis.cause


# Why does it not connect?


def stream(bench: SimulatedBench) -> None:
    bench.module.start_stream(bench.clock())


def only_echo(bench: SimulatedBench) -> None:
    at_each_frame(bench, lambda _request: False)
    echo(bench)


@pytest.mark.parametrize(
    ("options", "also", "cause", "button"),
    [
        ({"mute": True}, None, "nothing", "Find the baud rate"),
        ({}, only_echo, "echo", "Choose a port"),
        ({"corrupt": 0.09, "rate": 200}, stream, "bad line", "Connect again"),
        ({"baud": 57600, "rate": 50}, stream, "wrong rate", "Find the baud rate"),
    ],
)
def test_a_fault_of_the_line_has_one_cause_and_one_button(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, options: dict[str, Any],
    also: Callable[[SimulatedBench], object] | None, cause: str, button: str,
) -> None:  # fmt: skip
    with desk(qtbot, qapp, tmp_path, "diagnosis", is_connected=False, **options) as one:
        if also is not None:
            also(one.bench)
        page = one.find(DiagnosisPage)
        one.assembly.ports.connect_to(Target(one.url, 115200))
        one.until(lambda: cause_of(page) == cause)
        assert page.why.act.isVisible()
        assert page.why.act.text() == button
        assert page.why.next_step.isVisible()
        assert page.why.what.text()
        if cause == "wrong rate":
            one.click(page.why.act)
            one.until(lambda: "answers" in page.why.what.text())
            assert one.assembly.ports.module.is_going
            assert page.why.diagnosis is None
            assert not page.why.act.isVisible()


def test_a_port_that_cannot_be_opened_leads_to_a_command_or_to_the_list_of_ports(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=page_entries("diagnosis")) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages)
        assembly.window.go_to("diagnosis")
        page = find(assembly.window, DiagnosisPage)
        ports, panel = assembly.ports, assembly.window.panel
        assert cause_of(page) is None
        assert page.why.act.text() == "Choose a port"
        target = Target(str(tmp_path / "tty"), 115200, "0403:6001")
        ports.connect_to(target)
        qtbot.waitUntil(lambda: cause_of(page) == "missing")
        panel.hide()
        press(qtbot, page.why.act)
        assert panel.isVisible()
        page.ports_wanted.emit()
        assert panel.isVisible()  # shown, never toggled
        panel.hide()
        denied = PortError(PortErrorKind.NOT_ALLOWED, target.device, "denied")
        refused = ports.current.connection._replace(trouble=denied)
        ports.current._on_batch(Batch(steady_time(), refused, ConversationView(), None))
        qtbot.waitUntil(lambda: cause_of(page) == "no permission")
        if sys.platform.startswith("linux"):
            command = "sudo usermod -aG dialout $USER"
            assert command in page.why.next_step.text()
            assert page.why.act.text() == "Copy"
            press(qtbot, page.why.act)
            assert QApplication.clipboard().text() == command
        assembly.storage.left_active = (LeftActive(module="M-07"),)  # it may be this one
        page.why.refresh()
        assert page.why.next_step.text().startswith("Keep away")


def test_what_was_seen_of_the_port_before_is_no_evidence(one: Rig, page: DiagnosisPage) -> None:
    """Of a module that has never answered it would be said that it fell silent."""
    assert one.port.evidence.was_online
    with simulated("mute", mute=True):
        one.port.connect_to(Target("sim://mute", 115200))
        one.until(lambda: cause_of(page) is not None)
        assert cause_of(page) == "nothing"
        assert not one.port.evidence.was_online


# Figures


@pytest.mark.module(is_connected=False)
def test_figures_are_those_of_the_link(one: Rig, page: DiagnosisPage) -> None:
    statistics, now = one.port.module.statistics, one.clock()
    opened = Connection(PortState.OPEN, "sim://x", 115200)
    counters = Counters(sent=10, frames=8, time_outs=2, restarts=1)
    counters.rejected_bytes[Reason.CHECKSUM] = 12
    trips = [Answered(HEARTBEAT.query(), (Heartbeat(),), 1, trip_s, now) for trip_s in (0.003, 0.003, 0.003, 0.05)]
    for at, counted in ((now - 2, Counters(bytes_received=1000)), (now - 1, counters)):
        statistics.on_batch(Batch(at, opened, ConversationView(), counted, events=tuple(trips)))
    page.go_to("figures")
    shown = {key: figure.text() for key, figure in page.statistics.figures.items()}
    expected = {
        "sent": "10",
        "lost": "2 (20 %)",
        "rejected": "12\nwrong checksum: 12",
        "restarts": "1",
        "trip": "3.0 ms",
        "slowest": "50.0 ms",
    }
    assert shown.items() >= expected.items()
    warned = {key for key, figure in page.statistics.figures.items() if figure.property("look") == "attention"}
    assert warned == {"lost", "rejected"}


# The support bundle


@pytest.mark.promise("l")
def test_the_saved_bundle_equals_the_preview_and_is_made_again_for_another_module(
    request: pytest.FixtureRequest, tmp_path: Path, one: Rig, page: DiagnosisPage
) -> None:
    log = Log(tmp_path / "logs")
    logging.getLogger("test").warning("the cable is loose, says /home/somebody/notes")
    page.bundle.log = log
    request.addfinalizer(log.stop)
    page.go_to("bundle")
    one.until(lambda: page.bundle.files is not None)
    one.until(page.bundle.save.isEnabled)
    promise = page.bundle.findChild(QLabel, "bundle_promise")
    assert isinstance(promise, QLabel)
    assert promise.isVisible()
    for stays in ("modules", "files", "ports", "serial numbers", "addresses"):
        assert stays in promise.text()
    files = given(page.bundle.files)
    seen = page.bundle.text.toPlainText()
    assert all(name in seen and text in seen for name, text in files.items())
    assert {"about.json", "log.txt", "capture.txt"} <= files.keys()
    lines = seen.splitlines()
    assert any("the cable is loose" in line and "/home/<user>/notes" in line for line in lines)
    assert "boot_count" in seen
    path = tmp_path / "support.zip"
    page.bundle.ask_path = choosing(path)
    one.click(page.bundle.save)
    one.until(path.exists)
    one.until(lambda: "Saved to" in page.strip.accessibleName())
    with zipfile.ZipFile(path) as archive:
        assert {name: archive.read(name).decode() for name in archive.namelist()} == files
    one.port.treat_as_another()
    one.until(lambda: page.bundle.files is not files and page.bundle.save.isEnabled())
    assert given(page.bundle.files) is not files


# Sharing


@pytest.fixture
def card(one: Rig) -> SharingCard:
    """Switched on, at a free port."""
    card = one.find(DiagnosisPage).why.sharing
    card.address.setText("127.0.0.1:0")
    one.click(card.switch)
    assert card.switch.isChecked()
    return card


def reader(card: SharingCard) -> socket.socket:
    address = card.state.text().split(",")[0].removeprefix("shared://")
    client = socket.create_connection(("127.0.0.1", int(address.rpartition(":")[2])))
    client.setblocking(False)
    return client


def hear(one: Rig, client: socket.socket, length: int) -> bytes:
    heard = bytearray()

    def is_there() -> bool:
        try:
            heard.extend(client.recv(4096))
        except BlockingIOError:
            return False
        return len(heard) >= length

    one.until(is_there)
    return bytes(heard)


@pytest.mark.promise("h")
def test_a_reader_asks_and_changes_nothing(one: Rig, card: SharingCard) -> None:
    with reader(card) as client:
        client.sendall(BOOT_COUNT.query().encode())
        assert hear(one, client, 6)[:3] == bytes.fromhex("41 75 23")
        assert "readers: 1" in card.state.text()
        for change in (ACTIVATION.set(True), BY_NAME["freefall_time"].set(1.2)):
            client.sendall(change.encode() + STATUS.query().encode())
            hear(one, client, 8)
            assert f"{change.encode().hex(' ').upper()}: Shared, read-only" in card.last.text()
        assert one.acts == []
    one.until(lambda: "readers: 0" in card.state.text())


def test_a_readers_lock_is_that_of_the_window(one: Rig, card: SharingCard) -> None:
    one.bench.module.activate(is_active=True)
    one.until(lambda: one.assembly.ports.current.is_active)
    with reader(card) as client:
        client.sendall(LOCK.encode())
        assert hear(one, client, 6) == bytes.fromhex("41 75 10 01 00 11")
        assert not one.bench.module.state.is_active
        assert "The module reports LOCKED." in card.last.text()
        assert set(one.acts) == {LOCK}
        # A second one is sent as the first was.
        client.sendall(LOCK.encode())
        hear(one, client, 6)


@pytest.mark.parametrize("is_port_closed", [False, True])
def test_it_ends_with_the_switch_and_with_the_port(one: Rig, card: SharingCard, is_port_closed: bool) -> None:
    with reader(card) as client:
        one.until(lambda: "readers: 1" in card.state.text())
        if is_port_closed:
            one.assembly.ports.current.disconnect_port()
        else:
            one.click(card.switch)
        one.until(lambda: not card.switch.isChecked())
        assert hear(one, client, 0) == b""
        assert card.switch.isEnabled() is not is_port_closed


@pytest.mark.parametrize(
    ("address", "is_on", "said"),
    [("nowhere", False, "HOST:PORT"), ("192.0.2.1:7001", False, "192.0.2.1"), ("0.0.0.0:0", True, "no authentication")],
)
def test_an_address_is_judged(one: Rig, card: SharingCard, address: str, is_on: bool, said: str) -> None:
    one.click(card.switch)
    card.address.setText(address)
    one.click(card.switch)
    assert card.switch.isChecked() is is_on
    assert said in card.last.text()


STREAMED = Status(7, 1.0, triggered=False, active=False).encode()


def streamed(count: int, first: int = 0) -> list[Event]:
    frame = Frame(Direction.MODULE_TO_HOST, STREAMED)
    return [Received(frame, decode(STREAMED), Role.STREAMED, float(first + number)) for number in range(count)]


def rejected(raw: bytes) -> list[Event]:
    parser = StreamParser()
    return [Rejected(piece, 1.0) for piece in (*parser.feed(raw), *parser.flush()) if not isinstance(piece, Frame)]


def sent(name: str = "cell_voltage", attempt: int = 1) -> Sent:
    request = BY_NAME[name].query()
    return Sent(request.encode(), request, attempt, 1.0)


def cell(model: QAbstractItemModel, row: int, column: Column) -> str:
    return str(model.index(row, column).data())


def model_of(*events: Event) -> TrafficModel:
    model = TrafficModel()
    model.append(events)
    model.show_new()
    return model


def feed(traffic: TrafficView, *events: Event) -> None:
    traffic.model.append(events)
    traffic.draw()


@pytest.fixture
def traffic(qtbot: QtBot) -> Iterator[TrafficView]:
    """Alone in a window."""
    around = QWidget()
    qtbot.addWidget(around)
    view = TrafficView()
    view.setParent(around)
    around.resize(900, 620)
    view.resize(900, 620)
    around.show()
    around.activateWindow()
    qtbot.waitUntil(around.isActiveWindow)
    yield view
    around.close()


def test_the_oldest_rows_are_dropped_and_long_garbage_loses_nothing(qapp: QApplication) -> None:
    model = model_of(*streamed(MAX_ROWS - 1))
    model.append(streamed(11, first=MAX_ROWS))
    model.show_new()
    assert (model.rowCount(), model.rows[0].at, model.rows[-1].at) == (MAX_ROWS, 10.0, MAX_ROWS + 10)
    garbage = bytes(range(48)) * 100
    raws = [event.noise.raw for event in model_of(*rejected(garbage)).rows if isinstance(event, Rejected)]
    assert b"".join(raws) == garbage


def test_rows_describe_their_frames_or_why_bytes_are_none_and_are_searched(traffic: TrafficView) -> None:
    voltage = bytes.fromhex("4175 34 01 BE F3")
    answer = decode(voltage, BY_NAME["cell_voltage"].query())
    reply = Received(Frame(Direction.MODULE_TO_HOST, voltage), answer, Role.ANSWER, 1.0)
    wrong_checksum = bytes(STREAMED[:-1] + bytes((STREAMED[-1] ^ 1,)))
    feed(traffic, sent(), reply, *rejected(wrong_checksum), *streamed(10))
    assert [cell(traffic.model, row, Column.KIND) for row in range(3)] == ["sent", "reply", "invalid"]
    assert cell(traffic.model, 0, Column.BYTES) == "42 61 34 01 00 35"
    assert cell(traffic.model, 1, Column.MEANING) == "reply: cell voltage 3.80 V"
    assert "checksum" in cell(traffic.model, 2, Column.MEANING)
    assert traffic.model.index(2, Column.KIND).data(Qt.ItemDataRole.ForegroundRole) is not None
    for kind, query, count in (
        (Filter.ALL, "", 14),
        (Filter.WITHOUT_STREAM, "", 4),
        (Filter.REJECTED, "", 2),
        (Filter.ALL, "42 61", 1),
        (Filter.ALL, "Tilt 7", 10),
        (Filter.ALL, "query: cell", 1),
        (Filter.WITHOUT_STREAM, "tilt 7", 0),
        (Filter.ALL, "nowhere", 0),
    ):
        traffic.filter.setCurrentIndex(traffic.filter.findData(kind))
        traffic.search.setText(query)
        assert traffic.shown.rowCount() == count, (kind, query)
        assert traffic.count.text() == f"rows: {count}"
    feed(traffic, *rejected(b"\x02"))
    assert traffic.shown.rowCount() == 0
    traffic.search.clear()
    assert traffic.shown.rowCount() == 15


def test_the_frames_of_the_module_shown_are_searched_until_another_one_is(one: Rig, page: DiagnosisPage) -> None:
    page.go_to("traffic")
    traffic = page.traffic
    one.qtbot.keyClick(one.window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
    assert traffic.search.hasFocus()
    traffic.search.setText("heartbeat")
    one.until(lambda: traffic.shown.rowCount() > 1)
    one.assembly.ports.choose(one.assembly.ports.add())
    assert (traffic.count.text(), traffic.search.text()) == ("rows: 0", "")


def test_the_list_scrolls_only_from_its_end_and_what_is_in_sight_stays_when_old_rows_go(
    qtbot: QtBot, traffic: TrafficView
) -> None:
    bar = traffic.table.verticalScrollBar()
    feed(traffic, *streamed(200))
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    for height, count in ((520, 0), (520, 50)):
        before = bar.maximum()
        traffic.resize(900, height)
        feed(traffic, *streamed(count))
        qtbot.waitUntil(lambda: bar.value() == bar.maximum() > before)  # noqa: B023
    bar.setValue(100)
    feed(traffic, *streamed(1234))
    QApplication.processEvents()
    assert (bar.value(), traffic.count.text()) == (100, "1,234 new")
    bar.setValue(bar.maximum())
    qtbot.waitUntil(lambda: traffic.shown.rowCount() == 1484)
    feed(traffic, *streamed(MAX_ROWS))
    qtbot.waitUntil(lambda: bar.value() == bar.maximum())
    bar.setValue(bar.maximum() // 2)
    top = traffic.model.rows[traffic.table.rowAt(0)]
    feed(traffic, *streamed(100, first=MAX_ROWS))
    assert traffic.model.rows[traffic.table.rowAt(0)] is top
    bar.setValue(0)
    traffic.begin_again()
    QApplication.processEvents()
    feed(traffic, *streamed(2))
    assert traffic.shown.rowCount() == 2, "an empty list is at its end"


def test_copy_and_detail(qtbot: QtBot, traffic: TrafficView) -> None:
    feed(traffic, *streamed(3), sent(), sent("boot_count"), sent("light"))
    traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.WITHOUT_STREAM))
    traffic.table.selectRow(1)
    assert "42 61 23 01 00 24" in traffic.detail.text()
    qtbot.keyClick(traffic.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    (line,) = QApplication.clipboard().text().split("\n")
    assert line.split("\t")[1:] == ["sent", "42 61 23 01 00 24", "query: boot count"]
    traffic.table.clearSelection()
    qtbot.mouseClick(traffic.copy, Qt.MouseButton.LeftButton)
    assert len(QApplication.clipboard().text().split("\n")) == 3
    traffic.table.selectRow(1)
    traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.REJECTED))
    assert "42 61 23 01 00 24" not in traffic.detail.text()
