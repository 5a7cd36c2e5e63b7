"""Measures the program's window in its own process and prints one JSON object.

    python -m tests.benchmarks.window.window PORT SECONDS [--watch WINDOW_S]

Connects to PORT, waits for the stream, measures for SECONDS, and disconnects. With `--watch` it also times the draws
and the event loop, on a full time line of that length.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QApplication, QWidget

from app.engine.worker import Batch, PortState
from protocol.catalogue import STATUS
from protocol.events import Event, Received, Role, Sent
from protocol.frame import Direction, Frame
from protocol.messages import Status
from tests.benchmarks.figures import Durations, quantile
from ui.core.preferences import Preferences
from ui.main import Assembly, WindowOptions, assemble, collecting_garbage, start
from ui.services.storage import Storage

BEAT_MS: Final = 5
"""Period of the timer that watches the event loop."""
WARM_UP_S: Final = 1.5
SETTLE_S: Final = 0.3
"""Wait for the page's next draw."""
LIMIT_S: Final = 15.0
LINE_HZ: Final = 1440


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
            self._count(event)

    def _count(self, event: Event) -> None:
        if isinstance(event, Received):
            self.statuses += isinstance(event.message, Status)
        elif isinstance(event, Sent) and event.request == STATUS.query():
            self.asked += 1


@dataclass
class LoopWatch:
    """Measures the delay of a timer of the event loop and the time of each draw, in seconds."""

    late: Durations = field(default_factory=Durations)
    draws_s: list[float] = field(default_factory=list)
    is_measuring: bool = False
    _beat_at: float = 0.0
    _drawn_s: float = 0.0

    def timer(self) -> QTimer:
        """What measures the delay, once it is started."""
        beats = QTimer(interval=BEAT_MS, timerType=Qt.TimerType.PreciseTimer)
        beats.timeout.connect(self.beat)
        return beats

    def beat(self) -> None:
        now = time.perf_counter()
        if self.is_measuring and self._beat_at:
            self.late.add(max(0.0, now - self._beat_at - BEAT_MS / 1000))
        self._beat_at = now

    def follow(self, page: Any) -> None:
        """Time a refresh of the page's plots and the following paint as one draw."""
        draw, paint = page.plot.draw, page.plot._view.paintEvent

        def timed_draw(now_s: float) -> None:
            began = time.perf_counter()
            draw(now_s)
            self._drawn_s += time.perf_counter() - began

        def timed_paint(event: QPaintEvent) -> None:
            began = time.perf_counter()
            paint(event)
            if self.is_measuring and self._drawn_s:
                self.draws_s.append(self._drawn_s + time.perf_counter() - began)
            self._drawn_s = 0.0

        page.plot.draw = timed_draw
        page.plot._view.paintEvent = timed_paint


def turn_until(is_done: Any, limit_s: float) -> bool:
    """Run the event loop until `is_done()`, polled every 20 ms; return whether it was within `limit_s`."""
    loop = QEventLoop()
    deadline = time.monotonic() + limit_s
    timer = QTimer()
    timer.setInterval(20)
    timer.timeout.connect(lambda: loop.quit() if is_done() or time.monotonic() > deadline else None)
    timer.start()
    loop.exec()
    return bool(is_done())


def turn_for(seconds: float) -> None:
    """Run the event loop."""
    loop = QEventLoop()
    QTimer.singleShot(round(seconds * 1000), loop.quit)
    loop.exec()


@contextmanager
def window_apart(options: WindowOptions, store: Path | None = None) -> Iterator[tuple[QApplication, Assembly]]:
    """A window with preferences and store (unless `store`) in a folder of its own: the user's are not changed."""
    app = QApplication(sys.argv[:1])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        preferences, storage = Preferences(folder / "window.ini"), Storage(store or folder / "store")
        assembly = assemble(app, options, preferences=preferences, storage=storage)
        try:
            with collecting_garbage(assembly):
                yield app, assembly
        finally:
            assembly.window.close_now()
            assembly.connector.stop(2.0)
            storage.close()
            app.processEvents()


@contextmanager
def window_with_pages(options: WindowOptions) -> Iterator[tuple[QApplication, Assembly]]:
    """The same, started and with all its pages."""
    with window_apart(options) as (app, assembly):
        made: list[bool] = []
        assembly.window.pages_made.connect(lambda: made.append(True))
        start(assembly, options)
        if not turn_until(lambda: bool(made), 4 * LIMIT_S):
            raise RuntimeError("the pages were not made")
        yield app, assembly


def live_page(assembly: Assembly) -> Any:
    """The Live page, after it is made."""
    return assembly.window.findChild(QWidget, "live_page")


def reserve(page: Any) -> None:
    """Reserve the series' memory for ten hours now, so that further growth is a leak."""
    data = page.data
    for series in (data.tilt, data.acceleration, data.cell, data.light, data._flags):
        for column in (*series._exact._columns, *series._summary._columns):
            column.fill(0)


def fill_capture(page: Any) -> None:
    """The same for the traffic buffer of the Diagnosis page."""
    frame = Frame(Direction.MODULE_TO_HOST, Status(5, 1.0, triggered=False, active=False).encode())
    at_s = 0.0
    while not page.traffic_buffer.has_dropped:
        page.traffic_buffer.feed([Received(frame, None, Role.STREAMED, at_s)] * 10)
        at_s += 1 / 144


def resident_mb() -> float:
    """Resident memory of this process (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def fill(page: Any, length_s: float) -> None:
    """Fill as if it had been streaming at line rate for `length_s` until now, with noise."""
    source = np.random.default_rng(1)
    count = int(length_s * LINE_HZ)
    now_s = time.monotonic()
    times = np.linspace(now_s - length_s, now_s - 0.1, count)
    page.data.tilt.append(times, np.round(40 + 30 * np.sin(times / 3) + source.normal(0, 2, count)))
    page.data.acceleration.append(times, np.round(1 + source.normal(0, 0.1, count), 1))
    page.data._flags.append(times, np.zeros(count))


def measure(port: str, seconds: float, watched_s: float | None) -> dict[str, object]:
    """All results by name; times in seconds."""
    traffic, watch = Traffic(), LoopWatch()
    options = WindowOptions(port=port, language="en", offscreen_seconds=seconds)
    with window_apart(options) as (_app, assembly):
        connector = assembly.connector
        connector.batch.connect(traffic.on_batch)
        start(assembly, options)
        beats = watch.timer()
        if watched_s is not None:
            turn_until(lambda: live_page(assembly) is not None, LIMIT_S)
            fill(live_page(assembly), watched_s)
            live_page(assembly).plot.choose_window(watched_s)
            watch.follow(live_page(assembly))
            beats.start()
        is_streaming = turn_until(lambda: connector.device.is_streaming, LIMIT_S)
        turn_for(WARM_UP_S)
        before, began, cpu = traffic.samples, time.perf_counter(), time.process_time()
        watch.is_measuring = True
        turn_for(seconds)
        watch.is_measuring = False
        cpu_s, wall_s = time.process_time() - cpu, time.perf_counter() - began
        measured = traffic.samples - before
        connector.disconnect_port()
        is_closed = turn_until(lambda: connector.connection.state is PortState.CLOSED, LIMIT_S)
        turn_for(SETTLE_S)
        kept = len(live_page(assembly).data.tilt) if watched_s is None else None
    found: dict[str, object] = {
        "is_streaming": is_streaming, "is_closed": is_closed, "cpu_share": cpu_s / wall_s,
        "rate_hz": measured / wall_s, "statuses": traffic.statuses, "asked": traffic.asked,
        "samples": traffic.samples, "kept": kept,
    }  # fmt: skip
    if watch.draws_s:
        found |= {
            "draws": len(watch.draws_s), "draw_median_s": quantile(watch.draws_s, 0.5),
            "draw_p99_s": quantile(watch.draws_s, 0.99), "draw_longest_s": max(watch.draws_s),
            "beat_p99_s": watch.late.quantile_s(0.99), "stall_s": watch.late.longest_s,
        }  # fmt: skip
    return found


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description="Measure the window from inside.")
    parser.add_argument("port")
    parser.add_argument("seconds", type=float)
    parser.add_argument("--watch", type=float, metavar="WINDOW_S")
    args = parser.parse_args()
    print(json.dumps(measure(args.port, args.seconds, args.watch)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
