"""Result of a guided test: verdict, advice, measured values with tolerances."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from app.guided.results import VERDICT_WORDS, BrokenOff, GuidedResult, MeasuredValue
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.tests.texts import VERDICT_MEANINGS, outcome_text
from ui.style.icons import MEANING_ICONS, icon
from ui.style.theme import Space
from ui.widgets.controls import named, set_role
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import in_column, in_row

_ROW_PX: Final = 28

COLUMNS: Final[tuple[TableColumn[MeasuredValue], ...]] = (
    TableColumn(marked("Quantity"), lambda one: one.name.translated()),
    TableColumn(marked("Measured"), lambda one: one.shown.translated(), stretches=True),
    TableColumn(marked("Tolerance"), lambda one: one.tolerance.translated(), stretches=True),
    TableColumn(
        marked("Result"),
        lambda one: tr(VERDICT_WORDS[one.verdict]),
        picture=lambda one: icon(MEANING_ICONS[VERDICT_MEANINGS[one.verdict]], VERDICT_MEANINGS[one.verdict]),
        ink=lambda one: VERDICT_MEANINGS[one.verdict],
    ),
)


class ResultView(QWidget):
    """Shows one outcome."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "tests_result")
        self.mark, self.verdict = IconLabel("tests_verdict_mark", 24), text_label("tests_verdict", "heading")
        self.advice = text_label("tests_advice")
        self.table = RowsTable(texts, "tests_table", "Measured values", COLUMNS, lambda one: one.name, _row_sentence,
                               row_px=_ROW_PX, is_single=True)  # fmt: skip
        self.table.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        head = in_row(self.mark, (self.verdict, 1), spacing=Space.S)
        in_column(head, self.advice, self.table, 1, of=self, spacing=Space.S, margins=0)

    def show_outcome(self, outcome: GuidedResult | BrokenOff | None) -> None:
        meaning, text = outcome_text(outcome)
        is_result = isinstance(outcome, GuidedResult)
        if outcome is not None:
            self.mark.show_icon(MEANING_ICONS[meaning], meaning)
        set_role(self.verdict, "heading" if is_result else "title")
        self.verdict.setText(text)
        self.verdict.setAccessibleName(text)
        measured = outcome.measured if isinstance(outcome, GuidedResult) else ()
        self.table.show_rows(measured)
        self.table.setVisible(bool(measured))
        self.table.setFixedHeight(self.table.horizontalHeader().sizeHint().height() + _ROW_PX * len(measured) + 4)
        advice = outcome.advice if isinstance(outcome, GuidedResult) else None
        self.advice.setText("" if advice is None else advice.translated())
        self.advice.setVisible(advice is not None)


def _row_sentence(one: MeasuredValue) -> str:
    return ", ".join(column.text(one) for column in COLUMNS)
