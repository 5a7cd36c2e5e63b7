"""Writer thread of the store, so that neither the port nor the window waits for the disk.

Work is done in the order of submission. Each piece has a `Future`; its data is on disk once that is done without an
exception.
"""

import logging
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

_log = logging.getLogger(__name__)
Result = TypeVar("Result")


class WriteQueue:
    """Any thread may call. The thread starts with the first piece of work and is a daemon, so a disk that never answers
    does not keep the program from exiting."""

    def __init__(self) -> None:
        self._work: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._is_closed = False
        self._left = 0

    def submit(self, work: Callable[[], Result]) -> "Future[Result]":
        """Returns at once. After `close` the future is cancelled."""
        future: Future[Result] = Future()
        with self._lock:
            if self._is_closed:
                future.cancel()
                return future
            self._left += 1
            self._work.put((work, future))
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="dps-s store", daemon=True)
                self._thread.start()
        return future

    def close(self, limit_s: float, finish: Callable[[], None] = lambda: None) -> int:
        """Wait at most `limit_s` for the queued work; returns how many pieces were not written by then. `finish` runs
        after the last one, even if that is after the limit. Idempotent."""
        with self._lock:
            was_closed, self._is_closed = self._is_closed, True
            thread = self._thread
            if thread is not None and not was_closed:
                self._work.put((finish, Future()))
                self._work.put(None)
        if thread is None:
            finish()
            return 0
        thread.join(limit_s)
        with self._lock:
            return self._left

    def _run(self) -> None:
        while (item := self._work.get()) is not None:
            work, future = item
            if future.set_running_or_notify_cancel():
                try:
                    result = work()
                except Exception as error:  # noqa: BLE001  passed to the caller by the future
                    future.set_exception(error)
                else:
                    future.set_result(result)
            with self._lock:
                self._left = max(0, self._left - 1)
