"""What stands in place of the Live page's plots before any module has answered."""

from typing import Final

from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.i18n import tr
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.connect_panel import SIMULATED_PORT
from ui.connector import Target
from ui.icons import Icon, icon, pixmap
from ui.link_state import Phase, words
from ui.named import named
from ui.pages import Services
from ui.theme import Space, current

_TEXT_PX: Final = 420
_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE)


class EmptyPage(QWidget):
    """Before there is anything to show: how the link stands, and the next thing to do."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("live_empty")
        self._connector = services.connector
        self._picture = named(QLabel(), "live_empty_icon")
        self._title = named(QLabel(), "live_empty_title")
        self._title.setProperty("role", "title")
        self.text = named(QLabel(), "live_empty_text")
        self._promise = named(QLabel(), "live_empty_promise")
        self._promise.setProperty("role", "muted")
        self.choose = named(QPushButton(), "live_choose_port")
        self.choose.setProperty("role", "primary")
        self.choose.setIcon(icon(Icon.PLUG, is_on_primary=True))
        self.choose.clicked.connect(self._choose_port)
        self.simulate = named(QPushButton(), "live_simulate")
        self.simulate.setIcon(icon(Icon.SIMULATOR))
        self.simulate.clicked.connect(self._simulate)
        texts = services.texts
        texts.bind(self.choose.setText, "Choose a port …")
        texts.bind(self.choose.setAccessibleName, "Choose a port")
        texts.bind(self.choose.setToolTip, "Choose the port that the module is plugged into (Ctrl+K)")
        texts.bind(self.simulate.setText, "Simulated module")
        texts.bind(self.simulate.setAccessibleName, "Connect to the simulated module")
        texts.bind(self.simulate.setToolTip, "Try everything without a module")
        texts.bind(self._promise.setText, "Tilt, acceleration and voltage appear here as soon as a module answers.")
        for label in (self._picture, self._title, self.text, self._promise):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        for label in (self._title, self.text, self._promise):
            label.setWordWrap(True)
            label.setFixedWidth(_TEXT_PX)
        for button in (self.choose, self.simulate):
            button.setIconSize(QSize(16, 16))
            policy = button.sizePolicy()
            policy.setRetainSizeWhenHidden(True)
            button.setSizePolicy(policy)
        services.appearance.changed.connect(self._dress)
        self._lay_out()
        self._dress()

    def refresh(self) -> None:
        """How the link stands now."""
        state = self._connector.state
        said = words(state, self._connector.clock())
        is_idle = state.phase is Phase.CLOSED
        self._title.setText(tr("No module connected") if is_idle else said.word)
        self.text.setText(said.next_step if is_idle else f"{said.what}\n{said.next_step}".strip())
        panel_px = self._covered_px()
        margins = self._column.contentsMargins()
        if margins.left() != panel_px:
            self._column.setContentsMargins(panel_px, 0, 0, 0)
        for button in (self.choose, self.simulate):
            button.setVisible(state.phase not in _BUSY and not panel_px)

    def _covered_px(self) -> int:
        """How much of the left is under the sheet with the ports."""
        panel = self.window().findChild(QWidget, "connect_panel")
        if panel is None or not panel.isVisible():
            return 0
        return max(0, panel.mapTo(self.window(), panel.rect().topRight()).x() - self.mapTo(self.window(), QPoint()).x())

    def _choose_port(self) -> None:
        panel = self.window().findChild(QWidget, "connect_panel")
        act = self.window().findChild(QAction, "act_connect")
        if act is not None and (panel is None or not panel.isVisible()):
            act.trigger()

    def _simulate(self) -> None:
        self._connector.connect_to(Target(SIMULATED_PORT, DEFAULT_BAUD_RATE))

    def _dress(self) -> None:
        ratio = self.devicePixelRatio()
        self._picture.setPixmap(pixmap(Icon.LIVE, 48, current().muted, ratio=ratio))

    def _lay_out(self) -> None:
        buttons = QHBoxLayout()
        buttons.setSpacing(Space.S)
        buttons.addStretch(1)
        buttons.addWidget(self.choose)
        buttons.addWidget(self.simulate)
        buttons.addStretch(1)
        column = QVBoxLayout()
        column.setSpacing(Space.S)
        column.addStretch(2)
        for label in (self._picture, self._title, self.text, self._promise):
            column.addWidget(label)
        column.addSpacing(Space.S)
        column.addLayout(buttons)
        column.addStretch(3)
        self._column = QHBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.addStretch(1)
        self._column.addLayout(column)
        self._column.addStretch(1)
