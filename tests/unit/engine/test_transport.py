"""A port: what opening reports, who else may have it, the settings of the line, and errors, which become our own."""

import errno
import fcntl
import os
import struct
import sys
import termios
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import serial

from app.engine import transport
from app.engine.transport import PortError, PortErrorKind, SerialLine, open_line
from tests.module.line import Line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")


class FakeSerial:
    """As much of `serial.Serial` as `open_line` uses."""

    baudrate = 115200

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
        (OSError(errno.ENOENT, ""), PortErrorKind.MISSING),
        (serial.SerialException("FileNotFoundError(2)"), PortErrorKind.MISSING),
        (OSError(errno.EBUSY, ""), PortErrorKind.BUSY),
        (serial.SerialException(errno.EAGAIN, "Could not exclusively lock port"), PortErrorKind.BUSY),
        (serial.SerialException(errno.EACCES, "could not open port"), PortErrorKind.NOT_ALLOWED),
        (ValueError("Not a valid baudrate"), PortErrorKind.UNUSABLE),
    ],
)
def test_a_port_that_does_not_open_says_why(
    error: Exception, trouble: PortErrorKind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial, "serial_for_url", lambda *_args, **_more: FakeSerial(error))
    with pytest.raises(PortError) as failed:
        open_line("/dev/ttyS9", 115200)
    assert failed.value.kind is trouble


@pytest.mark.parametrize(("port", "is_exclusive"), [("/dev/ttyS9", True), ("socket://127.0.0.1:9", None)])
def test_a_port_is_opened_for_this_program_only_and_with_its_control_lines_low(
    port: str, is_exclusive: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = FakeSerial()
    monkeypatch.setattr(serial, "serial_for_url", lambda *_port, **_options: fake)
    open_line(port, 9600).close()
    assert fake.opened_with == {"exclusive": is_exclusive, "dtr": False, "rts": False}


class Terminal:
    """A pseudo-terminal; `name` is the port to open, `master` the other end."""

    def __init__(self) -> None:
        import tty  # POSIX

        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        os.set_blocking(self.master, False)
        self._is_open = True

    def send(self, data: bytes) -> None:
        os.write(self.master, data)

    def hang_up(self) -> None:
        if self._is_open:
            self._is_open = False
            os.close(self.master)
            os.close(self._slave)


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    made = Terminal()
    yield made
    made.hang_up()


@pytest.fixture
def line(terminal: Terminal) -> Iterator[SerialLine]:
    line = open_line(terminal.name, 115200)
    yield line
    line.close()


def test_what_the_driver_took_is_written_however_long_this_thread_was_kept_waiting(
    line: SerialLine, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The port was taken for stuck on a busy computer."""
    monkeypatch.setattr("serial.serialutil.Timeout.expired", lambda _timeout: True)
    line.write(b"Ba 123")
    assert os.read(terminal.master, 100) == b"Ba 123"


ACTS: dict[str, Callable[[SerialLine], object]] = {
    "os.write": lambda line: line.write(b"Ba 123"),
    "select.select": lambda line: line.read(10.0, 0.0),
    "os.read": lambda line: line.read(10.0, 0.0),
    "serial.Serial.read": lambda line: line.read(10.0, 0.0),
    "serial.Serial.reset_input_buffer": lambda line: line.use_rate(9600),
}
"""What fails, and what was done then."""


@pytest.mark.parametrize(
    "error",
    [
        serial.SerialException("device reports readiness to read but returned no data"),
        termios.error(errno.EIO, "Input/output error"),
        TypeError("'NoneType' object cannot be interpreted as an integer"),
    ],
    ids=["SerialException", "termios.error", "TypeError"],
)
@pytest.mark.parametrize("where", [*ACTS, "serial.Serial.close"])
@pytest.mark.promise("k")
def test_any_error_of_pyserial_is_a_lost_port(
    where: str, error: Exception, line: SerialLine, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> Any:
        raise error

    terminal.send(b"a report")
    if where == "serial.Serial.read":  # the way used on Windows, and for ports given by a URL
        monkeypatch.setattr(line, "_interrupts", None)
    with monkeypatch.context() as patch:
        patch.setattr(where, fail)
        if where == "serial.Serial.close":
            line.close()  # never raises
            return
        with pytest.raises(PortError) as lost:
            ACTS[where](line)
    assert lost.value.kind is PortErrorKind.LOST


INPUT, OUTPUT, CONTROL, LOCAL = 0, 1, 2, 3
TIOCGEXCL = 0x80045440  # Linux


@pytest.fixture
def spoiled() -> Iterator[Line]:
    with Line() as made:
        spoil(made)
        yield made


def spoil(spoiled: Line) -> None:
    """Leave it as badly as another program could: breaks, XON/XOFF, RTS/CTS, two stop bits, an echo."""
    left = spoiled.host_termios()
    left[INPUT] |= termios.BRKINT | termios.IXON | termios.IXOFF | termios.ICRNL | termios.PARMRK | termios.ISTRIP
    left[CONTROL] |= termios.CSTOPB | termios.CRTSCTS
    left[LOCAL] |= termios.ICANON | termios.ECHO | termios.ISIG
    termios.tcsetattr(spoiled.slave, termios.TCSANOW, left)


def is_plain(spoiled: Line) -> bool:
    """Whether the far end sees 8N1 and nothing that changes, adds or holds back bytes."""
    now = spoiled.host_termios()
    changing = termios.BRKINT | termios.IXON | termios.IXOFF | termios.ICRNL | termios.PARMRK | termios.ISTRIP
    other_than_8n1 = termios.CSTOPB | termios.CRTSCTS | termios.PARENB
    return (
        now[CONTROL] & termios.CSIZE == termios.CS8
        and not now[INPUT] & changing
        and not now[OUTPUT] & termios.OPOST
        and not now[CONTROL] & other_than_8n1
        and not now[LOCAL] & (termios.ICANON | termios.ECHO | termios.ISIG)
    )


@pytest.mark.promise("a")
def test_the_line_is_set_at_opening_and_at_a_change_of_rate(spoiled: Line) -> None:
    assert not is_plain(spoiled)
    opened = open_line(spoiled.port, 115200)
    try:
        assert is_plain(spoiled)
        assert spoiled.host_rate() == 115200
        for rate in (4800, 57600, 9600):
            spoil(spoiled)
            opened.use_rate(rate)
            assert is_plain(spoiled)
            assert spoiled.host_rate() == rate
    finally:
        opened.close()


@pytest.mark.promise("a")
def test_a_second_one_of_these_programs_is_kept_off(spoiled: Line) -> None:
    opened = open_line(spoiled.port, 115200)
    try:
        with pytest.raises(PortError) as failed:
            open_line(spoiled.port, 115200)
    finally:
        opened.close()
    assert failed.value.kind is PortErrorKind.BUSY
    open_line(spoiled.port, 115200).close()


@pytest.mark.promise("a")
def test_other_programs_are_kept_off_an_adapter(spoiled: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "is_pseudo_terminal", lambda _port: False)
    opened = open_line(spoiled.port, 115200)
    try:
        answer = fcntl.ioctl(spoiled.slave, TIOCGEXCL, bytes(4))
        assert struct.unpack("i", answer) == (1,)
        if os.geteuid() != 0:
            with pytest.raises(OSError) as refused:
                os.open(spoiled.port, os.O_RDWR | os.O_NOCTTY)
            assert refused.value.errno == errno.EBUSY
    finally:
        opened.close()
