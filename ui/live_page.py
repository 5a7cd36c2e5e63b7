"""What the module measures, now and over time: numbers at the left, plots at the right.

One timer draws while the page is in sight.  Batches are taken all the time: acquisition never depends on what is
looked at.
"""

import time
from typing import Final, cast

from PySide6.QtCore import QEvent, QPoint, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QHideEvent, QImage, QKeySequence, QShowEvent, QWindow
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QStackedLayout, QVBoxLayout, QWidget

from app.i18n import tr
from app.worker import Batch
from protocol.catalogue import DEFAULT_BAUD_RATE
from ui.connect_panel import SIMULATED_PORT
from ui.connector import Target
from ui.icons import Icon, icon, pixmap
from ui.link_state import Phase, words
from ui.live_data import LiveData, Recording, lanes
from ui.live_panel import Limits, LivePanel
from ui.live_save import SaveBar, picture_with_foot
from ui.named import named
from ui.pages import Services
from ui.plots import TimePlot
from ui.theme import Space, current

DRAW_EVERY_MS: Final = 33
_DRAWS_PER_REFRESH: Final = 3
"""Numbers change ten times a second at most: faster cannot be read."""
_EMPTY_PX: Final = 420
_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE)


class LivePage(QWidget):
    """See the module's docstring."""

    def __init__(self, services: Services, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("live_page")
        self._connector = services.connector
        texts = services.texts
        wall_offset_s = time.time() - time.monotonic()
        self.data = LiveData()
        self.panel = LivePanel(texts)
        self.plot = TimePlot(lanes(self.data), texts, wall_offset_s=wall_offset_s)
        self.save = SaveBar(
            texts,
            take_recording=self._recording,
            take_picture=self._picture,
            find_connection=lambda: self._connector.connection,
            wall_offset_s=wall_offset_s,
        )
        self.empty = _Empty(services)
        self._content = self._lay_out()
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self.empty)
        self._stack.addWidget(self._content)
        self._add_action("live_save_csv_key", "Ctrl+S", self._save_csv)
        self._add_action("live_save_png_key", "Ctrl+Shift+S", self._save_png)
        self._add_action("live_pause_key", "Ctrl+P", self._pause)
        self._draws = 0
        self._timer = QTimer(self)
        self._timer.setInterval(DRAW_EVERY_MS)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._tick)
        self._connector.changed.connect(self._refresh_empty)
        self.refresh()

    @property
    def is_empty(self) -> bool:
        """No module has said anything yet, so there is nothing to plot."""
        return self._stack.currentWidget() is self.empty

    def take(self, batch: Batch) -> None:
        """Remember a batch; nothing is drawn here."""
        for mark in self.data.take(batch):
            self.plot.add_mark(mark)

    def draw(self) -> None:
        """The plots as they are now."""
        if not self.is_empty:
            self.plot.draw(self._connector.clock())

    def refresh(self) -> None:
        """Numbers, ages and words as they are now."""
        now_s, device, data = self._connector.clock(), self._connector.device, self.data
        if data.has_samples and self.is_empty:
            self._stack.setCurrentWidget(self._content)
        if self.is_empty:
            self._refresh_empty()
            return
        light = device.fresh("light_threshold_v", now_s)
        limits = Limits(data.fires.value, data.falls.value, None if light is None else float(light))
        self.panel.show_device(device, now_s, limits=limits, reports_per_s=data.reports_per_s(now_s))
        self.save.refresh()

    def _tick(self) -> None:
        window = cast("QWindow | None", self.window().windowHandle())
        if window is not None and not window.isExposed():
            return
        self._draws += 1
        is_turn = self._draws % _DRAWS_PER_REFRESH == 0
        if is_turn:
            self.refresh()
        if self.plot.is_live or is_turn:
            self.draw()

    def _refresh_empty(self) -> None:
        if self.is_empty:
            self.empty.refresh()

    def _recording(self) -> Recording:
        span = self.plot.span
        return self.data.recording(span.start_s, span.end_s)

    def _picture(self, foot: str) -> QImage:
        return picture_with_foot(self._seen, foot)

    # What a person does by key

    def _save_csv(self) -> None:
        if not self.is_empty:
            self.save.save_csv()

    def _save_png(self) -> None:
        if not self.is_empty:
            self.save.save_png()

    def _pause(self) -> None:
        if not self.is_empty:
            self.plot.toggle_pause()

    # Making

    def _lay_out(self) -> QWidget:
        card = QFrame()
        card.setObjectName("live_plots")
        card.setProperty("role", "card")
        right = QVBoxLayout(card)
        right.setContentsMargins(Space.S, Space.S, Space.S, Space.S)
        right.addWidget(self.plot, 1)
        self._seen = QWidget()
        self._seen.setObjectName("live_seen")
        row = QHBoxLayout(self._seen)
        row.setContentsMargins(Space.S, Space.S, Space.S, Space.XS)
        row.setSpacing(Space.S)
        row.addWidget(self.panel)
        row.addWidget(card, 1)
        content = QWidget()
        content.setObjectName("live_content")
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self._seen, 1)
        foot = QHBoxLayout()
        foot.setContentsMargins(Space.M, 0, Space.S, Space.S)
        foot.addWidget(self.save)
        column.addLayout(foot)
        return content

    def _add_action(self, name: str, key: str, act: object) -> None:
        action = named(QAction(self), name)
        action.setShortcut(QKeySequence(key))
        action.triggered.connect(act)
        self.addAction(action)

    # Qt

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._timer.start()
        self.refresh()
        self.draw()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._timer.stop()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange and hasattr(self, "_timer"):
            self.refresh()


class _Empty(QWidget):
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
        texts.bind(self._promise.setText, "Tilt, acceleration and cell voltage appear here as soon as a module answers.")
        for label in (self._picture, self._title, self.text, self._promise):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        for label in (self._title, self.text, self._promise):
            label.setWordWrap(True)
            label.setFixedWidth(_EMPTY_PX)
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
