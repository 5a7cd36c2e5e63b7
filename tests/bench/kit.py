"""A row of results, a measurement in a process of its own, and the program's window with what is measured of it."""

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple

from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication

from tests.support.processes import ran
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import Assembly, WindowOptions, assemble, collecting_garbage
from ui.services.storage import Storage

LIMIT_S: Final = 15.0
WARM_UP_S: Final = 1.5
_BEAT_MS: Final = 5
_THREAD_LIMIT_S: Final = 3.0


class Figure(NamedTuple):
    """`is_met` is None if there is no aim."""

    name: str
    measured: str
    aim: str = ""
    is_met: bool | None = None

    @property
    def row(self) -> str:
        """As Markdown, which docs/performance.md is written in."""
        verdict = "" if self.is_met is None else "met" if self.is_met else "MISSED"
        return f"| {self.name} | {self.measured} | {self.aim} | {verdict} |"


def at_most(name: str, value: float, aim: float, form: str) -> Figure:
    """`form`: how a value is written."""
    return Figure(name, form.format(value), f"<= {form.format(aim)}", value <= aim)


def apart(program: str, *words: object) -> Any:
    """Return what `python -m tests.bench.PROGRAM words…` prints as JSON: no measurement influences the next."""
    done = ran(sys.executable, "-m", f"tests.bench.{program}", *words, QT_QPA_PLATFORM="offscreen")
    if done.returncode or not done.stdout:
        raise RuntimeError(f"{program} failed:\n{done.stderr[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


# The window


def turn_for(seconds: float) -> None:
    """Run the event loop."""
    loop = QEventLoop()
    QTimer.singleShot(round(seconds * 1000), loop.quit)
    loop.exec()


def turn_until(is_done: Callable[[], object], limit_s: float = LIMIT_S) -> bool:
    """Run the event loop until `is_done()`; return whether it was within `limit_s`."""
    deadline = time.monotonic() + limit_s
    while not is_done() and time.monotonic() < deadline:
        turn_for(0.02)
    return bool(is_done())


@contextmanager
def window_apart(options: WindowOptions, watcher: PortWatcher | None = None) -> Iterator[Assembly]:
    """A window with preferences and store in a folder of its own: the user's are not changed."""
    app = QApplication(sys.argv[:1])
    # A recorder that a busy disk keeps may still write when the window is gone.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        preferences, storage = Preferences(Path(name) / "window.ini"), Storage(Path(name) / "store")
        assembly = assemble(app, options, preferences=preferences, storage=storage, watcher=watcher)
        try:
            with collecting_garbage(assembly):
                yield assembly
        finally:
            assembly.window.close_now()
            assembly.ports.stop(_THREAD_LIMIT_S)
            assembly.watcher.stop(_THREAD_LIMIT_S)
            storage.close()
            app.processEvents()


class LoopWatch(QTimer):
    """Measures the longest delay of a timer of the event loop, once it is started."""

    def __init__(self) -> None:
        super().__init__(interval=_BEAT_MS, timerType=Qt.TimerType.PreciseTimer)
        self.longest_s = 0.0
        self._beat_at = 0.0
        self.timeout.connect(self._beat)

    def _beat(self) -> None:
        now = time.perf_counter()
        if self._beat_at:
            self.longest_s = max(self.longest_s, now - self._beat_at - _BEAT_MS / 1000)
        self._beat_at = now


def resident_mb() -> float:
    """Return the resident memory of this process (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
