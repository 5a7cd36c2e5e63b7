"""A redraw of the four plots of the Live page (CPU time, median, 1000 x 500), against pyqtgraph tuned as its
documentation suggests, as in its tutorial, and the painter of version 4a8b7c4c, which drew 60 s at 50 Hz in 1.1 to
1.2 ms and is no longer there to be measured."""

import json
import statistics
import sys
import time
from typing import Any, Final

import numpy as np
import pyqtgraph
from PySide6.QtWidgets import QApplication

from app.limits.out_of_limits import LimitsInUse
from app.recordings.markers import ModuleLimits
from tests.bench.figures import Figure, measured
from ui.pages.live.data import LiveData, live_lanes
from ui.plots.time_plot import TimePlot

AIM_MS: Final = 4.0
_CASES: Final = ((60, 50, 60), (60, 1440, 60), (600, 1440, 12))
"""Seconds in sight, reports a second, redraws."""
_SIZE: Final = 1000, 500


def figures() -> list[Figure]:
    """CPU time, which other work on the machine changes less."""
    found = []
    for length_s, rate_hz, draws in _CASES:
        took = measured("plots", length_s, rate_hz, draws)
        ours, tuned, tutorial = (statistics.median(took[name]) * 1000 for name in ("ours", "tuned", "tutorial"))
        text = f"{ours:.1f} ms; tuned {tuned:.0f} ms, tutorial {tutorial:.0f} ms"
        found.append(Figure(f"{length_s} s in sight at {rate_hz:,} Hz", text, f"<= {AIM_MS:.0f} ms", ours <= AIM_MS))
    return found


def _pyqtgraph(app: QApplication, length_s: int, rate_hz: int, draws: int, *, is_tuned: bool) -> list[float]:
    """CPU seconds of each redraw of four linked plots over `length_s`.

    As in the tutorial, growing lists are passed completely each time. Tuned as pyqtgraph's documentation suggests:
    arrays filled in place, peak down-sampling, clipping to the view, no antialiasing, a pen of one pixel, no search for
    NaN, and a range that is set.
    """
    window: Any = pyqtgraph.GraphicsLayoutWidget()
    window.resize(*_SIZE)
    plots = [window.addPlot(row=row, col=0) for row in range(4)]
    curves = [plot.plot() for plot in plots]
    for plot in plots[1:]:
        plot.setXLink(plots[0])
    count = length_s * rate_hz
    times = [at / rate_hz for at in range(count)]
    values = [40 + 30 * ((at * 7919) % 101) / 101 for at in range(count)]
    x, y = np.empty(count + draws), np.empty(count + draws)
    x[:count], y[:count] = times, values
    for plot, curve in zip(plots, curves, strict=True) if is_tuned else ():
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
    for end in range(count, count + draws):
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
    return took[1:]


def _ours(app: QApplication, length_s: int, rate_hz: int, draws: int) -> list[float]:
    """The same with the program's plots at the same size, each a pixel after the one before."""
    data = LiveData()
    times = np.arange(length_s * rate_hz) / rate_hz
    noise = 30 * ((np.arange(len(times)) * 7919) % 101) / 101
    slow = np.arange(length_s)
    data.tilt.append(times, 40 + noise)
    data.acceleration.append(times, 1 + noise / 60)
    data.light.append(slow, np.full(len(slow), 0.3))
    data.cell.append(slow, np.full(len(slow), 3.9))
    data.put(0.0, ModuleLimits(60.0, 50.0, 0.5, 1.8))
    plot = TimePlot(live_lanes(data, LimitsInUse()), wall_offset_s=0.0)
    plot.resize(*_SIZE)
    plot.show()
    plot.time_range.choose_length(length_s)
    app.processEvents()
    took = []
    now_s = float(times[-1])
    for _ in range(draws):
        now_s += plot.time_range.pixel_s
        data.tilt.append([now_s], [40.0])
        data.acceleration.append([now_s], [1.0])
        began = time.process_time()
        plot.draw(now_s)
        app.processEvents()
        took.append(time.process_time() - began)
    plot.close()
    return took[1:]


def measure(length_s: int, rate_hz: int, draws: int) -> dict[str, list[float]]:
    """By turns in one process, so that other load affects all alike."""
    app, took = QApplication(sys.argv[:1]), dict[str, list[float]](ours=[], tuned=[], tutorial=[])
    for _ in range(3):
        took["tutorial"] += _pyqtgraph(app, length_s, rate_hz, min(draws, 4), is_tuned=False)
        took["tuned"] += _pyqtgraph(app, length_s, rate_hz, min(draws, 24), is_tuned=True)
        took["ours"] += _ours(app, length_s, rate_hz, draws)
    return took


if __name__ == "__main__":
    print(json.dumps(measure(*map(int, sys.argv[1:]))))
