"""Alternatives for comparison: a byte loop, a parser with `construct`, pyqtgraph tuned and as in its tutorial."""

import json
import sys
import time
from typing import Final

import construct

HEADER: Final = b"Au\x32"
_WIDTH, _HEIGHT = 1000, 500


def parse_bytewise(chunks: list[bytes]) -> int:
    """Drops one byte wherever no frame begins; returns the status frames found."""
    buffer = bytearray()
    frames: list[bytes] = []
    rejected = bytearray()
    for chunk in chunks:
        for byte in chunk:
            buffer.append(byte)
            while len(buffer) >= 8:
                if buffer[0] == 0x41 and buffer[1] == 0x75 and sum(buffer[2:7]) & 0xFF == buffer[7]:
                    frames.append(bytes(buffer))
                    buffer.clear()
                else:
                    rejected.append(buffer.pop(0))
    return len(frames)


def _status_struct() -> construct.Struct:
    body = construct.RawCopy(
        construct.Struct(
            "code" / construct.Const(b"\x32"),
            "tilt_deg" / construct.Byte,
            "tenth_g" / construct.Byte,
            "triggered" / construct.Flag,
            "active" / construct.Flag,
        )
    )
    checksum = construct.Checksum(construct.Byte, lambda data: sum(data) & 0xFF, construct.this.body.data)
    return construct.Struct("header" / construct.Const(b"Au"), "body" / body, "checksum" / checksum)


def parse_with_construct(chunks: list[bytes]) -> int:
    """Declared with `construct`; skips one byte where parsing fails; returns the status frames found."""
    status = _status_struct()
    buffer, frames = b"", 0
    for chunk in chunks:
        buffer += chunk
        at = 0
        while len(buffer) - at >= 8:
            at = buffer.find(HEADER[:2], at)
            if at < 0 or len(buffer) - at < 8:
                break
            try:
                status.parse(buffer[at : at + 8])
            except construct.ConstructError:
                at += 1
            else:
                frames += 1
                at += 8
        buffer = buffer[at if at >= 0 else max(0, len(buffer) - 1) :]
    return frames


def draw_with_pyqtgraph(length_s: float, rate_hz: int, draws: int, *, is_tuned: bool) -> list[float]:
    """CPU seconds of each redraw of four linked plots over `length_s`.

    As in the tutorial, growing lists are passed completely each time. Tuned as pyqtgraph's documentation suggests:
    arrays filled in place, peak down-sampling, clipping to the view, no antialiasing, a pen of one pixel, no search for
    NaN, and a range that is set.
    """
    import numpy as np
    import pyqtgraph
    from PySide6.QtWidgets import QApplication

    app = QApplication.instance() or QApplication(sys.argv[:1])
    window = pyqtgraph.GraphicsLayoutWidget()
    window.resize(_WIDTH, _HEIGHT)
    plots = [window.addPlot(row=row, col=0) for row in range(4)]
    curves = [plot.plot() for plot in plots]
    for plot in plots[1:]:
        plot.setXLink(plots[0])
    count = int(length_s * rate_hz)
    times = [at / rate_hz for at in range(count)]
    values = [40 + 30 * ((at * 7919) % 101) / 101 for at in range(count)]
    x, y = np.empty(count + draws), np.empty(count + draws)
    x[:count], y[:count] = times, values
    if is_tuned:
        for plot, curve in zip(plots, curves, strict=True):
            plot.disableAutoRange()
            plot.setYRange(0, 90, padding=0)
            plot.setMouseEnabled(x=False, y=False)
            plot.hideButtons()
            curve.setPen(pyqtgraph.mkPen("w", width=1))
            curve.setDownsampling(auto=True, method="peak")
            curve.setClipToView(True)
            curve.setSkipFiniteCheck(True)
    window.show()
    app.processEvents()
    took = []
    for number in range(draws):
        end = count + number
        now_s = end / rate_hz
        times.append(now_s)
        values.append(values[-1])
        x[end], y[end] = now_s, 40.0
        began = time.process_time()
        for plot, curve in zip(plots, curves, strict=True):
            if is_tuned:
                plot.setXRange(now_s - length_s, now_s, padding=0)
                curve.setData(x[: end + 1], y[: end + 1], antialias=False, connect="all", skipFiniteCheck=True)
            else:
                curve.setData(times, values)
        app.processEvents()
        took.append(time.process_time() - began)
    window.close()
    return took


def draw_ours(length_s: float, rate_hz: int, draws: int) -> list[float]:
    """The same with the program's plots at the same size, each a pixel after the one before."""
    import numpy as np
    from PySide6.QtWidgets import QApplication

    from app.limits.out_of_limits import LimitsInUse
    from app.recordings.markers import ModuleLimits
    from ui.core.texts import Texts
    from ui.pages.live.data import LiveData, lanes
    from ui.plots.time_plot import TimePlot

    app = QApplication.instance() or QApplication(sys.argv[:1])
    data = LiveData()
    times = np.arange(int(length_s * rate_hz)) / rate_hz
    noise = 30 * ((np.arange(len(times)) * 7919) % 101) / 101
    slow = np.arange(length_s)
    data.tilt.append(times, 40 + noise)
    data.acceleration.append(times, 1 + noise / 60)
    data.light.append(slow, np.full(len(slow), 0.3))
    data.cell.append(slow, np.full(len(slow), 3.9))
    data.put(0.0, ModuleLimits(60.0, 50.0, 0.5, 1.8))
    plot = TimePlot(lanes(data, LimitsInUse()), Texts(), wall_offset_s=0.0)
    plot.resize(_WIDTH, _HEIGHT)
    plot.show()
    plot.time_range.choose_length(length_s)
    app.processEvents()
    took = []
    now_s = float(times[-1])
    for _ in range(draws):
        now_s += plot.time_range.pixel_s
        data.tilt.append(np.array([now_s]), np.array([40.0]))
        data.acceleration.append(np.array([now_s]), np.array([1.0]))
        began = time.process_time()
        plot.draw(now_s)
        app.processEvents()
        took.append(time.process_time() - began)
    plot.close()
    return took


def main(words: list[str]) -> int:
    """Runs all alternately in one process, so that other load affects all alike; prints the medians as JSON."""
    import statistics

    length_s, rate_hz, draws = float(words[0]), int(words[1]), int(words[2])
    naive: list[float] = []
    tuned: list[float] = []
    ours: list[float] = []
    for _ in range(3):
        naive += draw_with_pyqtgraph(length_s, rate_hz, min(draws, 4), is_tuned=False)[1:]
        tuned += draw_with_pyqtgraph(length_s, rate_hz, min(draws, 24), is_tuned=True)[1:]
        ours += draw_ours(length_s, rate_hz, draws)[1:]
    found = {"naive_s": naive, "tuned_s": tuned, "ours_s": ours}
    print(json.dumps({name: statistics.median(took) for name, took in found.items()}))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
