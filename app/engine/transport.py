"""The serial port: wraps pyserial and converts its exceptions to `PortError`.

One thread opens, reads, writes and closes (pyserial fails in many ways otherwise). For an unplugged adapter pyserial
raises SerialException, OSError, termios.error (not an OSError) or TypeError, depending on the call; all of them are
`PortErrorKind.LOST` here.
"""

import errno
import os
import re
import select
import sys
import time
from contextlib import suppress
from enum import Enum
from threading import Lock
from typing import Protocol

import serial

from app.engine.target import is_shared, is_socket

_DRIVER_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, TypeError, AttributeError)
if sys.platform != "win32":
    import fcntl
    import termios

    _DRIVER_ERRORS += (termios.error,)

# pyserial's time-out of a read, where the wait cannot be given for each read.
READ_SLICE_S = 0.01
# pyserial's time-out of a write. Closing waits for it, and must take half a second at most.
WRITE_LIMIT_S = 0.3
READ_CHUNK = 65536
# pyserial's text for ERROR_TIMEOUT and ERROR_BROKEN_PIPE. Under Wine a read during which nothing came ends with either;
# Windows uses neither for a port.
_NOTHING_CAME = re.compile(r"GetOverlappedResult failed .*, (?:1460|109)\)")
# pyserial knows more: some write files (`spy`), load any class (`alt`), or take whichever adapter fits (`hwgrep`).
SCHEMES = frozenset(("socket", "rfc2217", "loop", "sim", "shared"))


class PortErrorKind(Enum):
    """Why a port cannot be opened or used."""

    MISSING = "missing"  # no such port: unplugged, or another name
    BUSY = "busy"  # another program has it open
    NOT_ALLOWED = "not allowed"  # this user may not open it
    UNUSABLE = "unusable"  # not a port, or the driver refuses the settings
    UNSUPPORTED = "unsupported"  # a kind of address that this program does not open
    LOST = "lost"  # it was open and disappeared, or takes no bytes


class PortError(Exception):
    """The port could not be opened, or was lost. `detail` is the driver's text, for the log."""

    def __init__(self, kind: PortErrorKind, port: str, detail: str) -> None:
        super().__init__(f"{port}: {kind.value}: {detail}")
        self.kind = kind
        self.port = port
        self.detail = detail


class Line(Protocol):
    """The part of a port that a session needs."""

    port: str
    baud_rate: int

    def read(self, longest_s: float, gather_s: float) -> bytes: ...

    def write(self, data: bytes) -> None: ...

    def use_rate(self, baud_rate: int) -> None: ...

    def close(self) -> None: ...


def refuse_unsupported(port: str) -> None:
    """Raise `PortError` UNSUPPORTED for a URL whose scheme is not in `SCHEMES`."""
    scheme, separator, _rest = port.partition("://")
    if separator and scheme not in SCHEMES:
        raise PortError(PortErrorKind.UNSUPPORTED, port, "scheme")


def _trouble_at_opening(error: Exception) -> PortErrorKind:
    number = getattr(error, "errno", None)
    # pyserial has no number on Windows, where `PermissionError` is that of a port that is open elsewhere.
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV) or "FileNotFoundError" in str(error):
        return PortErrorKind.MISSING
    if number in (errno.EBUSY, errno.EAGAIN) or "PermissionError" in str(error):
        return PortErrorKind.BUSY
    if number in (errno.EACCES, errno.EPERM):
        return PortErrorKind.NOT_ALLOWED
    return PortErrorKind.UNUSABLE


class SerialLine:
    """An open port, made by `open_line`. Only the thread that opened it may use it, except `interrupt`."""

    def __init__(self, port: str, opened: serial.Serial) -> None:
        self.port, self.baud_rate = port, int(opened.baudrate)
        self._serial = opened
        # Readable after `interrupt`; POSIX only.
        self._interrupts: int | None = getattr(opened, "pipe_abort_read_r", None)
        self._closing = Lock()
        self._is_closed = False
        self._is_stuck = False

    def read(self, longest_s: float, gather_s: float) -> bytes:
        """Return the bytes that arrive within `longest_s` (of a socket, and on Windows, `READ_SLICE_S` at most).
        `gather_s`: how long to wait after the first byte, so that a stream causes a hundred wake-ups a second and not a
        thousand. `interrupt` ends the wait. Raises `PortError` LOST."""
        try:
            if self._interrupts is not None:
                return self._read_in_time(longest_s, gather_s, self._interrupts)
            if longest_s <= 0 and not self._serial.in_waiting:
                return b""
            try:
                first = self._serial.read(1)
            except serial.SerialException as error:
                if not _NOTHING_CAME.search(str(error)):
                    raise
                first = self._serial.read(1) if self._serial.in_waiting else b""  # raises if the port is gone
            if not first:
                return b""
            if gather_s > 0:
                time.sleep(gather_s)
            if not is_socket(self.port):
                return bytes(first + self._serial.read(min(self._serial.in_waiting, READ_CHUNK)))
            # `in_waiting` of a socket is at most 1, so reading it would fall behind a stream; a read without a time-out
            # takes all. (A real port would be reconfigured at every change of the time-out.)
            self._serial.timeout = 0
            try:
                return bytes(first + self._serial.read(READ_CHUNK))
            finally:
                self._serial.timeout = READ_SLICE_S
        except _DRIVER_ERRORS as error:
            raise PortError(PortErrorKind.LOST, self.port, str(error)) from error

    def _read_in_time(self, longest_s: float, gather_s: float, interrupts: int) -> bytes:
        # Wait once for the first byte and once for the rest; pyserial would poll for each byte.
        port = self._serial.fileno()
        ready, _, _ = select.select([port, interrupts], [], [], max(0.0, longest_s))
        if port not in ready:
            if ready:
                os.read(interrupts, READ_CHUNK)
            return b""
        if gather_s > 0:
            select.select([interrupts], [], [], gather_s)
        data = b""
        with suppress(BlockingIOError):
            data = os.read(port, READ_CHUNK)
        # Without data pyserial's slower read tells whether the port is gone or another program took the bytes.
        return data or bytes(self._serial.read(1))

    def write(self, data: bytes) -> None:
        """Hand all of `data` to the driver; raises `PortError` LOST, also where it takes nothing for 0.3 s."""
        try:
            if self._interrupts is None and (sys.platform == "win32" or not is_socket(self.port)):
                self._serial.write(data)
                return
            # pyserial also calls a time-out what the driver took, where this thread was kept waiting after it.
            port, ends_at = self._serial.fileno(), time.monotonic() + WRITE_LIMIT_S
            while data:
                _, ready, _ = select.select([], [port], [], max(0.0, ends_at - time.monotonic()))
                if not ready:
                    raise serial.SerialTimeoutException("Write timeout")
                with suppress(BlockingIOError):
                    data = data[os.write(port, data) :]
        except _DRIVER_ERRORS as error:
            self._is_stuck = isinstance(error, serial.SerialTimeoutException)
            raise PortError(PortErrorKind.LOST, self.port, str(error)) from error

    def use_rate(self, baud_rate: int) -> None:
        """Continue at another rate, with empty buffers; raises `PortError` LOST."""
        try:
            self._serial.baudrate = self.baud_rate = baud_rate
            self.begin()
        except _DRIVER_ERRORS as error:
            raise PortError(PortErrorKind.LOST, self.port, str(error)) from error

    def begin(self) -> None:
        """Set what pyserial leaves as it was, and discard what was received before."""
        number = getattr(self._serial, "fd", None)
        if number is not None and sys.platform != "win32":
            # With BRKINT a break on the line throws away what was received.
            attributes = termios.tcgetattr(number)
            attributes[0] &= ~termios.BRKINT
            termios.tcsetattr(number, termios.TCSANOW, attributes)
            # pyserial keeps off only the programs that ask for the port for themselves. Not for a pseudo-terminal: of
            # one whose other end stays open, this survives a program that was killed.
            if not is_pseudo_terminal(self.port):
                fcntl.ioctl(number, termios.TIOCEXCL)
        self._serial.reset_input_buffer()

    def interrupt(self) -> None:
        """End a waiting read, or else the next one. From any thread."""
        with self._closing:  # after closing the pipe's number may be another file's
            if not self._is_closed:
                with suppress(*_DRIVER_ERRORS):  # a socket cannot be interrupted
                    self._serial.cancel_read()

    def close(self) -> None:
        """Close the port. Idempotent; never raises."""
        with self._closing:
            self._is_closed = True
        if self._is_stuck:
            with suppress(*_DRIVER_ERRORS):  # else the system waits half a minute for the bytes to be sent
                self._serial.reset_output_buffer()
        with suppress(*_DRIVER_ERRORS):
            self._serial.close()


def is_pseudo_terminal(port: str) -> bool:
    return os.path.realpath(port).startswith(("/dev/pts/", "/dev/ttys"))


def open_line(port: str, baud_rate: int) -> SerialLine:
    """Open a device name, a pseudo-terminal or a URL of `SCHEMES` for this program only, 8N1, with DTR and RTS low, as
    some adapters connect them to a reset; and discard what was received before. Raises `PortError`."""
    refuse_unsupported(port)
    if "app.port_urls" not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append("app.port_urls")
    url = port.replace("shared:", "socket:", 1) if is_shared(port) else port  # the same on the line
    # pyserial takes no limit of writing for RFC 2217, whose socket it gives five seconds.
    limit_s = None if port.startswith("rfc2217:") else WRITE_LIMIT_S
    try:
        opened = serial.serial_for_url(
            url, do_not_open=True, baudrate=baud_rate, timeout=READ_SLICE_S, write_timeout=limit_s
        )
        if "://" not in port:
            opened.exclusive = True
        opened.dtr = False
        opened.rts = False
        opened.open()
    except Exception as error:
        raise PortError(_trouble_at_opening(error), port, str(error)) from error
    line = SerialLine(port, opened)
    try:
        line.begin()
    except _DRIVER_ERRORS as error:
        line.close()
        raise PortError(PortErrorKind.LOST, port, str(error)) from error
    return line
