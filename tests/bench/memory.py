"""Memory of the window after ten hours at line rate, and whether it grows on. The plots' buffers for ten hours are
filled before; in use they grow by about 1.6 MB an hour for the first twelve hours."""

import json
import random
import statistics
import sys
from typing import Final

import numpy as np
from PySide6.QtCore import QCoreApplication
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QWidget

from app.engine.session import Session
from app.engine.worker import Batch, Connection, PortState
from tests.bench.figures import Figure, measured
from tests.bench.parser import LINE_HZ, stream
from tests.bench.window import LIMIT_S, fill_capture, live_page, reserve, resident_mb, turn_until, window_apart
from ui.main import Assembly, WindowOptions, start

HOURS: Final = 10
WHOLE_S: Final = 12.0
"""So much of each hour passes through everything from bytes to drawing, the rest goes into the page's series directly:
52 million frames would take most of an hour."""
AIM_MB_PER_H: Final = 0.5
"""A tenth of a byte per frame."""
_STEP_S: Final = 1 / 120
_BYTES_PER_STEP: Final = int(LINE_HZ * _STEP_S) * 8
_STEPS_PER_BATCH: Final = 2
_BATCHES_PER_DRAW: Final = 6
_GARBAGE_EVERY: Final = 500
"""Steps: a little noise on the line belongs to ten hours."""
_CONNECTION: Final = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)


class _CannedLine:
    """A port with an endless stream."""

    baud_rate = 115200
    sets_rate = True

    def __init__(self) -> None:
        self._data = stream(LINE_HZ)
        self._steps = 0
        self._source = random.Random(3)

    def read(self, longest_s: float, gather_s: float) -> bytes:
        at = self._steps * _BYTES_PER_STEP % len(self._data)
        self._steps += 1
        data = self._data[at : at + _BYTES_PER_STEP]
        return data if self._steps % _GARBAGE_EVERY else data + self._source.randbytes(20)

    def write(self, data: bytes) -> None: ...

    def use_rate(self, baud_rate: int) -> None: ...

    def close(self) -> None: ...


class Hours:
    """A window that receives the batches of a worker on a simulated clock."""

    def __init__(self, assembly: Assembly) -> None:
        self.now_s = 100_000.0
        self.frames = 0
        self._port, self._page = assembly.ports.current, live_page(assembly)
        assembly.ports.clock = self._port._clock = lambda: self.now_s
        self._session = Session(_CannedLine(), lambda: self.now_s)
        self._source = np.random.default_rng(1)
        reserve(self._page)

    def stream_whole(self) -> None:
        """Through everything, from bytes to pixels."""
        for step in range(round(WHOLE_S / _STEP_S)):
            self.now_s += _STEP_S
            self._session.step()
            if step % _STEPS_PER_BATCH == 0:
                self._hand_over()
            if step % (_STEPS_PER_BATCH * _BATCHES_PER_DRAW) == 0:
                self._draw()
        self._hand_over()
        self._draw()

    def _draw(self) -> None:
        QCoreApplication.processEvents()
        self._page.refresh()
        self._page.draw()

    def _hand_over(self) -> None:
        session = self._session
        samples, events = tuple(session.take_samples()), tuple(session.take_events())
        self.frames += len(samples)
        view, link = session.conversation_view(self.now_s), session.link_view()
        self._port.bridge.deliver(Batch(self.now_s, _CONNECTION, view, link, samples, events))

    def stream_samples(self) -> None:
        """The rest of the hour, in steps of half a minute."""
        data, seconds = self._page.data, 3600 - WHOLE_S
        while seconds > 0:
            count = round(min(30.0, seconds) * LINE_HZ)
            times = self.now_s + np.arange(1, count + 1) / LINE_HZ
            data.tilt.append(times, self._source.integers(0, 90, count))
            data.acceleration.append(times, self._source.integers(0, 30, count) / 10)
            data._flags.append(times, np.zeros(count))
            self.now_s = float(times[-1])
            self.frames += count
            seconds -= 30.0


def figures() -> list[Figure]:
    """Measured from the second hour on, when everything limited by count has reached its limit."""
    name = f"memory after {HOURS} simulated hours at 1,440 Hz"
    if not sys.platform.startswith("linux"):
        return [Figure(name, "not measured: only Linux tells it here")]
    found = measured("memory")
    memory = found["memory_mb"]
    slope = statistics.linear_regression(range(len(memory[2:])), memory[2:]).slope
    return [
        Figure(
            f"{name} ({found['frames'] / 1e6:.1f} million frames, {HOURS * WHOLE_S / 60:.0f} min the whole way)",
            f"{memory[-1]:.0f} MB; {memory[0]:.0f} at the start, {memory[1]:.0f} after one hour, {slope:+.2f} MB/h",
            f"flat: <= {AIM_MB_PER_H} MB/h",
            slope <= AIM_MB_PER_H,
        )
    ]


def measure() -> dict[str, object]:
    options = WindowOptions(language="en", offscreen_seconds=1)
    with window_apart(options) as (_app, assembly):
        made = QSignalSpy(assembly.window.pages_made)
        start(assembly, options)
        assert turn_until(lambda: made.count() > 0, 4 * LIMIT_S), "the pages were not made"
        fill_capture(assembly.window.findChild(QWidget, "diagnosis_page"))
        simulated = Hours(assembly)
        memory = [resident_mb()]
        for _ in range(HOURS):
            simulated.stream_whole()
            simulated.stream_samples()
            memory.append(resident_mb())
    return {"memory_mb": memory, "frames": simulated.frames}


if __name__ == "__main__":
    print(json.dumps(measure()))
