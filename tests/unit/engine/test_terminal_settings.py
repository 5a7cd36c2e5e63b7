"""The settings of the line, read at its far end, and who else may open it."""

import errno
import os
import struct
import sys
from collections.abc import Iterator

import pytest

if sys.platform == "win32":
    pytest.skip("Windows has no terminals", allow_module_level=True)

import fcntl
import termios

from app.engine import transport
from app.engine.transport import PortError, PortTrouble, open_line
from tests.module.line import Line

INPUT, OUTPUT, CONTROL, LOCAL = 0, 1, 2, 3
TIOCGEXCL = 0x80045440  # Linux


@pytest.fixture
def line() -> Iterator[Line]:
    with Line() as made:
        spoil(made)
        yield made


def spoil(line: Line) -> None:
    """Leave it as badly as another program could: breaks, XON/XOFF, RTS/CTS, two stop bits, an echo."""
    left = line.host_termios()
    left[INPUT] |= termios.BRKINT | termios.IXON | termios.IXOFF | termios.ICRNL | termios.PARMRK | termios.ISTRIP
    left[CONTROL] |= termios.CSTOPB | termios.CRTSCTS
    left[LOCAL] |= termios.ICANON | termios.ECHO | termios.ISIG
    termios.tcsetattr(line.slave, termios.TCSANOW, left)


def is_plain(line: Line) -> bool:
    """Whether the far end sees 8N1 and nothing that changes, adds or holds back bytes."""
    now = line.host_termios()
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
def test_the_line_is_set_at_opening_and_at_a_change_of_rate(line: Line) -> None:
    assert not is_plain(line)
    opened = open_line(line.port, 115200)
    try:
        assert is_plain(line)
        assert line.host_rate() == 115200
        for rate in (4800, 57600, 9600):
            spoil(line)
            opened.use_rate(rate)
            assert is_plain(line)
            assert line.host_rate() == rate
    finally:
        opened.close()


@pytest.mark.promise("a")
def test_a_second_one_of_these_programs_is_kept_off(line: Line) -> None:
    opened = open_line(line.port, 115200)
    try:
        with pytest.raises(PortError) as failed:
            open_line(line.port, 115200)
    finally:
        opened.close()
    assert failed.value.trouble is PortTrouble.BUSY
    open_line(line.port, 115200).close()


@pytest.mark.promise("a")
def test_other_programs_are_kept_off_an_adapter(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "is_pseudo_terminal", lambda _port: False)
    opened = open_line(line.port, 115200)
    try:
        answer = fcntl.ioctl(line.slave, TIOCGEXCL, bytes(4))
        assert struct.unpack("i", answer) == (1,)
        if os.geteuid() != 0:
            with pytest.raises(OSError) as refused:
                os.open(line.port, os.O_RDWR | os.O_NOCTTY)
            assert refused.value.errno == errno.EBUSY
    finally:
        opened.close()
