"""The selected trigger records as a sentence, their bytes, and what a person judges."""

from collections.abc import Sequence
from functools import partial
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFrame, QGridLayout, QHBoxLayout, QLineEdit, QToolButton, QVBoxLayout

from app.system.clock import local_time
from app.text.i18n import tr
from app.text.messages import capitalised, labelled, with_units
from app.trigger_records.history import JUDGEMENT_WORDS, MAX_NOTE_LENGTH, Judgement, sentence
from protocol.translatable import marked
from ui.pages.triggers.model import COLUMNS
from ui.session.trigger_reading import TriggerRow
from ui.style.theme import Size, fixed_font, is_text_large
from ui.widgets.controls import control, named, text_label

JUDGEMENTS: Final = (None, *Judgement)


class TriggersDetail(QFrame):
    """`judged`: the record's id, the judgement (None removes it) and the note."""

    judged = Signal(int, object, str)

    def __init__(self) -> None:
        super().__init__()
        named(self, "triggers_detail", "card")
        self._rows: Sequence[TriggerRow] = ()
        self._note_of: int | None = None
        self.cause = text_label("triggers_cause", is_selectable=True)
        self.seen = text_label("triggers_seen", "small", is_selectable=True)
        self.bytes = text_label("triggers_bytes", "muted", is_selectable=True)
        self.bytes.hide()
        self.raw = control(QToolButton(), "triggers_raw", text=tr("Raw bytes"), is_checkable=True)
        self.raw.toggled.connect(self.bytes.setVisible)
        self.buttons: dict[Judgement | None, QToolButton] = {}
        for judgement in JUDGEMENTS:
            name = "none" if judgement is None else judgement.name.lower()
            text = marked("not reviewed") if judgement is None else JUDGEMENT_WORDS[judgement]
            self.buttons[judgement] = control(
                QToolButton(),
                f"triggers_judge_{name}",
                text=tr(text),
                role="choice",
                is_checkable=True,
                slot=partial(self._judge, judgement),
            )
        self.note = control(QLineEdit(), "triggers_note", says=tr("Note"), tip=tr("Note"))
        self.note.setMaxLength(MAX_NOTE_LENGTH)
        self.note.setPlaceholderText(tr("Note"))
        self.note.editingFinished.connect(self._commit_note)
        self._lay_out()
        self.show_rows(())

    @property
    def _row(self) -> TriggerRow | None:
        return self._rows[0] if len(self._rows) == 1 else None

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
        self.bytes.setFont(fixed_font(Size.SMALL))
        seen = self._seen_text(row)
        if is_text_large():  # the list has no room for all its columns
            fields = (labelled(tr(column.title), column.text(row)) for column in COLUMNS if column.is_spare)
            seen = " · ".join((seen, *fields))
        self.seen.setText(seen)
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
        alone = self._row
        for row in self._rows:
            if row.is_stored:
                self.judged.emit(row.seen.id, judgement, row.seen.note if alone is None else self.note.text())

    def _commit_note(self) -> None:
        row = self._row
        if row is not None and row.is_stored and self.note.text() != row.seen.note:
            self.judged.emit(row.seen.id, row.seen.judgement, self.note.text())

    def _lay_out(self) -> None:
        judging = QGridLayout()
        columns = 3 if is_text_large() else len(self.buttons)
        for number, button in enumerate(self.buttons.values()):
            judging.addWidget(button, number // columns, number % columns)
        row = QHBoxLayout()
        row.addLayout(judging)
        row.addWidget(self.note, 1)
        row.addWidget(self.raw)
        column = QVBoxLayout(self)
        for part in (self.cause, self.seen, self.bytes):
            column.addWidget(part)
        column.addLayout(row)
