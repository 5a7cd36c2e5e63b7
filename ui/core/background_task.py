"""Runs one function in a background thread and delivers its result to the GUI thread."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QObject, Qt, Signal
from shiboken6 import isValid

from app.store.fact_store import Facts, Store, StoreError
from app.text.messages import UserError
from protocol.translatable import marked

Result = TypeVar("Result")


class ExportCancelled(UserError):
    """The file is unchanged."""

    def __init__(self) -> None:
        super().__init__(marked("Cancelled."))


class Running:
    """Progress and cancellation of a running function, for long ones to look at between two steps."""

    def __init__(self) -> None:
        self.share: float | None = None  # 0 … 1; None if unknown
        self.is_requested = True

    def set_progress_or_end(self, share: float) -> None:
        """Set the progress. Raises `ExportCancelled` where it is cancelled."""
        if self.is_cancelled():
            raise ExportCancelled
        self.share = share

    def is_cancelled(self) -> bool:
        return not self.is_requested


class _Post(QObject):
    """Takes results to the window's thread, in which it is made; never deleted. A signal of the task itself would be
    emitted while that thread may be deleting the task with its page: that crashes the program."""

    # A task, its `Running` and the `Future` of its result.
    ended = Signal(object, object, object)

    def __init__(self) -> None:
        super().__init__()
        self.ended.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def _deliver(self, task: "BackgroundTask[Any]", running: Running, future: "Future[Any]") -> None:
        if isValid(task):
            task.take(running, future)


_post = cache(_Post)


class BackgroundTask(QObject, Generic[Result]):
    """Runs one function at a time and passes its result to `then` or `failed`, in the window's thread.

    A second `run` replaces the first, whose result is dropped. The thread is a daemon, so the program does not wait
    for it at exit, unless the task is `finished_at_close`: then it writes its file to the end. One `for_once` is freed
    as soon as its result is there, else it is with its parent.
    """

    def __init__(
        self, name: str, parent: QObject | None = None, *, finished_at_close: bool = False, for_once: bool = False
    ) -> None:
        super().__init__(parent)
        self._name, self._finished_at_close, self._for_once = name, finished_at_close, for_once
        # Of the last `run`.
        self._thread: threading.Thread | None = None
        self._running: Running | None = None
        self._then: Callable[[Result], object] | None = None
        self._failed: Callable[[Exception], object] | None = None
        self._post = _post()

    @property
    def is_running(self) -> bool:
        """A result is still expected."""
        return self._running is not None

    @property
    def share(self) -> float | None:
        return None if self._running is None else self._running.share

    def run(
        self,
        act: Callable[[Running], Result],
        then: Callable[[Result], object],
        failed: Callable[[Exception], object] | None = None,
    ) -> None:
        """Returns at once. `act` touches nothing that belongs to the window's thread. An error is raised in that
        thread, unless `failed` takes it."""
        running, future = self._begin(then, failed), Future[Result]()

        def work() -> None:
            try:
                future.set_result(act(running))
            except Exception as error:  # noqa: BLE001  delivered to the window's thread
                future.set_exception(error)
            self._post.ended.emit(self, running, future)

        self._thread = threading.Thread(target=work, name=self._name, daemon=not self._finished_at_close)
        self._thread.start()

    def run_in(
        self,
        store: Store,
        act: Callable[[Facts], Result],
        then: Callable[[Result], object],
        failed: Callable[[StoreError], object] | None = None,
    ) -> None:
        """Run `act` as one transaction in the store's thread, after what was asked for before; its result comes once
        that is on the disk. It runs even if it is replaced; once the store is closed no result is delivered."""

        def fail(error: Exception) -> None:
            if failed is None or not isinstance(error, StoreError):
                raise error
            failed(error)

        running = self._begin(then, fail)
        store.write(act).add_done_callback(
            lambda written: None if written.cancelled() else self._post.ended.emit(self, running, written)
        )

    def stop(self) -> None:
        """Asks the function to end; its result is still delivered."""
        if self._running is not None:
            self._running.is_requested = False

    def cancel(self) -> None:
        """Ask the function to end and drop its result."""
        self.stop()
        self._running = self._then = self._failed = None

    def close(self) -> None:
        """The window closes: a file is written to the end, and no result is delivered."""
        if self._finished_at_close:
            self._running = None
        self.cancel()

    def wait(self, deadline_s: float) -> bool:
        """Wait for the thread of the last `run`; whether it has ended."""
        if self._thread is not None:
            self._thread.join(deadline_s)
        return self._thread is None or not self._thread.is_alive()

    def _begin(self, then: Callable[[Result], object], failed: Callable[[Exception], object] | None) -> Running:
        self.stop()
        self._running, self._then, self._failed = Running(), then, failed
        return self._running

    def take(self, running: Running, future: "Future[Result]") -> None:
        """Take what has ended, in the window's thread."""
        if self._for_once:
            self.deleteLater()
        if running is not self._running:
            return
        then, failed = self._then, self._failed
        self._running = self._then = self._failed = None
        error = future.exception()
        if error is None:
            if then is not None:
                then(future.result())
        elif failed is not None and isinstance(error, Exception):
            failed(error)
        else:
            raise error
