"""Runs work on the store without blocking the window."""

import logging
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Qt, Signal

from app.store.store import Store

_log = logging.getLogger(__name__)
Result = TypeVar("Result")


class StoreWork(QObject):
    """Runs it in the store's own thread, and hands the finished future to `then` in the window's thread.

    Once the store is closed `then` is not called any more.
    """

    _ended = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._ended.connect(self._take, Qt.ConnectionType.QueuedConnection)

    def run(self, store: Store, work: Callable[[], Result], then: Callable[["Future[Result]"], None]) -> None:
        """Returns at once. `work` touches nothing that belongs to the window's thread."""
        store.queue.submit(work).add_done_callback(partial(self._emit, then))

    def _emit(self, then: Callable[[Any], None], future: "Future[Any]") -> None:
        """In the store's thread."""
        if future.cancelled():
            return
        try:
            self._ended.emit((then, future))
        except RuntimeError:  # the window went away meanwhile, and this object with it
            _log.debug("Work on the store ended after the window had closed")

    def _take(self, ended: tuple[Callable[[Any], None], "Future[Any]"]) -> None:
        then, future = ended
        then(future)
