"""Triggers page: all trigger records of a module, newest first, with the details and the review of the selected ones.

    head     search, Read
    list     `RowsTable`, or why it is empty; beside it `TriggersDetail`
    foot     copy, export
or one record beside a flight log, in `RecordBesideLog`: the moments at which the log meets its cause, for a person to
confirm.
`TriggersController` reads the records, merges them with the stored ones and stores judgements.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFontMetrics, QGuiApplication
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QStackedWidget, QToolButton, QWidget

from app.flight_analysis.record_match import (
    Moment,
    RecordMatch,
    match_record,
    measured_text,
    moment_message,
    record_limits,
)
from app.flight_analysis.summary import moment_text
from app.records.trigger_archive import write_archive
from app.store.database import StoreTrouble
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import capitalised, join_sentences, saved_text, with_units
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, sentence
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.files.file_dialogs import AskOpen, AskPath, ask_flight_log, ask_path
from ui.forms.rows_table import RowsTable, SearchedRows
from ui.forms.table_kit import select_row
from ui.pages.triggers.controller import TriggerRow, TriggersController
from ui.pages.triggers.detail import WIDTH_PX, TriggersDetail
from ui.pages.triggers.model import (
    COLUMNS,
    Column,
    as_text,
    count_text,
    csv_name,
    empty_text,
    empty_title,
    news_text,
    record_text,
)
from ui.plots.flight_plot import FlightPlot
from ui.plots.lanes import Mark
from ui.services.context import Services
from ui.services.module_field import ModuleField
from ui.services.page import HEIGHT_PX, Page, WaysBack
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import FlowRow, fold_beside, in_column, in_row, scroll_area, stacked
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

CONFIRMED: Final = (Judgement.REAL, Judgement.FALSE, Judgement.BENCH_TEST)
"""What a person can say of a record whose moment is found."""
_ICON_PX: Final = 20
_WITH_PLOTS_LINES: Final = 16
"""Height of the page, in lines of text, from which the plots are shown."""


class RecordBesideLog(QWidget):
    """`judged`: the row, the judgement, and what is to be noted. `closed`: back to the list."""

    judged = Signal(object, object, str)
    closed = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("beside_log")
        self.row: TriggerRow | None = None
        self.match: RecordMatch | None = None
        """None while the log is read."""
        self._path = Path()
        self._has_room = True
        self.back = control(QPushButton(), texts, "beside_back", "All records", key="Esc", picture=Icon.CHEVRON_LEFT,
                            slot=self.close_log)  # fmt: skip
        self.name = named(ElidedLabel(), "beside_name", "title")
        self.record = text_label("beside_record", "strong", is_selectable=True)
        self.picture = IconLabel("beside_icon", _ICON_PX)
        self.explanation = text_label("beside_said", is_selectable=True)
        self.moments = control(QComboBox(), texts, "beside_moments", says="Time")
        WheelGuard(self.moments)
        self.moments.currentIndexChanged.connect(self._show_moment)
        self.question = control(QLabel(), texts, "beside_question", "Confirm this moment as:")
        self.buttons = {
            judgement: control(QToolButton(), texts, f"beside_{judgement.name.lower()}", JUDGEMENT_WORDS[judgement],
                               role="choice", slot=partial(self._confirm, judgement))
            for judgement in CONFIRMED
        }  # fmt: skip
        self.chart = FlightPlot("beside", texts)
        self.chart.shown.connect(self._show_match)
        head = in_row((self.name, 1), self.back, spacing=Space.M)
        head.addStrut(HEIGHT_PX)
        proposal = in_row((self.picture, Qt.AlignmentFlag.AlignTop), (self.explanation, 1), spacing=Space.S)
        confirming = FlowRow(self.moments, right=(self.question, *self.buttons.values()))
        in_column(head, self.record, proposal, confirming, (self.chart, 1), of=self, spacing=Space.XS, margins=0)
        VisibilityTimer(self, retranslate=self._write)

    def open(self, row: TriggerRow, path: Path) -> None:
        """Reads the log and looks for the record in it."""
        self.row, self.match, self._path = row, None, path
        self.chart.open(path, record_limits(row.record), partial(match_record, row.record))
        self._write()

    def close_log(self) -> None:
        self.chart.close_log()
        self.row = self.match = None
        self.closed.emit()

    def fit_height(self, page_px: int) -> None:
        """Hides the plots on a low page, where they would cover what a person decides by."""
        self._has_room = page_px >= _WITH_PLOTS_LINES * QFontMetrics(font()).height()
        self._say()

    @property
    def moment(self) -> Moment | None:
        row = self.moments.currentIndex()
        return self.match.moments[row] if self.match is not None and 0 <= row < len(self.match.moments) else None

    def _write(self) -> None:
        if self.row is None:
            return
        self.name.setText(tr("Trigger record beside {log}", log=clean(self._path.name)))
        self.record.setText(with_units(capitalised(sentence(self.row.record).translated())))
        chosen = self.moment
        moments = () if self.match is None else self.match.moments
        with QSignalBlocker(self.moments):
            self.moments.clear()
            for moment in moments:
                self.moments.addItem(f"{moment_text(moment.firing.at_s)} · {measured_text(moment.firing)}")
            self.moments.setCurrentIndex(moments.index(chosen) if chosen in moments else -1)
        self.chart.retranslate()
        self._say()

    def _show_match(self, match: RecordMatch) -> None:
        self.match = match
        if self.chart.plot is not None:
            self.chart.plot.add_marks([
                Mark(moment.firing.at_s, marked("trigger record?"), Icon.HISTORY, Meaning.INFORMATION)
                for moment in match.moments
            ])  # fmt: skip
        self._write()
        if match.likeliest is not None:
            self.moments.setCurrentIndex(match.moments.index(match.likeliest))

    def _show_moment(self) -> None:
        moment = self.moment
        if moment is not None:
            self.chart.look_at(moment.firing.at_s)
        self._say()

    def _say(self) -> None:
        match, moment, row = self.match, self.moment, self.row
        for widget in (self.question, *self.buttons.values()):
            widget.setVisible(moment is not None)
        self.moments.setVisible(self.moments.count() > 1)
        self.chart.setVisible(self._has_room or moment is None)
        self.picture.setVisible(match is not None)
        if row is None or match is None:
            self.explanation.setText("")
        elif match.why_none is not None:
            self.picture.show_icon(Icon.WARNING, Meaning.ATTENTION)
            self.explanation.setText(match.why_none.translated())
        elif moment is not None:
            self.picture.show_icon(Icon.INFORMATION, Meaning.INFORMATION)
            count = len(match.moments)
            lines = [moment_message(moment, row.record).translated()]
            if count > 1:
                lines.append(tr("Moments that match: {count}.", count=f"> {count}" if match.has_more else count))
            if not self._has_room:
                lines.append(tr("A higher window also shows: {plots}", plots=tr("Plots")))
            self.explanation.setText("\n".join(lines))

    def _confirm(self, judgement: Judgement, _is_checked: bool = False) -> None:
        moment, row = self.moment, self.row
        if moment is not None and row is not None:
            note = tr("{log} at {time}: {what}", log=clean(self._path.name), time=moment_text(moment.firing.at_s),
                      what=measured_text(moment.firing))  # fmt: skip
            self.judged.emit(row, judgement, note)
            self.close_log()


_ROW_PX: Final = 36
_READ_EVERY_MS: Final = 500
"""Retry interval until the module is online and idle."""


class TriggersPage(Page):
    def __init__(self, services: Services) -> None:
        super().__init__("triggers")
        self._services, self._connector = services, services.connector
        self.ask_path: AskPath = ask_path
        self.ask_log: AskOpen = ask_flight_log
        self._folder = self._log_folder = Path.home()
        self.work = TriggersController(services, self)
        self.table = RowsTable(services.texts, "triggers_table", "Trigger records", COLUMNS, lambda row: row.seen.id,
                               record_text, row_px=_ROW_PX, sorted_by=Column.WHEN,
                               searches_sentence=True)  # fmt: skip
        self.detail = TriggersDetail(services.texts)
        self.beside = RecordBesideLog(services.texts)
        self.strip = named(NoticeBar(services.texts), "triggers_notice")
        self.module = ModuleField("triggers_module", services.connector, services.texts)
        self.module.setMinimumContentsLength(14)
        self.count = named(QLabel(), "triggers_count", "strong")
        self.news = named(ElidedLabel(), "triggers_news", "small")
        self._make_buttons()
        self.list = SearchedRows(services.texts, "triggers", self.table, Icon.HISTORY)
        self._lay_out()
        timer = VisibilityTimer(
            self, self._on_shown, every_ms=_READ_EVERY_MS, tick=self.work.read_unasked, retranslate=self.refresh
        )
        self.work.changed.connect(timer.refresh_seen)
        self.work.changed.connect(self._end_beside)
        self._wire()
        self.refresh()

    def refresh(self) -> None:
        work = self.work
        self.list.show_rows(work.rows)
        has_rows = bool(work.rows)
        self._beside.setVisible(has_rows)
        if has_rows and not self.table.selectionModel().hasSelection():
            select_row(self.table, 0)
        self.list.empty.title.setText(empty_title(work))
        notice = work.notice() or self._idle_notice()
        why = empty_text(work, is_open=self._connector.current.is_open)
        is_told = notice is not None and notice.text.startswith(why)
        self.list.empty.text.setText("" if is_told else why)
        self.count.setText(count_text(work))
        known_by = self._connector.current.module.known_by if has_rows else ""
        self.news.setText(" · ".join(filter(None, (news_text(work), known_by))))
        self.read.setEnabled(work.can_read)
        for widget in (self.copy, self.save_page, self.save_archive, self.list.search):
            widget.setEnabled(has_rows)
        self.strip.show_notice(notice)
        self._show_detail()

    # A record beside a flight log

    def choose_log(self) -> None:
        for row in self.table.chosen():
            self.ask_log(self, self._log_folder, partial(self.open_beside, row))

    def open_beside(self, row: TriggerRow, log: Path) -> None:
        """Unless another module has come while the log was chosen."""
        if not self._is_listed(row):
            text = partial(tr, "Another module is shown now: nothing was opened.")
            self.work.job.notify(Meaning.ATTENTION, text)
            return
        self._log_folder = log.parent
        self.beside.open(row, log)
        self._views.setCurrentWidget(self.beside)
        self.beside.back.setFocus()

    def _end_beside(self) -> None:
        """Another module's records are shown: the chosen one is none of them."""
        row = self.beside.row
        if row is not None and not self.work.is_busy and not self._is_listed(row):
            self.beside.close_log()

    def _is_listed(self, row: TriggerRow) -> bool:
        return any(row.seen.id == shown.seen.id for shown in self.work.rows)

    def _judge_beside(self, row: TriggerRow, judgement: Judgement, finding: str) -> None:
        """What was found comes before what was noted earlier."""
        noted = next((shown for shown in self.work.rows if shown.seen.id == row.seen.id), row).seen.note
        note = noted if finding in noted else " · ".join(filter(None, (finding, noted)))
        self.work.judge(row.seen.id, judgement, note)

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
        self.ask_path(self, title, self._folder / csv_name(name), "*.csv", save)

    def _save_to(self, write: Callable[[Path], object], count: int, path: Path) -> None:
        self._folder = path.parent
        self.work.job.write_file(path, partial(write, path), lambda _none: saved_text(path, count))

    # Making

    def _make_buttons(self) -> None:
        texts = self._services.texts
        self.read = control(QPushButton(), texts, "triggers_read", "Read", keys="F5", picture=Icon.HISTORY,
                            role="primary", slot=self.work.read)  # fmt: skip
        self.copy = control(QPushButton(), texts, "triggers_copy", "Copy", keys="Ctrl+C", picture=Icon.TABLE,
                            slot=self.copy_rows)  # fmt: skip
        self.save_page = control(QPushButton(), texts, "triggers_save_page", "Export shown…", keys="Ctrl+S",
                                 picture=Icon.SAVE, slot=partial(self._save, is_archive=False))  # fmt: skip
        self.save_archive = control(QPushButton(), texts, "triggers_save_archive", "Export all…", keys="Ctrl+Shift+S",
                                    picture=Icon.SAVE, slot=partial(self._save, is_archive=True))  # fmt: skip

    def _wire(self) -> None:
        self.table.selectionModel().selectionChanged.connect(self._show_detail)
        self.detail.judged.connect(self.work.judge)
        self.detail.beside.clicked.connect(self.choose_log)
        self.beside.judged.connect(self._judge_beside)
        self.beside.closed.connect(partial(self._views.setCurrentWidget, self._records))
        self.saving, self.exporting = self.save_page, self.save_archive

    def _lay_out(self) -> None:
        texts = self._services.texts
        head = self.make_header(texts, marked("Triggers"), self.list.search, self.read)
        foot = FlowRow(right=(self.copy, self.save_page, self.save_archive))
        says = in_row(self.count, (self.news, 1), self.module, spacing=Space.M)
        beside = self._beside = scroll_area(self.detail, texts, "triggers_scroll", "Trigger records", is_vertical=True)
        beside.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._lists = in_row((self.list, 1), beside, spacing=Space.S)
        self._records = named(QWidget(), "triggers_records")
        in_column(head, says, (self._lists, 1), self.strip, foot, of=self._records, spacing=Space.S, margins=0)
        self._views = stacked(named(QStackedWidget(), "triggers_views"), self._records, self.beside)
        in_column(self._views, of=self, margins=(Space.M, 0, Space.M, Space.S))

    # Qt

    def fit(self) -> None:
        fold_beside(self._lists, self.list, self._beside, WIDTH_PX, self.width())
        self.detail.fit_height(self.height())
        self.beside.fit_height(self.height())

    def ways_back(self) -> WaysBack:
        work = self.work
        return (
            (self.beside.row, self.beside.close_log),
            (work.is_busy, work.job.cancel),
            (work.notice(), work.job.dismiss),
        )
