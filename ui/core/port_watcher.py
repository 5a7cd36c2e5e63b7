"""Polls the list of ports in a background thread: listing can take seconds (Bluetooth ports)."""

import logging
from collections.abc import Callable, Iterable

from PySide6.QtCore import QObject, QTimer, Signal

from app.engine.ports import PortInfo, list_ports
from app.text.messages import UserError
from ui.core.background_task import BackgroundTask

_log = logging.getLogger(__name__)

POLL_EVERY_MS = 1500
SCAN_LIMIT_S = 3.0


class PortWatcher(QObject):
    """Lists the ports once with `refresh`, or over and over while `is_watching`."""

    listed = Signal()  # After each scan, whether or not something changed; in the window's thread

    def __init__(self, scan: Callable[[float], Iterable[PortInfo]] = list_ports) -> None:
        super().__init__()
        self._scan = scan
        self._scanning: BackgroundTask[tuple[PortInfo, ...]] = BackgroundTask("dps-s port list", self)
        self.ports: tuple[PortInfo, ...] = ()
        self.has_listed = False
        self.is_current = False  # `ports` is the result of the last scan; else of an earlier one
        self._timer = QTimer(self, interval=POLL_EVERY_MS)
        self._timer.timeout.connect(self.refresh)

    def watch(self, is_watching: bool) -> None:
        if is_watching and not self._timer.isActive():
            self.refresh()
            self._timer.start()
        elif not is_watching:
            self._timer.stop()

    def refresh(self) -> bool:
        """Scan now; returns False, and does nothing, while a scan is running."""
        if self._scanning.is_running:
            return False
        self._scanning.run(lambda _running: tuple(self._scan(SCAN_LIMIT_S)), self._on_listed, self._fail)
        return True

    def stop(self, deadline_s: float) -> bool:
        """Stop scanning; whether the running scan ended within `deadline_s`."""
        self._timer.stop()
        return self._scanning.wait(deadline_s)

    def _on_listed(self, ports: tuple[PortInfo, ...]) -> None:
        self.ports = ports
        self._tell(is_current=True)

    def _fail(self, error: Exception) -> None:
        """The last list stays. A driver may fail in any way; the window works without the list."""
        if isinstance(error, UserError):
            _log.warning("The ports could not be listed within %s s", SCAN_LIMIT_S)
        else:
            _log.error("The ports could not be listed", exc_info=error)
        self._tell(is_current=False)

    def _tell(self, *, is_current: bool) -> None:
        self.has_listed, self.is_current = True, is_current
        self.listed.emit()
