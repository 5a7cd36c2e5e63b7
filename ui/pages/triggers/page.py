"""Triggers page: all trigger records of a module, newest first, with the details and the review of the selected ones.

    head     search, Read
    list     `RowsTable` with all fields as columns, or why it is empty; below it `TriggersDetail`
    foot     export
`TriggerReading` reads the records of the module shown, merges them with the stored ones and stores judgements.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QLineEdit, QPushButton, QToolButton

from app.limits.limits import record_outside
from app.store.fact_store import StoreError
from app.store.rows import Judgement
from app.system.clock import local_time
from app.text.i18n import tr
from app.text.messages import capitalised, join_sentences, labelled, saved_text, with_units
from app.trigger_records.history import MAX_NOTE_LENGTH, sentence, source_message, uptime_message, write_archive
from protocol.translatable import marked
from ui.files.file_dialogs import AskPath, ask_path
from ui.forms.tables import RowsTable, SearchedRows, TableColumn, select_row
from ui.services.context import Services
from ui.services.page import Page, WaysBack
from ui.session.trigger_reading import TriggerReading, TriggerRow
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, RowHeight, Size, Space, fixed_font, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, text_label
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Choice, Notice
from ui.widgets.visibility_timer import VisibilityTimer

# Retry interval until the module is online and idle.
_READ_EVERY_MS: Final = 500


def record_text(row: TriggerRow) -> str:
    text = sentence(row.record).translated()
    if row.is_seen_once:
        text = labelled(capitalised(tr("seen once")), text)
    return f"{text} — {row.seen.note}" if row.seen.note else text


def _when(row: TriggerRow) -> str:
    uptime = uptime_message(row.record).translated()
    return tr("{uptime} · boot {boot}", boot=row.record.boot_count, uptime=uptime)


def _why(row: TriggerRow) -> str:
    return " + ".join(source_message(name).translated() for name in row.record.sources) or tr("no cause stated")


def _settings(row: TriggerRow) -> str:
    record = row.record
    return f"{record.attitude_threshold_deg}° {record.freefall_acceleration_g:.1f} g {record.freefall_time_s:.2f} s"


def _judged(row: TriggerRow) -> str:
    if row.is_seen_once:
        return tr("seen once")
    return "—" if row.seen.judgement is None else tr(row.seen.judgement.value)


def _cell_meaning(row: TriggerRow) -> Meaning | None:
    is_suspect = row.record.implausible or record_outside(row.record) is not None
    return Meaning.ATTENTION if is_suspect else None


def _settings_key(row: TriggerRow) -> float:
    return row.record.attitude_threshold_deg


def _light_key(row: TriggerRow) -> float:
    return row.record.light_v


def _spare(
    title: str, text: Callable[[TriggerRow], str], widest: Callable[[], str], **more: Any
) -> TableColumn[TriggerRow]:
    return TableColumn(title, text, widest=widest, is_spare=True, **more)


COLUMNS: Final[tuple[TableColumn[TriggerRow], ...]] = (
    TableColumn(
        marked("After power-on"),
        _when,
        lambda row: float(row.seen.place),
        picture=lambda row: icon(Icon.UNKNOWN, Meaning.ATTENTION) if row.is_seen_once else None,
    ),
    TableColumn(
        marked("Why"),
        _why,
        widest=lambda: max(f"{tr('attitude')} + {tr('free fall')}", f"{tr('serial')} + PWM", key=len),
        stretches=True,
    ),
    _spare(marked("Settings"), _settings, lambda: "180° 2.5 g 2.55 s", sort_key=_settings_key),
    _spare(
        marked("Link"),
        lambda row: tr("yes") if row.record.serial_connected else tr("no"),
        lambda: tr("yes"),
    ),
    _spare(marked("Charger"), lambda row: tr("yes") if row.record.charging else tr("no"), lambda: tr("yes")),
    _spare(marked("Light"), lambda row: f"{row.record.light_v:.1f} V", lambda: "25.5 V", sort_key=_light_key),
    _spare(
        marked("Cell"),
        lambda row: f"{row.record.cell_voltage_v:.2f} V",  # the sentence says what is wrong with it
        lambda: "0.00 V",
        sort_key=lambda row: row.record.cell_voltage_v,
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if _cell_meaning(row) else None,
        ink=_cell_meaning,
    ),
    TableColumn(
        marked("Reviewed"), _judged, widest=lambda: max(tr("seen once"), *(tr(one.value) for one in Judgement), key=len)
    ),
)


class TriggersPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("triggers")
        self._services, self._ports = services, services.ports
        self.ask_path: AskPath = ask_path
        self._is_review_wanted = False
        self.table = RowsTable(
            "triggers_table",
            tr("Trigger records"),
            COLUMNS,
            lambda row: (row.is_stored, row.seen.place),
            record_text,
            row_px=RowHeight.TALL,
            sorted_by=0,
        )
        self.detail = TriggersDetail(lambda: self.work)
        self.strip = named(NoticeBar(), "triggers_notice")
        self.count = named(QLabel(), "triggers_count", "strong")
        self.list = SearchedRows("triggers", self.table, Icon.HISTORY)
        self.read = control(QPushButton(tr("Read")), "triggers_read", keys="F5", picture=Icon.HISTORY, role="primary")
        self.read.clicked.connect(lambda _is_checked: self.work.read())
        self.export = control(QPushButton(tr("Export…")), "triggers_export", keys="Ctrl+S", picture=Icon.SAVE)
        self.export.clicked.connect(self._export)
        head = self.make_header(tr("Triggers"), self.list.search, self.read)
        foot = in_row(1, self.export, spacing=Space.S)
        parts = (head, self.count, (self.list, 1), self.detail, self.strip, foot)
        in_column(*parts, of=self, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))
        self.table.selectionModel().selectionChanged.connect(self._show_detail)
        services.exchange.review_wanted.connect(self._choose_unreviewed)
        VisibilityTimer(self, self._read_unasked, every_ms=_READ_EVERY_MS)

    @property
    def work(self) -> TriggerReading:
        return self.module.triggers

    def refresh(self) -> None:
        work, empty = self.work, self.list.empty
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
        title, why = _why_empty(work, is_open=self._ports.current.is_open)
        notices = work.job.notices or self._idle_notices()
        empty.title.setText(title)
        empty.text.setText("" if notices and notices[0].text.startswith(why) else why)
        # Without a number while the list is empty: its place says why.
        self.count.setText(labelled(tr("Trigger records"), len(work.rows)) if has_rows else tr("Trigger records"))
        self.read.setEnabled(work.can_read)
        for widget in (self.export, self.list.search):
            widget.setEnabled(has_rows)
        self.strip.show_notices(notices)
        self._show_detail()

    def _read_unasked(self) -> None:
        self.work.read_unasked()

    def _idle_notices(self) -> list[Notice]:
        """Why the records are not stored."""
        if not self.work.rows or self.work.rows[0].is_stored:
            return []
        if not self.module.name:
            name_it = Choice("name_it", tr("Name it"), lambda: self.page_wanted.emit("preflight"))
            return [Notice(Meaning.INFORMATION, tr("Name the module to keep these records."), (name_it,))]
        store = self._services.storage.store
        if isinstance(store, StoreError):
            return [Notice(Meaning.ATTENTION, join_sentences((store.sentence, tr("Not kept."))))]
        return []

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
        once = frozenset(row.seen.place for row in rows if row.is_seen_once)
        write = partial(write_archive, module=name, records=[row.seen for row in rows], seen_once=once)

        def save(path: Path) -> None:
            self.work.job.write_file(path, partial(write, path), lambda _none: saved_text(path, len(rows)))

        safe = "".join(character if character.isalnum() or character in "-_" else "_" for character in name[:40])
        self.ask_path(self, tr("Export…"), Path(f"dps-s triggers {safe or 'module'}.csv"), "*.csv", save)

    def ways_back(self) -> WaysBack:
        work = self.work
        return (
            (work.is_busy, work.job.cancel),
            (work.job.said, work.job.dismiss),
        )


def _why_empty(work: TriggerReading, *, is_open: bool) -> tuple[str, str]:
    if work.is_busy:
        return tr("Reading the trigger records"), ""
    if work.reading is None:
        text = tr("Read as soon as the module answers.") if is_open else tr("Connect or choose a module.")
        return capitalised(tr("not read yet")), text
    if work.reading.history.is_confirmed:
        return labelled(tr("Trigger records"), 0), tr("It has never fired, or its memory was cleared.")
    if work.reading.history.is_answered:
        return capitalised(tr("unknown")), tr("The readings differ: records may be missing. Read again.")
    return capitalised(tr("unknown")), tr("No answer: the records are unknown.")


class TriggersDetail(QFrame):
    """The selected trigger records as a sentence, their bytes, and what a person judges."""

    def __init__(self, find_work: Callable[[], TriggerReading]) -> None:
        super().__init__()
        named(self, "triggers_detail", "card")
        self._find_work = find_work
        self._rows: Sequence[TriggerRow] = ()
        self._note_of: int | None = None
        self.cause = text_label("triggers_cause", is_selectable=True)
        self.seen = text_label("triggers_seen", "small", is_selectable=True)
        self.bytes = text_label("triggers_bytes", "muted", is_selectable=True)
        self.bytes.setFont(fixed_font(Size.SMALL))
        self.raw = control(QToolButton(), "triggers_raw", text=tr("Raw bytes"))
        self.raw.setCheckable(True)
        self.raw.toggled.connect(self.bytes.setVisible)
        self.buttons: dict[Judgement | None, QToolButton] = {}
        judging, columns = QGridLayout(), 3 if is_text_large() else len(Judgement) + 1
        for number, judgement in enumerate((None, *Judgement)):
            name = "none" if judgement is None else judgement.name.lower()
            text = tr("not reviewed") if judgement is None else tr(judgement.value)
            button = control(QToolButton(), f"triggers_judge_{name}", text=text, role="choice")
            button.setCheckable(True)
            self.buttons[judgement] = button
            button.clicked.connect(partial(self._judge, judgement))
            judging.addWidget(button, number // columns, number % columns)
        self.note = named(QLineEdit(), "triggers_note", says=tr("Note"), tip=tr("Note"))
        self.note.setMaxLength(MAX_NOTE_LENGTH)
        self.note.setPlaceholderText(tr("Note"))
        self.note.editingFinished.connect(self._commit_note)
        in_column(self.cause, self.seen, self.bytes, in_row(judging, (self.note, 1), self.raw), of=self)
        self.show_rows(())

    def show_rows(self, rows: Sequence[TriggerRow]) -> None:
        """The selected rows; several are judged at once."""
        self._rows, row = rows, rows[0] if len(rows) == 1 else None
        for widget in (self.raw, self.note, self.seen):
            widget.setVisible(row is not None)
        self.bytes.setVisible(row is not None and self.raw.isChecked())
        judgements = {chosen.seen.judgement for chosen in rows if chosen.is_stored}
        for judgement, button in self.buttons.items():
            button.setVisible(bool(rows))
            button.setChecked(judgements == {judgement})
            button.setEnabled(bool(judgements))
        if row is None:
            self.cause.setText(tr("{count} selected", count=len(rows)) if rows else tr("Select a row."))
            self._note_of = None
            return
        self.cause.setText(with_units(capitalised(sentence(row.record).translated())))
        self.bytes.setText(row.record.raw.hex(" ").upper())
        if row.is_seen_once:
            seen = tr("Seen in one reading only. Read again.")
        elif not row.is_stored:
            seen = tr("Saving…") if self._find_work().is_busy else tr("Not kept.")
        else:
            where = tr("On the module") if row.is_on_module else tr("No longer on the module")
            seen = f"{tr('First seen {time}', time=local_time(row.seen.first_seen_at))} · {where}"
        if is_text_large():  # the list has no room for all its columns
            fields = (labelled(tr(column.title), column.text(row)) for column in COLUMNS if column.is_spare)
            seen = " · ".join((seen, *fields))
        self.seen.setText(seen)
        self.note.setEnabled(row.is_stored)
        if self._note_of != row.seen.place or not self.note.hasFocus():
            self.note.setText(row.seen.note)
        self._note_of = row.seen.place

    def _judge(self, judgement: Judgement | None) -> None:
        is_alone = len(self._rows) == 1
        for row in self._rows:
            if row.is_stored:
                note = self.note.text() if is_alone else row.seen.note
                self._find_work().judge(row.seen, judgement, note)

    def _commit_note(self) -> None:
        row = self._rows[0] if len(self._rows) == 1 else None
        if row is not None and row.is_stored and self.note.text() != row.seen.note:
            self._find_work().judge(row.seen, row.seen.judgement, self.note.text())
