"""Pane with the explanation, consequences and vendor's advice of the chosen setting."""

from PySide6.QtWidgets import QFrame, QWidget

from app.safety.consequences import Weight
from app.settings.form import FormRow, RowState
from app.settings.setting_texts import advice_text
from app.text.i18n import tr
from app.text.sentences import capitalised, join_sentences, with_units
from ui.core.texts import Texts
from ui.pages.settings.row import WRONG, reason_text
from ui.style.theme import Space
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, scroll_area
from ui.widgets.naming import named, set_role


class SettingPane(QFrame):
    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "setting_pane", "card")
        self.title = text_label("setting_title", "strong")
        self.term = text_label("setting_term", "small")
        self.what = text_label("setting_what")
        self.meaning = text_label("setting_meaning")
        self.reason = text_label("setting_reason", "small")
        self.advice = text_label("setting_advice", "small")
        self.heading = named(QWidget(), "setting_heading")
        """Below the table the chosen row is heading enough."""
        in_column(self.title, self.term, of=self.heading, spacing=0, margins=0)
        content = named(QWidget(), "setting_content")
        in_column(
            self.heading, self.reason, self.meaning, self.what, self.advice, 1,
            of=content, spacing=Space.XS, margins=(Space.M, Space.XS),
        )  # fmt: skip
        scroll = scroll_area(content, texts, "setting_scroll", "Parameter", is_transparent=True)
        in_column(scroll, of=self, margins=1)

    def show_row(self, row: FormRow) -> None:
        command = row.command
        title, term = tr(command.title), command.vendor_term
        reason = "" if row.state is RowState.INVALID else reason_text(row)  # the notice says it
        is_loud = any(one.weight is not Weight.PLAIN for one in row.consequences)
        for label, text in (
            (self.title, title),
            (self.term, "" if term == title else term),  # in Chinese it is the title
            (self.reason, reason),
            (self.what, tr(command.explanation)),
            (self.meaning, with_units(join_sentences(one.sentence for one in row.consequences))),
            (self.advice, capitalised(advice_text(command))),
        ):
            label.setText(text)
            label.setVisible(bool(text))
        set_role(self.reason, "danger" if row.state in WRONG else "small")
        set_role(self.meaning, "attention" if is_loud else "")
