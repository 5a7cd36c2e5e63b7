"""Triggers page: all trigger records of a module, newest first, with the details and the review of the selected ones.

    head     search, Read
    list     `RowsTable` with all fields as columns, or why it is empty; below it `TriggersDetail`
    foot     export
`TriggerReading` reads the records of the module shown, merges them with the stored ones and stores judgements.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QLabel, QPushButton

from app.store.fact_store import StoreTrouble
from app.text.i18n import tr
from app.text.messages import join_sentences, saved_text
from app.trigger_records.history import Judgement, write_archive
from ui.files.file_dialogs import AskPath, ask_path
from ui.forms.tables import RowsTable, SearchedRows, select_row
from ui.pages.triggers.detail import TriggersDetail
from ui.pages.triggers.model import COLUMNS, Column, count_text, csv_name, empty_text, empty_title, record_text
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.name_question import ModuleField
from ui.session.trigger_reading import TriggerReading
from ui.style.icons import Icon
from ui.style.theme import Meaning, RowHeight, Space
from ui.widgets.controls import ElidedLabel, control, in_column, in_row, named
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

_READ_EVERY_MS: Final = 500
"""Retry interval until the module is online and idle."""


class TriggersPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("triggers")
        self._services, self._ports = services, services.ports
        self.ask_path: AskPath = ask_path
        self._folder = Path.home()
        self._is_review_wanted = False
        self.table = RowsTable(
            "triggers_table",
            tr("Trigger records"),
            COLUMNS,
            lambda row: row.seen.id,
            record_text,
            row_px=RowHeight.TALL,
            sorted_by=Column.WHEN,
        )
        self.detail = TriggersDetail()
        self.strip = named(NoticeBar(), "triggers_notice")
        self.name_field = ModuleField("triggers_module", services.ports)
        self.name_field.setMinimumContentsLength(14)
        self.count = named(QLabel(), "triggers_count", "strong")
        self.known_by = named(ElidedLabel(), "triggers_known_by", "small")
        self._make_buttons()
        self.list = SearchedRows("triggers", self.table, Icon.HISTORY)
        self._lay_out()
        VisibilityTimer(self, self._read_unasked, every_ms=_READ_EVERY_MS, tick=self._read_unasked)
        self._wire()

    @property
    def work(self) -> TriggerReading:
        """Of the module shown."""
        return self.module.triggers

    def refresh(self) -> None:
        work = self.work
        self.list.show_rows(work.rows)
        for shown in (self.list, self.detail):
            shown.setEnabled(self.module.is_going or self.module.end is None)
        has_rows = bool(work.rows)
        self.detail.setVisible(has_rows)
        if has_rows and self._is_review_wanted and work.reading is not None and not work.is_busy:
            self._is_review_wanted = False
            self.table.choose(lambda row: row.is_on_module and row.seen.judgement is None)
        if has_rows and not self.table.selectionModel().hasSelection():
            select_row(self.table, 0)
        self.list.empty.title.setText(empty_title(work))
        notice = work.notice() or self._idle_notice()
        why = empty_text(work, is_open=self._ports.current.is_open)
        is_told = notice is not None and notice.text.startswith(why)
        self.list.empty.text.setText("" if is_told else why)
        self.count.setText(count_text(work))
        self.known_by.setText(self.module.known_by.translated() if has_rows else "")
        self.read.setEnabled(work.can_read)
        for widget in (self.export, self.list.search):
            widget.setEnabled(has_rows)
        self.strip.show_notice(notice)
        self._show_detail()

    def _read(self) -> None:
        self.work.read()

    def _judge(self, record_id: int, judgement: Judgement | None, note: str) -> None:
        self.work.judge(record_id, judgement, note)

    def _read_unasked(self) -> None:
        self.work.read_unasked()

    def _idle_notice(self) -> Notice | None:
        """Why the records are not stored."""
        if not self.work.rows or self.work.rows[0].is_stored:
            return None
        if not self.module.name:
            text = tr("Name the module to keep these records.")
            return Notice(Meaning.INFORMATION, text, (Choice("name_it", tr("Name it"), self.name_field.setFocus),))
        store = self._services.storage.store
        if isinstance(store, StoreTrouble):
            return Notice(Meaning.ATTENTION, join_sentences((store.sentence, tr("Not kept."))))
        return None

    def _show_detail(self) -> None:
        chosen = self.table.chosen()
        self.detail.show_rows(chosen)
        if self.isVisible():
            self.module.keep_looked_at(row.seen.raw for row in chosen if row.is_on_module)

    def _choose_unreviewed(self) -> None:
        """Choose the records on the module that nobody has reviewed, as soon as they are there."""
        self._is_review_wanted = True
        self.refresh()

    def _export(self) -> None:
        """The rows shown, which are all unless something is searched."""
        name, rows = self.module.name, self.table.filter.shown()
        once = frozenset(row.seen.id for row in rows if row.is_seen_once)
        write = partial(write_archive, module=name, records=[row.seen for row in rows], seen_once=once)
        save = partial(self._save_to, write, len(rows))
        self.ask_path(self, tr("Export…"), self._folder / csv_name(name), "*.csv", save)

    def _save_to(self, write: Callable[[Path], object], count: int, path: Path) -> None:
        self._folder = path.parent
        self.work.job.write_file(path, partial(write, path), lambda _none: saved_text(path, count))

    # Making

    def _make_buttons(self) -> None:
        self.read = control(
            QPushButton(tr("Read")),
            "triggers_read",
            keys="F5",
            picture=Icon.HISTORY,
            role="primary",
            slot=self._read,
        )
        self.export = control(
            QPushButton(tr("Export…")), "triggers_export", keys="Ctrl+S", picture=Icon.SAVE, slot=self._export
        )

    def _wire(self) -> None:
        self.table.selectionModel().selectionChanged.connect(self._show_detail)
        self.detail.judged.connect(self._judge)
        self._services.exchange.review_wanted.connect(self._choose_unreviewed)
        self.saving = self.exporting = self.export

    def _lay_out(self) -> None:
        head = self.make_header(tr("Triggers"), self.list.search, self.read)
        foot = in_row(1, self.export, spacing=Space.S)
        says = in_row(self.count, (self.known_by, 1), self.name_field, spacing=Space.M)
        in_column(
            head,
            says,
            (self.list, 1),
            self.detail,
            self.strip,
            foot,
            of=self,
            spacing=Space.S,
            margins=(Space.M, 0, Space.M, Space.S),
        )

    # Qt

    def ways_back(self) -> WaysBack:
        work = self.work
        return (
            (work.is_busy, work.job.cancel),
            (work.notice(), work.job.dismiss),
        )
