"""A batch of new modules: what each gets, whose turn it is in large letters, and the list."""

from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QCheckBox, QLineEdit, QMenu, QPushButton, QToolButton, QWidget

from app.fleet.batch import READY, SET_ASIDE, BatchRow, Bench, ModuleBatch, batch_of
from app.fleet.batch_list import TITLES, cells, summary, write_batch_labels, write_list
from app.fleet.batch_names import EXAMPLE, MAX_NAME_LENGTH, counted_names
from app.preflight.findings import Person
from app.procedures.write_all import SettingChange
from app.records.labels import PAPERS
from app.store.store import Store
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import error_text, join_names, join_sentences
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.files.report_printer import print_pages
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.fleet.batch_turns import BatchTurns, Stage
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.running_job import is_risk_open, risk_notice
from ui.style.accessible_roles import announce
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import Meaning, Size, Space, font, scaled
from ui.widgets.controls import control, named, without_key
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import FlowRow, captioned_row, in_column, in_row, scroll_area
from ui.widgets.step_button import StepButton
from ui.widgets.visibility_timer import VisibilityTimer

_ROW_PX: Final = 30
_TABLE_PX: Final = 60
_HIGH: Final = 7
"""Times the largest letters."""
_PAPERS: Final = {"A4": marked("A4 sheets…"), "62": marked("62 mm tape…"), "24": marked("24 mm tape…")}
_HINTS: Final = {
    Stage.PLUG_IN: marked("Plug in the next module. Only questions are sent until its label is confirmed."),
    Stage.ASK: marked("Put this label on the module, then scan it, type it or press."),
    Stage.WORKING: marked("Reading, writing, enabling and checking. LOCK works at any time."),
    Stage.DONE: marked("Every name is given. Export the list and print the labels."),
    Stage.STOPPED: marked("Go back and begin again: what is done is kept."),
}


_PICTURES: Final = {Stage.PLUG_IN: Icon.PLUG, Stage.ASK: Icon.LABEL, Stage.WORKING: Icon.CONNECTING}


class BatchForm(QWidget):
    """What every module of a batch gets, and what is said of all of them."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("fleet_batch_form")
        self.path: Path | None = None
        self.choose = control(QPushButton(), texts, "fleet_batch_choose", "Open profile…", picture=Icon.SETTINGS)
        self.names = control(QLineEdit(), texts, "fleet_batch_names", says="Names")
        self.names.setPlaceholderText(EXAMPLE)
        self.who = control(QLineEdit(), texts, "fleet_batch_who", says="Checked by")
        self.enables, self.reviewed, self.all_new = (
            control(QCheckBox(), texts, f"fleet_batch_{name}", text)
            for name, text in (
                ("enables", marked("Enable both automatic triggers first")),
                ("reviewed", marked("Trigger records reviewed; without an answer: a new module")),
                ("all_new", marked("All are new, also those that resemble a known module")),
            )
        )
        self.start = control(QPushButton(), texts, "fleet_batch_start", "Start", role="primary")
        form = captioned_row(
            texts, (marked("Profile"), self.choose), (marked("Names"), self.names), (marked("Checked by"), self.who)
        )
        in_column(form, self.enables, self.reviewed, self.all_new, in_row(1, self.start), 1, of=self, spacing=Space.M,
                  margins=(Space.M, Space.S))  # fmt: skip
        self.names.textChanged.connect(self.refresh)
        self.refresh()

    def show_profile(self, path: Path) -> None:
        self.path = path
        self.refresh()

    def refresh(self) -> None:
        if self.path is not None:
            name = clean(self.path.name, longest=40)
            self.choose.setText(without_key(name))
            self.choose.setAccessibleName(name)
        self.start.setEnabled(self.path is not None and bool(self.names.text().strip()))


class BatchPanel(QWidget):
    """The form, then the turns of a `BatchTurns`."""

    closed = Signal()

    def __init__(self, services: Services, turns: BatchTurns, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("fleet_batch_panel")
        self._services, self._turns, self._result = services, turns, result
        texts = services.texts
        self.ask_path: AskPath = ask_path
        self.ask_profile: AskOpen = ask_profile
        self._turn: object = None
        self.form = BatchForm(texts)
        self.form.choose.clicked.connect(self._choose_profile)
        self.form.start.clicked.connect(self.begin)
        self.sign = IconLabel("fleet_batch_sign", Size.NUMBER)
        self.close_button = control(QPushButton(), texts, "fleet_batch_close", "Back", slot=self.closed)
        self.export = control(QPushButton(), texts, "fleet_batch_export", "Export…", picture=Icon.SAVE,
                              slot=self._choose_list)  # fmt: skip
        self.labels = control(QToolButton(), texts, "fleet_batch_labels", "Print labels", picture=Icon.LABEL)
        self.labels.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = named(QMenu(self.labels), "fleet_batch_labels_menu")
        self.labels.setMenu(menu)
        for key, title in _PAPERS.items():
            action = named(menu.addAction(""), f"fleet_batch_labels_{key}")
            texts.bind(action.setText, title)
            action.triggered.connect(partial(self._choose_labels, key))
        self.words = text_label("fleet_batch_words")
        self.hint = text_label("fleet_batch_hint", is_selectable=True)
        self.label = control(QLineEdit(), texts, "fleet_batch_label", says="Name on its label")
        self.label.setMaxLength(MAX_NAME_LENGTH)
        texts.bind(self.label.setPlaceholderText, "Name on its label")
        self.label.returnPressed.connect(lambda: self._confirm(self.label.text().strip()))
        self.confirm = control(StepButton(), texts, "fleet_batch_confirm", role="primary",
                               slot=lambda: self._confirm(turns.name))  # fmt: skip
        self.table: RowsTable[BatchRow] = RowsTable(
            texts, "fleet_batch_table", "Modules", _COLUMNS, lambda row: (row.name, row.at),
            lambda row: join_names(filter(None, cells(row))), row_px=scaled(_ROW_PX),
        )  # fmt: skip
        row = FlowRow(self.label, self.confirm, right=(self.close_button, self.labels, self.export))
        self.form_view = scroll_area(self.form, texts, "fleet_batch_scroll", "What each module gets", is_vertical=True)
        headline = in_row(self.sign, (self.words, 1), spacing=Space.M)
        in_column((self.form_view, 1), headline, self.hint, row, (self.table, 1), of=self, spacing=Space.S,
                  margins=(Space.M, Space.XS))  # fmt: skip
        VisibilityTimer(self, self.refresh, restyle=self._fit)
        self.table.setMinimumHeight(_TABLE_PX)
        turns.changed.connect(self.refresh)

    def refresh(self) -> None:
        turns, has_begun = self._turns, self._turns.bench is not None
        self.form_view.setVisible(not has_begun)
        for widget in (self.sign, self.words, self.hint, self.table):
            widget.setVisible(has_begun)
        for field in (self.label, self.confirm):
            field.setVisible(has_begun and bool(turns.name))
        for button in (self.labels, self.export):
            button.setVisible(has_begun and not turns.is_working)
        self.close_button.setVisible(not turns.is_working)
        self.form.refresh()
        if not has_begun:
            self._turn = None
            if not self.form.who.isModified():
                self.form.who.setText(self._services.preferences.who)
            return
        stage = turns.stage
        self.words.setText(tr(stage.value, module=turns.name))
        self.hint.setText("\n".join(filter(None, (self._outcome(), self._hint(stage)))))
        is_aside = turns.outcome is not None and turns.outcome.why is not None
        after = Meaning.DANGER if is_aside else Meaning.GOOD
        meaning = {Stage.UNPLUG: after, Stage.DONE: after, Stage.STOPPED: Meaning.DANGER}.get(stage)
        picture = _PICTURES[stage] if meaning is None else MEANING_ICONS[meaning]
        self.sign.show_icon(picture, meaning)
        for field in (self.label, self.confirm):
            field.setEnabled(stage is Stage.ASK)
        self.confirm.setText(tr("Its label reads {module}", module=turns.name))
        self.confirm.setAccessibleName(self.confirm.text())
        self.table.show_rows(turns.rows)
        if self._turn != (turn := (stage, turns.module)):
            self._turn = turn
            self.label.clear()  # what is typed was meant for the former module
            announce(self.words.text())
            if stage is Stage.ASK and self.isVisible():
                self.label.setFocus()

    def summary(self) -> str:
        """The head of the page while the panel is shown."""
        bench = self._turns.bench
        return tr("Batch of new modules") if bench is None else summary(bench.batch, self._turns.rows)

    def _hint(self, stage: Stage) -> str:
        outcome, trouble = self._turns.outcome, self._turns.trouble
        sentences = [] if trouble is None else [trouble.sentence]
        if outcome is not None and outcome.why is not None:
            sentences.append(tr("Take the label {module} off: the name is free.", module=outcome.name))
        return join_sentences((*sentences, tr(_HINTS[stage]) if stage in _HINTS else ""))

    def _outcome(self) -> str:
        outcome = self._turns.outcome
        if outcome is None:
            return ""
        if outcome.why is None:
            return f"{outcome.name}: {tr(READY)}"
        return f"{tr(SET_ASIDE)}: {outcome.why.translated()}"

    def _confirm(self, name: str) -> None:
        if self._turns.confirm(name):
            self._result.dismiss()
        elif name and self._turns.stage is Stage.ASK:
            self._result.notify(Meaning.ATTENTION, lambda: tr("{module} is not one of the names left.", module=name))
        self.label.clear()

    # To begin

    def _choose_profile(self) -> None:
        self.ask_profile(self, self._services.preferences.profile_folder, self.form.show_profile)

    def begin(self, _is_checked: bool = False, *, accepted: frozenset[SettingChange] = frozenset()) -> None:
        """Asks first where it takes protection away, as before every write."""
        form, preferences = self.form, self._services.preferences
        try:
            batch, store = self._batch(), self._services.storage.store
            if not isinstance(store, Store):
                raise store
        except UserError as refusal:
            self._result.notify(Meaning.ATTENTION, partial(error_text, refusal))
            return
        if is_risk_open(batch.changes, accepted):
            self._result.set_notice(partial(risk_notice, batch.changes, self.begin, self._result.dismiss))
            return
        self._result.dismiss()
        preferences.who = clean(form.who.text().strip())
        person = Person(who=preferences.who, are_records_reviewed=form.reviewed.isChecked())
        self._turns.start(Bench(batch, store, person, is_enabling=form.enables.isChecked(),
                                are_all_new=form.all_new.isChecked(), accepted=accepted), store)  # fmt: skip

    def _batch(self) -> ModuleBatch:
        """Raises `UserError` where it cannot begin."""
        form, port = self.form, self._services.connector.current
        names = counted_names(form.names.text().strip())
        if names is None:
            raise UserError(marked("Expected {expected}."), expected=EXAMPLE)
        if not port.is_requested:
            raise UserError(marked("Add the port that the modules are plugged into."))
        batch = batch_of(form.path or Path(), names, port.connection.baud_rate)
        if not (form.enables.isChecked() or batch.enables_triggers):
            raise UserError(marked("No module is READY without both triggers."))
        return batch

    # Files

    def _choose_list(self) -> None:
        self.ask_path(self, tr("Export…"), self._suggested(), "*.pdf", self.export_list)

    def export_list(self, path: Path) -> None:
        """As PDF, and as CSV beside it."""
        bench = self._turns.bench
        if bench is not None:
            write = partial(write_list, path, bench.batch, self._turns.rows, print_pages)
            self._result.write_file(path, write, beside=".csv")

    def _choose_labels(self, key: str) -> None:
        self.ask_path(self, tr("Print labels"), self._suggested(tr("label")), "*.pdf",
                      partial(self.print_labels, key))  # fmt: skip

    def print_labels(self, key: str, path: Path) -> None:
        self._result.write_file(path, partial(write_batch_labels, path, self._turns.rows, PAPERS[key], print_pages))

    def _suggested(self, kind: str = "") -> Path:
        bench = self._turns.bench
        return Path.home() / f"{' '.join(filter(None, ('' if bench is None else bench.batch.title, kind)))}.pdf"

    # Qt

    def _fit(self) -> None:
        """In a low window the letters are only as large as the list can be seen below them."""
        is_low = self.height() < _HIGH * scaled(Size.HERO)
        self.words.setFont(font(Size.NUMBER if is_low else Size.HERO, is_bold=True))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()


_COLUMNS: Final = [TableColumn[BatchRow](title, lambda row, place=place: cells(row)[place])  # type: ignore[misc]
                   for place, title in enumerate(TITLES)]  # fmt: skip
