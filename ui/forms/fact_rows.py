"""Facts about one thing: rows of a name and a value."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtWidgets import QLabel, QWidget

from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.naming import named

NAME_PX: Final = 88


class FactRows(QWidget):
    """`names`: the name of each fact by its key, in English, marked. `labels`: used in place of labels that wrap."""

    def __init__(
        self, texts: Texts, page: str, names: Mapping[str, str], labels: Mapping[str, QLabel] | None = None
    ) -> None:
        super().__init__()
        self.setObjectName(f"{page}_fact_rows")
        self.values: dict[str, QLabel] = {}
        self._rows: dict[str, QWidget] = {}
        for key, english in names.items():
            value = (labels or {}).get(key) or text_label(f"{page}_{key}", "", is_selectable=True)
            name = control(QLabel(), texts, f"{page}_{key}_name", english, role="muted")
            name.setFixedWidth(NAME_PX)
            texts.bind(value.setAccessibleDescription, english)
            row = named(QWidget(), f"{page}_{key}_row")
            in_row(name, (value, 1), of=row, spacing=Space.S, margins=0)
            self.values[key], self._rows[key] = value, row
        in_column(*self._rows.values(), of=self, spacing=Space.XS, margins=0)

    def show_facts(self, values: Mapping[str, str]) -> None:
        """Facts without a value are hidden."""
        for key, label in self.values.items():
            text = values.get(key, "")
            label.setText(text)
            self._rows[key].setVisible(bool(text))
