"""pyserial's handler of `sim://NAME?option=value&…`: the simulated module of that name in this process.

It has no thread: each read computes what is due by the clock. As with a real adapter there is one user at a time, a
port that was unplugged stays dead, and bytes at the wrong rate are garbled.
"""

import errno
import time
from urllib.parse import parse_qsl, urlsplit

from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from app.simulator import bench as benches
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup, parse_options
from app.text.messages import UserError


def options_of(url: str) -> Setup:
    """Return the options of a `sim://` URL; raises `UserError`, which names the wrong one."""
    return parse_options(dict(parse_qsl(url.partition("?")[2], keep_blank_values=True)))


def open_bench(url: str) -> SimulatedBench:
    parts = urlsplit(url)
    name = (parts.netloc + parts.path).strip("/")
    return benches.module(name, options_of(url))


class Serial(SerialBase):
    """A port of pyserial's shape, without modem lines; no write waits."""

    _bench: SimulatedBench | None = None
    _received = bytearray()

    def open(self) -> None:
        """Raises `SerialException` where it is unplugged or in use, or the URL is wrong."""
        try:
            bench = open_bench(str(self.portstr))
        except UserError as error:
            raise SerialException(errno.EINVAL, f"could not open port {self.portstr}: {error}") from error
        with bench.lock:
            if not bench.is_plugged_in:
                raise SerialException(errno.ENOENT, f"could not open port {self.portstr}: No such device")
            if bench.holder is not None:
                raise SerialException(errno.EBUSY, f"could not open port {self.portstr}: Device or resource busy")
            bench.holder = self
            bench.wire.clear(bench.clock())
            bench.wire.host_baud = self.baudrate
            self._bench = bench
            self._received = bytearray()
            self.is_open = True

    def close(self) -> None:
        bench = self._bench
        if bench is None:
            return
        with bench.lock:
            self.is_open = False
            self._bench = None
            if bench.holder is self:
                bench.holder = None
                bench.wire.host_baud = None

    @property
    def in_waiting(self) -> int:
        bench = self._source()
        with bench.lock:
            self._received += bench.wire.read(bench.clock())
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return up to `size` bytes that arrive within the time-out; where there is none it does not wait. Raises
        `SerialException` where it is unplugged."""
        bench = self._source()
        ends_s = bench.clock() + (self.timeout or 0.0)
        while self.in_waiting < size and (now_s := bench.clock()) < ends_s:
            with bench.lock:
                due_s = bench.wire.next_due(now_s)
            time.sleep(min(due_s, ends_s) - now_s)
        taken = bytes(self._received[:size])
        del self._received[:size]
        return taken

    def write(self, data: bytes, /) -> int:  # type: ignore[override]
        bench = self._source()
        with bench.lock:
            bench.wire.write(bytes(data), bench.clock())
        return len(data)

    def reset_input_buffer(self) -> None:
        del self._received[: self.in_waiting]

    def _source(self) -> SimulatedBench:
        bench = self._bench
        if bench is None:
            raise PortNotOpenError
        if bench.holder is not self:
            raise SerialException(errno.EIO, f"{self.portstr}: Input/output error (device disconnected?)")
        return bench

    def _reconfigure_port(self) -> None:
        if self._bench is not None:
            with self._bench.lock:
                self._bench.wire.host_baud = self.baudrate
