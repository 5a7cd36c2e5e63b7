"""The opened port: what opening reports, and how a read waits."""

import errno
import os
import select
import sys
from collections.abc import Iterator
from typing import Any

import pytest
import serial

from app.engine import transport
from app.engine.transport import PortError, PortHolder, PortTrouble, SerialLine, open_line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes cannot be selected on Windows")
HOLDER = PortHolder("other", 42)


class FakeSerial:
    """As much of `serial.Serial` as `SerialLine` uses, on two pipes."""

    def __init__(self, **failures: Exception) -> None:
        self.failures = failures
        self.is_closed = False
        self.data, self.far_end = os.pipe()
        self.pipe_abort_read_r, self._abort = os.pipe()

    def open(self) -> None:
        self._fail("open")

    def reset_input_buffer(self) -> None:
        self._fail("reset_input_buffer")

    def _fail(self, name: str) -> None:
        if name in self.failures:
            raise self.failures[name]

    def fileno(self) -> int:
        return self.data

    def cancel_read(self) -> None:
        os.write(self._abort, b"x")

    def close(self) -> None:
        self.is_closed = True

    def release(self) -> None:
        for one in (self.data, self.far_end, self.pipe_abort_read_r, self._abort):
            os.close(one)


@pytest.fixture
def fake() -> Iterator[FakeSerial]:
    made = FakeSerial()
    yield made
    made.release()


@pytest.mark.parametrize(("number", "holder"), [(errno.EBUSY, HOLDER), (errno.EACCES, None)])
def test_only_of_a_busy_port_it_is_looked_up_who_has_it(
    number: int, holder: PortHolder | None, fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake.failures["open"] = serial.SerialException(number, os.strerror(number))
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: fake)
    monkeypatch.setattr(transport, "holder_of", lambda _port: HOLDER)
    with pytest.raises(PortError) as failed:
        open_line("/dev/ttyS9", 115200)
    assert failed.value.holder == holder


def test_a_port_that_fails_right_after_the_opening_is_lost_and_closed(
    fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake.failures["reset_input_buffer"] = OSError(errno.EIO, "gone")
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: fake)
    with pytest.raises(PortError) as failed:
        open_line("/dev/ttyS9", 115200)
    assert failed.value.trouble is PortTrouble.LOST
    assert fake.is_closed


def test_an_interrupt_ends_one_read_only(fake: FakeSerial) -> None:
    line = SerialLine("/dev/ttyS9", fake)  # type: ignore[arg-type]
    line.interrupt()
    assert line.read(60.0, 0.0) == b""
    assert select.select([fake.pipe_abort_read_r], [], [], 0.0)[0] == []


@pytest.mark.parametrize("gather_s", [0.0, 0.008])
def test_a_read_gathers_for_as_long_as_it_is_told(
    gather_s: float, fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, waits = select.select, []

    def without_waiting(readable: Any, writable: Any, special: Any, longest_s: float) -> Any:
        waits.append(longest_s)
        return real(readable, writable, special, 0.0)

    monkeypatch.setattr(select, "select", without_waiting)
    os.write(fake.far_end, b"Au")
    assert SerialLine("/dev/ttyS9", fake).read(0.05, gather_s) == b"Au"  # type: ignore[arg-type]
    assert waits == [0.05] + [gather_s] * (gather_s > 0)
