"""Flight logs page with 500 flights: from a dragged threshold until map and lists are painted.

    python -m tests.benchmarks.window.flights_page COUNT DRAGS

measures in its own process and prints JSON.
"""

import json
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np
from PySide6.QtWidgets import QApplication

from app.flight_analysis.flight_set import FlightGroup
from app.flight_analysis.summary import summarise
from tests.benchmarks.figures import Figure, quantile
from tests.benchmarks.runs import measured
from tests.benchmarks.window.window import LIMIT_S, turn_for, turn_until, window_with_pages
from tests.support.flights.many_flights import crash, ordinary_flight
from ui.main import Assembly, WindowOptions
from ui.pages.flights.page import FlightsPage

FLIGHTS: Final = 500
DRAGS: Final = 25
AIM_MS: Final = 100.0
_SECONDS: Final = 20.0
_SETTLE_S: Final = 2.0
"""Controls are explained once the page is there."""
_MUST_EVERY: Final = 10
_NAMES: Final = {
    "tilt": "attitude threshold", "acceleration": "free-fall acceleration", "time": "free-fall time",
    "map": "cross on the map",
}  # fmt: skip


def figures() -> list[Figure]:
    """One row per dragged threshold."""
    took = measured("tests.benchmarks.window.flights_page", str(FLIGHTS), str(DRAGS))
    found = []
    for kind, seconds in took.items():
        slowest_ms = quantile([one * 1000 for one in seconds], 0.95)
        text = f"{quantile([one * 1000 for one in seconds], 0.5):.0f} ms median, {slowest_ms:.0f} ms p95, of CPU"
        name = f"{_NAMES[kind]} dragged over {FLIGHTS} flights"
        found.append(Figure(name, text, f"<= {AIM_MS:g} ms of CPU", slowest_ms <= AIM_MS))
    return found


def fill(page: FlightsPage, count: int) -> None:
    """Add flights as if they had been read."""
    random = np.random.default_rng(5)
    made = {FlightGroup.MUST_NOT: ordinary_flight, FlightGroup.MUST: crash}
    for number in range(count):
        group = FlightGroup.MUST if number % _MUST_EVERY == 0 else FlightGroup.MUST_NOT
        flight = made[group](f"/logs/flight-{number:04}.ulg", random, seconds=_SECONDS)
        page.work.flights.add([summarise(flight)], group)
    page.work.move((), FlightGroup.MUST)


def measure(app: QApplication, assembly: Assembly, count: int, drags: int) -> dict[str, list[float]]:
    """Seconds until it is painted, by dragged threshold."""
    page = assembly.window.findChild(FlightsPage)
    if page is None:
        raise RuntimeError("there is no page of flights")
    assembly.window.go_to("flights")
    fill(page, count)
    turn_until(lambda: not page.work.is_proposing, LIMIT_S)
    turn_for(_SETTLE_S)
    dials = page.thresholds
    acts: dict[str, Callable[[int], None]] = {
        "tilt": lambda number: dials.tilt.slider.setValue(40 + number),
        "acceleration": lambda number: dials.acceleration.slider.setValue(1 + number % 9),
        "time": lambda number: dials.time.slider.setValue(40 + 4 * number),
        "map": lambda number: page.map.chosen.emit(35 + number, 0.3 + number * 0.05),
    }
    return {kind: [_took_s(app, partial(act, number)) for number in range(drags)] for kind, act in acts.items()}


def _took_s(app: QApplication, act: Callable[[], None]) -> float:
    """CPU time of the window's thread, independent of other load."""
    began = time.thread_time()
    act()
    app.processEvents()  # what was posted
    app.processEvents()  # what that asked for: layouts, paints
    return time.thread_time() - began


def main(count: int, drags: int) -> int:
    with window_with_pages(WindowOptions(language="en", offscreen_seconds=1)) as (app, assembly):
        assembly.window.panel.hide()
        print(json.dumps(measure(app, assembly, count, drags)))
    return 0


if __name__ == "__main__":
    sys.exit(main(*(int(one) for one in sys.argv[1:3])))
