"""Serves a simulated module to other processes through one endpoint.

One loop, no thread. It wakes up for bytes of the host, bytes that are due, and `stop`.
"""

import math
import select
import socket
from contextlib import suppress
from typing import Protocol

from app.simulator.bench import SimulatedBench

BATCH_S = 0.004
"""In a fast stream several frames are written at once: waking up for each takes a tenth of a core."""
QUICK_HZ = 200.0
READ_CHUNK = 65536


class Endpoint(Protocol):
    """One way for a host to reach the module, open from its making until `close`."""

    address: str
    """What the host opens."""

    def files(self) -> list[int]:
        """File descriptors to wait for."""

    def host_baud(self) -> int | None:
        """Baud rate of the host, None if unknown."""

    def receive(self, ready: list[int]) -> bytes:
        """Bytes from the host, b"" for none."""

    def send(self, data: bytes) -> None:
        """Send bytes to the host; lost if it does not read them."""

    def close(self) -> None:
        """Make it unreachable, also for a host that has it open."""


class Loop:
    """Serves until `stop`, which any thread and any signal handler may call."""

    def __init__(self, bench: SimulatedBench, endpoint: Endpoint) -> None:
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
        """Serve until stopped."""
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

    def _timeout_s(self) -> float | None:
        bench = self._bench
        with bench.changed:
            now_s = bench.clock()
            due_s = bench.wire.next_due(now_s)
            if due_s is None:
                return None
            if bench.module.is_streaming and bench.module.setup.rate > QUICK_HZ:
                due_s = max(due_s, self._last_batch_s + BATCH_S)
            return max(0.0, due_s - now_s)

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
