"""Serves the simulated module on a pseudo-terminal (Linux, macOS)."""

import errno
import os
import struct
import sys
from contextlib import suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl
    import termios
    import tty

READ_CHUNK = 65536
_CUSTOM_RATE = 0o10000
"""Linux: the rate is a number instead of a code, as set by Wine and for custom rates."""
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("4I20B2I")


class PtyEndpoint:
    """A pseudo-terminal, with an optional symbolic link to it."""

    def __init__(self, link: Path | None, *, baud_rate: int) -> None:
        """`baud_rate`: initial rate of the port. Raises OSError if there is no pseudo-terminal, or the path for the
        link is taken by something else."""
        if link is not None and link.exists() and not link.is_symlink():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
        self._link = link
        self._bauds = {
            getattr(termios, f"B{rate}"): rate
            for rate in (1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600)
            if hasattr(termios, f"B{rate}")
        }
        # The slave stays open: reading the master fails while nobody has it open.
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        settings = termios.tcgetattr(self._slave)
        settings[4] = settings[5] = next(code for code, rate in self._bauds.items() if rate == baud_rate)
        termios.tcsetattr(self._slave, termios.TCSANOW, settings)
        os.set_blocking(self._master, False)
        self.address = os.ttyname(self._slave)
        """Path of the port."""
        if link is not None:
            self._refresh_link(link)

    def close(self) -> None:
        if self._link is not None:
            with suppress(OSError):
                if self._link.is_symlink() and str(self._link.readlink()) == self.address:
                    self._link.unlink()
        os.close(self._master)
        os.close(self._slave)

    def files(self) -> list[int]:
        return [self._master]

    def host_baud(self) -> int | None:
        """The rate that the host set; 0 for an unknown one."""
        code = termios.tcgetattr(self._master)[4]
        if code == _CUSTOM_RATE and sys.platform == "linux":
            return int(_TERMIOS2.unpack(fcntl.ioctl(self._master, _TCGETS2, bytes(_TERMIOS2.size)))[-1])
        return self._bauds.get(code, 0)

    def receive(self, ready: list[int]) -> bytes:
        if self._master not in ready:
            return b""
        try:
            return os.read(self._master, READ_CHUNK)
        except OSError:  # nothing there after all
            return b""

    def send(self, data: bytes) -> None:
        """Bytes that do not fit are lost."""
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def _refresh_link(self, link: Path) -> None:
        """Replace the link atomically."""
        new = link.with_name(f".{link.name}.{os.getpid()}")
        new.unlink(missing_ok=True)
        new.symlink_to(self.address)
        new.replace(link)
