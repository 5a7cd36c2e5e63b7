"""The opened port: what opening reports, who has it open, and how a read waits."""

import errno
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, nullcontext
from pathlib import Path

import pytest
import serial

from app.engine import transport
from app.engine.transport import PortError, PortHolder, PortTrouble, SerialLine, holder_of, open_line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes cannot be selected on Windows")
HOLDER = PortHolder("other", 42)


class FakeSerial:
    """As much of `serial.Serial` as `open_line` uses."""

    def __init__(self, failure: Exception | None = None) -> None:
        self.failure = failure
        self.opened_with: dict[str, object] = {}

    def open(self) -> None:
        self.opened_with = {name: getattr(self, name, None) for name in ("exclusive", "dtr", "rts")}
        if self.failure is not None:
            raise self.failure

    def reset_input_buffer(self) -> None:
        """There is none."""

    def close(self) -> None:
        """Nothing is open."""


@pytest.mark.parametrize(
    ("error", "trouble"),
    [
        (OSError(errno.ENOENT, ""), PortTrouble.MISSING),
        (serial.SerialException("FileNotFoundError(2)"), PortTrouble.MISSING),
        (serial.SerialException("[Errno 111] Connection refused"), PortTrouble.MISSING),
        (OSError(errno.EBUSY, ""), PortTrouble.BUSY),
        (serial.SerialException("Could not exclusively lock port"), PortTrouble.BUSY),
        (OSError(errno.EACCES, ""), PortTrouble.NOT_ALLOWED),
        (ValueError("Not a valid baudrate"), PortTrouble.UNUSABLE),
    ],
)
def test_a_port_that_does_not_open_says_why_and_who_has_it_if_it_is_busy(
    error: Exception, trouble: PortTrouble, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: FakeSerial(error))
    monkeypatch.setattr(transport, "holder_of", lambda _port: HOLDER)
    with pytest.raises(PortError) as failed:
        open_line("/dev/ttyS9", 115200)
    assert failed.value.trouble is trouble
    assert failed.value.holder == (HOLDER if trouble is PortTrouble.BUSY else None)


@pytest.mark.parametrize(("port", "is_exclusive"), [("/dev/ttyS9", True), ("socket://127.0.0.1:9", None)])
def test_a_port_is_opened_for_this_program_only_and_with_its_control_lines_low(
    port: str, is_exclusive: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, object] = {}
    fake = FakeSerial()

    def made(_port: str, **options: object) -> FakeSerial:
        given.update(options)
        return fake

    monkeypatch.setattr(serial, "serial_for_url", made)
    open_line(port, 9600).close()
    assert given == {"do_not_open": True, "baudrate": 9600, "timeout": 0.01, "write_timeout": 0.3}
    assert fake.opened_with == {"exclusive": is_exclusive, "dtr": False, "rts": False}


@pytest.fixture(params=["pty", "socket"])
def opened(request: pytest.FixtureRequest) -> Iterator[tuple[SerialLine, int]]:
    """A real port, and the number of its other end."""
    with ExitStack() as ends:
        if request.param == "pty":
            far, near = os.openpty()
            for end in (far, near):
                ends.callback(os.close, end)
            address = os.ttyname(near)
        else:
            server = ends.enter_context(socket.create_server(("127.0.0.1", 0)))
            address = f"socket://127.0.0.1:{server.getsockname()[1]}"
        line = open_line(address, 115200)
        if request.param == "socket":
            far = ends.enter_context(server.accept()[0]).fileno()
        ends.callback(line.close)
        yield line, far


def test_what_the_driver_took_is_written_however_long_this_thread_was_kept_waiting(
    opened: tuple[SerialLine, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The port was taken for stuck on a busy computer."""
    line, far = opened
    monkeypatch.setattr("serial.serialutil.Timeout.expired", lambda _timeout: True)
    line.write(b"Ba 123")
    assert os.read(far, 100) == b"Ba 123"


def test_only_a_stuck_port_is_emptied_before_closing(
    opened: tuple[SerialLine, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the system would wait half a minute for the bytes to be sent."""
    line, _far = opened
    emptied: list[bool] = []
    monkeypatch.setattr(line._serial, "reset_output_buffer", lambda: emptied.append(True))
    with pytest.raises(PortError, match=PortTrouble.STUCK.value):
        line.write(bytes(16_000_000))
    line.close()
    assert emptied == [True]
    line.interrupt()  # has no effect: its pipe's number may be another file's


class Uninterrupted:
    """A port whose waiting read cannot be ended, as on Windows."""

    def __init__(self, arriving: bytes = b"AuAuAu", trouble: str = "") -> None:
        self.timeout, self.trouble = 0.01, trouble
        self.left = arriving
        self.reads: list[tuple[int, float]] = []

    @property
    def in_waiting(self) -> int:
        return len(self.left)

    def read(self, size: int) -> bytes:
        self.reads.append((size, self.timeout))
        if self.trouble:
            trouble, self.trouble = self.trouble, ""
            raise serial.SerialException(trouble)
        taken, self.left = self.left[:size], self.left[size:]
        return taken


@pytest.mark.parametrize(
    ("trouble", "arriving", "heard"),
    [
        ("GetOverlappedResult failed (OSError(9, 'x', None, 1460))", b"Au", b"Au"),
        ("GetOverlappedResult failed (BrokenPipeError(9, 'x', None, 109))", b"", b""),
        ("ClearCommError failed", b"Au", None),
    ],
)
def test_a_read_of_nothing_is_no_lost_port(trouble: str, arriving: bytes, heard: bytes | None) -> None:
    line = SerialLine("COM3", Uninterrupted(arriving, trouble))  # type: ignore[arg-type]
    with pytest.raises(PortError, match=PortTrouble.LOST.value) if heard is None else nullcontext():
        assert line.read(0.05, 0.0) == heard


LINUX_ONLY = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc is Linux's")


@LINUX_ONLY
def test_the_only_other_program_that_has_it_open_is_named(tmp_path: Path) -> None:
    device, namesake, folder = tmp_path / "ttyUSB0", tmp_path / "elsewhere", tmp_path / "proc"
    device.touch()
    namesake.touch()  # another device, which has this name in another namespace

    def runs(number: int, name: str, opened: Path) -> None:
        (folder / str(number) / "fd").mkdir(parents=True)
        (folder / str(number) / "comm").write_text(f"{name}\n", encoding="utf-8")
        (folder / str(number) / "fd" / "3").symlink_to(opened)

    runs(os.getpid(), "dps-s", device)
    runs(77, "other", namesake)
    assert holder_of(str(device), folder) is None
    runs(42, "minicom", device)
    assert holder_of(str(device), folder) == PortHolder("minicom", 42)
    runs(43, "screen", device)
    assert holder_of(str(device), folder) is None, "it is not certain which one"
