"""The serial port: wraps pyserial and converts its exceptions to `PortError`.

One thread opens, reads, writes and closes (pyserial fails in many ways otherwise). For an unplugged adapter pyserial
raises SerialException, OSError, termios.error (not an OSError) or TypeError, depending on the call; all of them are
`PortTrouble.LOST` here.

    PortError
     ├─ MISSING      no such port: unplugged, or another name
     ├─ BUSY         another program has it open, or of this user the same network address
     ├─ NOT_ALLOWED  this user may not open it
     ├─ UNUSABLE     not a port, or the driver refuses the settings
     ├─ UNSUPPORTED  a kind of address, or an option in it, that this program does not open
     ├─ LOST         it was open and disappeared
     └─ STUCK        it accepts no bytes
"""

import errno
import os
import re
import select
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from enum import Enum
from pathlib import Path
from threading import Event, Lock
from types import MappingProxyType
from typing import IO, NamedTuple, Protocol

import serial

from app.engine.address_lock import AddressHeld, is_network_address, lock_address, sets_rate

_DRIVER_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, TypeError, AttributeError)
if sys.platform != "win32":
    from app.engine import terminal_settings

    _DRIVER_ERRORS += (terminal_settings.TerminalError,)

READ_SLICE_S = 0.01
"""pyserial's time-out of a read, where the wait cannot be given for each read."""
WRITE_LIMIT_S = 0.3
"""pyserial's time-out of a write. Closing waits for it, and must take half a second at most."""
READ_CHUNK = 65536
_NOTHING_CAME = re.compile(r"GetOverlappedResult failed .*, (?:1460|109)\)")
"""pyserial's text for ERROR_TIMEOUT and ERROR_BROKEN_PIPE. Under Wine a read during which nothing came ends with
either; Windows uses neither for a port."""
URL_OPTIONS: Mapping[str, frozenset[str] | None] = MappingProxyType({
    "socket": frozenset(),
    "rfc2217": frozenset({"ign_set_control", "poll_modem", "timeout"}),
    "loop": frozenset(),
    "sim": None,
})  # fmt: skip
"""The schemes that are opened, each with its options; None: the scheme is ours and judges them itself. pyserial knows
more: some write files (`spy`), load any class (`alt`), or take whichever adapter fits a pattern (`hwgrep`)."""


class PortTrouble(Enum):
    MISSING = "missing"
    BUSY = "busy"
    NOT_ALLOWED = "not allowed"
    UNUSABLE = "unusable"
    UNSUPPORTED = "unsupported"
    LOST = "lost"
    STUCK = "stuck"


class PortHolder(NamedTuple):
    """A program that has the port open, where the system tells."""

    name: str
    pid: int


class PortError(Exception):
    """The port could not be opened, or was lost. `detail` is the driver's text, for the log."""

    def __init__(self, trouble: PortTrouble, port: str, detail: str, holder: PortHolder | None = None) -> None:
        super().__init__(f"{port}: {trouble.value}: {detail}")
        self.trouble = trouble
        self.port = port
        self.detail = detail
        self.holder = holder


class Line(Protocol):
    """The part of a port that a session needs."""

    @property
    def baud_rate(self) -> int: ...

    @property
    def sets_rate(self) -> bool: ...

    def read(self, longest_s: float, gather_s: float) -> bytes: ...

    def write(self, data: bytes) -> None: ...

    def use_rate(self, baud_rate: int) -> None: ...

    def close(self) -> None: ...


def holder_of(port: str, proc: Path = Path("/proc")) -> PortHolder | None:
    """The other program that has this device open, if it is the only one that this user can see. Linux only."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        device = Path(port).stat()
    except OSError:  # unplugged meanwhile
        return None
    holders: set[PortHolder] = set()
    for link in proc.glob("[0-9]*/fd/*"):
        process = link.parents[1]
        with suppress(OSError, ValueError):  # it has ended meanwhile, or is another user's
            # In another namespace the name may be another device's.
            if int(process.name) != os.getpid() and os.path.samestat(link.stat(), device):
                name = (process / "comm").read_text(errors="replace", encoding="utf-8").strip()
                holders.add(PortHolder(name, int(process.name)))
    return holders.pop() if len(holders) == 1 else None


def refuse_unsupported(port: str) -> None:
    """Raise `PortError` UNSUPPORTED for a URL whose scheme or options are not in `URL_OPTIONS`."""
    scheme, separator, rest = port.partition("://")
    if not separator:
        return
    if scheme not in URL_OPTIONS:
        raise PortError(PortTrouble.UNSUPPORTED, port, "scheme")
    allowed = URL_OPTIONS[scheme]
    if allowed is None:
        return
    query = rest.partition("#")[0].partition("?")[2]
    if {part.partition("=")[0] for part in re.split("[&;]", query) if part} - allowed:
        raise PortError(PortTrouble.UNSUPPORTED, port, "option")


def _trouble_at_opening(error: Exception) -> PortTrouble:
    number = getattr(error, "errno", None)
    text = str(error)
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV) or "FileNotFoundError" in text or "No such" in text:
        return PortTrouble.MISSING
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        return PortTrouble.BUSY
    if sys.platform == "win32" and "PermissionError" in text:
        return PortTrouble.BUSY  # Windows' error for a port that is open elsewhere
    if number in (errno.EACCES, errno.EPERM):
        return PortTrouble.NOT_ALLOWED
    if "ConnectionRefused" in text or number == errno.ECONNREFUSED or "Connection refused" in text:
        return PortTrouble.MISSING
    return PortTrouble.UNUSABLE


class SerialLine:
    """An open port, made by `open_line`.

    Only the thread that opened it may use it, except `interrupt` and `abort`.
    """

    def __init__(self, port: str, opened: serial.Serial, address_lock: IO[bytes] | None = None) -> None:
        self.port = port
        self._serial = opened
        self._address_lock = address_lock
        self._interrupts: int | None = getattr(opened, "pipe_abort_read_r", None)
        """Readable after `interrupt`; POSIX only."""
        self._aborts: int | None = getattr(opened, "pipe_abort_write_r", None)
        """As `_interrupts`, after `abort`."""
        self._wake_up = Event()
        self._closing = Lock()
        self._is_closed = False
        self._is_stuck = False

    @property
    def baud_rate(self) -> int:
        return int(self._serial.baudrate)

    @property
    def sets_rate(self) -> bool:
        return sets_rate(self.port)

    def read(self, longest_s: float, gather_s: float) -> bytes:
        """Return the bytes that arrive within `longest_s`, b"" if none do. A socket, and any port on Windows, is
        waited for as long as `READ_SLICE_S` only.

        `gather_s` is how long to wait after the first byte, so that a stream causes a hundred wake-ups a second and not
        a thousand. `interrupt` ends both waits. Raises `PortError` LOST.
        """
        try:
            if self._interrupts is not None:
                return self._read_in_time(longest_s, gather_s, self._interrupts)
            if longest_s <= 0 and not self._serial.in_waiting:
                return b""
            first = self._read_one()
            if not first:
                return b""
            if gather_s > 0:
                self._gather(gather_s)
            return first + self._read_waiting()
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error

    def _read_in_time(self, longest_s: float, gather_s: float, interrupts: int) -> bytes:
        """Wait once for the first byte and once for the rest; pyserial would poll for each byte."""
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

    def _gather(self, gather_s: float) -> None:
        self._wake_up.wait(gather_s)
        self._wake_up.clear()

    def _read_one(self) -> bytes:
        """Read one byte, b"" if none arrives in time."""
        try:
            first: bytes = self._serial.read(1)
        except serial.SerialException as error:
            if not _NOTHING_CAME.search(str(error)):
                raise
            first = self._serial.read(1) if self._serial.in_waiting else b""  # raises if the port is gone
        return first

    def _read_waiting(self) -> bytes:
        """Read what is there, without waiting."""
        if self.port.startswith("socket://"):
            # `in_waiting` of a socket is at most 1, so reading it would fall behind a stream; a read without a time-out
            # takes all. (A real port would be reconfigured at every change of the time-out.)
            self._serial.timeout = 0
            try:
                rest: bytes = self._serial.read(READ_CHUNK)
            finally:
                self._serial.timeout = READ_SLICE_S
            return rest
        waiting = self._serial.in_waiting
        return self._serial.read(min(waiting, READ_CHUNK)) if waiting else b""

    def write(self, data: bytes) -> None:
        """Hand all of `data` to the driver; raises `PortError` LOST, or STUCK after 0.3 s."""
        try:
            if self._aborts is not None or (sys.platform != "win32" and self.port.startswith("socket://")):
                self._write_in_time(data)
            else:
                self._serial.write(data)
        except serial.SerialTimeoutException as error:
            self._is_stuck = True
            raise PortError(PortTrouble.STUCK, self.port, str(error)) from error
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error
        if self._is_stuck:
            raise PortError(PortTrouble.STUCK, self.port, "broken off")

    def _write_in_time(self, data: bytes) -> None:
        """pyserial also calls a time-out what the driver took, where this thread was kept waiting after it."""
        port, ends_at = self._serial.fileno(), time.monotonic() + WRITE_LIMIT_S
        while data:
            left_s, written = max(0.0, ends_at - time.monotonic()), 0
            aborted, ready, _ = select.select([] if self._aborts is None else [self._aborts], [port], [], left_s)
            if ready and not aborted:
                with suppress(BlockingIOError):
                    written = os.write(port, data)
            if aborted or not (written or left_s):
                raise serial.SerialTimeoutException("Write timeout")
            data = data[written:]

    def use_rate(self, baud_rate: int) -> None:
        """Continue at another rate, with empty buffers; raises `PortError` LOST, or UNUSABLE if the driver refuses."""
        try:
            self._serial.baudrate = baud_rate
            self.complete_settings()
            self._serial.reset_input_buffer()
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error

    def complete_settings(self) -> None:
        """Set what pyserial leaves as it was, and make sure that the driver took everything.

        Raises `PortError` UNUSABLE if it did not. An address and a port on Windows have no such settings.
        """
        number = getattr(self._serial, "fd", None)
        if number is None or sys.platform == "win32":
            return
        terminal_settings.complete(number)
        refused = terminal_settings.refused(number, self.baud_rate)
        if refused:
            raise PortError(PortTrouble.UNUSABLE, self.port, f"the driver refuses {refused}")
        if not terminal_settings.is_pseudo_terminal(self.port):
            terminal_settings.keep_others_off(number)

    def interrupt(self) -> None:
        """End a waiting read with b"", or else the next one. From any thread."""
        self._wake_up.set()
        with self._closing:  # after closing the pipe's number may be another file's
            if not self._is_closed:
                with suppress(*_DRIVER_ERRORS):  # a socket cannot be interrupted
                    self._serial.cancel_read()

    def abort(self) -> None:
        """End a blocked write as STUCK, and a waiting read; afterwards it can only be closed. From any thread."""
        with self._closing:
            if not self._is_closed:
                self._is_stuck = True
                for cancel in ("cancel_write", "cancel_read"):
                    with suppress(*_DRIVER_ERRORS):
                        getattr(self._serial, cancel)()

    def close(self) -> None:
        """Close the port. Idempotent; never raises."""
        with self._closing:
            self._is_closed = True
        if self._is_stuck:
            with suppress(*_DRIVER_ERRORS):  # else the system waits half a minute for the bytes to be sent
                self._serial.reset_output_buffer()
        with suppress(*_DRIVER_ERRORS):
            self._serial.close()
        if self._address_lock is not None:
            self._address_lock.close()


def open_line(port: str, baud_rate: int) -> SerialLine:
    """Open a device name, a pseudo-terminal or a URL (`socket://`, `rfc2217://`, `sim://`), 8N1; raises `PortError`.

    Requests exclusive use, leaves DTR and RTS low (some adapters connect them to a reset), and discards what was
    received before.
    """
    refuse_unsupported(port)
    if "app.port_urls" not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.insert(0, "app.port_urls")  # before pyserial's: for rfc2217:// it has one, too
    address_lock = _lock_address(port) if is_network_address(port) else None
    try:
        opened = serial.serial_for_url(
            port, do_not_open=True, baudrate=baud_rate, timeout=READ_SLICE_S, write_timeout=WRITE_LIMIT_S
        )
        if "://" not in port:
            opened.exclusive = True
        opened.dtr = False
        opened.rts = False
        opened.open()
    except Exception as error:
        if address_lock is not None:
            address_lock.close()
        trouble = _trouble_at_opening(error)
        holder = holder_of(port) if trouble is PortTrouble.BUSY else None
        raise PortError(trouble, port, str(error), holder) from error
    line = SerialLine(port, opened, address_lock)
    try:
        line.complete_settings()
        opened.reset_input_buffer()
    except PortError:
        line.close()
        raise
    except _DRIVER_ERRORS as error:
        line.close()
        raise PortError(PortTrouble.LOST, port, str(error)) from error
    return line


def _lock_address(port: str) -> IO[bytes] | None:
    try:
        return lock_address(port)
    except AddressHeld as held:
        holder = None if held.pid is None else PortHolder("dps-s", held.pid)
        raise PortError(PortTrouble.BUSY, port, "another of these programs is connected", holder) from held
