"""The worker's threads and Qt: batches delivered to the window's thread, and garbage collected in that thread only.

Python collects garbage in whatever thread happens to make the next object. Where the garbage holds objects of Qt (a
dialog that was closed, a model that was replaced), a worker would then free them in its own thread, beneath the
window's feet, and the process ends without a word. So the automatic collection is off while the window runs, and a
timer of the window's thread does the same work by the same rule: Python's own counts and thresholds (module `gc`).
"""

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from threading import Lock
from typing import Final

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from app.engine.worker import Batch


class Bridge(QObject):
    """Passes the worker's batches to the window's thread: one batch for each turn of its event loop,
    connection and conversation.

    After a stall the window gets a single batch with every sample and event since: waiting batches are joined, never
    dropped, and the event queue never fills up.
    """

    batch = Signal(object)  # A `Batch`, in the window's thread
    _delivered = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._lock = Lock()
        self._waiting: list[Batch] = []
        self._is_closed = False
        self._delivered.connect(self._emit, Qt.ConnectionType.QueuedConnection)

    def deliver(self, batch: Batch) -> None:
        """The worker's callback; called from its thread."""
        with self._lock:
            if self._is_closed:
                return
            self._waiting.append(batch)
            if len(self._waiting) == 1:
                # Under the lock, so that `close` cannot return while the signal is on its way out.
                self._delivered.emit()

    def close(self) -> None:
        """Pass nothing on from now; waiting batches are dropped because the window closes."""
        with self._lock:
            self._is_closed = True
            self._waiting.clear()

    def _emit(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        # Nothing of one port or conversation is joined with that of the next one.
        for _of, batches in groupby(waiting, key=lambda batch: (batch.connection, batch.conversation.number)):
            first, *later = batches
            whole = first
            if later:  # everything that happened, oldest first, and the latest state
                whole = later[-1]._replace(
                    samples=tuple(sample for batch in (first, *later) for sample in batch.samples),
                    events=tuple(event for batch in (first, *later) for event in batch.events),
                    finished=tuple(job for batch in (first, *later) for job in batch.finished),
                )
            self.batch.emit(whole)


POLL_EVERY_MS: Final = 200


@contextmanager
def garbage_freed_here() -> Iterator[None]:
    """While this lasts, garbage is freed by this thread's event loop and nowhere else; raises RuntimeError in any
    thread but the main one, where the window's objects live."""
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError("the window's garbage is freed in the main thread")

    def collect_due() -> None:
        """The oldest generation that is due, as Python would choose it."""
        counted = enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True))
        due = [generation for generation, (count, threshold) in counted if threshold and count > threshold]
        if due:
            gc.collect(due[-1])

    was_enabled = gc.isenabled()
    gc.disable()
    timer = QTimer(interval=POLL_EVERY_MS)
    timer.timeout.connect(collect_due)
    timer.start()
    try:
        yield
    finally:
        timer.stop()
        if was_enabled:
            gc.enable()
