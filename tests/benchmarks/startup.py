"""From the start of the process to the first paint of the window, on the simulated module.

    python -m tests.benchmarks.startup

runs `dps-s gui --demo` up to its first paint and prints the clock at that moment as JSON.
"""

import json
import statistics
import sys
import time
from typing import Final

from PySide6.QtCore import QCoreApplication, QEvent, QObject, QTimer
from PySide6.QtGui import QPaintEvent

from app.__main__ import main as program
from tests.benchmarks.figures import Figure
from ui.shell.main_window import MainWindow

AIM_S: Final = 0.5


def figures(runs: int = 5) -> list[Figure]:
    """The median, after one run that fills the file system's cache."""
    from tests.benchmarks.runs import measured  # loads the simulated module, which the window does not before its paint

    took = []
    for _ in range(runs + 1):
        began = time.time()
        took.append(float(measured("tests.benchmarks.startup")["painted_at"]) - began)
    median = statistics.median(took[1:])
    return [
        Figure(
            f"process start to first paint, median of {runs}",
            f"{median:.2f} s ({min(took[1:]):.2f} to {max(took[1:]):.2f}); what takes it: "
            "python -X importtime -m app gui --demo",
            f"<= {AIM_S} s",
            median <= AIM_S,
        )
    ]


_PAINTED = QEvent.Type(QEvent.registerEventType())


class _Stamp(QObject):
    """Records when the current paint of the window has ended."""

    at: float | None = None

    def event(self, event: QEvent) -> bool:
        if event.type() == _PAINTED and self.at is None:
            self.at = time.time()
            # Exit at once: `run` does not return while pages are loading.
            print(json.dumps({"painted_at": self.at}), flush=True)
            QTimer.singleShot(0, QCoreApplication.quit)
        return super().event(event)


def main() -> int:
    """Entry point."""
    stamp = _Stamp()
    paint = MainWindow.paintEvent

    def painted(window: MainWindow, event: QPaintEvent) -> None:
        paint(window, event)
        # The children are painted in the same event; this one is processed before any timer.
        QCoreApplication.postEvent(stamp, QEvent(_PAINTED), 1000)

    MainWindow.paintEvent = painted  # type: ignore[assignment,method-assign]
    return program(["gui", "--demo", "--offscreen-seconds", "20"])


if __name__ == "__main__":
    sys.exit(main())
