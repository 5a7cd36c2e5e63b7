"""What the module measures, now and over time: numbers at the left, plots at the right.

One timer draws while the page is in sight.  Batches are taken all the time: acquisition never depends on what is
looked at.
"""

import time
from typing import Final, cast

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QAction, QHideEvent, QImage, QKeySequence, QShowEvent, QWindow
from PySide6.QtWidgets import QFrame, QHBoxLayout, QStackedLayout, QVBoxLayout, QWidget

from app.worker import Batch
from ui.bridge import joined
from ui.live_data import LiveData, Recording, lanes
from ui.live_empty import EmptyPage
from ui.live_panel import Limits, LivePanel
from ui.live_save import SaveBar, picture_with_foot
from ui.named import named
from ui.pages import Services
from ui.plots import TimePlot
from ui.theme import Space

DRAW_EVERY_MS: Final = 33
_DRAWS_PER_REFRESH: Final = 3
"""Numbers change ten times a second at most: faster cannot be read."""
_WAITING_MOST: Final = 15
"""Batches, a quarter of a second: out of sight that is often enough."""


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
        self.empty = EmptyPage(services)
        self._content = self._lay_out()
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self.empty)
        self._stack.addWidget(self._content)
        self._add_action("live_save_csv_key", "Ctrl+S", self._save_csv)
        self._add_action("live_save_png_key", "Ctrl+Shift+S", self._save_png)
        self._add_action("live_pause_key", "Ctrl+P", self._pause)
        self._draws = 0
        self._drawn_s = 0.0
        self._waiting: list[Batch] = []
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
        """Remember a batch; nothing is drawn here, and what is alike is worked through together."""
        if self._waiting and not _is_alike(self._waiting[-1], batch):
            self._digest()
        self._waiting.append(batch)
        if len(self._waiting) >= _WAITING_MOST:
            self._digest()

    def draw(self) -> None:
        """The plots as they are now."""
        self._digest()
        if not self.is_empty:
            self._drawn_s = self._connector.clock()
            self.plot.draw(self._drawn_s)

    def refresh(self) -> None:
        """Numbers, ages and words as they are now."""
        self._digest()
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
        if is_turn or (self.plot.is_live and self._connector.clock() - self._drawn_s >= self._pixel_s):
            self.draw()

    @property
    def _pixel_s(self) -> float:
        """How much time a pixel shows: the picture moves by no less."""
        return self.plot.span.length_s / max(1.0, self.plot.width() * self.devicePixelRatio())

    def _digest(self) -> None:
        """Work through what waits."""
        if self._waiting:
            batch = joined(self._waiting)
            self._waiting.clear()
            for mark in self.data.take(batch):
                self.plot.add_mark(mark)

    def _refresh_empty(self) -> None:
        if self.is_empty:
            self.empty.refresh()

    def _recording(self) -> Recording:
        self._digest()
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


def _is_alike(one: Batch, other: Batch) -> bool:
    """Nothing happened to the link in between."""
    return (
        one.connection == other.connection
        and one.device.presence is other.device.presence
        and one.device.restarts == other.device.restarts
    )
