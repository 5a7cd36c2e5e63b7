"""When and where a lost port is opened again."""

import pytest

from app.engine.ports import PortInfo, port_named
from app.engine.reconnect import Absence, Reconnection
from app.engine.target import Target
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Connection, PortState

MINE = PortInfo("/dev/ttyUSB0", "CP2102", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1:1.0")
OTHER = MINE._replace(device="/dev/ttyUSB1", serial_number="0002", location="1-2:1.0")
NAMELESS = PortInfo("/dev/ttyUSB0", "CH340", "", "", 0x1A86, 0x7523, "1-1:1.0")


def opened(device: str = MINE.device) -> Connection:
    return Connection(PortState.OPEN, device, 115200)


def closed(trouble: PortErrorKind | None = PortErrorKind.LOST, device: str = MINE.device) -> Connection:
    error = None if trouble is None else PortError(trouble, device, "")
    return Connection(PortState.CLOSED, device, 115200, error)


def connected(*ports: PortInfo, device: str = "") -> Reconnection:
    """To the first of the ports, all of which are listed while it is open."""
    made = Reconnection()
    name = device or ports[0].device
    chosen = port_named(name, ports)
    made.request(Target(name, 115200, "" if chosen is None else chosen.identity))
    made.feed(opened(name), 99.0)
    if made.is_due(99.0):
        made.poll(ports, 99.0)
    return made


def lost(*ports: PortInfo, device: str = "") -> Reconnection:
    """At 100 s the first of the ports was lost."""
    made = connected(*ports, device=device)
    made.feed(closed(device=device or ports[0].device), 100.0)
    return made


def test_the_same_adapter_is_opened_again_under_any_name() -> None:
    made = lost(MINE)
    assert (made.absence, made.is_waiting, made.is_due(100.0)) == (Absence.AWAY, True, True)
    assert made.poll([OTHER], 100.0) is None
    assert made.poll([OTHER, MINE._replace(device="/dev/ttyUSB4")], 101.0) == "/dev/ttyUSB4"
    made.feed(opened("/dev/ttyUSB4"), 101.5)
    assert made.absence is None


def test_without_a_serial_number_only_in_the_same_socket() -> None:
    made = lost(NAMELESS)
    assert made.poll([NAMELESS._replace(location="1-9:1.0")], 100.0) is None
    assert made.poll([NAMELESS], 101.0) is not None


@pytest.mark.promise("f")
def test_another_adapter_in_its_place_is_left_alone() -> None:
    made = lost(MINE)
    assert made.poll([OTHER._replace(device=MINE.device)], 100.0) is None
    assert made.is_waiting


@pytest.mark.promise("f")
@pytest.mark.parametrize("is_seen_before", [False, True])
def test_one_that_has_or_had_a_twin_is_left_to_a_person(is_seen_before: bool) -> None:
    twin = MINE._replace(device="/dev/ttyUSB1", location="1-2:1.0")
    made = lost(MINE, twin) if is_seen_before else lost(MINE)
    assert made.poll([twin] if is_seen_before else [twin, MINE], 100.0) is None
    assert (made.absence, made.is_waiting) == (Absence.UNCLEAR, False)
    assert made.poll([MINE], 101.0) is None


@pytest.mark.promise("f")
def test_a_bare_name_is_never_opened_again() -> None:
    made = lost(PortInfo("/dev/ttyS0"))
    assert (made.absence, made.is_waiting) == (Absence.UNCLEAR, False)
    assert not made.is_due(110.0)
    assert made.poll([PortInfo("/dev/ttyS0")], 110.0) is None


def test_an_adapter_that_was_typed_is_learnt_while_it_is_open() -> None:
    made = Reconnection()
    made.request(Target(MINE.device, 115200))
    made.feed(opened(), 99.0)
    assert made.is_due(99.0)
    made.poll([MINE], 99.0)
    assert not made.is_due(99.0)
    made.feed(closed(), 100.0)
    assert made.poll([MINE._replace(device="/dev/ttyUSB7")], 100.0) is not None


@pytest.mark.parametrize("trouble", [PortErrorKind.MISSING, PortErrorKind.BUSY, None])
def test_what_was_never_open_or_was_closed_on_purpose_is_not_opened(trouble: PortErrorKind | None) -> None:
    made = connected(MINE)
    made.feed(closed(trouble), 100.0)
    assert (made.absence, made.is_waiting) == (None, False)
    assert made.poll([MINE], 100.0) is None
