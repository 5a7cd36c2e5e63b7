"""The opened port: what opening reports, who has it open, and how a read waits."""

import errno
import os
import select
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, nullcontext
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple

import pytest
import serial

from app.engine import transport
from app.engine.transport import PortError, PortHolder, PortTrouble, SerialLine, holder_of, open_line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes cannot be selected on Windows")
HOLDER = PortHolder("other", 42)


class FakeSerial:
    """As much of `serial.Serial` as `SerialLine` uses, on two pipes."""

    def __init__(self, **failures: Exception) -> None:
        self.failures = failures
        self.is_closed = False
        self.called: list[str] = []
        self.opened_with: dict[str, object] = {}
        self.data, self.far_end = os.pipe()
        self.pipe_abort_read_r, self._abort = os.pipe()

    def open(self) -> None:
        self.opened_with = {name: getattr(self, name, None) for name in ("exclusive", "dtr", "rts")}
        self._fail("open")

    def reset_input_buffer(self) -> None:
        self._fail("reset_input_buffer")

    def reset_output_buffer(self) -> None:
        self._fail("reset_output_buffer")

    def _fail(self, name: str) -> None:
        self.called.append(name)
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


@pytest.mark.parametrize(
    ("error", "trouble"),
    [
        (OSError(errno.ENOENT, ""), PortTrouble.MISSING),
        (OSError(errno.ENXIO, ""), PortTrouble.MISSING),
        (OSError(errno.ENODEV, ""), PortTrouble.MISSING),
        (OSError(errno.ECONNREFUSED, ""), PortTrouble.MISSING),
        (serial.SerialException("FileNotFoundError(2)"), PortTrouble.MISSING),
        (serial.SerialException("No such device"), PortTrouble.MISSING),
        (serial.SerialException("ConnectionRefusedError(111)"), PortTrouble.MISSING),
        (serial.SerialException("[Errno 111] Connection refused"), PortTrouble.MISSING),
        (OSError(errno.EBUSY, ""), PortTrouble.BUSY),
        (OSError(errno.EAGAIN, ""), PortTrouble.BUSY),
        (serial.SerialException("Could not exclusively lock port"), PortTrouble.BUSY),
        (OSError(errno.EACCES, ""), PortTrouble.NOT_ALLOWED),
        (OSError(errno.EPERM, ""), PortTrouble.NOT_ALLOWED),
        (OSError(errno.ENOTTY, ""), PortTrouble.UNUSABLE),
        (ValueError("Not a valid baudrate"), PortTrouble.UNUSABLE),
    ],
)
def test_a_port_that_does_not_open_says_why_and_who_has_it_if_it_is_busy(
    error: Exception, trouble: PortTrouble, fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake.failures["open"] = error
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: fake)
    monkeypatch.setattr(transport, "holder_of", lambda _port: HOLDER)
    with pytest.raises(PortError) as failed:
        open_line("/dev/ttyS9", 115200)
    assert failed.value.trouble is trouble
    assert failed.value.holder == (HOLDER if trouble is PortTrouble.BUSY else None)


@pytest.mark.parametrize(
    ("text", "trouble"), [("PermissionError(13)", PortTrouble.BUSY), ("OSError(22)", PortTrouble.UNUSABLE)]
)
def test_on_windows_a_port_without_permission_is_open_elsewhere(
    text: str, trouble: PortTrouble, fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake.failures["open"] = serial.SerialException(f"could not open port 'COM3': {text}")
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: fake)
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(PortError) as failed:
        open_line("COM3", 115200)
    assert (failed.value.trouble, failed.value.holder) == (trouble, None)


@pytest.mark.parametrize(("port", "is_exclusive"), [("/dev/ttyS9", True), ("socket://127.0.0.1:9", None)])
def test_a_port_is_opened_for_this_program_only_and_with_its_control_lines_low(
    port: str, is_exclusive: bool | None, fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, object] = {}

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


def test_a_port_that_takes_nothing_is_stuck(opened: tuple[SerialLine, int]) -> None:
    line, _far = opened
    with pytest.raises(PortError, match=PortTrouble.STUCK.value):
        line.write(bytes(16_000_000))


@pytest.mark.parametrize("failing", ["reset_input_buffer", None])
def test_another_rate_begins_with_nothing_heard_before(failing: str | None, fake: FakeSerial) -> None:
    line = SerialLine("/dev/ttyS9", fake)  # type: ignore[arg-type]
    if failing is not None:
        fake.failures[failing] = OSError(errno.EIO, "gone")
    with nullcontext() if failing is None else pytest.raises(PortError, match=PortTrouble.LOST.value):
        line.use_rate(9600)
    assert (line.baud_rate, fake.called) == (9600, ["reset_input_buffer"])


def test_only_a_stuck_port_is_emptied_before_closing(
    opened: tuple[SerialLine, int], fake: FakeSerial, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the system would wait half a minute for the bytes to be sent."""
    line, _far = opened
    emptied: list[bool] = []
    monkeypatch.setattr(line._serial, "reset_output_buffer", lambda: emptied.append(True))
    with pytest.raises(PortError, match=PortTrouble.STUCK.value):
        line.write(bytes(16_000_000))
    line.close()
    assert emptied == [True]
    other = SerialLine("/dev/ttyS9", fake)  # type: ignore[arg-type]
    other.close()
    assert fake.called == []
    assert fake.is_closed
    other.interrupt()
    assert not select.select([fake.pipe_abort_read_r], [], [], 0.0)[0], "its number may be another file's"


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


@pytest.mark.parametrize(("port", "rest"), [("socket://127.0.0.1:9", (65536, 0)), ("COM3", (5, 0.01))])
def test_where_a_read_cannot_be_interrupted_the_rest_is_read_without_waiting(
    port: str, rest: tuple[int, float]
) -> None:
    opened = Uninterrupted()
    assert SerialLine(port, opened).read(0.05, 0.0) == b"AuAuAu"  # type: ignore[arg-type]
    assert opened.reads == [(1, 0.01), rest]
    assert opened.timeout == 0.01


@pytest.mark.parametrize(
    ("longest_s", "waiting", "reads"), [(0.0, b"", 0), (0.05, b"", 1), (0.0, b"A", 1), (0.0, b"Au", 2)]
)
def test_a_read_without_time_takes_only_what_waits(longest_s: float, waiting: bytes, reads: int) -> None:
    opened = Uninterrupted(waiting)
    assert SerialLine("COM3", opened).read(longest_s, 0.0) == waiting  # type: ignore[arg-type]
    assert len(opened.reads) == reads


def test_a_read_that_cannot_be_interrupted_gathers_until_it_is_woken(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float | None] = []
    monkeypatch.setattr(Event, "wait", lambda _event, timeout=None: waits.append(timeout))
    for gather_s in (0.0, 0.008):
        line = SerialLine("COM3", Uninterrupted())  # type: ignore[arg-type]
        line.interrupt()
        assert line.read(0.05, gather_s) == b"AuAuAu"
        assert line._wake_up.is_set() is (gather_s == 0.0)
    assert waits == [0.008]


@pytest.mark.parametrize(
    ("trouble", "arriving", "heard"),
    [
        ("GetOverlappedResult failed (OSError(9, 'x', None, 1460))", b"Au", b"Au"),
        ("GetOverlappedResult failed (OSError(9, 'x', None, 1460))", b"", b""),
        ("GetOverlappedResult failed (BrokenPipeError(9, 'x', None, 109))", b"", b""),
        ("ClearCommError failed", b"Au", None),
    ],
)
def test_a_read_of_nothing_is_no_lost_port(trouble: str, arriving: bytes, heard: bytes | None) -> None:
    line = SerialLine("COM3", Uninterrupted(arriving, trouble))  # type: ignore[arg-type]
    with pytest.raises(PortError, match=PortTrouble.LOST.value) if heard is None else nullcontext():
        assert line.read(0.05, 0.0) == heard


LINUX_ONLY = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc is Linux's")


class Proc(NamedTuple):
    """A made-up /proc, and a port."""

    device: Path
    folder: Path

    @property
    def namesake(self) -> Path:
        """Another device, which has this name in another namespace."""
        return self.folder.with_name("elsewhere") / self.device.name

    def runs(self, number: int, name: str, opened: Path | None = None) -> None:
        (self.folder / str(number) / "fd").mkdir(parents=True)
        (self.folder / str(number) / "comm").write_text(f"{name}\n", encoding="utf-8")
        (self.folder / str(number) / "fd" / "3").symlink_to(opened or self.device)

    def holder(self) -> PortHolder | None:
        return holder_of(str(self.device), self.folder)


@pytest.fixture
def proc(tmp_path: Path) -> Proc:
    made = Proc(tmp_path / "ttyUSB0", tmp_path / "proc")
    made.device.touch()
    made.folder.mkdir()
    made.namesake.parent.mkdir()
    made.namesake.touch()
    made.runs(os.getpid(), "dps-s")
    made.runs(77, "other", made.namesake)
    return made


@LINUX_ONLY
def test_the_only_other_program_that_has_it_open_is_named(proc: Proc) -> None:
    assert proc.holder() is None
    proc.runs(42, "minicom")
    assert proc.holder() == PortHolder("minicom", 42)
    proc.runs(43, "screen")
    assert proc.holder() is None, "it is not certain which one"


@LINUX_ONLY
def test_a_process_that_ended_meanwhile_holds_nothing(proc: Proc) -> None:
    proc.runs(42, "minicom")
    (proc.folder / "42" / "comm").unlink()
    assert proc.holder() is None


@LINUX_ONLY
def test_an_unplugged_port_and_another_system_name_nobody(proc: Proc, monkeypatch: pytest.MonkeyPatch) -> None:
    proc.runs(42, "minicom")
    monkeypatch.setattr(sys, "platform", "darwin")
    assert proc.holder() is None
    monkeypatch.undo()
    proc.device.unlink()
    assert proc.holder() is None
