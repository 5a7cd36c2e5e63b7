"""pyserial's handler of `sim://NAME?option=value&…`: the simulated module of that name in this process.

    serial.protocol_handler_packages.insert(0, "app.port_urls")
    serial.serial_for_url("sim://bench?rate=200&drop=0.1")

It has no thread: each read computes what is due by the clock. As with a real adapter there is one user at a time, a
port that was unplugged stays dead, and bytes at the wrong rate are garbled.
"""

import errno
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from app.simulator import bench as benches
from app.simulator.bench import DEFAULT_NAME, SimulatedBench
from app.simulator.setup import parse_options
from app.text.messages import UserError


def options_of(url: str) -> dict[str, Any]:
    """Return the options of a `sim://` URL; raises `UserError`, which names the wrong one."""
    return parse_options(dict(parse_qsl(url.partition("?")[2], keep_blank_values=True)))


def open_bench(url: str) -> SimulatedBench:
    parts = urlsplit(url)
    name = (parts.netloc + parts.path).strip("/") or DEFAULT_NAME
    return benches.module(name, options_of(url))


class Serial(SerialBase):
    """A port of pyserial's shape, without modem lines; no write waits."""

    _bench: SimulatedBench | None = None
    _received = bytearray()
    _is_cancelled = False

    def open(self) -> None:
        """Raises `SerialException` where it is unplugged or in use, or the URL is wrong."""
        try:
            bench = open_bench(str(self.portstr))
        except UserError as error:
            raise SerialException(errno.EINVAL, f"could not open port {self.portstr}: {error}") from error
        with bench.changed:
            if not bench.is_plugged_in:
                raise SerialException(errno.ENOENT, f"could not open port {self.portstr}: No such device")
            if bench.holder is not None:
                raise SerialException(errno.EBUSY, f"could not open port {self.portstr}: Device or resource busy")
            bench.holder = self
            bench.wire.clear(bench.clock())
            bench.wire.host_baud = self.baudrate
            self._bench = bench
            self._received = bytearray()
            self._is_cancelled = False
            self.is_open = True

    def close(self) -> None:
        bench = self._bench
        if bench is None:
            return
        with bench.changed:
            self.is_open = False
            self._bench = None
            if bench.holder is self:
                bench.holder = None
                bench.wire.host_baud = None
            bench.changed.notify_all()

    @property
    def in_waiting(self) -> int:
        bench = self._source()
        with bench.changed:
            self._received += bench.wire.read(bench.clock())
            return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return up to `size` bytes that arrive within the time-out. Raises `SerialException` where it is unplugged."""
        bench = self._source()
        with bench.changed:
            ends_s = None if self.timeout is None else bench.clock() + self.timeout
            self._is_cancelled = False
            while True:
                now_s = bench.clock()
                self._received += bench.wire.read(now_s)
                if len(self._received) >= size or self._is_cancelled or (ends_s is not None and now_s >= ends_s):
                    break
                times_s = [at_s for at_s in (ends_s, bench.wire.next_due(now_s)) if at_s is not None]
                bench.changed.wait(max(0.0, min(times_s) - now_s) if times_s else None)
                if not self.is_open:
                    break
                self._source()
            taken = bytes(self._received[:size])
            del self._received[:size]
            return taken

    def write(self, data: bytes, /) -> int:  # type: ignore[override]
        bench = self._source()
        with bench.changed:
            bench.wire.write(bytes(data), bench.clock())
            bench.changed.notify_all()
        return len(data)

    def reset_input_buffer(self) -> None:
        bench = self._source()
        with bench.changed:
            bench.wire.read(bench.clock())
            self._received.clear()

    def cancel_read(self) -> None:
        bench = self._bench
        if bench is not None:
            with bench.changed:
                self._is_cancelled = True
                bench.changed.notify_all()

    def _source(self) -> SimulatedBench:
        bench = self._bench
        if bench is None or not self.is_open:
            raise PortNotOpenError
        if bench.holder is not self:
            raise SerialException(errno.EIO, f"{self.portstr}: Input/output error (device disconnected?)")
        return bench

    def _reconfigure_port(self) -> None:
        if self._bench is not None and self.is_open:
            with self._bench.changed:
                self._bench.wire.host_baud = self.baudrate
