"""Dock with the panel of the simulated module, which is created on first use."""

import logging
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDockWidget, QMainWindow

from app.text.i18n import tr
from app.text.user_error import UserError
from ui.session.ports import Ports
from ui.style.theme import is_text_large

if TYPE_CHECKING:
    from ui.simulator.panel import SimulatorPanel

_log = logging.getLogger(__name__)


class SimulatorDock(QDockWidget):
    """Controls the simulated module that is connected; disabled while there is none."""

    def __init__(self, ports: Ports, window: QMainWindow) -> None:
        super().__init__(window)
        self.setObjectName("simulator_dock")
        self._ports = ports
        self._device: str | None = None
        self._panel: SimulatorPanel | None = None
        self.setWindowTitle(tr("Simulated module"))
        self.setAccessibleName(tr("Simulated module"))
        ports.changed.connect(self._update_panel)
        areas = Qt.DockWidgetArea
        # Large text leaves no room beside the page.
        window.addDockWidget(areas.BottomDockWidgetArea if is_text_large() else areas.RightDockWidgetArea, self)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._panel is None:
            from ui.simulator.panel import SimulatorPanel

            self._panel = SimulatorPanel()
            self.setWidget(self._panel)
        self._update_panel()

    def _update_panel(self) -> None:
        """Show the module of the chosen port, also while it is unplugged, so that it can be plugged in again."""
        panel = self._panel
        if panel is None:
            return
        from app.port_urls.protocol_sim import open_bench

        target = self._ports.current.target if self._ports.current.is_requested else None
        device = target.device if target is not None and target.is_simulated else None
        if device == self._device:
            return
        self._device = device
        try:
            panel.use_bench(None if device is None else open_bench(device))
        except UserError as error:  # opening the port reports the same reason
            _log.info("No simulated module at %s: %s", device, error)
            panel.use_bench(None)
