"""The window with everything behind it: LOCK, the first paint, the plots, CPU time.

Each is measured in a process of its own, `python -m tests.bench.window NAME …`, which prints JSON.
"""

import json
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import wait
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.limits.limits import LimitsInUse
from app.preflight.verdict import Standing
from app.recordings.markers import ModuleLimits
from app.store.fact_store import Store
from tests.bench.kit import LIMIT_S, WARM_UP_S, Figure, LoopWatch, apart, at_most, turn_for, turn_until, window_apart
from tests.support.processes import module_apart, ran_code, run_module
from ui.main import PAGES, WindowOptions, start
from ui.pages.live.data import LiveData
from ui.pages.preflight.page import PreflightPage
from ui.plots.lanes import measured_lanes
from ui.plots.time_plot import TimePlot

BLOCKED_S: Final = 3.0
PRESSES: Final = 200
BETWEEN_S: Final = 0.06
CPU_S: Final = 6.0
CHECK_S: Final = 60.0
_BEFORE_S: Final = 0.1
# By reports a second: runs, and the aim as a share of one core.
RATES: Final = {50: (1, 0.09), 1440: (3, 0.15)}
# Seconds in sight, reports a second, redraws.
REDRAWS: Final = ((60, 50, 60), (60, 1440, 60), (600, 1440, 36))
# Each prints when it was painted.
_BAREST_WINDOW: Final = """if True:
    import os, time
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication, QWidget

    def end():
        print(time.time(), flush=True)
        os._exit(0)

    class Window(QWidget):
        def paintEvent(self, event):
            QTimer.singleShot(0, end)

    app = QApplication()
    window = Window()
    window.show()
    app.exec()
"""
_OUR_WINDOW: Final = """if True:
    import gc, os, time
    from PySide6.QtCore import QTimer
    from app.__main__ import main
    gc.disable()  # as `app.__main__` does before it imports the window
    from ui.shell.main_window import MainWindow

    paint = MainWindow.paintEvent

    def end():
        print(time.time(), flush=True)
        os._exit(0)  # the program would not end while pages are loading

    def noted(window, event):
        paint(window, event)
        QTimer.singleShot(0, end)  # the children are painted in the same event

    MainWindow.paintEvent = noted
    main(["gui", "--demo", "--offscreen-seconds", "20"])
"""


def lock() -> Iterator[Figure]:
    """From the press of LOCK in the window to its frame at the module, a process of its own, while the module streams:
    with a store that takes everything at once, and with one that is blocked for 3 s, over and over. A press whose frame
    had not arrived after 60 ms counts as 15 s."""
    for store, took_s in apart("window", "lock").items():
        took_ms = sorted(1000 * one for one in took_s)
        p99 = took_ms[int(0.99 * PRESSES)]
        text = f"median {statistics.median(took_ms):.1f} ms, 99 % {p99:.1f} ms, longest {took_ms[-1]:.1f} ms"
        name = f"press of LOCK to its frame at the module, the store {store} ({PRESSES} presses)"
        yield Figure(name, text, "99 % <= 50 ms", p99 <= 50)


def measure_lock() -> dict[str, list[float]]:
    """Return the seconds of each press, for the free and the blocked store."""
    found: dict[str, list[float]] = {"free": [], "blocked": []}

    def block(store: Store, is_over: threading.Event) -> None:
        """Hold the writing connection, like a disk that takes 3 s per commit."""
        while not is_over.is_set():
            wait([store.write(lambda _facts: is_over.wait(BLOCKED_S))])

    with tempfile.TemporaryDirectory() as folder, module_apart(Path(folder) / "module", "stream_hz=100") as module:
        options = WindowOptions(port=f"{folder}/module", language="en")
        with window_apart(options) as assembly:
            start(assembly, options)
            button = assembly.window.top_bar.lock
            opened = turn_until(lambda: button.isEnabled() and assembly.ports.current.is_open, LIMIT_S)
            assert opened, "the port did not open"
            store = assembly.storage.open_store()
            assert isinstance(store, Store)
            turn_for(WARM_UP_S)
            for name, took_s in found.items():
                is_over = threading.Event()
                if name == "blocked":
                    threading.Thread(target=block, args=(store, is_over), daemon=True).start()
                for _ in range(PRESSES):
                    pressed_at = time.monotonic()
                    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
                    turn_for(BETWEEN_S)
                    arrived_at = float(module.tell("last 10"))  # all processes share Linux' monotonic clock
                    took_s.append(arrived_at - pressed_at if arrived_at >= pressed_at else LIMIT_S)
                is_over.set()
    return found


def startup(pairs: int = 15) -> Iterator[Figure]:
    """From the start of the process to the first paint of the window, on the simulated module, and of the barest window
    of PySide6, in turns: the medians, after one pair that fills the file system's cache."""
    took: dict[str, list[float]] = {_BAREST_WINDOW: [], _OUR_WINDOW: []}
    for _ in range(pairs + 1):
        for window, times in took.items():
            began = time.time()
            times.append(float(ran_code(window, QT_QPA_PLATFORM="offscreen").stdout) - began)
    bare, ours = (statistics.median(times[1:]) for times in took.values())
    yield at_most("process start to first paint", ours, 0.5, "{:.2f} s")
    yield at_most("the same, against the barest window of PySide6", ours / bare, 2.5, "{:.2f} x")


def plots() -> Iterator[Figure]:
    """A redraw of the four plots of the Live page (CPU time, median, 1000 x 500)."""
    for length_s, rate_hz, draws in REDRAWS:
        took_ms = statistics.median(apart("window", "plots", length_s, rate_hz, draws)) * 1000
        yield at_most(f"{length_s} s in sight at {rate_hz:,} Hz", took_ms, 4.0, "{:.1f} ms")


def measure_plots(length_s: int, rate_hz: int, draws: int) -> list[float]:
    """CPU seconds of each redraw, each a pixel after the one before."""
    app, data = QApplication(sys.argv[:1]), LiveData()
    times = np.arange(length_s * rate_hz) / rate_hz
    noise = 30 * ((np.arange(len(times)) * 7919) % 101) / 101
    slow = np.arange(length_s)
    data.tilt.append(times, 40 + noise)
    data.acceleration.append(times, 1 + noise / 60)
    data.light.append(slow, np.full(len(slow), 0.3))
    data.cell.append(slow, np.full(len(slow), 3.9))
    data.acting.put(0.0, ModuleLimits(60.0, 50.0, 0.5, light_v=1.8))
    plot = TimePlot(measured_lanes(data, LimitsInUse(), data.acting, data.unproven), wall_offset_s=0.0)
    plot.resize(1000, 500)
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
    return took[1:]


def cpu() -> Iterator[Figure]:
    """CPU time of the whole program, window and worker, and stalls of its event loop, while a module in another process
    streams to its Live page."""
    for rate_hz, (count, aim) in RATES.items():
        runs = []
        for _ in range(count):
            with run_module("--rate", str(rate_hz), "--lifelike") as module:
                runs.append(apart("window", "cpu", module.port))
        share, stall_s = (statistics.median(run[at] for run in runs) for at in (0, 1))
        yield at_most(f"CPU of window and worker at {rate_hz} Hz, of one core", share, aim, "{:.1%}")
        yield at_most(f"longest stall of the event loop at {rate_hz} Hz", stall_s * 1000, 50, "{:.1f} ms")


def measure_cpu(port: str) -> tuple[float, float]:
    options = WindowOptions(port=port, language="en", offscreen_seconds=CPU_S)
    with window_apart(options) as assembly:
        start(assembly, options)
        assert turn_until(lambda: assembly.ports.current.module.view.is_streaming, LIMIT_S), "the module did not stream"
        turn_for(WARM_UP_S)
        began, used = time.perf_counter(), time.process_time()
        turn_for(CPU_S)
        share = (time.process_time() - used) / (time.perf_counter() - began)
        watch = LoopWatch()
        watch.start()  # only now, since it takes a tenth of all CPU time
        turn_for(CPU_S)
        watch.stop()
    return share, watch.longest_s


def stalls(runs: int = 3) -> Iterator[Figure]:
    """The longest turn of the event loop from the first paint on: while the pages are made, when each is first shown,
    during a check, and when what passed is unfolded; the shortest of some runs, as others stall the machine, too."""
    found = [apart("window", "stalls") for _ in range(runs)]
    for phase in found[0]:
        yield at_most(f"longest stall: {phase}", min(run[phase] for run in found) * 1000, 50, "{:.0f} ms")


def measure_stalls() -> dict[str, float]:
    options, found = WindowOptions(demo=True, language="en"), dict[str, float]()
    with window_apart(options) as assembly:
        window = assembly.window

        def watch(phase: str, act: Callable[[], object], is_done: Callable[[], object] = lambda: True) -> None:
            loop = LoopWatch()
            loop.start()
            turn_for(_BEFORE_S)
            QTimer.singleShot(0, act)
            turn_for(WARM_UP_S)
            assert turn_until(is_done, CHECK_S), f"it never ended: {phase}"
            loop.stop()
            found[phase] = loop.longest_s

        start(assembly, options)
        turn_until(window.isVisible)
        watch("pages are made, a module is connected", bool, lambda: assembly.ports.module.is_read)
        for entry in PAGES:
            watch(f"{entry.title} is first shown", partial(window.go_to, entry.key))
        page = window.findChild(PreflightPage)
        assert page is not None
        window.go_to("preflight")
        turn_for(WARM_UP_S)  # a step that has just come into sight is dead
        verdicts = (Standing.READY, Standing.NO_GO)
        watch("a check", page.enable.click, lambda: page.state.standing in verdicts)
        watch("what passed is unfolded", page.list.fold.click)
    return found


if __name__ == "__main__":
    what, *words = sys.argv[1:]
    measures: dict[str, Any] = {"lock": measure_lock, "plots": lambda *case: measure_plots(*map(int, case))}
    print(json.dumps((measures | {"cpu": measure_cpu, "stalls": measure_stalls})[what](*words)))
