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

from PySide6.QtCore import QTimer

POLL_EVERY_MS: Final = 200


def collect_due() -> None:
    """Collects the oldest generation that is due, as Python would choose it; nothing where none is."""
    counted = enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True))
    due = [generation for generation, (count, threshold) in counted if threshold and count > threshold]
    if due:
        gc.collect(due[-1])


@contextmanager
def garbage_freed_here() -> Iterator[None]:
    """While this lasts, garbage is freed by this thread's event loop and nowhere else; raises RuntimeError in any
    thread but the main one, where the window's objects live."""
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError("the window's garbage is freed in the main thread")
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
