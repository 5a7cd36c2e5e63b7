"""Empty state of the Live page."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QBoxLayout, QLabel, QPushButton

from app.diagnosis.link_state import Phase, link_text
from app.engine.target import Target
from app.text.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.connect.connect_panel import SIMULATED_PORT
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.controls import control, set_role
from ui.widgets.labels import EmptyState
from ui.widgets.layouts import in_row, retain_size

_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE, Phase.LATE)


class EmptyPage(EmptyState):
    """Shown until there are values: state of the link, and the first steps; what helps in trouble is in the notice."""

    def __init__(self, services: Services, page: Page) -> None:
        texts = services.texts
        super().__init__("live_empty", Icon.LIVE, texts)
        self._connector = services.connector
        self._way = control(QLabel(), texts, "live_empty_way",
                            "1. Connect: choose the adapter's port.\n2. Settings: compare with the vendor's "
                            "advice.\n3. Pre-flight: check and activate before each flight, until it says GO.",
                            role="muted")  # fmt: skip
        self._way.setWordWrap(True)
        self.choose = control(QPushButton(), texts, "live_choose_port", "Choose a port…", key="Ctrl+K",
                              picture=Icon.PLUG, role="primary", slot=page.ports_wanted)  # fmt: skip
        self.simulate = control(QPushButton(), texts, "live_simulate", "Simulated module",
                                picture=Icon.SIMULATOR, slot=self._simulate)  # fmt: skip
        self.recordings = control(QPushButton(), texts, "live_recordings", "Recordings",
                                  picture=Icon.RECORDINGS,
                                  slot=lambda: page.page_wanted.emit("recordings"))  # fmt: skip
        self._buttons = (self.choose, self.simulate, self.recordings)
        for button in self._buttons:
            retain_size(button)
        self.column.insertLayout(4, in_row(1, (self._way, 6), 1, margins=Space.S))
        middle = Qt.AlignmentFlag.AlignCenter
        self._row = in_row(1, *((button, middle) for button in self._buttons), 1, spacing=Space.S)
        self.column.insertLayout(5, self._row)

    def refresh(self) -> None:
        state = self._connector.current.state
        state_text = link_text(state, self._connector.clock())
        is_idle = state.phase is Phase.CLOSED
        self.title.setText(tr("No module connected") if is_idle else state_text.word)
        self.text.setText(state_text.next_step)
        self.text.setVisible(is_idle)
        set_role(self.choose, "primary" if is_idle else "")
        self.choose.setIcon(icon(Icon.PLUG, is_on_primary=is_idle))
        for button in self._buttons:
            button.setVisible(state.phase not in _BUSY)
        self._way.setVisible(is_idle)
        is_narrow = sum(button.sizeHint().width() + Space.S for button in self._buttons) > self.width()
        direction = QBoxLayout.Direction
        self._row.setDirection(direction.TopToBottom if is_narrow else direction.LeftToRight)

    def _simulate(self) -> None:
        self._connector.connect_to(Target(SIMULATED_PORT, DEFAULT_BAUD_RATE))
