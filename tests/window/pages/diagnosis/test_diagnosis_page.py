"""The Diagnosis page: causes and next steps, sharing of the port, statistics, support bundle, errors of the program."""

import logging
import re
import socket
import sys
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from app.diagnosis.causes import AdapterFacts
from app.engine.conversation import ConversationView
from app.engine.procedure import LinkView
from app.engine.target import Target
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Connection, PortState
from app.safety.journal import Act
from app.system.clock import steady_time
from app.system.logs import Log, start_log
from app.system.uncaught import catch_uncaught_errors
from protocol.catalogue import ACTIVATION, BOOT_COUNT, BY_NAME, HEARTBEAT, LOCK, STATUS
from protocol.events import Answered, Counters
from protocol.messages import Heartbeat, Reason
from tests.support.window.fakes_ui import connect, simulated, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import choosing, find, given, notice_text, press, show_page
from ui.main import Assembly
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.why import SharingCard
from ui.services.context import PageEntry
from ui.style.icons import Icon

ALONE = (PageEntry("diagnosis", "Diagnosis", Icon.DIAGNOSIS, DiagnosisPage),)


@contextmanager
def diagnosis(
    qtbot: QtBot, qapp: QApplication, folder: Path, **more: object
) -> Iterator[tuple[Assembly, DiagnosisPage]]:
    with window(qapp, folder, entries=ALONE, **more) as assembly:  # type: ignore[arg-type]
        yield assembly, show_page(qtbot, assembly.window, "diagnosis", DiagnosisPage)


def cause_of(page: DiagnosisPage) -> str | None:
    page.why.refresh()
    return None if page.why.diagnosis is None else page.why.diagnosis.cause


# Why does it not connect?


@pytest.mark.parametrize(
    ("options", "cause", "button"),
    [
        ({"mute": True}, "nothing", "Find the baud rate"),
        ({"mute": True, "echo": True}, "echo", "Choose a port"),
        ({"corrupt": 0.09, "stream_at_boot": True, "rate": 200}, "bad line", "Connect again"),
    ],
)
def test_a_fault_of_the_line_has_one_cause_and_one_button(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, options: dict[str, object], cause: str, button: str
) -> None:
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "why", ALONE, **options) as one:
        page = show_page(qtbot, one.assembly.window, "diagnosis", DiagnosisPage)
        one.assembly.ports.connect_to(Target(one.url, 115200))
        one.until(lambda: cause_of(page) == cause)
        assert page.why.act.isVisible()
        assert page.why.act.text() == button
        assert page.why.next_step.isVisible()
        assert page.why.what.text()


def test_a_module_that_fell_silent_has_the_time_of_its_last_value(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "why-silent", ALONE) as one:
        page = show_page(qtbot, one.assembly.window, "diagnosis", DiagnosisPage)
        one.connect()
        assert not page.why.silence.isVisible()
        one.bench.power_off()
        one.until(page.why.silence.isVisible)
        one.until(lambda: "since: 0 of" not in page.why.silence.text())
        said = re.fullmatch(
            r"Last value at (.+)\. Unanswered since: (\d+) of (\d+)\. The port is open\.",
            page.why.silence.text(),
        )
        assert said is not None
        assert 0 < int(said[2]) <= int(said[3])
        last = max(known.at for known in one.assembly.ports.module.view.values.values())
        ago_s = one.clock() - last
        shown = {time.strftime("%H:%M:%S", time.localtime(time.time() - ago_s + off_s)) for off_s in (-1, 0, 1)}
        assert said[1] in shown


def test_the_button_finds_the_rate(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    options = {"baud": 57600, "stream_at_boot": True, "rate": 50}
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "why-find", ALONE, **options) as one:
        page = show_page(qtbot, one.assembly.window, "diagnosis", DiagnosisPage)
        one.assembly.ports.connect_to(Target(one.url, 115200))
        one.until(lambda: cause_of(page) == "wrong rate")
        one.click(page.why.act)
        one.until(lambda: "answers" in page.why.what.text())
        assert one.assembly.ports.module.is_going
        assert page.why.diagnosis is None
        assert not page.why.act.isVisible()


def test_without_a_port_and_with_one_that_is_not_there_a_port_is_to_be_chosen(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        assert cause_of(page) is None
        assert page.why.act.text() == "Choose a port"
        assembly.ports.connect_to(Target(str(tmp_path / "none"), 115200))
        qtbot.waitUntil(lambda: cause_of(page) == "missing")
        panel = assembly.window.panel
        panel.hide()
        press(qtbot, page.why.act)
        assert panel.isVisible()
        page.why.choose_wanted.emit()
        assert panel.isVisible()  # shown, never toggled


def test_a_command_is_shown_and_copied(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    facts = AdapterFacts(group="dialout")
    monkeypatch.setattr("ui.pages.diagnosis.why.facts_about", lambda _port: facts)
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        target = Target(str(tmp_path / "tty"), 115200)
        assembly.ports.connect_to(target)
        qtbot.waitUntil(lambda: cause_of(page) == "missing")
        denied = PortError(PortTrouble.NOT_ALLOWED, target.device, "denied")
        refused = assembly.ports.current.connection._replace(trouble=denied)
        assembly.ports.current._on_batch(Batch(steady_time(), refused, ConversationView(), None))
        qtbot.waitUntil(lambda: cause_of(page) == "no permission")
        if sys.platform.startswith("linux"):
            assert page.why.command.text() == "sudo usermod -aG dialout $USER"
            assert page.why.act.text() == "Copy"
            press(qtbot, page.why.act)
            assert QApplication.clipboard().text() == "sudo usermod -aG dialout $USER"


def test_what_the_system_says_of_one_adapter_is_not_said_of_another_one_of_the_same_name(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [AdapterFacts(group="uucp"), AdapterFacts(group=None)]
    monkeypatch.setattr("ui.pages.diagnosis.why.facts_about", lambda _port: found[0])
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        for adapter in ("0403:6001", "0403:6015"):
            assembly.ports.connect_to(Target(str(tmp_path / "tty"), 115200, adapter))
            assert page.why.evidence().facts == AdapterFacts()
            qtbot.waitUntil(lambda: page.why.evidence().facts == found[0])
            found.pop(0)


# Figures


def link(counters: Counters) -> LinkView:
    return LinkView(counters + Counters(bytes_received=0 if counters.bytes_received else 1000), 0.003)


def exchanges(at: float, trips_s: list[float]) -> tuple[Answered, ...]:
    return tuple(Answered(HEARTBEAT.query(), (Heartbeat(),), 1, trip_s, at) for trip_s in trips_s)


def test_figures_show_loss_reasons_and_round_trips(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        statistics = assembly.ports.module.statistics
        now = assembly.ports.clock()
        opened = Connection(PortState.OPEN, "sim://x", 115200)
        statistics.on_batch(Batch(now - 2, opened, ConversationView(), link(Counters()), events=()))
        counters = Counters(sent=10, frames=8, time_outs=2, restarts=1)
        counters.rejected_bytes[Reason.CHECKSUM] = 12
        statistics.on_batch(
            Batch(now - 1, opened, ConversationView(), link(counters), events=exchanges(now, [0.003] * 3 + [0.05]))
        )
        lost = PortError(PortTrouble.LOST, "sim://x", "gone")
        statistics.on_batch(Batch(now, Connection(PortState.CLOSED, "sim://x", 115200, lost), ConversationView(), None))
        page.go_to("figures")
        shown = {key: figure.text() for key, figure in page.statistics.figures.items()}
        assert shown["sent"] == "10"
        assert shown["lost"] == "2 (20 %)"
        assert shown["trip"] == "3.0 ms"
        assert shown["rejected"] == "12"
        assert shown["restarts"] == "1"
        assert shown["losses"] == "1"
        assert shown["reasons"] == "wrong checksum: 12"
        assert shown["slowest"] == "50.0 ms"


# The support bundle


@pytest.fixture
def log(tmp_path: Path) -> Iterator[Log]:
    one = start_log(tmp_path / "logs")
    try:
        yield one
    finally:
        one.stop()


@pytest.mark.promise("l")
def test_the_saved_bundle_equals_the_preview_and_is_made_again_for_another_module(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, log: Log
) -> None:
    logging.getLogger("test").warning("the cable is loose, says /home/somebody/notes")
    with simulated("bundle"), diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        page.bundle.log = log
        connect(qtbot, assembly, "sim://bundle")
        port = assembly.ports.current
        qtbot.waitUntil(lambda: "boot_count" in port.module.view.values)
        page.go_to("bundle")
        qtbot.waitUntil(lambda: page.bundle.files is not None)
        qtbot.waitUntil(page.bundle.save.isEnabled)
        promise = page.bundle.findChild(QLabel, "bundle_promise")
        assert isinstance(promise, QLabel)
        assert promise.isVisible()
        for stays in ("modules", "files", "ports", "serial numbers", "addresses"):
            assert stays in promise.text()
        files = given(page.bundle.files)
        seen = page.bundle.text.toPlainText()
        assert all(name in seen and text in seen for name, text in files.items())
        assert {"about.json", "link.json", "module.json", "log.txt", "capture.txt"} <= files.keys()
        lines = seen.splitlines()
        assert any("the cable is loose" in line and "/home/<user>/notes" in line for line in lines)
        assert "boot_count" in seen
        path = tmp_path / "support.zip"
        page.bundle.ask_path = choosing(path)
        press(qtbot, page.bundle.save)
        qtbot.waitUntil(path.exists)
        qtbot.waitUntil(lambda: "Saved to" in page.strip.accessibleName())
        with zipfile.ZipFile(path) as archive:
            assert {name: archive.read(name).decode() for name in archive.namelist()} == files
        port.treat_as_another()
        qtbot.waitUntil(lambda: page.bundle.files is not files and page.bundle.save.isEnabled())
        assert given(page.bundle.files) is not files


# Errors of our own


def raise_uncaught(error: Exception) -> None:
    try:
        raise error
    except Exception as raised:  # noqa: BLE001
        sys.excepthook(type(raised), raised, raised.__traceback__)


def test_an_error_disarms_is_logged_and_said_with_its_details(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, log: Log
) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        bar = assembly.window.notice_bar
        armed = assembly.armed
        armed.act = Act.DEPLOY
        with ExitStack() as stack:
            stack.callback(catch_uncaught_errors(assembly.window.attention.report))
            raise_uncaught(LookupError("a bug"))
            assert armed.act is None
            qtbot.waitUntil(lambda: "a bug" in notice_text(bar))
            press(qtbot, bar.button("copy_details"))
            assert "raise_uncaught" in QApplication.clipboard().text()
            assert "Traceback" not in bar.notice.text
            assert "a bug" in log.text()
            dismiss = find(bar, QWidget, "notice_dismiss")
            press(qtbot, dismiss)
            qtbot.waitUntil(lambda: bar.notice is None or "a bug" not in bar.notice.text)
            assert page.isVisible()
            armed.act = Act.ACTIVATE
            for _ in range(3):  # in another thread
                thread = threading.Thread(target=int, args=("no number",))
                thread.start()
                thread.join()
            assert armed.act is None
            qtbot.waitUntil(lambda: "no number" in notice_text(bar))


@pytest.fixture
def rig(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Rig]:
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "shared", ALONE) as one:
        one.connect("boot_count")
        yield one


@pytest.fixture
def card(qtbot: QtBot, rig: Rig) -> SharingCard:
    """Switched on, at a free port."""
    card = show_page(qtbot, rig.assembly.window, "diagnosis", DiagnosisPage).why.sharing
    card.address.setText("127.0.0.1:0")
    rig.click(card.switch)
    assert card.switch.isChecked()
    return card


def reader(card: SharingCard) -> socket.socket:
    address = card.state.text().split(",")[0].removeprefix("shared://")
    client = socket.create_connection(("127.0.0.1", int(address.rpartition(":")[2])))
    client.setblocking(False)
    return client


def hear(rig: Rig, client: socket.socket, length: int) -> bytes:
    heard = bytearray()

    def is_there() -> bool:
        try:
            heard.extend(client.recv(4096))
        except BlockingIOError:
            return False
        return len(heard) >= length

    rig.until(is_there)
    return bytes(heard)


@pytest.mark.promise("h")
def test_a_reader_asks_and_changes_nothing(rig: Rig, card: SharingCard) -> None:
    with reader(card) as client:
        client.sendall(BOOT_COUNT.query().encode())
        assert hear(rig, client, 6)[:3] == bytes.fromhex("41 75 23")
        assert "readers: 1" in card.state.text()
        for change in (ACTIVATION.set(True), BY_NAME["freefall_time"].set(1.2)):
            client.sendall(change.encode() + STATUS.query().encode())
            hear(rig, client, 8)
            assert f"{change.encode().hex(' ').upper()}: Shared, read-only" in card.last.text()
        assert rig.acts == []
    rig.until(lambda: "readers: 0" in card.state.text())


def test_a_readers_lock_is_that_of_the_window(rig: Rig, card: SharingCard) -> None:
    rig.bench.module.activate(is_active=True)
    rig.until(lambda: rig.assembly.ports.current.is_active)
    with reader(card) as client:
        client.sendall(LOCK.encode())
        assert hear(rig, client, 6) == bytes.fromhex("41 75 10 01 00 11")
        assert not rig.bench.module.state.is_active
        assert "The module reports LOCKED." in card.last.text()
        assert set(rig.acts) == {LOCK}
        # A second one is sent as the first was.
        client.sendall(LOCK.encode())
        hear(rig, client, 6)


def test_it_ends_with_the_switch_and_with_the_port(rig: Rig, card: SharingCard) -> None:
    with reader(card) as client:
        rig.until(lambda: "readers: 1" in card.state.text())
        rig.click(card.switch)
        assert hear(rig, client, 0) == b""
    rig.click(card.switch)
    with reader(card) as client:
        rig.until(lambda: "readers: 1" in card.state.text())
        rig.assembly.ports.current.disconnect_port()
        rig.until(lambda: not card.switch.isChecked())
        assert hear(rig, client, 0) == b""
        assert not card.switch.isEnabled()


@pytest.mark.parametrize(
    ("address", "is_on", "said"),
    [("nowhere", False, "HOST:PORT"), ("192.0.2.1:7001", False, "192.0.2.1"), ("0.0.0.0:0", True, "no authentication")],
)
def test_an_address_is_judged(rig: Rig, card: SharingCard, address: str, is_on: bool, said: str) -> None:
    rig.click(card.switch)
    card.address.setText(address)
    rig.click(card.switch)
    assert card.switch.isChecked() is is_on
    assert said in card.last.text()
