"""sim:// through pyserial, in real time."""

from collections.abc import Iterator

import pytest
import serial

from app.simulator import bench as benches
from protocol.catalogue import STATUS

ASK = STATUS.query().encode()
ANSWER = bytes.fromhex("41 75 32 00 0a 00 00 3c")
URL = "sim://test"


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    if "app.port_urls" not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.insert(0, "app.port_urls")
    benches.remove_bench("test")
    yield
    benches.remove_bench("test")


def port() -> serial.Serial:
    opened: serial.Serial = serial.serial_for_url(URL, baudrate=115200, timeout=0.5)
    return opened


def test_unplugged_it_fails_as_an_adapter_does_and_the_old_port_stays_dead() -> None:
    opened = port()
    bench = benches.module("test")
    bench.unplug()
    for act in (lambda: opened.read(1), lambda: opened.write(ASK), lambda: opened.in_waiting, port):
        with pytest.raises(serial.SerialException):
            act()
    bench.plug()
    with pytest.raises(serial.SerialException):
        opened.read(1)
    opened.close()
    with port() as again:
        again.write(ASK)
        assert again.read(8) == ANSWER
