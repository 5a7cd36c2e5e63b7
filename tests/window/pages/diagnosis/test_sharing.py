"""The switch in Diagnosis that shares the window's port with readers."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from protocol.catalogue import ACTIVATION, BOOT_COUNT, BY_NAME, LOCK, STATUS
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import show_page
from tests.window.pages.diagnosis.test_diagnosis_page import ALONE
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.panels import SharingCard


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
