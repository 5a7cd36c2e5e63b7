"""The rules of coming back, and the same over real pseudo-terminals with the worker."""

import json
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest
from app.engine.identity import UNKNOWN, Expected, Identity, IdentityEvidence, Trust

from app.engine.ports import PortInfo, list_ports, scan
from app.engine.reconnect import EAGER_S, LOSSES, Absence, Address, PortStage, Reconnection, address_of
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Connection, PortState
from app.text.user_error import UserError

MINE = PortInfo("/dev/ttyUSB0", "CP2102", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1:1.0")
OTHER = MINE._replace(device="/dev/ttyUSB1", serial_number="0002", location="1-2:1.0")
BRIDGE = Address("socket://bridge:4000")
FOUND = IdentityEvidence(37, {"attitude_threshold_deg": 60})
NAMELESS = PortInfo("/dev/ttyUSB0", "CH340", "", "", 0x1A86, 0x7523, "1-1:1.0")


def opened(device: str = MINE.device) -> Connection:
    return Connection(PortState.OPEN, device, 115200)


def closed(trouble: PortTrouble | None = PortTrouble.LOST, device: str = MINE.device) -> Connection:
    error = None if trouble is None else PortError(trouble, device, "")
    return Connection(PortState.CLOSED, device, 115200, error)


def lost(port: PortInfo = MINE, *, is_link: bool = False, now: float = 100.0) -> Reconnection:
    """A connection to `port` that has just gone."""
    made = Reconnection(is_link=lambda _device: is_link)
    made.request(address_of(port.device, [port]))
    made.feed(opened(port.device), now - 1)
    made.feed(closed(device=port.device), now)
    return made


def staged(stage: PortStage) -> Reconnection:
    """A connection to `MINE` at this stage, at 100 s."""
    made = Reconnection(is_link=lambda _device: False)
    made.request(address_of(MINE.device, [MINE]))
    if stage is not PortStage.IDLE:
        made.feed(opened(), 100.0)
    if stage is PortStage.MISTAKEN:
        made.poll([OTHER._replace(device=MINE.device)], 100.0)
    elif stage in (PortStage.KNOWN, PortStage.LOST):
        made.poll([MINE], 100.0)
    if stage is PortStage.LOST:
        made.feed(closed(), 100.0)
    return made


SLOWER = Connection(PortState.OPEN, MINE.device, 9600)
NEVER_OPEN = [trouble for trouble in PortTrouble if trouble not in LOSSES]
NOT_YET = [PortTrouble.NOT_ALLOWED, PortTrouble.BUSY, PortTrouble.UNUSABLE]


@pytest.mark.parametrize(
    ("stage", "event", "follows", "absence"),
    [
        (PortStage.IDLE, SLOWER, PortStage.UNKNOWN, None),
        (PortStage.UNKNOWN, SLOWER, PortStage.UNKNOWN, None),
        (PortStage.KNOWN, SLOWER, PortStage.KNOWN, None),
        (PortStage.MISTAKEN, SLOWER, PortStage.MISTAKEN, Absence.ANOTHER),
        (PortStage.LOST, SLOWER, PortStage.UNKNOWN, None),
        (PortStage.IDLE, closed(None), PortStage.IDLE, None),
        (PortStage.UNKNOWN, closed(None), PortStage.IDLE, None),
        (PortStage.KNOWN, closed(None), PortStage.IDLE, None),
        (PortStage.MISTAKEN, closed(None), PortStage.LOST, Absence.ANOTHER),
        (PortStage.LOST, closed(None), PortStage.LOST, Absence.AWAY),
        *((stage, closed(loss), PortStage.LOST, Absence.AWAY) for stage in PortStage for loss in LOSSES),
        *((PortStage.IDLE, closed(trouble), PortStage.IDLE, None) for trouble in NEVER_OPEN),
        *((PortStage.LOST, closed(trouble), PortStage.LOST, Absence.FAILED) for trouble in NOT_YET),
        (PortStage.LOST, closed(PortTrouble.MISSING), PortStage.LOST, Absence.AWAY),
    ],
)
def test_what_follows_a_change_of_the_connection(
    stage: PortStage, event: Connection, follows: PortStage, absence: Absence | None
) -> None:
    made = staged(stage)
    for _ in range(2):  # what is told again is no news
        made.feed(event, 100.1)
        assert (made._stage, made.absence) == (follows, absence)
    assert made.is_mistaken is (follows is PortStage.MISTAKEN)
    assert made.is_waiting is (absence is not None)
    assert made.is_due(100.1 + EAGER_S) is (follows in (PortStage.LOST, PortStage.UNKNOWN))


@pytest.mark.parametrize("stage", PortStage)
@pytest.mark.parametrize("leave", [Reconnection.give_up, lambda made: made.request(Address("/dev/ttyUSB4"))])
def test_what_somebody_leaves_is_over(stage: PortStage, leave: Callable[[Reconnection], None]) -> None:
    made = staged(stage)
    leave(made)
    assert (made.is_mistaken, made.is_waiting, made.is_due(200.0)) == (False, False, False)
    assert made.poll([MINE], 200.0) is None
    if leave is Reconnection.give_up:
        made.feed(closed(), 201.0)
        assert not made.is_waiting


def test_the_same_adapter_is_found_under_another_name() -> None:
    made = lost()
    assert made.is_due(100.0)
    back = MINE._replace(device="/dev/ttyUSB3")
    assert made.poll([OTHER, back], 100.0) == Address("/dev/ttyUSB3", MINE.identity, MINE.location)


@pytest.mark.parametrize(
    ("address", "again", "is_same_adapter"),
    [
        (Address("/dev/pts/5"), (1, 8, 34821), True),
        (Address("/dev/pts/5"), (1, 9, 34822), False),
        (Address("/dev/pts/5"), None, False),
        (Address("/dev/ttyUSB0", "10c4:ea60:0001", "1-1"), (9, 9, 9), True),
        (BRIDGE, None, True),
    ],
    ids=["the same file", "another file behind the link", "nothing there", "an adapter on USB", "an address"],
)
@pytest.mark.promise("a")
def test_a_name_is_the_same_adapter_only_while_it_leads_to_the_same_file(
    address: Address, again: tuple[int, int, int] | None, is_same_adapter: bool
) -> None:
    nodes: dict[str, tuple[int, int, int] | None] = {address.device: (1, 8, 34821)}
    made = Reconnection(is_link=lambda _device: True, node=lambda device: nodes[device])
    made.request(address)
    made.feed(Connection(PortState.OPEN, address.device, 115200), 1.0)
    nodes[address.device] = again
    assert made.is_adapter_same is is_same_adapter


@pytest.mark.parametrize(
    ("lost", "address", "expected"),
    [
        (Identity(), BRIDGE, None),
        (Identity(), Address("/dev/ttyS9"), Expected(UNKNOWN, is_adapter_same=False, is_named=False)),
        (Identity(Trust.PROVEN, is_named=True), BRIDGE, Expected(UNKNOWN)),
        (Identity(now=FOUND), BRIDGE, Expected(FOUND, is_named=False)),
        (
            Identity(Trust.UNPROVEN, FOUND, IdentityEvidence(12), is_adapter_same=False, is_named=True),
            BRIDGE,
            Expected(FOUND, is_adapter_same=False),
        ),
    ],
    ids=["nothing was read", "another adapter", "only its name", "it was read", "it was in doubt itself"],
)
def test_after_a_loss_the_lost_module_is_expected_if_anything_is_known_of_it(
    lost: Identity, address: Address, expected: Expected | None
) -> None:
    made = Reconnection(node=lambda _device: None)
    made.request(address)
    assert made.expected(lost) == expected


def test_only_a_url_needs_no_list_of_ports() -> None:
    made = Reconnection()
    assert not made.needs_ports
    for device, needs_ports in ((MINE.device, True), ("/dev/ttyS0", True), ("socket://host:1", False)):
        made.request(address_of(device, [MINE]))
        assert made.needs_ports is needs_ports


def test_another_adapter_in_its_place_is_left_alone() -> None:
    made = lost()
    assert made.poll([OTHER._replace(device=MINE.device)], 100.0) is None
    assert made.absence is Absence.ANOTHER
    assert made.poll([], 101.0) is None
    assert made.absence is Absence.AWAY


def test_an_adapter_is_recognised_while_its_port_is_open() -> None:
    """A person typed the name, or the list was not there yet."""
    made = Reconnection(is_link=lambda _device: False)
    made.request(Address(MINE.device))
    assert not made.is_due(0.0)
    made.feed(opened(), 1.0)
    assert made.is_due(1.0)
    assert made.poll([OTHER, MINE], 1.0) is None
    assert not made.is_mistaken
    assert not made.is_due(2.0)
    made.feed(closed(), 3.0)
    assert made.absence is Absence.AWAY
    assert made.poll([MINE._replace(device="/dev/ttyUSB5")], 3.0) is not None


def test_a_port_that_is_requested_again_is_looked_at_again() -> None:
    made = Reconnection(is_link=lambda _device: False)
    for now in (1.0, 3.0):
        made.request(Address(MINE.device))
        assert not made.is_due(now)
        made.feed(opened(), now)
        assert made.is_due(now)
        made.poll([MINE], now)
        assert not made.is_due(now)


def test_another_adapter_that_has_the_name_by_the_time_of_opening_is_closed_again() -> None:
    """The list was older than the name, at the first opening as at any later one."""
    made = Reconnection(is_link=lambda _device: False)
    made.request(address_of(MINE.device, [MINE]))
    for now in (1.0, 11.0):
        made.feed(opened(), now)
        assert made.is_due(now)
        assert made.poll([OTHER._replace(device=MINE.device)], now) is None
        assert (made.is_mistaken, made.is_waiting, made.absence) == (True, True, Absence.ANOTHER)
        made.feed(closed(None), now + 0.1)
        assert not made.is_mistaken
        assert not made.is_due(now + EAGER_S / 2)
        assert made.poll([OTHER], now + 1) is None
        assert made.poll([MINE], now + 2) == Address(MINE.device, MINE.identity, MINE.location)
    assert made.returns == 0


def test_a_name_behind_which_nothing_is_listed_by_the_time_of_opening_is_closed_again() -> None:
    made = lost()
    found = made.poll([MINE], 101.0)
    assert found is not None
    made.feed(opened(), 101.1)
    assert made.poll([], 101.2) is None
    assert (made.is_mistaken, made.absence, made.returns) == (True, Absence.AWAY, 0)


def test_without_a_serial_number_the_socket_decides() -> None:
    made = lost(NAMELESS)
    assert made.poll([NAMELESS._replace(location="1-4:1.0")], 100.0) is None
    assert made.poll([NAMELESS._replace(device="/dev/ttyUSB5")], 101.0) is not None


def test_two_adapters_with_the_same_serial_number_are_told_apart_by_the_socket_or_not_at_all() -> None:
    twin = MINE._replace(device="/dev/ttyUSB1", location="1-2:1.0")
    made = lost()
    found = made.poll([twin, MINE._replace(device="/dev/ttyUSB2")], 100.0)
    assert found is not None
    assert found.device == "/dev/ttyUSB2"
    assert made.poll([twin, twin._replace(device="/dev/ttyUSB4", location="1-3:1.0")], 101.0) is None
    assert made.absence is Absence.SEVERAL


def test_the_twin_that_is_left_is_not_taken_for_the_one_that_went() -> None:
    twin = MINE._replace(device="/dev/ttyUSB1", location="1-2:1.0")
    made = Reconnection()
    made.request(address_of(MINE.device, [MINE, twin]))
    made.feed(opened(), 1.0)
    made.poll([MINE, twin], 1.0)
    made.feed(closed(), 2.0)
    assert made.poll([twin], 2.0) is None
    assert made.absence is Absence.SEVERAL
    found = made.poll([twin, MINE._replace(device="/dev/ttyUSB4")], 3.0)
    assert found is not None
    assert found.device == "/dev/ttyUSB4"


def test_alone_with_its_serial_number_it_may_come_back_in_another_socket() -> None:
    made = lost()
    assert made.poll([MINE._replace(location="1-9:1.0")], 100.0) is not None


def test_a_bare_name_is_never_opened_again() -> None:
    made = Reconnection(is_link=lambda _device: False)
    made.request(Address("/dev/ttyS0"))
    made.feed(opened("/dev/ttyS0"), 1.0)
    made.feed(closed(device="/dev/ttyS0"), 2.0)
    assert made.absence is Absence.NAME_ONLY
    assert not made.is_due(10.0)
    assert made.poll([PortInfo("/dev/ttyS0")], 10.0) is None


@pytest.mark.parametrize("device", ["socket://10.0.0.2:4000", "sim://bench", "/home/me/module"])
def test_a_url_and_a_link_are_addresses_of_their_own(device: str) -> None:
    made = Reconnection(is_link=lambda device: device == "/home/me/module")
    made.request(Address(device))
    made.feed(opened(device), 1.0)
    made.feed(closed(device=device), 2.0)
    assert made.poll([], 2.0) == Address(device)
    assert made.absence is (Absence.NO_ANSWER if device.startswith("socket:") else Absence.AWAY)
    made.feed(opened(device), 3.0)
    if "://" in device:
        assert made.returns == 1, "nothing is listed that could tell more"
    else:
        made.poll([], 3.1)
    assert (made.returns, made.is_mistaken, made.is_due(3.2)) == (1, False, False)


def test_a_link_behind_which_an_adapter_has_come_is_left_alone(tmp_path: Path) -> None:
    link = tmp_path / "module"
    link.symlink_to("/dev/pts/999")
    made = Reconnection()
    made.request(Address(str(link)))
    made.feed(opened(str(link)), 1.0)
    made.feed(closed(device=str(link)), 2.0)
    link.unlink()
    link.symlink_to(MINE.device)
    assert made.poll([MINE], 2.0) is None
    assert made.absence is Absence.ANOTHER


def test_open_again_is_counted_and_the_next_loss_is_a_new_one() -> None:
    made = lost()
    found = made.poll([MINE._replace(device="/dev/ttyUSB9")], 100.0)
    assert found is not None
    made.feed(opened("/dev/ttyUSB9"), 100.5)
    assert (made.returns, made.is_waiting) == (0, False)  # it is not known yet what was opened
    made.poll([MINE._replace(device="/dev/ttyUSB9")], 100.6)
    assert (made.returns, made.is_mistaken) == (1, False)
    made.feed(closed(device="/dev/ttyUSB9"), 200.0)
    assert made.is_waiting
    assert made.address == Address("/dev/ttyUSB9", MINE.identity, MINE.location)


@pytest.mark.parametrize(("now", "next_at"), [(100.0, 100.5), (129.9, 130.4), (130.0, 131.0)])
def test_it_looks_twice_a_second_for_half_a_minute_and_then_once(now: float, next_at: float) -> None:
    made = lost(now=100.0)
    assert made.poll([], now) is None
    assert not made.is_due(next_at - 0.01)
    assert made.is_due(next_at)


class _Listed(NamedTuple):
    """A port as pyserial describes it."""

    device: str
    product: str | None = None
    description: str | None = "n/a"
    manufacturer: str | None = None
    serial_number: str | None = None
    vid: int | None = None
    pid: int | None = None
    location: str | None = None


def test_what_the_system_does_not_tell_of_a_port_is_empty_and_usb_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = _Listed("/dev/ttyS0")
    usb = _Listed("/dev/ttyUSB0", None, "CP2102", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1:1.0")
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [bare, usb])
    assert scan() == [MINE._replace(description="CP2102"), PortInfo("/dev/ttyS0")]


@pytest.mark.parametrize(
    ("program", "is_frozen", "command"),
    [("/usr/bin/python3", False, ["/usr/bin/python3", "-m", "app"]), ("/opt/dps-s-gui.exe", True, ["/opt/dps-s.exe"])],
)
def test_the_process_that_lists_the_ports_has_a_deadline(
    program: str, is_frozen: bool, command: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, object] = {}

    def run(words: list[str], **options: object) -> object:
        given.update(options, words=words)
        return SimpleNamespace(stdout=json.dumps({"ports": [MINE._asdict()]}).encode())

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys, "executable", program)
    monkeypatch.setattr(sys, "frozen", is_frozen, raising=False)
    monkeypatch.setattr("subprocess.run", run)
    assert list_ports() == [MINE]
    assert given["words"] == [*command, "ports", "--json", "--list-here"]
    assert (given["timeout"], given["check"], given["capture_output"]) == (3.0, True, True)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere a process lists them")
def test_the_thread_that_lists_the_ports_holds_nobody_up_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[threading.Thread] = []

    def comports() -> list[object]:
        threads.append(threading.current_thread())
        return [_Listed("/dev/ttyS0")]

    monkeypatch.setattr("serial.tools.list_ports.comports", comports)
    assert list_ports() == [PortInfo("/dev/ttyS0")]
    assert [(thread.name, thread.daemon) for thread in threads] == [("dps-s ports", True)]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: 1 / 0)
    with pytest.raises(UserError):
        list_ports()
    is_over = threading.Event()
    monkeypatch.setattr("serial.tools.list_ports.comports", is_over.wait)
    with pytest.raises(UserError):  # rather than an empty list
        list_ports(0.01)
    is_over.set()
