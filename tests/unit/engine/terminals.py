"""A pseudo-terminal; a worker's batches, of which a test waits for one."""

import os
import threading
import time
from collections.abc import Callable

from app.engine.worker import Batch
from protocol.messages import Status
from tests.support.patience import PATIENCE_S

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


class Batches:
    """A worker's callback; `until` waits for a batch since `mark`."""

    def __init__(self) -> None:
        self.all: list[Batch] = []
        self._first = 0
        self._came = threading.Condition()

    def __call__(self, batch: Batch) -> None:
        with self._came:
            self.all.append(batch)
            self._came.notify_all()

    @property
    def last(self) -> Batch | None:
        return self.all[-1] if self.all else None

    def mark(self) -> None:
        with self._came:
            self._first = len(self.all)

    def until(
        self,
        is_enough: Callable[[Batch], bool],
        *,
        limit_s: float = PATIENCE_S,
    ) -> Batch:
        """Return the first batch since `mark` that is enough."""
        end_s = time.monotonic() + limit_s
        seen = self._first
        while time.monotonic() < end_s:
            with self._came:
                if len(self.all) == seen:
                    self._came.wait(0.05)
                news, seen = self.all[seen:], len(self.all)
            for batch in news:
                if is_enough(batch):
                    return batch
        reports, last = sum(len(batch.samples) for batch in self.all), self.last and self.last.connection
        raise AssertionError(f"it did not happen in time: {reports} reports in {len(self.all)} batches, then {last}")
