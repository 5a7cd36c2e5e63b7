"""The serial port: wraps pyserial and converts its exceptions to `PortError`.

One thread opens, reads, writes and closes (pyserial fails in many ways otherwise). For one pulled cable pyserial
raises SerialException, plain OSError, termios.error (no OSError) or TypeError, depending on where it is caught; all
of them are `PortTrouble.LOST` here.

    PortError
     ├─ MISSING      no such port: unplugged, or another name
     ├─ BUSY         another program has it
     ├─ NOT_ALLOWED  this user may not open it
     ├─ UNUSABLE     the name is no port, or the driver refuses the settings
     ├─ UNSUPPORTED  a kind of address, or an option in it, that this program does not open
     ├─ LOST         it was open and went away
     └─ STUCK        it takes no bytes
"""

import errno
import os
import re
import select
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from threading import Event, Lock
from types import MappingProxyType
from typing import Protocol

import serial

try:
    import termios
except ImportError:  # Windows
    _DRIVER_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, TypeError, AttributeError)
else:
    _DRIVER_ERRORS = (OSError, ValueError, TypeError, AttributeError, termios.error)

READ_SLICE_S = 0.01
"""Longest time that a read blocks where it cannot be told for how long: pyserial's time-out."""
WRITE_LIMIT_S = 0.3
"""Longest time that a write blocks: closing waits for it, and must take half a second at most."""
READ_CHUNK = 65536
_NOTHING_CAME = re.compile(r"GetOverlappedResult failed .*, (?:1460|109)\)")
"""pyserial's text for ERROR_TIMEOUT and ERROR_BROKEN_PIPE. Under Wine a read during which nothing came ends with
either; Windows uses neither for a port."""
URL_OPTIONS: Mapping[str, frozenset[str] | None] = MappingProxyType({
    "socket": frozenset(),
    "rfc2217": frozenset({"ign_set_control", "poll_modem", "timeout"}),
    "loop": frozenset(),
    "sim": None,
    "capture": None,
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


@dataclass(frozen=True, slots=True)
class Holder:
    """A program that has the port open, where the system tells."""

    name: str
    pid: int


class PortError(Exception):
    """The port could not be had, or was lost. `detail` is the driver's own text, for the log."""

    def __init__(self, trouble: PortTrouble, port: str, detail: str, holder: Holder | None = None) -> None:
        super().__init__(f"{port}: {trouble.value}: {detail}")
        self.trouble = trouble
        self.port = port
        self.detail = detail
        self.holder = holder


class Line(Protocol):
    """What a session needs of a port; a test's fake gives the same."""

    @property
    def baud_rate(self) -> int: ...

    def read(self, longest_s: float, gather_s: float) -> bytes: ...

    def write(self, data: bytes) -> None: ...

    def use_rate(self, baud_rate: int) -> None: ...

    def close(self) -> None: ...


def holder_of(port: str, proc: Path = Path("/proc")) -> Holder | None:
    """Who else has this device, where that is certain: of the other programs that have this very device open, as far as
    this user may see, the only one, or the one that has locked it. Only on Linux."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        device = Path(port).stat()
    except OSError:  # unplugged meanwhile
        return None
    holders: dict[int, Holder] = {}
    for link in proc.glob("[0-9]*/fd/*"):
        process = link.parents[1]
        with suppress(OSError, ValueError):  # it has ended meanwhile, or is none of this user's business
            # The name alone may be another device's, in another namespace.
            if int(process.name) == os.getpid() or not os.path.samestat(link.stat(), device):
                continue
            started = _started(process)
            name = (process / "comm").read_text(errors="replace", encoding="utf-8").strip()
            # Unless it is the same process from the beginning to the end, the number has gone to another one.
            if os.path.samestat(link.stat(), device) and _started(process) == started:
                holders[int(process.name)] = Holder(name, int(process.name))
    locking = _locking(device, proc) & holders.keys() if len(holders) > 1 else holders.keys()
    return holders[next(iter(locking))] if len(locking) == 1 else None


def _locking(device: os.stat_result, proc: Path) -> set[int]:
    """The processes that have locked this file, by the system's own list."""
    try:
        rows = [row.split() for row in (proc / "locks").read_text(encoding="utf-8").splitlines()]
    except OSError:
        return set()
    name = f"{os.major(device.st_dev):02x}:{os.minor(device.st_dev):02x}:{device.st_ino}"
    return {int(row[4]) for row in rows if len(row) > 5 and row[1] == "FLOCK" and row[5] == name and row[4].isdigit()}


def _started(process: Path) -> str:
    """When it started, in ticks since the computer did."""
    return (process / "stat").read_text(errors="replace", encoding="utf-8").rpartition(")")[2].split()[19]


def refuse_unsupported(port: str) -> None:
    """Raises `PortError` UNSUPPORTED for a URL of another kind, or with another option, than `URL_OPTIONS` has."""
    scheme, separator, rest = port.partition("://")
    if not separator:
        return
    # pyserial opens CAPTURE:// too, which nothing here would take for a capture.
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
        return PortTrouble.BUSY  # Windows refuses a port that is open elsewhere with this very error
    if number in (errno.EACCES, errno.EPERM):
        return PortTrouble.NOT_ALLOWED
    if "ConnectionRefused" in text or number == errno.ECONNREFUSED or "Connection refused" in text:
        return PortTrouble.MISSING
    return PortTrouble.UNUSABLE


class SerialLine:
    """An open port. Made by `open_line`; belongs to the thread that opened it, but for `wake`, `interrupt`, `abort`."""

    def __init__(self, port: str, opened: serial.Serial) -> None:
        self.port = port
        self._serial = opened
        self._interrupts: int | None = getattr(opened, "pipe_abort_read_r", None)
        """Readable when `interrupt` was called; only POSIX has it."""
        self._woken = Event()
        self._closing = Lock()
        self._is_closed = False
        self._is_stuck = False

    @property
    def baud_rate(self) -> int:
        return int(self._serial.baudrate)

    def read(self, longest_s: float, gather_s: float) -> bytes:
        """Bytes that came within `longest_s`, b"" if none did.

        With `gather_s` it lingers that long after the first byte, so that a stream costs a hundred wake-ups a second
        and not a thousand. `interrupt` ends both. Raises `PortError` LOST.
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
                self._woken.wait(gather_s)
            return first + self._read_waiting()
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error

    def _read_in_time(self, longest_s: float, gather_s: float, interrupts: int) -> bytes:
        """Waits once for the first byte and once for the rest; pyserial polls in slices, for each byte again."""
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
        # Of nothing, pyserial's slower read knows whether the port is gone or another program was quicker.
        return data or bytes(self._serial.read(1))

    def _read_one(self) -> bytes:
        """One byte, b"" if none came in time."""
        try:
            first: bytes = self._serial.read(1)
        except serial.SerialException as error:
            if not _NOTHING_CAME.search(str(error)):
                raise
            first = self._serial.read(1) if self._serial.in_waiting else b""  # asking fails where the port is gone
        return first

    def _read_waiting(self) -> bytes:
        """What is there now, without waiting."""
        if self.port.startswith("socket://"):
            # pyserial counts at most one byte of a socket, so a stream would come ever later; a read without a time-out
            # takes all. (A real port would be configured again at every change of the time-out.)
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
            self._serial.write(data)
        except serial.SerialTimeoutException as error:
            self._is_stuck = True
            raise PortError(PortTrouble.STUCK, self.port, str(error)) from error
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error
        if self._is_stuck:
            raise PortError(PortTrouble.STUCK, self.port, "broken off")

    def use_rate(self, baud_rate: int) -> None:
        """Continue at another rate, with empty buffers; raises `PortError` LOST."""
        try:
            self._serial.baudrate = baud_rate
            self._serial.reset_input_buffer()
        except _DRIVER_ERRORS as error:
            raise PortError(PortTrouble.LOST, self.port, str(error)) from error

    def wake(self) -> None:
        """End a lingering read now. From any thread."""
        self._woken.set()

    def interrupt(self) -> None:
        """End a read that waits, with nothing. From any thread; with nobody reading, the next read ends at once."""
        with self._closing:  # a closed port's pipe may be another file by now
            if not self._is_closed:
                with suppress(*_DRIVER_ERRORS):  # a socket cannot: it is waited for
                    self._serial.cancel_read()

    def abort(self) -> None:
        """End a write that blocks as STUCK, and a read that waits; then it can only be closed. From any thread."""
        with self._closing:
            if not self._is_closed:
                self._is_stuck = True
                for cancel in ("cancel_write", "cancel_read"):
                    with suppress(*_DRIVER_ERRORS):
                        getattr(self._serial, cancel)()

    def close(self) -> None:
        """Idempotent; never raises, whatever became of the port."""
        with self._closing:
            self._is_closed = True
        if self._is_stuck:
            with suppress(*_DRIVER_ERRORS):  # else the system waits for half a minute for bytes that nobody takes
                self._serial.reset_output_buffer()
        with suppress(*_DRIVER_ERRORS):  # the port is gone, which is what was wanted
            self._serial.close()


def open_line(port: str, baud_rate: int) -> SerialLine:
    """Open a device name, a pseudo-terminal or a pyserial URL (`socket://`, `sim://`), 8N1; raises `PortError`.

    Asks for exclusive use, leaves DTR and RTS low (some adapters wire them to a reset), and drops what was received
    before the opening.
    """
    refuse_unsupported(port)
    if "app.port_urls" not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append("app.port_urls")
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
        trouble = _trouble_at_opening(error)
        holder = holder_of(port) if trouble is PortTrouble.BUSY else None
        raise PortError(trouble, port, str(error), holder) from error
    line = SerialLine(port, opened)
    try:
        opened.reset_input_buffer()
    except _DRIVER_ERRORS as error:
        line.close()
        raise PortError(PortTrouble.LOST, port, str(error)) from error
    return line
