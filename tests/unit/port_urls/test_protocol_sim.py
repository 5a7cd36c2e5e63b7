"""sim:// through pyserial, in real time."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
import serial

from app.simulator import bench as benches
from protocol.catalogue import STATUS
from tests.support.patience import PATIENCE_S

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


def port(url: str = URL, *, timeout_s: float | None = 0.5, baud_rate: int = 115200) -> serial.Serial:
    opened: serial.Serial = serial.serial_for_url(url, baudrate=baud_rate, timeout=timeout_s)
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


ENDS: dict[str, Callable[[serial.Serial], object]] = {
    "bytes come": lambda opened: opened.write(ASK),
    "it is cancelled": lambda opened: opened.cancel_read(),
    "it is unplugged": lambda _opened: benches.module("test").unplug(),
    "it is closed": lambda opened: opened.close(),
}


@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)
def test_a_read_without_a_time_out_ends_when(end: Callable[[serial.Serial], object]) -> None:
    opened = port(timeout_s=None)

    def read() -> None:
        with suppress(serial.SerialException):
            opened.read(8)

    thread = threading.Thread(target=read)
    thread.start()
    bench = benches.module("test")
    deadline = time.monotonic() + PATIENCE_S
    # Private, but the only way to know that the reader waits.
    while not bench.changed._waiters and time.monotonic() < deadline:  # type: ignore[attr-defined]
        time.sleep(0.001)
    end(opened)
    thread.join(PATIENCE_S)
    assert not thread.is_alive()
    opened.close()
