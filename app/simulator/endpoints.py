"""Serves a simulated module to other processes: one loop without a thread, on a pseudo-terminal (Linux, macOS) or on a
TCP socket, for pyserial's `socket://` (every platform).
"""

import errno
import math
import os
import select
import socket
import struct
import sys
from contextlib import suppress
from pathlib import Path

from app.simulator.bench import SimulatedBench

if sys.platform != "win32":
    import fcntl
    import termios
    import tty

BATCH_S = 0.004
"""In a fast stream several frames are written at once: waking up for each takes a tenth of a core."""
QUICK_HZ = 200.0
LONGEST_S = 1.0
"""Of a wait: the handler of a signal that comes just before it runs only after it."""
READ_CHUNK = 65536
_CUSTOM_RATE = 0o10000
"""Linux: the rate is a number instead of a code, as set by Wine and for custom rates."""
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("4I20B2I")


class Loop:
    """Serves until `stop`, which any thread and any signal handler may call. Wakes up for bytes of the host, bytes that
    are due, and `stop`."""

    def __init__(self, bench: SimulatedBench, endpoint: "Endpoint") -> None:
        self._bench = bench
        self._endpoint = endpoint
        self._is_stopped = False
        self._wake_sender, self._wake_receiver = socket.socketpair()
        self._wake_sender.setblocking(False)
        self._wake_receiver.setblocking(False)
        self._last_batch_s = -math.inf

    def stop(self) -> None:
        """End `run` soon; idempotent."""
        self._is_stopped = True
        self.wake()

    def wake(self) -> None:
        """Check the bench now, which another thread has changed."""
        with suppress(OSError):
            self._wake_sender.send(b"!")

    def run(self) -> None:
        try:
            while not self._is_stopped:
                ready = self._wait()
                if self._wake_receiver.fileno() in ready:
                    with suppress(OSError):
                        self._wake_receiver.recv(READ_CHUNK)
                self._exchange(ready)
        finally:
            self._wake_sender.close()
            self._wake_receiver.close()

    def _wait(self) -> list[int]:
        files = [self._wake_receiver.fileno(), *self._endpoint.files()]
        # select has time-outs in microseconds, epoll in milliseconds.
        ready, _, _ = select.select(files, [], [], self._timeout_s())
        return ready

    def _timeout_s(self) -> float:
        bench = self._bench
        with bench.changed:
            now_s = bench.clock()
            due_s = bench.wire.next_due(now_s)
            if due_s is None:
                return LONGEST_S
            if bench.module.is_streaming and bench.module.setup.rate > QUICK_HZ:
                due_s = max(due_s, self._last_batch_s + BATCH_S)
            return min(LONGEST_S, max(0.0, due_s - now_s))

    def _exchange(self, ready: list[int]) -> None:
        received = self._endpoint.receive(ready)
        bench = self._bench
        with bench.changed:
            now_s = bench.clock()
            bench.wire.host_baud = self._endpoint.host_baud()
            bench.wire.write(received, now_s)
            data = bench.wire.read(now_s)
        if data:
            self._last_batch_s = now_s
            self._endpoint.send(data)


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


class TcpEndpoint:
    """Serves one client at a time; the next one waits."""

    def __init__(self, host: str, port: int) -> None:
        """Port 0 picks a free port. Raises OSError, also `socket.gaierror`, if it cannot listen."""
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        self._client: socket.socket | None = None
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._listener.bind(address)
            self._listener.listen(1)
            self._listener.setblocking(False)
        except OSError:
            self._listener.close()
            raise
        self.port: int = self._listener.getsockname()[1]
        shown_host = f"[{host}]" if ":" in host else host
        self.address = f"socket://{shown_host}:{self.port}"
        """A URL that pyserial opens."""

    def close(self) -> None:
        """Idempotent."""
        self._disconnect()
        self._listener.close()

    def files(self) -> list[int]:
        return [(self._client or self._listener).fileno()]

    def host_baud(self) -> int | None:
        """Unknown: a socket has no rate."""
        return None

    def receive(self, ready: list[int]) -> bytes:
        if self.files()[0] not in ready:
            return b""
        if self._client is None:
            with suppress(OSError):
                self._client, _ = self._listener.accept()
                self._client.setblocking(False)
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        try:
            data = self._client.recv(READ_CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._disconnect()
        return data

    def send(self, data: bytes) -> None:
        """Bytes that no client takes are lost."""
        if self._client is None:
            return
        try:
            self._client.send(data)
        except BlockingIOError:
            pass
        except OSError:
            self._disconnect()

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


Endpoint = PtyEndpoint | TcpEndpoint
"""One way for a host to reach the module, open from its making until `close`. `address`: what the host opens; `files`:
what to wait for; `host_baud`: None if unknown; `receive`: b"" for none."""
