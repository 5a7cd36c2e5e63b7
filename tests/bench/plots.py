"""A redraw of the four plots of the Live page (CPU time, median, 1000 x 500), against pyqtgraph tuned as its
documentation suggests."""

import json
import statistics
import sys
import time
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
import pyqtgraph
from PySide6.QtWidgets import QApplication

from app.limits.limits import LimitsInUse
from app.recordings.markers import ModuleLimits
from tests.bench.kit import Figure, apart
from ui.pages.live.data import LiveData
from ui.plots.lanes import measured_lanes
from ui.plots.time_plot import TimePlot

AIM_MS: Final = 4.0
CASES: Final = ((60, 50, 60), (60, 1440, 60), (600, 1440, 12))
"""Seconds in sight, reports a second, redraws."""
SIZE: Final = 1000, 500


def figures() -> Iterator[Figure]:
    for length_s, rate_hz, draws in CASES:
        took = apart("plots", length_s, rate_hz, draws)
        ours, tuned = (statistics.median(took[name]) * 1000 for name in ("ours", "tuned"))
        text = f"{ours:.1f} ms; pyqtgraph tuned {tuned:.0f} ms"
        yield Figure(f"{length_s} s in sight at {rate_hz:,} Hz", text, f"<= {AIM_MS:.0f} ms", ours <= AIM_MS)


def _tuned(app: QApplication, length_s: int, rate_hz: int, draws: int) -> list[float]:
    """CPU seconds of each redraw of four linked plots over `length_s`: arrays filled in place, peak down-sampling,
    clipping to the view, a pen of one pixel, no search for NaN, and a range that is set."""
    window: Any = pyqtgraph.GraphicsLayoutWidget()
    window.resize(*SIZE)
    plots = [window.addPlot(row=row, col=0) for row in range(4)]
    curves = [plot.plot() for plot in plots]
    for plot, curve in zip(plots, curves, strict=True):
        plot.setXLink(plots[0])
        plot.disableAutoRange()
        plot.setYRange(0, 90, padding=0)
        plot.setMouseEnabled(x=False, y=False)
        plot.hideButtons()
        curve.setPen(pyqtgraph.mkPen("w", width=1))
        curve.setDownsampling(auto=True, method="peak")
        curve.setClipToView(True)
        curve.setSkipFiniteCheck(True)
    count = length_s * rate_hz
    x = np.arange(count + draws) / rate_hz
    y = 40 + 30 * ((np.arange(count + draws) * 7919) % 101) / 101
    window.show()
    app.processEvents()
    took = []
    for end in range(count, count + draws):
        began = time.process_time()
        for plot, curve in zip(plots, curves, strict=True):
            plot.setXRange(x[end] - length_s, x[end], padding=0)
            curve.setData(x[: end + 1], y[: end + 1], antialias=False, connect="all", skipFiniteCheck=True)
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
    data.acting.put(0.0, ModuleLimits(60.0, 50.0, 0.5, light_v=1.8))
    plot = TimePlot(measured_lanes(data, LimitsInUse(), data.acting, data.unproven), wall_offset_s=0.0)
    plot.resize(*SIZE)
    plot.show()
    plot.time_range.choose_length(length_s)
    app.processEvents()
    took, now_s = [], float(times[-1])
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


def measure(*case: int) -> dict[str, list[float]]:
    """By turns in one process, so that other load affects both alike."""
    app, took = QApplication(sys.argv[:1]), dict[str, list[float]](ours=[], tuned=[])
    for _ in range(3):
        took["tuned"] += _tuned(app, *case)
        took["ours"] += _ours(app, *case)
    return took


if __name__ == "__main__":
    print(json.dumps(measure(*map(int, sys.argv[1:]))))
