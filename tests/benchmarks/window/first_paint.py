"""Runs `dps-s gui --demo` up to its first paint and prints the clock at that moment as JSON.

python -m tests.benchmarks.window.first_paint
"""

import json
import sys
import time

from PySide6.QtCore import QCoreApplication, QEvent, QObject, QTimer
from PySide6.QtGui import QPaintEvent

from app.__main__ import main as program
from ui.shell.main_window import MainWindow

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
