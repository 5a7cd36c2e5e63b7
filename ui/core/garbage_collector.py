"""Runs Python's garbage collection in the GUI thread only.

Python collects garbage in whatever thread happens to make the next object. Where the garbage holds objects of Qt (a
dialog that was closed, a model that was replaced), a worker would then free them in its own thread, beneath the
window's feet, and the process ends without a word. So the automatic collection is off while the window runs, and a
timer of the window's thread does the same work by the same rule: Python's own counts and thresholds (module `gc`).
"""

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from PySide6.QtCore import QObject, QTimer

POLL_EVERY_MS: Final = 200


class GarbageCollector(QObject):
    """Collects from `begin` to `end`, both called in the thread it was made in. One in a process at a time."""

    def __init__(self) -> None:
        super().__init__()
        self._was_enabled = False
        self._timer = QTimer(self, interval=POLL_EVERY_MS)
        self._timer.timeout.connect(self.collect)

    def begin(self) -> None:
        self._was_enabled = gc.isenabled()
        gc.disable()
        self._timer.start()

    def end(self) -> None:
        """Python collects by itself again, if it did before."""
        self._timer.stop()
        if self._was_enabled:
            gc.enable()

    def collect(self) -> None:
        """The oldest generation that is due, as Python would choose it; nothing where none is."""
        due = [
            generation
            for generation, (count, threshold) in enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True))
            if threshold and count > threshold
        ]
        if due:
            gc.collect(due[-1])


@contextmanager
def garbage_freed_here() -> Iterator[None]:
    """While this lasts, garbage is freed by this thread's event loop and nowhere else; raises RuntimeError in any
    thread but the main one, where the window's objects live."""
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError("the window's garbage is freed in the main thread")
    collector = GarbageCollector()
    collector.begin()
    try:
        yield
    finally:
        collector.end()
