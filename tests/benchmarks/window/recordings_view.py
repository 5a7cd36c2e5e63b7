"""Ten million reports in the window: stalls of the event loop while they are opened, and time of a draw while panning
and zooming.

    python -m tests.benchmarks.window.recordings_view FOLDER

opens the only recording in FOLDER in its own process and prints JSON.
"""

import json
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from PySide6.QtWidgets import QWidget

from tests.benchmarks.figures import Figure, quantile
from tests.benchmarks.runs import measured
from tests.benchmarks.window.window import LoopWatch, live_page, turn_for, turn_until, window_apart
from tests.support.records.recordings_made import written_at_once
from ui.main import WindowOptions, start
from ui.plots.time_plot import TimePlot
from ui.services.storage import RECORDINGS

ROWS: Final = 10_000_000
DRAW_AIM_S: Final = 0.010
STALL_AIM_S: Final = 0.100
OPENING_AIM_S: Final = 2.0
_LIMIT_S: Final = 20.0
_SETTLE_S: Final = 0.5
_STEPS: Final = 60
"""Number of draws per length of the time line."""
_LENGTHS_S: Final = (10.0, 60.0, 600.0)


def figures(rows: int = ROWS) -> list[Figure]:
    with tempfile.TemporaryDirectory() as name:
        written_at_once(Path(name) / RECORDINGS, rows)
        found = measured("tests.benchmarks.window.recordings_view", name)
    opening_s, stall_s, draw_s = found["opening_s"], found["stall_s"], found["draw_p99_s"]
    return [
        Figure(
            f"a recording of {rows:,} reports from the click to the plots",
            f"{opening_s:.2f} s",
            f"<= {OPENING_AIM_S:g} s",
            opening_s <= OPENING_AIM_S,
        ),
        Figure(
            "longest stall of the event loop meanwhile",
            f"{stall_s * 1000:.0f} ms",
            f"<= {STALL_AIM_S * 1000:.0f} ms",
            stall_s <= STALL_AIM_S,
        ),
        Figure(
            f"draw of its plots while it is panned and zoomed ({found['draws']} draws)",
            f"median {found['draw_median_s'] * 1000:.1f} ms, 99 % {draw_s * 1000:.1f} ms, "
            f"longest {found['draw_longest_s'] * 1000:.1f} ms",
            f"99 % <= {DRAW_AIM_S * 1000:.0f} ms",
            draw_s <= DRAW_AIM_S,
        ),
    ]


def measure(folder: Path) -> dict[str, float]:
    """In this process."""
    options, watch = WindowOptions(language="en"), LoopWatch()
    with window_apart(options, store=folder) as (_app, assembly):
        beat = watch.timer()
        start(assembly, options)
        page = _list_of(assembly, assembly.window)
        beat.start()
        turn_for(_SETTLE_S)
        watch.is_measuring = True
        began = time.perf_counter()
        page.table.selectRow(0)
        page.buttons.open.click()
        live = live_page(assembly)
        if not turn_until(lambda: live.recording is not None, _LIMIT_S):
            raise RuntimeError("the recording was not opened")
        opening_s = time.perf_counter() - began
        turn_for(_SETTLE_S)
        beat.stop()
        draws = _draws(live)
    return {
        "opening_s": opening_s,
        "stall_s": watch.late.longest_s,
        "draws": len(draws),
        "draw_median_s": quantile(draws, 0.5),
        "draw_p99_s": quantile(draws, 0.99),
        "draw_longest_s": max(draws),
    }


def _list_of(assembly: Any, window: Any) -> Any:
    """The Recordings page with one entry."""
    found: list[Any] = []

    def is_listed() -> bool:
        if not found:
            found.extend(one for one in [window.findChild(QWidget, "recordings_page")] if one is not None)
            if found:
                window.go_to("recordings")
        return bool(found) and len(found[0].work.entries) == 1

    if not turn_until(is_listed, _LIMIT_S):
        raise RuntimeError("the recording was not listed")
    return found[0]


def _draws(live: Any) -> list[float]:
    """Seconds of each draw with its painting: drags at several zoom levels, and jumps."""
    plot: TimePlot = live.plot
    canvas: Any = plot.findChild(QWidget, "time-plot-canvas")
    source = random.Random(1)
    found = []

    def timed(act: Any, *words: float) -> None:
        began = time.perf_counter()
        act(*words)
        canvas.viewport().repaint()
        found.append(time.perf_counter() - began)

    for _ in range(_STEPS):  # from everything down to a few reports and back
        timed(canvas.zoomed.emit, source.choice((0.5, 0.8, 1.25, 1.6)), source.random())
    for length_s in _LENGTHS_S:
        timed(plot.choose_window, length_s)
        timed(plot.show_instant, source.uniform(live.recording.start_s, live.recording.end_s))
        for _ in range(_STEPS):
            timed(canvas.panned.emit, source.uniform(-0.05, 0.05))
            timed(canvas.pointed.emit, source.random())
    for _ in range(_STEPS):
        timed(plot.show_instant, source.uniform(live.recording.start_s, live.recording.end_s))
    timed(plot.back_to_live)
    return found


def main() -> int:
    """Entry point."""
    print(json.dumps(measure(Path(sys.argv[1]))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
