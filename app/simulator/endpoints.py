"""Serves a simulated module to other processes, in one loop without a thread.

It does so on a pseudo-terminal (Linux and macOS), or on a TCP socket, for pyserial's `socket://` (every platform).
"""

import errno
import os
import select
import socket
import sys
from contextlib import suppress
from pathlib import Path
from threading import Event

from app.simulator.bench import SimulatedBench
from protocol.catalogue import BAUD_RATES

if sys.platform != "win32":
    import termios
    import tty

    _BAUD_RATES = {getattr(termios, f"B{rate}"): rate for rate in BAUD_RATES}

# A signal's handler runs only after the wait, so the wait is short.
LONGEST_WAIT_S = 0.1
CHUNK = 65536


def serve(bench: SimulatedBench, endpoint: "Endpoint", is_stopped: Event) -> None:
    """Serve until the event is set, by any thread or the handler of a signal."""
    wait_s = 0.0
    while not is_stopped.is_set():
        ready, _, _ = select.select([endpoint], [], [], wait_s)
        received = endpoint.receive() if ready else b""
        with bench.lock:
            now_s = bench.clock()
            bench.wire.host_baud = endpoint.host_baud()
            if received:
                bench.wire.write(received, now_s)
            data = bench.wire.read(now_s)
            due_s = bench.wire.next_due(now_s)
        if data:
            endpoint.send(data)
        wait_s = min(LONGEST_WAIT_S, due_s - now_s)


class PtyEndpoint:
    """A pseudo-terminal, with an optional symbolic link to it."""

    def __init__(self, link: Path | None) -> None:
        """Raises OSError where there is no pseudo-terminal, or something else stands in the place of the link."""
        if link is not None and link.exists() and not link.is_symlink():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
        # The slave stays open: to read the master fails while nobody has it open.
        self._master, self._slave = os.openpty()
        self.address = os.ttyname(self._slave)
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._link = link
        if link is not None:
            link.unlink(missing_ok=True)
            link.symlink_to(self.address)

    def fileno(self) -> int:
        return self._master

    def host_baud(self) -> int | None:
        return _BAUD_RATES.get(termios.tcgetattr(self._master)[4])

    def receive(self) -> bytes:
        with suppress(OSError):  # nothing is there after all
            return os.read(self._master, CHUNK)
        return b""

    def send(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        if self._link is not None and self._link.is_symlink() and str(self._link.readlink()) == self.address:
            self._link.unlink()
        os.close(self._master)
        os.close(self._slave)


class TcpEndpoint:
    """Serves one client at a time; the next one waits."""

    def __init__(self, host: str, port: int) -> None:
        """Port 0 is any free one. Raises OSError, also `socket.gaierror`, where it cannot listen."""
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._listener = socket.create_server((host, port), family=family, backlog=1)
        self._listener.setblocking(False)
        self._client: socket.socket | None = None
        self.port: int = self._listener.getsockname()[1]
        self.address = f"socket://[{host}]:{self.port}" if ":" in host else f"socket://{host}:{self.port}"

    def fileno(self) -> int:
        return (self._client or self._listener).fileno()

    def host_baud(self) -> int | None:
        return None

    def receive(self) -> bytes:
        data = b""
        with suppress(OSError):
            if self._client is None:
                self._client, _ = self._listener.accept()
                self._client.setblocking(False)
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return b""
            data = self._client.recv(CHUNK)
        if not data:
            self._disconnect()
        return data

    def send(self, data: bytes) -> None:
        with suppress(OSError):  # it does not read, or has left, which receiving finds out
            if self._client is not None:
                self._client.send(data)

    def close(self) -> None:
        self._disconnect()
        self._listener.close()

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


# A way for a host to reach the module, from its making until `close`. `address` is what the host opens, `fileno` what
# to wait for; `host_baud` is None where the rate is unknown. What the host does not take of `send` is lost.
Endpoint = PtyEndpoint | TcpEndpoint
