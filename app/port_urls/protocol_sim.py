"""pyserial URL handler for `sim://NAME?option=value&…`: the simulated module of that name in this process.

    serial.protocol_handler_packages.append("app.port_urls")
    serial.serial_for_url("sim://bench?rate=200&drop=0.1")

No thread: each read computes what is due by the clock. It behaves like a real adapter: one user at a time, a port that
was unplugged stays dead, and bytes at the wrong rate are garbled.
"""

import errno
from urllib.parse import parse_qsl, urlsplit

from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from app.simulator import bench as benches
from app.simulator.bench import DEFAULT_NAME, SimulatedBench
from app.simulator.setup import parse_options
from app.simulator.wire import MAX_BYTES
from app.text.user_error import UserError


def open_bench(url: str) -> SimulatedBench:
    """The module that a `sim://` URL names; raises `UserError`."""
    parts = urlsplit(url)
    name = (parts.netloc + parts.path).strip("/") or DEFAULT_NAME
    options = parse_options(parse_qsl(parts.query, keep_blank_values=True))
    return benches.module(name, options)


class Serial(SerialBase):
    """A port of pyserial's shape; `open`, `read`, `write` … as there. There are no modem lines; no write waits."""

    BAUDRATES = tuple(rate for rate in SerialBase.BAUDRATES if rate >= 1200)

    _bench: SimulatedBench | None = None
    _plug_number = 0
    _received: bytearray = bytearray()
    _is_cancelled = False

    def open(self) -> None:
        """Raises `SerialException` if it is unplugged or in use, or the URL is invalid."""
        if self.is_open:
            raise SerialException("Port is already open.")
        if not self.portstr:
            raise SerialException("Port must be configured before it can be used.")
        try:
            bench = open_bench(self.portstr)
        except UserError as error:
            raise SerialException(errno.EINVAL, f"could not open port {self.portstr}: {error}") from error
        if not bench.is_plugged_in:
            raise SerialException(errno.ENOENT, f"could not open port {self.portstr}: No such device")
        if not bench.hold(self):
            raise SerialException(errno.EBUSY, f"could not open port {self.portstr}: Device or resource busy")
        with bench.changed:
            self._bench = bench
            self._plug_number = bench.plug_number
            self._received = bytearray()
            self._is_cancelled = False
            bench.wire.clear(bench.clock())
            bench.wire.host_baud = self.baudrate
            self.is_open = True

    def close(self) -> None:
        """Idempotent; a pending read returns what it has."""
        bench = self._bench
        if bench is None:
            return
        with bench.changed:
            self.is_open = False
            self._bench = None
            bench.release(self)

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read now."""
        bench = self._source()
        with bench.changed:
            self._receive(bench)
            return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes that arrive within the time-out. Raises `SerialException` if it is unplugged."""
        bench = self._source()
        with bench.changed:
            timeout_s = self.timeout
            deadline_s = None if timeout_s is None else bench.clock() + timeout_s
            self._is_cancelled = False
            while True:
                self._receive(bench)
                now_s = bench.clock()
                is_late = deadline_s is not None and now_s >= deadline_s
                if len(self._received) >= size or is_late or self._is_cancelled:
                    break
                ends_s = [at_s for at_s in (deadline_s, bench.wire.next_due(now_s)) if at_s is not None]
                bench.changed.wait(max(0.0, min(ends_s) - now_s) if ends_s else None)
                if not self.is_open:
                    break
                self._source()
            taken = bytes(self._received[:size])
            del self._received[:size]
            return taken

    def write(self, data: bytes, /) -> int:  # type: ignore[override]
        """Send all bytes at once. Raises `SerialException` if it is unplugged."""
        bench = self._source()
        raw = bytes(data)
        with bench.changed:
            bench.wire.write(raw, bench.clock())
            bench.changed.notify_all()
        return len(raw)

    def reset_input_buffer(self) -> None:
        bench = self._source()
        with bench.changed:
            self._receive(bench)
            self._received.clear()

    def cancel_read(self) -> None:
        """End a pending read, if there is one."""
        bench = self._bench
        if bench is not None:
            with bench.changed:
                self._is_cancelled = True
                bench.changed.notify_all()

    def _source(self) -> SimulatedBench:
        bench = self._bench
        if bench is None or not self.is_open:
            raise PortNotOpenError
        if not bench.is_plugged_in or bench.plug_number != self._plug_number:
            raise SerialException(errno.EIO, f"{self.portstr}: Input/output error (device disconnected?)")
        return bench

    def _receive(self, bench: SimulatedBench) -> None:
        self._received += bench.wire.read(bench.clock())
        if len(self._received) > MAX_BYTES:
            del self._received[MAX_BYTES:]

    def _reconfigure_port(self) -> None:
        bench = self._bench
        if bench is not None and self.is_open:
            with bench.changed:
                bench.wire.host_baud = self.baudrate

    def reset_output_buffer(self) -> None:
        self._source()

    def cancel_write(self) -> None:
        """Nothing to cancel."""
