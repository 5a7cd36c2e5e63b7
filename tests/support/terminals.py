"""A pseudo-terminal for tests; limits of closing and returning."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from protocol.messages import Status
from tests.support.patience import PATIENCE_S

CLOSING_S = 0.5
STATUS_FRAME = Status(5, 1.0, triggered=False, active=False).encode()


class Terminal:
    """A pseudo-terminal; `name` is the port to open, `master` the other end."""

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


@contextmanager
def taken(name: str) -> Iterator[None]:
    """Keep a pseudo-terminal of this name open, so that no new one gets the name."""
    files: list[int] = []
    try:
        end_s = time.monotonic() + PATIENCE_S
        while not files or os.ttyname(files[-1]) != name:
            if Path(name).exists():  # another test has it for the time being
                assert time.monotonic() < end_s, f"{name} is not free"
                time.sleep(0.05)
            else:
                files.extend(os.openpty())
        yield
    finally:
        for file in files:
            os.close(file)
