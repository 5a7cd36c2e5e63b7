"""Empty state of the Live page."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from app.diagnosis.link_state import Phase, link_text
from app.engine.target import Target
from app.text.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.connect.connect_panel import SIMULATED_PORT
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon, icon
from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import IconLabel
from ui.widgets.layouts import Gap, in_column, in_row, retain_size

_TEXT_PX: Final = 500
_MIN_TEXT_PX: Final = 240
_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE, Phase.LATE)


class EmptyPage(QWidget):
    """Shown until there are values: state of the link, and the first steps; what helps in trouble is in the notice."""

    def __init__(self, services: Services, page: Page) -> None:
        super().__init__()
        self.setObjectName("live_empty")
        self._connector = services.connector
        self._picture = IconLabel("live_empty_icon", 48)
        self._picture.show_icon(Icon.LIVE, is_muted=True)
        self._title = named(QLabel(), "live_empty_title", "title")
        self.text = named(QLabel(), "live_empty_text")
        texts = services.texts
        self._way = control(QLabel(), texts, "live_empty_way",
                            "1. Connect: choose the adapter's port.\n2. Settings: compare with the vendor's "
                            "advice.\n3. Pre-flight: check and activate before each flight, until it says GO.",
                            role="muted")  # fmt: skip
        self.choose = control(QPushButton(), texts, "live_choose_port", "Choose a port…", key="Ctrl+K",
                              picture=Icon.PLUG, role="primary", slot=page.ports_wanted)  # fmt: skip
        self.simulate = control(QPushButton(), texts, "live_simulate", "Simulated module",
                                picture=Icon.SIMULATOR, slot=self._simulate)  # fmt: skip
        self.recordings = control(QPushButton(), texts, "live_recordings", "Recordings",
                                  picture=Icon.RECORDINGS,
                                  slot=lambda: page.page_wanted.emit("recordings"))  # fmt: skip
        for label in (self._picture, self._title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        for label in (self._title, self.text, self._way):
            label.setWordWrap(True)
            label.setFixedWidth(_TEXT_PX)
        for button in (self.choose, self.simulate, self.recordings):
            retain_size(button)
        self._lay_out()

    def refresh(self) -> None:
        state = self._connector.current.state
        said = link_text(state, self._connector.clock())
        is_idle = state.phase is Phase.CLOSED
        self._title.setText(tr("No module connected") if is_idle else said.word)
        self.text.setText(said.next_step)
        self.text.setVisible(is_idle)
        set_role(self.choose, "primary" if is_idle else "")
        self.choose.setIcon(icon(Icon.PLUG, is_on_primary=is_idle))
        width_px = max(_MIN_TEXT_PX, min(scaled(_TEXT_PX), self.width() - 2 * Space.S))
        for label in (self._title, self.text, self._way):
            label.setFixedWidth(width_px)
        for button in (self.choose, self.simulate, self.recordings):
            button.setVisible(state.phase not in _BUSY)
        self._way.setVisible(is_idle)

    def _simulate(self) -> None:
        self._connector.connect_to(Target(SIMULATED_PORT, DEFAULT_BAUD_RATE))

    def _lay_out(self) -> None:
        buttons = in_row(1, self.choose, self.simulate, self.recordings, 1, spacing=Space.S)
        gap = Gap(Space.S)
        column = in_column(2, self._picture, self._title, self.text, gap, self._way, gap, buttons, 3, spacing=Space.S)
        in_row(1, column, 1, of=self, margins=0)
