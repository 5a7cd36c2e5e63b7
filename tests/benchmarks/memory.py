"""Memory of the window after ten hours at line rate, and its further growth.

The plots' buffers for ten hours are filled before. In use they grow by about 1.6 MB an hour for the first twelve hours.

    python -m tests.benchmarks.memory HOURS FULL_S

simulates the hours in the window and prints its memory as JSON. FULL_S seconds of each hour pass through everything
from bytes to drawing. The rest is added to the page's series directly, because 52 million frames would take most of
an hour.
"""

import json
import random
import statistics
import sys
from collections.abc import Callable
from typing import Final

import numpy as np
from PySide6.QtWidgets import QApplication, QWidget

from app.engine.session import Session
from app.engine.worker import Batch, Connection, PortState
from tests.benchmarks.figures import Figure
from tests.benchmarks.parser import stream
from tests.benchmarks.runs import measured
from tests.benchmarks.window import fill_capture, live_page, reserve, resident_mb, window_with_pages
from ui.main import Assembly, WindowOptions

HOURS: Final = 10
AIM_MB_PER_H: Final = 0.5
"""A tenth of a byte per frame."""


_LINE_HZ: Final = 1440
_STEP_S: Final = 1 / 120
_FRAME: Final = 8
_BYTES_PER_STEP: Final = int(_LINE_HZ * _STEP_S) * _FRAME
_STEPS_PER_BATCH: Final = 2
_BATCHES_PER_DRAW: Final = 6
_GARBAGE_EVERY: Final = 500
"""Steps: a little noise on the line belongs to ten hours."""
_CONNECTION: Final = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)


class _CannedLine:
    """A port with an endless stream."""

    baud_rate = 115200

    def __init__(self) -> None:
        self._data = stream(_LINE_HZ)
        self._at = self._steps = 0
        self._source = random.Random(3)

    def read(self, longest_s: float, gather_s: float) -> bytes:
        data = self._data[self._at : self._at + _BYTES_PER_STEP]
        self._at = (self._at + _BYTES_PER_STEP) % len(self._data)
        self._steps += 1
        return data if self._steps % _GARBAGE_EVERY else data + self._source.randbytes(20)

    def write(self, data: bytes) -> None: ...

    def use_rate(self, baud_rate: int) -> None: ...

    def close(self) -> None: ...


class Hours:
    """A window that receives the batches of a worker on a simulated clock."""

    def __init__(self, app: QApplication, assembly: Assembly) -> None:
        self.now_s = 100_000.0
        self.frames = 0
        self._app, self._connector, self._page = app, assembly.connector, live_page(assembly)
        self._connector.clock = self._connector.current.clock = lambda: self.now_s
        self._deliver: Callable[[Batch], None] = assembly.connector.current.bridge.deliver
        self._session = Session(_CannedLine(), lambda: self.now_s)
        self._source = np.random.default_rng(1)
        reserve(self._page)

    def stream_whole(self, seconds: float) -> None:
        """Through everything, from bytes to pixels."""
        for step in range(round(seconds / _STEP_S)):
            self.now_s += _STEP_S
            self._session.step()
            if step % _STEPS_PER_BATCH == 0:
                self._hand_over()
            if step % (_STEPS_PER_BATCH * _BATCHES_PER_DRAW) == 0:
                self._app.processEvents()
                self._page.refresh()
                self._page.draw()
        self._hand_over()
        self._app.processEvents()
        self._page.draw()

    def _hand_over(self) -> None:
        session = self._session
        samples, events = tuple(session.device.take_samples()), tuple(session.take_events())
        self.frames += len(samples)
        view, link = session.device.view(self.now_s), session.link_view()
        self._deliver(Batch(self.now_s, _CONNECTION, view, link, samples, events))

    def stream_samples(self, seconds: float) -> None:
        """Into the page's series only, in steps of half a minute."""
        data = self._page.data
        while seconds > 0:
            length_s = min(30.0, seconds)
            count = round(length_s * _LINE_HZ)
            times = self.now_s + np.arange(1, count + 1) / _LINE_HZ
            data.tilt.append(times, self._source.integers(0, 90, count))
            data.acceleration.append(times, self._source.integers(0, 30, count) / 10)
            data._flags.append(times, np.zeros(count))
            self.now_s = float(times[-1])
            self.frames += count
            seconds -= length_s


def figures(full_s: float = 12.0) -> list[Figure]:
    """Measured from the second hour on, when everything limited by count has reached its limit."""
    name = f"memory after {HOURS} simulated hours at 1,440 Hz"
    if not sys.platform.startswith("linux"):
        return [Figure(name, "not measured: only Linux tells it here")]
    found = measured("tests.benchmarks.memory", str(HOURS), f"{full_s:g}")
    memory = found["memory_mb"]
    later = memory[2:]
    slope = statistics.linear_regression(range(len(later)), later).slope
    return [
        Figure(
            f"{name} ({found['frames'] / 1e6:.1f} million frames, {HOURS * full_s / 60:.0f} min the whole way)",
            f"{memory[-1]:.0f} MB; {memory[0]:.0f} at the start, {memory[1]:.0f} after one hour, {slope:+.2f} MB/h",
            f"flat: <= {AIM_MB_PER_H} MB/h",
            slope <= AIM_MB_PER_H,
        )
    ]


def main(words: list[str]) -> int:
    """Entry point."""
    hours, full_s = int(words[0]), float(words[1])
    with window_with_pages(WindowOptions(language="en", offscreen_seconds=1)) as (app, assembly):
        fill_capture(assembly.window.findChild(QWidget, "diagnosis_page"))
        simulated = Hours(app, assembly)
        memory = [resident_mb()]
        for _ in range(hours):
            simulated.stream_whole(full_s)
            simulated.stream_samples(3600 - full_s)
            memory.append(resident_mb())
    print(json.dumps({"memory_mb": memory, "frames": simulated.frames}))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
