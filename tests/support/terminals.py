"""A pseudo-terminal in a test's hands, and how long closing may take."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

from protocol.messages import Status

CLOSING_S = 0.5
MACHINE_S = 0.25
"""What a busy machine adds."""
MOST_FILES = 128
STATUS_FRAME = Status(5, 1.0, triggered=False, active=False).encode()


class Terminal:
    """A pseudo-terminal whose other end the test holds."""

    def __init__(self) -> None:
        import tty  # POSIX

        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        os.set_blocking(self.master, False)
        self._is_open = True

    def send(self, data: bytes) -> None:
        os.write(self.master, data)

    def hang_up(self) -> None:
        if self._is_open:
            self._is_open = False
            os.close(self.master)
            os.close(self._slave)

    def choke(self) -> None:
        """Nobody reads, and the driver's buffer is full."""
        os.set_blocking(self._slave, False)
        while True:
            try:
                os.write(self._slave, b"\x00" * 1024)
            except BlockingIOError:
                return


@contextmanager
def in_time(limit_s: float = CLOSING_S) -> Iterator[None]:
    start_s = time.monotonic()
    yield
    took_s = time.monotonic() - start_s
    assert took_s < limit_s + MACHINE_S, f"took {took_s:.2f} s"


@contextmanager
def taken(name: str) -> Iterator[None]:
    """A pseudo-terminal has this name, so that it is not free for a module that is plugged in again."""
    files: list[int] = []
    try:
        while name not in [os.ttyname(file) for file in files[1::2]]:
            assert len(files) < MOST_FILES, f"{name} is not free"
            files.extend(os.openpty())
        yield
    finally:
        for file in files:
            os.close(file)
