"""Live page: a column of values beside the plots.

While the page is visible each batch draws, or a timer where no batch comes: the plots only when they moved by a pixel,
the numbers some ten times a second and whenever the module's state changes. Batches are taken at all times, visible
or not. It is always live: recordings are shown on Logs.
"""

from datetime import datetime
from pathlib import Path
from typing import Final, cast

from PySide6.QtCore import QStandardPaths
from PySide6.QtGui import QWindow
from PySide6.QtWidgets import QFrame, QPushButton, QStackedLayout, QToolButton, QWidget

from app import version
from app.diagnosis.link_state import Phase, link_text
from app.engine.worker import Batch, PortState
from app.system.clock import wall_offset_s
from app.text.i18n import tr
from ui.core.bridge import joined
from ui.files.file_dialogs import default_name
from ui.pages.live.data import LiveData, SaveNote, live_lanes
from ui.pages.live.panel import LivePanel
from ui.plots.time_plot import TimePlot
from ui.services.context import Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import (
    EmptyState,
    Shortcut,
    control,
    in_column,
    in_row,
    named,
    retain_size,
    stacked,
    text_label,
)
from ui.widgets.visibility_timer import VisibilityTimer

_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE, Phase.LATE)


class EmptyPage(EmptyState):
    """Shown until there are values: state of the link, and the first steps; what helps in trouble is in the notice."""

    def __init__(self, services: Services, page: Page) -> None:
        super().__init__("live_empty", Icon.LIVE)
        self._ports = services.ports
        self._way = text_label("live_empty_way", "muted")
        self._way.setText(
            tr(
                "1. Connect: choose the adapter's port.\n2. Settings: compare with the vendor's advice.\n"
                "3. Pre-flight: before each flight, until it says GO."
            )
        )
        self.choose = control(
            QPushButton(tr("Choose a port…")),
            "live_choose_port",
            key="Ctrl+K",
            picture=Icon.PLUG,
            role="primary",
            slot=page.ports_wanted,
        )
        retain_size(self.choose)
        self.column.insertLayout(4, in_row(1, (self._way, 6), 1, margins=Space.S))
        self.column.insertLayout(5, in_row(1, self.choose, 1))

    def refresh(self) -> None:
        state = self._ports.current.state
        state_text = link_text(state, self._ports.clock())
        is_idle = state.phase is Phase.CLOSED
        self.title.setText(tr("Not connected") if is_idle else state_text.word)
        self.text.setText(state_text.next_step)
        self.text.setVisible(is_idle)
        self.choose.setVisible(state.phase not in _BUSY)
        self._way.setVisible(is_idle)


DRAW_EVERY_MS: Final = 150
"""While no batches come: ages and the time line go on."""
REFRESH_EVERY_S: Final = 0.06
"""Numbers: faster changes could not be read."""
_MAX_WAITING: Final = 15
# A larger difference means that the time of day was set; smaller ones are a time server at work.
CLOCK_SET_S: Final = 2.0
"""Batches, half a second: often enough while hidden."""


class LivePage(Page):
    shows_link = True

    def __init__(self, services: Services) -> None:
        super().__init__("live")
        self._services, self._ports = services, services.ports
        self._in_use = services.in_use
        self.data = LiveData()
        self.panel = LivePanel()
        drawn = live_lanes(self.data, self._in_use)
        self.plot = TimePlot(drawn, wall_offset_s=wall_offset_s())
        self.note = SaveNote()
        self.csv = control(
            QToolButton(),
            "live_save_csv",
            says=tr("Save values…"),
            keys="Ctrl+S",
            picture=Icon.TABLE,
            slot=self._save_values,
        )
        self.png = control(
            QToolButton(),
            "live_save_png",
            says=tr("Save picture…"),
            keys="Ctrl+Shift+S",
            picture=Icon.CAMERA,
            slot=self._save_picture,
        )
        self.stop = control(
            QPushButton(tr("Cancel")), "live_save_cancel", picture=Icon.CROSS, slot=self.note.job.cancel_files
        )
        self.stop.hide()
        self.note.job.changed.connect(self._refresh_saving)
        self.empty = EmptyPage(services, self)
        self._content = self._lay_out()
        self._stack = stacked(QStackedLayout(self), self.empty, self._content)
        self.saving, self.exporting = self.csv, self.png
        Shortcut(self.plot.pause, "Ctrl+P", self.plot.time_range.toggle_pause, holder=self._content)
        self._refreshed_at = 0.0
        self._waiting: list[Batch] = []
        self._last: Batch | None = None
        self._port = ""
        """The curves are of this port. A conversation that ends there breaks them with a mark."""
        self._timer = VisibilityTimer(
            self,
            self._show_now,
            every_ms=DRAW_EVERY_MS,
            tick=self._tick_alone,
            hidden=self._ports.set_drawing_interval,
        )
        self._ports.changed.connect(self._refresh_empty)
        self._ports.chosen.connect(self._begin_again)

    @property
    def is_empty(self) -> bool:
        """There is nothing to plot yet."""
        return self._stack.currentWidget() is self.empty

    def on_batch(self, batch: Batch) -> None:
        """Queues a batch; similar ones are processed together."""
        offset_s = wall_offset_s()
        if abs(offset_s - self.plot.canvas.wall_offset_s) > CLOCK_SET_S:
            self.plot.be_at(offset_s)
        if self._last is not None and not _is_same_state(self._last, batch):
            self._process_waiting()
            self._refreshed_at = 0.0  # refresh the numbers at once
        self._last = batch
        if batch.connection.state is PortState.OPEN and batch.connection.port != self._port:
            self._begin_again()
            self._port = batch.connection.port
        self._waiting.append(batch)
        if len(self._waiting) >= _MAX_WAITING:
            self._process_waiting()
        if self.isVisible():
            self._timer.restart()
            self._tick()

    def draw(self) -> None:
        self._process_waiting()
        if not self.is_empty:
            self.plot.draw(self._ports.clock())
            self._ports.set_drawing_interval(self.plot.time_range.pixel_s)

    def refresh(self) -> None:
        self._process_waiting()
        now_s, data = self._ports.clock(), self.data
        self._refreshed_at = now_s
        if data.has_samples and self.is_empty:
            self._stack.setCurrentWidget(self._content)
        if self.is_empty:
            self._refresh_empty()
            return
        self.panel.show_device(
            self.module.view,
            now_s,
            in_use=self._in_use,
            limits=data.at(),
            unproven=data.unproven.at(),
            reports_per_s=data.reports_per_s(now_s),
            direction=self.module.light_direction,
        )

    def _show_now(self) -> None:
        self.refresh()
        self.draw()

    def _tick_alone(self) -> None:
        """Called while no batches come."""
        self._refreshed_at = 0.0
        self._tick()
        self._refreshed_at = 0.0  # a batch right after it waits for nothing

    def _tick(self) -> None:
        window = cast("QWindow | None", self.window().windowHandle())
        if window is not None and not window.isExposed():
            return
        now_s = self._ports.clock()
        is_turn = now_s - self._refreshed_at >= REFRESH_EVERY_S
        if is_turn:
            self.refresh()
        if not self.is_empty and self.plot.canvas.is_due(now_s):
            self.draw()
        elif is_turn:
            self.plot.show_age(now_s)

    def _process_waiting(self) -> None:
        if self._waiting:
            batch = joined(self._waiting)
            self._waiting.clear()
            self.plot.add_marks(self.data.on_batch(batch))

    def _begin_again(self) -> None:
        """Discards all data: another module is connected or shown."""
        self._process_waiting()
        self.data.reset()
        self.plot.reset()
        self._stack.setCurrentWidget(self.empty)
        self._refresh_empty()

    def _refresh_empty(self) -> None:
        if self.is_empty:
            self.empty.refresh()

    # Saving

    def _refresh_saving(self) -> None:
        is_writing = self.note.job.is_writing
        self.stop.setVisible(is_writing)
        self.csv.setDisabled(is_writing)
        self.png.setDisabled(is_writing)

    def _save_values(self) -> None:
        """All samples in sight."""
        self._process_waiting()
        excerpt = self.data.excerpt(*self.plot.time_range.span)
        self.note.save_values(self._place(".csv"), excerpt, wall_offset_s())

    def _save_picture(self) -> None:
        self.note.save_picture(self._place(".png"), self.plot.canvas.grab(), self.footer_text())

    def footer_text(self) -> str:
        """Time, module, port and program version, below a picture."""
        connection = self._ports.current.connection
        shown_at = datetime.fromtimestamp(self.plot.time_range.span.end_s + wall_offset_s()).astimezone()
        port = f"{connection.port} · {connection.baud_rate} baud" if connection.port else tr("Not connected")
        parts = (shown_at.isoformat(" ", "seconds"), self.module.name, port, f"DPS-S Configurator {version()}")
        return "  ·  ".join(part for part in parts if part)

    def _place(self, suffix: str) -> Path:
        documents = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.DocumentsLocation)
        name = self.module.name or self._ports.current.connection.port
        return Path(documents or Path.home()) / default_name(name, suffix, datetime.now().astimezone())

    # Construction

    def _lay_out(self) -> QWidget:
        card = named(QFrame(), "live_plots", "card")
        in_column((self.plot, 1), of=card, margins=Space.S)
        self._seen = named(QWidget(), "live_seen")
        in_row(self.panel, (card, 1), of=self._seen, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))
        head = self.header = self.make_header(tr("Live"))
        head.row.setStretchFactor(head.title, 0)
        head.row.insertWidget(1, self.note, 1)
        for action in (self.stop, self.csv, self.png):
            head.add(action)
        head.row.setContentsMargins(Space.M, Space.XS, Space.M, Space.XS)
        content = named(QWidget(), "live_content")
        in_column(head, (self._seen, 1), of=content, spacing=0, margins=0)
        return content


def _is_same_state(batch: Batch, other: Batch) -> bool:
    return (
        batch.connection == other.connection
        and batch.conversation.number == other.conversation.number
        and batch.conversation.is_going is other.conversation.is_going
        and batch.conversation.reported == other.conversation.reported
    )
