"""The two lists of flights, one above the other."""

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from app.flight_analysis.flight_set import FlightGroup, FlightOutcome
from ui.core.texts import Texts
from ui.forms.table_kit import RowsFilter
from ui.pages.flights.controller import GROUPS, FlightRow
from ui.pages.flights.model import flights_model
from ui.pages.flights.table import FlightTable
from ui.pages.flights.texts import MOVE_WORD, OTHER_LIST, list_caption, list_detail, problem_count
from ui.pages.flights.verdicts import Verdict, verdict_of
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import in_column, in_row
from ui.widgets.naming import named

_NAMES: Final = {FlightGroup.MUST_NOT: "flights_must_not", FlightGroup.MUST: "flights_must"}
_ICON_PX: Final = 16


class FlightList(QWidget):
    """One list: caption, button that moves, table."""

    opened = Signal(object)
    """`FlightRow`."""
    move_wanted = Signal(object, object)
    """Names, and the target list."""
    remove_wanted = Signal(object)
    """Names."""

    def __init__(self, group: FlightGroup, texts: Texts) -> None:
        super().__init__()
        name = _NAMES[group]
        self.setObjectName(f"{name}_list")
        self.group = group
        self.model = flights_model(self)
        self.filter = RowsFilter(self.model, self)
        self.table = FlightTable(f"{name}_table", group, self.filter)
        self.picture = IconLabel(f"{name}_icon", _ICON_PX)
        self.caption = named(QLabel(), f"{name}_caption", "strong")
        self.detail = named(ElidedLabel(), f"{name}_detail", "small")
        is_first = group is FlightGroup.MUST_NOT
        self.move_button = control(QPushButton(), texts, f"{name}_move", "Move", tip=MOVE_WORD, key="M",
                                   picture=Icon.CHEVRON_DOWN if is_first else Icon.CHEVRON_UP,
                                   slot=self.move_chosen)  # fmt: skip
        texts.bind(self.table.setAccessibleName, group.value)
        head = in_row(self.picture, self.caption, spacing=Space.XS)
        head.addSpacing(Space.XS)
        head.addWidget(self.detail, 1)
        head.addWidget(self.move_button)
        in_column(head, (self.table, 1), of=self, spacing=Space.XS, margins=0)
        self.table.opened.connect(self._open)
        self.table.move_wanted.connect(self.move_chosen)
        self.table.remove_wanted.connect(lambda: self.remove_wanted.emit(self._names()))
        self.table.selectionModel().selectionChanged.connect(self._refresh_button)
        self._refresh_button()

    def show_rows(self, rows: Sequence[FlightRow]) -> None:
        self.model.show_rows(tuple(rows))
        outcomes = [row.outcome for row in rows if row.outcome is not None]
        self.show_caption(outcomes)
        self._refresh_button()

    def show_caption(self, outcomes: list[FlightOutcome]) -> None:
        text, meaning = list_caption(self.group, outcomes)
        self.caption.setText(text)
        self.detail.setText(list_detail(self.group, outcomes))
        good = Icon.NOT_TRIGGERED if self.group is FlightGroup.MUST_NOT else Icon.PARACHUTE
        bad = Icon.PARACHUTE if self.group is FlightGroup.MUST_NOT else Icon.CROSS
        self.picture.show_icon(good if meaning is None else bad, meaning)

    def show_only_fired(self, *, is_wanted: bool) -> None:
        """Hides flights that do not fire with the chosen thresholds."""
        hidden = (Verdict.HOLDS, Verdict.UNREAD)
        self.filter.use("", lambda row: not is_wanted or verdict_of(row.outcome) not in hidden)

    def move_chosen(self) -> None:
        names = self._names()
        if names:
            self.move_wanted.emit(names, OTHER_LIST[self.group])

    def _names(self) -> list[str]:
        return [row.name for row in self.table.chosen()]

    def _open(self) -> None:
        chosen = self.table.chosen()
        if len(chosen) == 1:
            self.opened.emit(chosen[0])

    def _refresh_button(self) -> None:
        self.move_button.setEnabled(self.table.selectionModel().hasSelection())


class FlightLists(QWidget):
    """Both lists share the height."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("flights_lists")
        self.of: dict[FlightGroup, FlightList] = {group: FlightList(group, texts) for group in GROUPS}
        in_column(*((one, 1) for one in self.of.values()), of=self, spacing=Space.S, margins=0)

    def show_rows(self, rows: dict[FlightGroup, list[FlightRow]]) -> None:
        has_problems = any(problem_count(row) for of_group in rows.values() for row in of_group)
        for group, one in self.of.items():
            one.show_rows(rows[group])
            one.table.show_problems(has_problems=has_problems)  # the same columns in both
