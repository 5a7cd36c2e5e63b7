"""Recordings page: lists, opens, exports, pins and deletes recorded sessions, each with an outline of its tilt."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, QPointF, QRectF, Signal
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QStyledItemDelegate, QStyleOptionViewItem, QTableView

from app.recordings.entry_texts import entry_text, size_text, when_text
from app.recordings.library import RecordingEntry
from app.recordings.recording import tilt_outline
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences, labelled
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.forms.rows_table import RowsTable, SearchedRows
from ui.forms.table_kit import ROW_ROLE, Index, select_row
from ui.pages.recordings.detail import WIDTH_PX, RecordingsDetail
from ui.pages.recordings.model import COLUMNS, Column
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page import Page, WaysBack
from ui.services.recording_jobs import ExportKind
from ui.style.icons import Icon
from ui.style.painted_widget import pen
from ui.style.theme import Meaning, Space, Theme, current, scaled
from ui.widgets.controls import named
from ui.widgets.labels import ElidedLabel
from ui.widgets.layouts import in_column, in_row
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

ROW_PX: Final = 44
_FRAME_PX: Final = 8
"""Padding of the style at both sides of a cell."""


BUCKETS: Final = 96
_AT_ONCE: Final = 8
"""Read at a time."""
_TOP_DEG: Final = 90.0
Outline = tuple[tuple[float, float], ...]


class Outlines(QObject):
    """Cache of outlines. `changed`: more are available."""

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._known: dict[Path, tuple[int, Outline]] = {}
        """With the number of samples then, since a running recording grows; it is read again when it has grown by a
        twentieth, not each time that it is listed."""
        self._reading: BackgroundTask[dict[Path, tuple[int, Outline]]] = BackgroundTask("dps-s outlines", self)

    def of(self, entry: RecordingEntry) -> Outline:
        """The outline; empty until it is read."""
        return self._known.get(entry.path, (0, ()))[1]

    def read(self, entries: Iterable[RecordingEntry]) -> None:
        """Reads some missing ones; called repeatedly while the page is visible."""
        if self._reading.is_running:
            return
        missing = [entry for entry in entries if entry.trouble is None and not self._is_known(entry)][:_AT_ONCE]
        if missing:
            self._reading.run(lambda running: _outlines(missing, running), self._on_read, lambda _error: None)

    def _is_known(self, entry: RecordingEntry) -> bool:
        count = self._known.get(entry.path, (-1, ()))[0]
        return count == entry.sample_count or (entry.is_running and count <= entry.sample_count < 1.05 * count)

    def _on_read(self, outlines: dict[Path, tuple[int, Outline]]) -> None:
        self._known |= outlines
        self.changed.emit()


def _outlines(missing: list[RecordingEntry], running: Running) -> dict[Path, tuple[int, Outline]]:
    return {
        entry.path: (entry.sample_count, tilt_outline(entry, BUCKETS))
        for entry in missing
        if not running.is_cancelled()
    }


def draw_outline(painter: QPainter, box: QRectF, outline: Outline, theme: Theme) -> None:
    """Draws the tilt from 0 to 90°, or to 180° where it was larger; moves the painter."""
    painter.setPen(pen(theme.divider if theme.border_px == 1 else theme.muted, 1))
    painter.drawLine(box.bottomLeft(), box.bottomRight())
    if not outline:
        return
    top_deg = _TOP_DEG if max(high for _, high in outline) <= _TOP_DEG else 2 * _TOP_DEG
    painter.translate(box.bottomLeft())
    painter.scale(box.width() / len(outline), -box.height() / top_deg)
    line = pen(theme.curves[0], theme.line_px * painter.device().devicePixelRatioF())
    line.setCosmetic(True)  # in device pixels
    painter.setPen(line)
    painter.drawPolyline([QPointF(number + 0.5, value) for number, ends in enumerate(outline) for value in ends])


class OutlineDelegate(QStyledItemDelegate):
    def __init__(self, outlines: Outlines, parent: QTableView) -> None:
        super().__init__(parent)
        self._outlines = outlines

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        entry = index.data(ROW_ROLE)
        if isinstance(entry, RecordingEntry):
            painter.save()
            box = QRectF(option.rect).adjusted(_FRAME_PX, 7, -_FRAME_PX, -7)
            draw_outline(painter, box, self._outlines.of(entry), current())
            painter.restore()


class PinDelegate(QStyledItemDelegate):
    """Paints the icon only, since the header says the word; the model's text is for search and screen readers."""

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        option.text = ""


_LIST_EVERY_MS: Final = 2000
"""For the growing recording, while the page is visible."""


class RecordingsPage(Page):
    suffixes = (".mcap",)

    def __init__(self, services: Services) -> None:
        super().__init__("recordings")
        self._services = services
        self.work = services.storage.recordings
        self.ask_path: AskPath = ask_path
        self._folder = Path.home()
        self._to_delete: tuple[RecordingEntry, ...] = ()
        """Recordings whose deletion needs confirmation."""
        self.outlines = Outlines(self)
        self.table = RowsTable(
            "recordings_table",
            tr("Recordings"),
            COLUMNS,
            lambda entry: entry.path,
            entry_text,
            row_px=ROW_PX,
            sorted_by=Column.WHEN,
        )
        self.table.setAlternatingRowColors(True)
        self.table.setItemDelegateForColumn(Column.TILT, OutlineDelegate(self.outlines, self.table))
        self.table.setItemDelegateForColumn(Column.PINNED, PinDelegate(self.table))
        self.outlines.changed.connect(self.table.viewport().update)
        self.strip = named(NoticeBar(), "recordings_notice")
        self.bounds = named(ElidedLabel(), "recordings_bounds", "small")
        self.detail = RecordingsDetail()
        words = tr("No recordings yet"), tr("Every session is recorded automatically.")
        self.list = SearchedRows("recordings", self.table, Icon.RECORDINGS, *words)
        self._lay_out()
        VisibilityTimer(self, self.work.refresh, every_ms=_LIST_EVERY_MS)
        self.work.changed.connect(VisibilityTimer(self, self.refresh).refresh_seen)
        self._wire()
        self.refresh()

    def refresh(self) -> None:
        work, chosen = self.work, self.table.chosen()
        self.list.show_rows(work.entries)
        paths = {entry.path for entry in chosen}
        if {entry.path for entry in self.table.chosen()} != paths:
            self.table.choose(lambda entry: entry.path in paths)
        has_entries = bool(work.entries)
        self.outlines.read(work.entries)
        self.detail.setVisible(has_entries)
        if has_entries and not self.table.chosen() and not self._to_delete:
            select_row(self.table, 0)
        self.bounds.setText(self._bounds_text())
        self._refresh_notice()
        self._refresh_buttons()

    def _refresh_notice(self) -> None:
        is_asked = self._to_delete and not self.work.is_busy
        self.strip.show_notice(self._question() if is_asked else self.work.notice())

    def _refresh_buttons(self) -> None:
        self.detail.show_chosen(self.table.chosen(), is_idle=not self.work.is_busy)

    def _bounds_text(self) -> str:
        library = self.work.library
        used = size_text(sum(entry.size_bytes for entry in self.work.entries if not entry.is_pinned))
        text = tr("{used} of {size} used; then the oldest are deleted.", used=used, size=size_text(library.max_bytes))
        return f"{len(self.work.entries):,} · {text}"

    def _question(self) -> Notice:
        entries = self._to_delete
        what = entry_text(entries[0])
        if len(entries) > 1:
            size = size_text(sum(entry.size_bytes for entry in entries))
            what = join_names((labelled(tr("Recordings"), len(entries)), size))
        kept = sum(entry.is_pinned for entry in entries) if len(entries) > 1 else 0
        pinned = [labelled(capitalised(tr("pinned")), kept)] if kept else []
        text = join_sentences((tr("Delete for good? {what}", what=what), *pinned))
        choices = (
            Choice("delete_recordings", tr("Delete for good"), self._delete, is_step=True),
            Choice("keep_recordings", tr("Cancel"), self._cancel_deletion, is_main=True),
        )
        return Notice(Meaning.ATTENTION, text, choices)

    def _show_opened(self) -> None:
        """Not a lambda, which what is no part of the window would hold, and with it the whole window."""
        self.page_wanted.emit("live")

    def _open_chosen(self) -> None:
        if self.detail.open.isEnabled():
            self.work.open(self.table.chosen()[0])

    def _export(self, kind: ExportKind) -> None:
        chosen = self.table.chosen()
        if len(chosen) != 1 or not self.detail.csv.isEnabled():
            return
        entry = chosen[0]
        name = default_name(entry.module or entry.port, kind.value, entry.started_at.astimezone())
        title = tr("Recording of {time}", time=when_text(entry))

        def export(path: Path) -> None:
            self._folder = path.parent
            self.work.export(entry, path, kind)

        self.ask_path(self, title, self._folder / name, f"*{kind.value}", export)

    def _toggle_pin(self) -> None:
        chosen = self.table.chosen()
        self.work.set_pinned(chosen, is_pinned=not all(entry.is_pinned for entry in chosen))

    def _ask_to_delete(self) -> None:
        if self.detail.delete.isEnabled():
            self._to_delete = self.table.chosen()
            self._refresh_notice()
            button = self.strip.button("keep_recordings")
            if button is not None:
                button.setFocus()

    def _delete(self) -> None:
        entries, self._to_delete = self._to_delete, ()
        self.work.delete(entries)
        self.table.setFocus()

    def _cancel_deletion(self) -> None:
        self._to_delete = ()
        self._refresh_notice()
        self.table.setFocus()

    def _on_selection_changed(self) -> None:
        """Cancels the question when other recordings are selected."""
        if self._to_delete and self.table.chosen() and self.table.chosen() != self._to_delete:
            self._to_delete = ()
        self._refresh_notice()
        self._refresh_buttons()

    def open_file(self, path: Path) -> None:
        self.work.open_file(path)

    # Making

    def _wire(self) -> None:
        self.outlines.changed.connect(lambda: self.outlines.read(self.work.entries))
        self.work.opened.connect(self._show_opened)
        self.detail.open.clicked.connect(self._open_chosen)
        self.detail.csv.clicked.connect(partial(self._export, ExportKind.CSV))
        self.detail.mcap.clicked.connect(partial(self._export, ExportKind.MCAP))
        self.detail.pin.clicked.connect(self._toggle_pin)
        self.detail.delete.clicked.connect(self._ask_to_delete)
        self.table.opened.connect(self._open_chosen)
        self.table.remove_wanted.connect(self._ask_to_delete)
        self.table.selectionModel().selectionChanged.connect(self._on_selection_changed)
        self.saving, self.exporting = self.detail.csv, self.detail.mcap

    def _lay_out(self) -> None:
        head = self.make_header(tr("Recordings"), self.list.search)
        head.row.setStretchFactor(head.title, 0)
        head.row.insertWidget(1, self.bounds, 1)
        self.detail.setFixedWidth(scaled(WIDTH_PX))
        lists = in_row((self.list, 1), self.detail, spacing=Space.S)
        in_column(head, (lists, 1), self.strip, of=self, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))

    # Qt

    def notices(self) -> list[JobNotice]:
        return [self.work]

    def ways_back(self) -> WaysBack:
        return (
            (self.work.is_busy, self.work.cancel_files),
            (self._to_delete, self._cancel_deletion),
            (self.work.notice(), self.work.dismiss),
        )
