"""The program's window in a process of its own, and what is measured of it."""

import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication, QWidget

from app.engine.worker import Batch
from protocol.catalogue import STATUS
from protocol.events import Received, Role, Sent
from protocol.frame import Direction, Frame
from protocol.messages import Status
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import Assembly, WindowOptions, assemble, collecting_garbage
from ui.pages.diagnosis.traffic import MAX_ROWS
from ui.services.storage import Storage

BEAT_MS: Final = 5
"""Period of the timer that watches the event loop."""
WARM_UP_S: Final = 1.5
LIMIT_S: Final = 15.0
THREAD_LIMIT_S: Final = 3.0


@dataclass
class Traffic:
    """Counts what the worker delivers."""

    statuses: int = 0
    samples: int = 0
    asked: int = 0
    """Status queries, each of which is answered by one more frame."""

    def on_batch(self, batch: Batch) -> None:
        self.samples += len(batch.samples)
        for event in batch.events:
            self.statuses += isinstance(event, Received) and isinstance(event.message, Status)
            self.asked += isinstance(event, Sent) and event.request == STATUS.query()


@dataclass
class LoopWatch:
    """Measures the longest delay of a timer of the event loop, in seconds."""

    longest_s: float = 0.0
    is_measuring: bool = False
    _beat_at: float = 0.0

    def timer(self) -> QTimer:
        """What measures the delay, once it is started."""
        beats = QTimer(interval=BEAT_MS, timerType=Qt.TimerType.PreciseTimer)
        beats.timeout.connect(self.beat)
        return beats

    def beat(self) -> None:
        now = time.perf_counter()
        if self.is_measuring and self._beat_at:
            self.longest_s = max(self.longest_s, now - self._beat_at - BEAT_MS / 1000)
        self._beat_at = now


def turn_until(is_done: Any, limit_s: float) -> bool:
    """Run the event loop until `is_done()`, polled every 20 ms; return whether it was within `limit_s`."""
    deadline = time.monotonic() + limit_s
    while not is_done() and time.monotonic() < deadline:
        turn_for(0.02)
    return bool(is_done())


def turn_for(seconds: float) -> None:
    """Run the event loop."""
    loop = QEventLoop()
    QTimer.singleShot(round(seconds * 1000), loop.quit)
    loop.exec()


@contextmanager
def window_apart(options: WindowOptions, watcher: PortWatcher | None = None) -> Iterator[tuple[QApplication, Assembly]]:
    """A window with preferences and store in a folder of its own: the user's are not changed."""
    app = QApplication(sys.argv[:1])
    # A recorder that a busy disk keeps may still write when the window is gone.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        preferences, storage = Preferences(folder / "window.ini"), Storage(folder / "store")
        assembly = assemble(app, options, preferences=preferences, storage=storage, watcher=watcher)
        try:
            with collecting_garbage(assembly):
                yield app, assembly
        finally:
            assembly.window.close_now()
            assembly.ports.stop(THREAD_LIMIT_S)
            assembly.watcher.stop(THREAD_LIMIT_S)
            storage.close()
            app.processEvents()


def live_page(assembly: Assembly) -> Any:
    """The Live page, after it is made."""
    return assembly.window.findChild(QWidget, "live_page")


def reserve(page: Any) -> None:
    """Reserve all memory of the series now, so that further growth is a leak."""
    data = page.data
    for series in (data.tilt, data.acceleration, data.cell, data.light, data._flags):
        for column in series._memory:
            column.fill(0)


def fill_capture(page: Any) -> None:
    """The same for the traffic of the Diagnosis page."""
    frame = Frame(Direction.MODULE_TO_HOST, Status(5, 1.0, triggered=False, active=False).encode())
    page.traffic.model.append([Received(frame, None, Role.STREAMED, n / 1440) for n in range(MAX_ROWS)])


def resident_mb() -> float:
    """Resident memory of this process (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
