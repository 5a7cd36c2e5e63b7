"""Live page: a column of values beside the plots, which are saved as a picture or a table.

While the page is visible each batch draws, or a timer where no batch comes: the plots only when they moved by a pixel,
the numbers some ten times a second and whenever the module's state changes. Batches are taken at all times, visible
or not. It is always live: recordings are shown on Logs.
"""

from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final, cast

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPixmap, QShowEvent, QWindow
from PySide6.QtWidgets import QFrame, QPushButton, QStackedLayout, QToolButton, QWidget

from app import version
from app.diagnosis.link_state import Phase
from app.engine.worker import Batch, PortState
from app.recordings.excerpt import csv_parts, part_count
from app.recordings.recording import write_parts
from app.system.clock import wall_offset_s
from app.text.i18n import tr
from app.text.messages import not_written, saved_text
from ui.core.background_task import Running
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.pages.live.data import LiveData
from ui.pages.live.panel import LivePanel
from ui.plots.lanes import measured_lanes
from ui.plots.time_plot import TimePlot
from ui.services.context import Services
from ui.services.page import Page
from ui.session.page_job import PageJob
from ui.style.icons import Icon
from ui.style.theme import Size, Space, current, font, is_text_large
from ui.widgets.controls import EmptyState, Shortcut, control, in_column, in_row, named, retain_size, stacked
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

_BUSY: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE, Phase.LATE)
# While no batches come: ages and the time line go on.
DRAW_EVERY_MS: Final = 150
# Numbers that changed faster could not be read.
REFRESH_EVERY_S: Final = 0.06
_FOOT_PX: Final = 28


class LivePage(Page):
    shows_link = True

    def __init__(self, services: Services) -> None:
        super().__init__("live")
        self._ports, self._in_use = services.ports, services.in_use
        self.data = LiveData()
        self.panel = LivePanel()
        lanes = measured_lanes(self.data, self._in_use, self.data.acting, self.data.unproven)
        self.plot = TimePlot(lanes, wall_offset_s=wall_offset_s())
        self.ask_path: AskPath = ask_path
        self.job = PageJob(self)
        self.strip = named(NoticeBar(is_foot=not is_text_large()), "live_notice")
        self.csv = control(QToolButton(), "live_save_csv", says=tr("Save values…"), keys="Ctrl+S", picture=Icon.TABLE)
        self.csv.clicked.connect(self._save_values)
        says = tr("Save picture…")
        self.png = control(QToolButton(), "live_save_png", says=says, keys="Ctrl+Shift+S", picture=Icon.CAMERA)
        self.png.clicked.connect(self._save_picture)
        self._lay_out()
        Shortcut(self.plot.pause, "Ctrl+P", self.plot.time_range.toggle_pause, holder=self._content)
        self._refreshed_at = 0.0
        # With another one the numbers are refreshed at once.
        self._state: object = None
        # The curves are of this port. A conversation that ends there breaks them with a mark.
        self._port = ""
        self._timer = VisibilityTimer(
            self, every_ms=DRAW_EVERY_MS, tick=self._tick_alone, hidden=self._ports.set_drawing_interval
        )
        self.job.changed.connect(self._refresh_saving)
        self._ports.changed.connect(self._refresh_empty)
        self._ports.chosen.connect(self._begin_again)

    def _lay_out(self) -> None:
        # Until there are values: state of the link; what helps in trouble is in the notice.
        self.empty = EmptyState("live_empty", Icon.LIVE)
        choose = QPushButton(tr("Choose a port…"))
        self.choose = control(choose, "live_choose_port", key="Ctrl+K", picture=Icon.PLUG, role="primary")
        self.choose.clicked.connect(self.ports_wanted)
        retain_size(self.choose)
        self.empty.column.insertLayout(4, in_row(1, self.choose, 1))
        head = self.make_header(tr("Live"), self.csv, self.png)
        head.row.setContentsMargins(Space.M, Space.XS, Space.M, Space.XS)
        card = named(QFrame(), "live_plots", "card")
        in_column((self.plot, 1), of=card, margins=Space.S)
        body = in_row(self.panel, (card, 1), spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))
        self._content = named(QWidget(), "live_content")
        column = in_column(head, (body, 1), of=self._content, spacing=0, margins=0)
        if is_text_large():
            column.insertWidget(1, self.strip)
        else:  # room is kept for it: the plots never move
            retain_size(self.strip)
            head.row.setStretchFactor(head.title, 0)
            head.row.insertWidget(1, self.strip, 1)
        self._stack = stacked(QStackedLayout(self), self.empty, self._content)

    @property
    def is_empty(self) -> bool:
        return self._stack.currentWidget() is self.empty

    def on_batch(self, batch: Batch) -> None:
        self.plot.canvas.wall_offset_s = wall_offset_s()  # which changes with the time of day, and with a sleep
        connection, view = batch.connection, batch.conversation
        state = connection, view.number, view.is_going, view.reported
        if state != self._state:
            self._state = state
            self._refreshed_at = 0.0
        if connection.state is PortState.OPEN and connection.port != self._port:
            self._begin_again()
            self._port = connection.port
        self.plot.add_marks(self.data.on_batch(batch))
        if self.isVisible():
            self._timer.timer.start()
            self._tick()

    def refresh(self) -> None:
        now_s = self._refreshed_at = self._ports.clock()
        if self.data.has_samples and self.is_empty:
            self._stack.setCurrentWidget(self._content)
        self._refresh_empty()
        if not self.is_empty:
            direction = self.module.light_direction
            self.panel.show_device(self.module.view, now_s, in_use=self._in_use, direction=direction)

    def draw(self) -> None:
        if not self.is_empty:
            self.plot.draw(self._ports.clock())
            self._ports.set_drawing_interval(self.plot.time_range.pixel_s)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.draw()

    def _tick_alone(self) -> None:
        """Go on with the time; called while no batches come."""
        self._refreshed_at = 0.0
        self._tick()

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

    def _begin_again(self) -> None:
        """Discards all data: another module is connected or shown."""
        self.data.reset()
        self.plot.reset()
        self._stack.setCurrentWidget(self.empty)
        self._refresh_empty()

    def _refresh_empty(self) -> None:
        if self.is_empty:
            state = self._ports.current.state
            is_idle = state.phase is Phase.CLOSED
            self.empty.title.setText(state.word_at(self._ports.clock()))
            self.empty.text.setText(state.next_step)
            self.empty.text.setVisible(is_idle)
            self.choose.setVisible(state.phase not in _BUSY)

    # Saving

    def _refresh_saving(self) -> None:
        self.strip.show_notices(self.job.notices)
        for button in (self.csv, self.png):
            button.setDisabled(self.job.is_busy)

    def _save_values(self) -> None:
        """Save all samples in sight."""
        excerpt = self.data.excerpt(*self.plot.time_range.span)
        parts = csv_parts(excerpt, wall_offset_s=wall_offset_s())
        saved = partial(saved_text, rows=excerpt.row_count, is_whole=excerpt.is_whole)
        self._save(tr("Save values…"), ".csv", parts, part_count(excerpt), saved)

    def _save_picture(self) -> None:
        picture = picture_with_footer(self.plot.canvas.grab(), self.footer_text())
        self._save(tr("Save picture…"), ".png", png_parts(picture), 1, lambda path: tr("Saved to {path}.", path=path))

    def footer_text(self) -> str:
        """Time, module, port and program version, below a picture."""
        connection = self._ports.current.connection
        shown_at = datetime.fromtimestamp(self.plot.time_range.span.end_s + wall_offset_s()).astimezone()
        port = f"{connection.port} · {connection.baud_rate} baud" if connection.port else tr("Not connected")
        parts = (shown_at.isoformat(" ", "seconds"), self.module.name, port, f"DPS-S Configurator {version()}")
        return "  ·  ".join(part for part in parts if part)

    def _save(self, title: str, suffix: str, parts: Iterable[bytes], count: int, saved: Callable[[Path], str]) -> None:
        def save(path: Path) -> None:
            def write(running: Running) -> None:
                write_parts(path, parts, count, running.set_progress_or_end)

            def end(_none: None) -> None:
                self.job.notify_saved(path, saved(path))

            self.job.begin(tr("Saving…"), write, end, partial(not_written, path))

        name = self.module.name or self._ports.current.connection.port
        suggested = default_name(name, suffix, datetime.now().astimezone())
        self.ask_path(self, title, Path(suggested), f"*{suffix}", save)


def picture_with_footer(pixmap: QPixmap, foot: str) -> QImage:
    ratio = pixmap.devicePixelRatio()
    width, height = pixmap.width() / ratio, pixmap.height() / ratio
    whole = QPixmap(pixmap.width(), pixmap.height() + round(_FOOT_PX * ratio))
    whole.setDevicePixelRatio(ratio)
    whole.fill(QColor(current().window))
    painter = QPainter(whole)
    painter.drawPixmap(0, 0, pixmap)
    painter.setFont(font(Size.SMALL))
    painter.setPen(QColor(current().text))
    room = QRectF(Space.M, height, width - 2 * Space.M, _FOOT_PX)
    painter.drawText(room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, foot)
    painter.end()
    return whole.toImage()


def png_parts(image: QImage) -> Iterator[bytes]:
    """The PNG file of `image`, encoded where it is written. Raises OSError."""
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not image.save(buffer, "PNG"):  # type: ignore[call-overload]
        raise OSError("the picture could not be encoded as PNG")
    yield bytes(data.data())
