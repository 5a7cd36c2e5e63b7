"""From Connect to the first measured value on the Live page, and until everything that can be read is known, on a
simulated module in another process that answers in 2 ms. CPU time of the window's thread is what a quiet machine adds.

    python -m tests.benchmarks.window.connecting PORT

measures on this port in its own process and prints JSON.
"""

import json
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QWidget

from app.engine.target import Target
from app.engine.worker import PortState
from app.procedures.read import READABLE
from protocol.catalogue import STATUS
from tests.benchmarks.figures import Figure
from tests.benchmarks.module import streaming_module
from tests.benchmarks.runs import measured
from tests.benchmarks.window.window import LIMIT_S, turn_until, window_with_pages
from ui.main import Assembly, WindowOptions
from ui.style.painted_widget import Freshness

AIMS_S: Final = {"the first value": 0.200, "everything read": 0.400}
ROUNDS: Final = 8
_LOOK_EVERY_MS: Final = 2
_DELAY: Final = "delay-ms=2"
_ALL: Final = tuple("active" if command is STATUS else command.key for command in READABLE)


def figures() -> list[Figure]:
    """One row each; includes the first connection, which initialises caches."""
    with tempfile.TemporaryDirectory() as folder, streaming_module(Path(folder) / "module", _DELAY) as module:
        took = measured("tests.benchmarks.window.connecting", module.port)
    found = []
    for what, aim_s in AIMS_S.items():
        wall_s, cpu_s = (statistics.median(one[n] for one in took[what]) for n in (0, 1))
        longest_s = max(one[0] for one in took[what])
        found.append(
            Figure(
                f"from Connect to {what}, median of {ROUNDS}",
                f"{wall_s * 1000:.0f} ms (longest {longest_s * 1000:.0f} ms; {cpu_s * 1000:.0f} ms of CPU)",
                f"<= {aim_s * 1000:.0f} ms",
                wall_s <= aim_s,
            )
        )
    return found


class Connecting:
    """One connection, measured in the window's thread."""

    def __init__(self, assembly: Assembly, port: str) -> None:
        self._assembly = assembly
        self._tilt: Any = assembly.window.findChild(QWidget, "live_tilt")
        self.took: dict[str, tuple[float, float]] = {}
        self._timer = QTimer(interval=_LOOK_EVERY_MS)
        self._timer.timeout.connect(self._look)
        self._timer.start()
        self._began, self._cpu = time.perf_counter(), time.thread_time()
        assembly.window.connect_to(Target(port, 115200))

    @property
    def is_done(self) -> bool:
        return len(self.took) == len(AIMS_S)

    @property
    def shows_value(self) -> bool:
        return self._tilt.freshness is Freshness.FRESH

    def _look(self) -> None:
        connector = self._assembly.connector
        if self.shows_value:
            self._note("the first value")
        if all(connector.device.fresh(key, connector.clock()) is not None for key in _ALL):
            self._note("everything read")

    def _note(self, what: str) -> None:
        self.took.setdefault(what, (time.perf_counter() - self._began, time.thread_time() - self._cpu))
        if self.is_done:
            self._timer.stop()


def measure(assembly: Assembly, port: str) -> dict[str, list[tuple[float, float]]]:
    """Connect and disconnect a few times."""
    found: dict[str, list[tuple[float, float]]] = {what: [] for what in AIMS_S}
    for _ in range(ROUNDS):
        for what, took in _measure_one(assembly, port).items():
            found[what].append(took)
    return found


def _measure_one(assembly: Assembly, port: str) -> dict[str, tuple[float, float]]:
    one = Connecting(assembly, port)
    if not turn_until(lambda: one.is_done, LIMIT_S):
        raise RuntimeError("not everything was read")
    assembly.connector.disconnect_port()
    turn_until(lambda: assembly.connector.connection.state is PortState.CLOSED, LIMIT_S)
    turn_until(lambda: not one.shows_value, LIMIT_S)
    return one.took


def main(words: list[str]) -> int:
    """Entry point."""
    (port,) = words
    with window_with_pages(WindowOptions(language="en")) as (_app, assembly):
        print(json.dumps(measure(assembly, port)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
