"""Runs one function in a background thread and delivers its result to the GUI thread."""

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Qt, Signal

_log = logging.getLogger(__name__)
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class _Ended:
    number: int
    result: object
    error: Exception | None


class BackgroundTask(QObject, Generic[Result]):
    """Runs one function at a time and hands what came of it to `then` or `failed`, in the window's thread.

    A second `run` replaces the first: what comes of that is dropped. The function is given `is_wanted`, to look at
    between two steps where it takes long. The thread is a daemon: nothing waits for it when the program ends.
    """

    _ended = Signal(object)

    def __init__(self, name: str, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._name = name
        self._number = 0
        self._is_running = False
        self._then: Callable[[Result], None] | None = None
        self._failed: Callable[[Exception], None] | None = None
        self._ended.connect(self._take, Qt.ConnectionType.QueuedConnection)

    @property
    def is_running(self) -> bool:
        """Somebody still waits for a result."""
        return self._is_running

    def run(
        self,
        act: Callable[[Callable[[], bool]], Result],
        then: Callable[[Result], None],
        failed: Callable[[Exception], None],
    ) -> None:
        """Returns at once. `act` touches nothing that belongs to the window's thread."""
        self._number += 1
        self._is_running, self._then, self._failed = True, then, failed
        number = self._number
        threading.Thread(target=self._work, args=(number, act), name=self._name, daemon=True).start()

    def cancel(self) -> None:
        """Nobody wants the result any more."""
        self._number += 1
        self._is_running = False
        self._then = self._failed = None

    def _work(self, number: int, act: Callable[[Callable[[], bool]], Result]) -> None:
        try:
            ended = _Ended(number, act(lambda: number == self._number), None)
        except Exception as error:  # noqa: BLE001  told in the window; a thread has nobody else to tell
            ended = _Ended(number, None, error)
        try:
            self._ended.emit(ended)
        except RuntimeError:  # the window went away meanwhile, and this object with it
            _log.debug("%s ended after the window had closed", self._name)

    def _take(self, ended: _Ended) -> None:
        if ended.number != self._number:
            return
        then, failed = self._then, self._failed
        self.cancel()
        if ended.error is not None:
            if failed is not None:
                failed(ended.error)
        elif then is not None:
            then(ended.result)  # type: ignore[arg-type]  # what `act` of the same `run` returned
