"""Triggers page: all trigger records of a module, newest first, with the details and the review of the selected ones.

    head     search, filter, Read
    list     `RowsTable`, or why it is empty; beside it `TriggersDetail`
    foot     copy, export
`TriggersController` reads the records, merges them with the stored ones and stores judgements.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics, QGuiApplication
from PySide6.QtWidgets import (
    QComboBox,
    QFrame,
    QLabel,
    QLineEdit,
    QPushButton,
    QStackedWidget,
    QToolButton,
)

from app.recordings.export import not_saved_text
from app.records.check_store import MAX_NOTE_LENGTH
from app.records.trigger_archive import write_archive
from app.store.database import StoreTrouble
from app.system.wall_clock import local_time
from app.text.i18n import tr
from app.text.sentences import capitalised, join_sentences, with_units
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, cause_message, uptime_message
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.files.file_dialogs import AskPath, ask_path
from ui.forms.rows_table import FactRows, RowsTable
from ui.forms.table_kit import select_row
from ui.pages.triggers.controller import TriggerRow, TriggersController
from ui.pages.triggers.model import (
    COLUMNS,
    Column,
    Show,
    as_text,
    count_text,
    csv_name,
    empty_text,
    empty_title,
    is_chosen,
    news_text,
    record_text,
    sources_text,
)
from ui.plots.trigger_picture import TriggerPicture
from ui.services.context import Services
from ui.services.module_field import ModuleField
from ui.services.page import Page
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, fixed_font, font
from ui.widgets.controls import Shortcut, control, named
from ui.widgets.labels import ElidedLabel, EmptyState, text_label
from ui.widgets.layouts import FlowRow, Gap, in_column, in_row, scroll_area
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_FACTS: Final = {
    "link": Column.LINK,
    "charger": Column.CHARGE,
    "light": Column.LIGHT,
    "cell": Column.CELL,
}
"""Those of the table's columns that may be hidden there."""
JUDGEMENTS: Final = (None, *Judgement)
WIDTH_PX: Final = 304
_WITH_PICTURE_LINES: Final = 28
"""Height of the page, in lines of text, from which the picture is shown."""


class TriggersDetail(QFrame):
    """`judged`: the record's id, the judgement (None removes it) and the note."""

    judged = Signal(int, object, str)

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "triggers_detail", "card")
        self._rows: Sequence[TriggerRow] = ()
        self._note_of: int | None = None
        self._has_picture = True
        self.picture = TriggerPicture("triggers_picture")
        self.cause = text_label("triggers_cause", "strong", is_selectable=True)
        self.facts = FactRows(
            texts, "triggers", {"when": marked("When")} | {key: COLUMNS[one].title for key, one in _FACTS.items()}
        )
        self.seen = text_label("triggers_seen", "small", is_selectable=True)
        self.bytes = text_label("triggers_bytes", "muted", is_selectable=True)
        self.bytes.hide()
        self.raw = control(QToolButton(), texts, "triggers_raw", "Raw bytes", is_checkable=True)
        self.raw.toggled.connect(self.bytes.setVisible)
        self.buttons: dict[Judgement | None, QToolButton] = {}
        for judgement in JUDGEMENTS:
            name = "none" if judgement is None else judgement.name.lower()
            text = marked("not reviewed") if judgement is None else JUDGEMENT_WORDS[judgement]
            self.buttons[judgement] = control(QToolButton(), texts, f"triggers_judge_{name}", text, role="choice",
                                              is_checkable=True, slot=partial(self._judge, judgement))  # fmt: skip
        self.note = control(QLineEdit(), texts, "triggers_note", says="Note", tip="Note")
        self.note.setMaxLength(MAX_NOTE_LENGTH)
        texts.bind(self.note.setPlaceholderText, "Note")
        self.note.editingFinished.connect(self._commit_note)
        self._lay_out()
        self.show_rows(())

    @property
    def _row(self) -> TriggerRow | None:
        return self._rows[0] if len(self._rows) == 1 else None

    def show_rows(self, rows: Sequence[TriggerRow]) -> None:
        """The selected rows; several are judged at once."""
        self._rows, row = rows, rows[0] if len(rows) == 1 else None
        for widget in (self.facts, self.raw, self.note, self.seen):
            widget.setVisible(row is not None)
        self.picture.setVisible(row is not None and self._has_picture)
        self.bytes.setVisible(row is not None and self.raw.isChecked())
        said = {one.seen.judgement for one in rows if one.is_stored}
        for judgement, button in self.buttons.items():
            button.setVisible(bool(rows))
            button.setChecked(said == {judgement})
            button.setEnabled(bool(said))
        if row is None:
            self.cause.setText(tr("{count} selected", count=len(rows)) if rows else tr("Select a row."))
            self._note_of = None
            return
        self.cause.setText(with_units(capitalised(cause_message(row.record).translated())))
        when = tr("{uptime} after power-on, boot {boot}", boot=row.record.boot_count,
                  uptime=uptime_message(row.record).translated())  # fmt: skip
        self.facts.show_facts({"when": when} | {key: COLUMNS[one].text(row) for key, one in _FACTS.items()})
        self.picture.show_record(row.record, sources_text(row.record.sources))
        self.bytes.setText(row.record.raw.hex(" ").upper())
        self.bytes.setFont(fixed_font(Size.SMALL))
        self.seen.setText(self._seen_text(row))
        self.note.setEnabled(row.is_stored)
        if self._note_of != row.seen.id or not self.note.hasFocus():
            self.note.setText(row.seen.note)
        self._note_of = row.seen.id

    @staticmethod
    def _seen_text(row: TriggerRow) -> str:
        if row.is_seen_once:
            return tr("Seen in one reading only. Read again.")
        if row.is_being_stored:
            return tr("Saving…")
        if not row.is_stored:
            return tr("Not kept.")
        where = tr("On the module") if row.is_on_module else tr("No longer on the module")
        return f"{tr('First seen {time}', time=local_time(row.seen.first_seen_at))} · {where}"

    def _judge(self, judgement: Judgement | None, _is_checked: bool = False) -> None:
        for one, button in self.buttons.items():
            button.setChecked(one is judgement)
        alone = self._row
        for row in self._rows:
            if row.is_stored:
                self.judged.emit(row.seen.id, judgement, row.seen.note if alone is None else self.note.text())

    def _commit_note(self) -> None:
        row = self._row
        if row is not None and row.is_stored and self.note.text() != row.seen.note:
            self.judged.emit(row.seen.id, row.seen.judgement, self.note.text())

    def fit_height(self, page_px: int) -> None:
        """Hides the picture on a low page."""
        self._has_picture = page_px >= _WITH_PICTURE_LINES * QFontMetrics(font()).height()
        self.picture.setVisible(self._row is not None and self._has_picture)

    def _lay_out(self) -> None:
        judging = FlowRow()
        judging.add(*self.buttons.values())
        in_column(
            self.picture,
            self.cause,
            self.facts,
            self.seen,
            Gap(Space.XS),
            judging,
            self.note,
            1,
            self.bytes,
            (self.raw, Qt.AlignmentFlag.AlignRight),
            of=self,
            spacing=Space.S,
            margins=Space.M,
        )


_ROW_PX: Final = 36
_SEARCH_PX: Final = 140
_READ_EVERY_MS: Final = 500
"""Retry interval until the module is online and idle."""


class TriggersPage(Page):
    """See the module's docstring."""

    def __init__(self, services: Services) -> None:
        super().__init__("triggers")
        self._services, self._connector = services, services.connector
        self.ask_path: AskPath = ask_path
        self._folder = Path.home()
        self.work = TriggersController(services, self)
        self.table = RowsTable(services.texts, "triggers_table", "Trigger records", COLUMNS, lambda row: row.seen.id,
                               record_text, row_px=_ROW_PX, sorted_by=Column.WHEN,
                               searches_sentence=True)  # fmt: skip
        self.detail = TriggersDetail(services.texts)
        self.strip = named(NoticeBar(services.texts), "triggers_notice")
        guard = WheelGuard(self)
        self.module = ModuleField("triggers_module", services.connector, services.texts, guard)
        self.module.setMinimumContentsLength(14)
        self.count = named(QLabel(), "triggers_count", "strong")
        self.news = named(ElidedLabel(), "triggers_news", "small")
        self.show_box = control(QComboBox(), services.texts, "triggers_show", says="Filter", tip="Filter")
        self._make_show(guard)
        self.search = control(QLineEdit(), services.texts, "triggers_search", says="Search", key="Ctrl+F")
        self.search.setFixedWidth(_SEARCH_PX)
        self.search.setClearButtonEnabled(True)
        self._make_buttons()
        self.empty = EmptyState("triggers_empty", Icon.HISTORY, services.texts)
        self.no_match = EmptyState("triggers_no_match", Icon.HISTORY, services.texts, marked("No matches"))
        self._stack = QStackedWidget()
        for widget in (self.empty, self.table, self.no_match):
            self._stack.addWidget(widget)
        self._lay_out()
        timer = VisibilityTimer(
            self, self._on_shown, every_ms=_READ_EVERY_MS, tick=self.work.read_unasked, retranslate=self.refresh
        )
        self.work.changed.connect(timer.refresh_seen)
        self._wire()
        self.refresh()

    def refresh(self) -> None:
        work = self.work
        self.table.show_rows(work.rows)
        has_rows = bool(work.rows)
        self._show_list()
        if has_rows and not self.table.selectionModel().hasSelection():
            select_row(self.table, 0)
        self.empty.title.setText(empty_title(work))
        self.empty.text.setText(empty_text(work, is_open=self._connector.current.is_open))
        self.count.setText(count_text(work))
        known_by = self._connector.current.module.known_by if has_rows else ""
        self.news.setText(" · ".join(filter(None, (news_text(work), known_by))))
        self.read.setEnabled(work.can_read)
        for widget in (self.copy, self.save_page, self.save_archive, self.show_box, self.search):
            widget.setEnabled(has_rows)
        self.strip.show_notice(work.notice() or self._idle_notice())
        self._show_detail()

    def _show_list(self) -> None:
        """The list with the details, or why it is empty."""
        found = self.table if self.table.filter.rowCount() else self.no_match
        self._stack.setCurrentWidget(found if self.work.rows else self.empty)
        self._beside.setVisible(bool(self.work.rows))

    def _on_shown(self) -> None:
        self.work.read_unasked()
        self.refresh()

    def _idle_notice(self) -> Notice | None:
        """Why the records are not stored."""
        if not self.work.rows or self.work.rows[0].is_stored:
            return None
        if not self._connector.current.module.name:
            text = tr("Name the module to keep these records.")
            return Notice(Meaning.INFORMATION, text, (Choice("name_it", tr("Name it"), self.module.setFocus),))
        store = self._services.storage.store
        if isinstance(store, StoreTrouble):
            return Notice(Meaning.ATTENTION, join_sentences((store.sentence, tr("Not kept."))))
        return None

    def _show_detail(self) -> None:
        self.detail.show_rows(self.table.chosen())

    def copy_rows(self) -> None:
        """Copies the selected rows, else all shown ones."""
        QGuiApplication.clipboard().setText(as_text(self.table.chosen() or self.table.filter.shown()))

    def _save(self, _is_checked: bool = False, *, is_archive: bool) -> None:
        rows = self.work.rows if is_archive else self.table.filter.shown()
        name = self._connector.current.module.name
        title = tr("Export all…") if is_archive else tr("Export shown…")
        new = frozenset(row.seen.id for row in rows if row.is_new)
        has_past = self.work.reading is not None and not self.work.is_first_visit
        once = frozenset(row.seen.id for row in rows if row.is_seen_once)
        records = [row.seen for row in rows]
        write = partial(write_archive, module=name, records=records, new=new if has_past else None, seen_once=once)
        save = partial(self._save_to, write, len(rows))
        self.ask_path(self, title, self._folder / csv_name(name), tr("Table (*.csv)"), save)

    def _save_to(self, write: Callable[[Path], object], count: int, path: Path) -> None:
        try:
            write(path)
        except OSError as error:
            fault = error  # the name of an except clause ends with it
            self.work.job.notify(Meaning.DANGER, lambda: not_saved_text(path, fault))
            return
        self._folder = path.parent
        self.work.job.notify(Meaning.GOOD, lambda: tr("Saved to {path}. Rows: {rows}.", rows=count, path=path))

    def _use_filter(self) -> None:
        self.table.filter.use(self.search.text(), partial(is_chosen, self.show_box.currentData()))
        self._show_list()
        self._show_detail()

    # Making

    def _name_entry(self, number: int, text: str) -> None:
        self.show_box.setItemText(number, capitalised(text))

    def _make_show(self, guard: WheelGuard) -> None:
        box = self.show_box
        for number, show in enumerate(Show):
            box.addItem("", show)
            self._services.texts.bind(partial(self._name_entry, number), show.value)
        box.setMinimumContentsLength(10)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        guard.guard(box)

    def _make_buttons(self) -> None:
        texts = self._services.texts
        self.read = control(QPushButton(), texts, "triggers_read", "Read", key="F5", picture=Icon.HISTORY,
                            role="primary", slot=self.work.read)  # fmt: skip
        self.copy = control(QPushButton(), texts, "triggers_copy", "Copy", key="Ctrl+C", picture=Icon.TABLE,
                            slot=self.copy_rows)  # fmt: skip
        self.save_page = control(QPushButton(), texts, "triggers_save_page", "Export shown…", key="Ctrl+S",
                                 picture=Icon.SAVE, slot=partial(self._save, is_archive=False))  # fmt: skip
        self.save_archive = control(QPushButton(), texts, "triggers_save_archive", "Export all…", key="Ctrl+Shift+S",
                                    picture=Icon.SAVE, slot=partial(self._save, is_archive=True))  # fmt: skip
        texts.bind(self.search.setPlaceholderText, "Search")

    def _wire(self) -> None:
        self.show_box.currentIndexChanged.connect(self._use_filter)
        self.search.textChanged.connect(self._use_filter)
        self.table.selectionModel().selectionChanged.connect(self._show_detail)
        self.detail.judged.connect(self.work.judge)
        Shortcut("triggers_read_key", self, self.read)
        Shortcut("triggers_copy_key", self, self.copy)
        self.saving = Shortcut("triggers_save_key", self, self.save_page)
        self.exporting = Shortcut("triggers_archive_key", self, self.save_archive)
        Shortcut("triggers_search_key", self, self.search, self.search.setFocus)

    def _lay_out(self) -> None:
        texts = self._services.texts
        head = self.make_header(texts, marked("Triggers"), self.search, self.show_box, self.read)
        foot = FlowRow()
        foot.add_right(self.copy, self.save_page, self.save_archive)
        says = in_row(self.count, (self.news, 1), self.module, spacing=Space.M)
        beside = self._beside = scroll_area(self.detail, texts, "triggers_scroll", "Trigger records", is_vertical=True)
        beside.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        beside.setFixedWidth(WIDTH_PX)
        lists = in_row((self._stack, 1), beside, spacing=Space.S)
        in_column(
            head,
            says,
            (lists, 1),
            self.strip,
            foot,
            of=self,
            spacing=Space.S,
            margins=(Space.M, 0, Space.M, Space.S),
        )

    # Qt

    def fit(self) -> None:
        self.detail.fit_height(self.height())

    def on_escape(self) -> bool:
        """Cancels reading or closes a message."""
        if self.work.is_busy:
            self.work.job.cancel()
        elif self.work.notice() is not None:
            self.work.job.dismiss()
        else:
            return False
        return True
