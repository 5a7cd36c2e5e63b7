"""Runs one function in a background thread and delivers its result to the GUI thread."""

import logging
import threading
from collections.abc import Callable
from functools import partial
from typing import Generic, NamedTuple, TypeVar

from PySide6.QtCore import QObject, Qt, Signal

from app.store.database import StoreTrouble
from app.store.write_queue import WriteQueue

_log = logging.getLogger(__name__)
Result = TypeVar("Result")


class Running:
    """What a function in the background tells of itself, and what it is told."""

    def __init__(self) -> None:
        self.share: float | None = None
        self.is_wanted = True

    def tell(self, share: float) -> None:
        """How much is done, 0 … 1."""
        self.share = share

    def is_cancelled(self) -> bool:
        """Looked at between two steps by what takes long."""
        return not self.is_wanted


class _Ended(NamedTuple):
    running: Running
    result: object
    error: Exception | None


class BackgroundTask(QObject, Generic[Result]):
    """Runs one function at a time and hands what came of it to `then` or `failed`, in the window's thread.

    A second `run` replaces the first: what comes of that is dropped. The thread is a daemon: nothing waits for it when
    the program ends. Not where the task is `finished_at_close`: what it writes is written to its end.
    """

    _ended = Signal(object)

    def __init__(self, name: str, parent: QObject | None = None, *, finished_at_close: bool = False) -> None:
        super().__init__(parent)
        self._name, self._finished_at_close = name, finished_at_close
        self._running: Running | None = None
        self._then: Callable[[Result], object] | None = None
        self._failed: Callable[[Exception], object] | None = None
        self._ended.connect(self._take, Qt.ConnectionType.QueuedConnection)

    @property
    def is_running(self) -> bool:
        """Somebody still waits for a result."""
        return self._running is not None

    @property
    def share(self) -> float | None:
        """How much is done, 0 … 1; None where nobody can tell."""
        return None if self._running is None else self._running.share

    def run(
        self,
        act: Callable[[Running], Result],
        then: Callable[[Result], object],
        failed: Callable[[Exception], object],
    ) -> None:
        """Returns at once. `act` touches nothing that belongs to the window's thread."""
        running = self._begin(then, failed)
        work = partial(self._work, running, partial(act, running))
        threading.Thread(target=work, name=self._name, daemon=not self._finished_at_close).start()

    def run_in(
        self,
        queue: WriteQueue,
        act: Callable[[], Result],
        then: Callable[[Result], object],
        failed: Callable[[StoreTrouble], object] | None = None,
    ) -> None:
        """As `run`, in the store's own thread behind what was handed over before. It is done even if it is replaced;
        once the store is closed nothing is told any more."""

        def fail(error: Exception) -> None:
            if failed is None or not isinstance(error, StoreTrouble):
                raise error
            failed(error)

        queue.submit(partial(self._work, self._begin(then, fail), act))

    def stop(self) -> None:
        """The function is to end; what comes of it is told as ever."""
        if self._running is not None:
            self._running.is_wanted = False

    def cancel(self) -> None:
        """Nobody wants the result any more."""
        self.stop()
        self._forget()

    def close(self) -> None:
        """The window goes."""
        if not self._finished_at_close:
            self.stop()
        self._forget()

    def _begin(self, then: Callable[[Result], object], failed: Callable[[Exception], object]) -> Running:
        self.stop()
        self._running, self._then, self._failed = Running(), then, failed
        return self._running

    def _forget(self) -> None:
        self._running = self._then = self._failed = None

    def _work(self, running: Running, act: Callable[[], Result]) -> None:
        try:
            ended = _Ended(running, act(), None)
        except Exception as error:  # noqa: BLE001  told in the window; a thread has nobody else to tell
            ended = _Ended(running, None, error)
        try:
            self._ended.emit(ended)
        except RuntimeError:  # the window went away meanwhile, and this object with it
            _log.debug("%s ended after the window had closed", self._name)

    def _take(self, ended: _Ended) -> None:
        if ended.running is not self._running:
            return
        then, failed = self._then, self._failed
        self._forget()
        if ended.error is not None:
            if failed is not None:
                failed(ended.error)
        elif then is not None:
            then(ended.result)  # type: ignore[arg-type]  # what `act` of the same `run` returned
