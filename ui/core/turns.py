"""Long work of the window's thread in steps, a few in each turn of the event loop."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Final

from PySide6.QtCore import QObject, QTimer

# With 0 Qt would process no other events between two turns.
_BETWEEN_TURNS_MS: Final = 1
# After so long no further step is begun in this turn.
_TURN_S: Final = 0.005


class Turns(QTimer):
    """Takes steps one by one, so that keys, clicks and batches come between them and the window never stands still for
    all of the work. A step that raises is reported like any error of the window, and the next one is taken."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent, interval=_BETWEEN_TURNS_MS)
        self._steps: Iterator[Callable[[], object]] = iter(())
        self.timeout.connect(self._take_steps)

    def take(self, steps: Iterable[Callable[[], object]]) -> None:
        """Take these, in place of what is left of the former ones."""
        self._steps = iter(steps)
        self.start()

    def _take_steps(self) -> None:
        ends_at = time.monotonic() + _TURN_S
        while time.monotonic() < ends_at:
            step = next(self._steps, None)
            if step is None:
                self.stop()
                return
            step()
