"""The two lists of flights, one above the other: opened, moved to the other list, removed by mouse and keyboard."""

import math
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QFontMetrics
from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from app.flight_analysis.fire_map import FlightGroup
from app.text.durations import stopwatch
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.flights.controller import GROUPS, FlightRow
from ui.pages.flights.texts import (
    MOVE_WORD,
    OTHER_LIST,
    appearance_of,
    list_caption,
    list_detail,
    order_of,
    problem_count,
    row_text,
    short_name,
    verdict_of,
    verdict_text,
)
from ui.style.icons import Icon, StateStyle, icon
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import in_column, in_row

_NAMES: Final = {FlightGroup.MUST_NOT: "flights_must_not", FlightGroup.MUST: "flights_must"}
_ICON_PX: Final = 16
_ROW_PX: Final = 28


class FlightColumn(IntEnum):
    NAME = 0
    FIRES = 1
    TILT = 2
    FALL = 3
    DURATION = 4
    PROBLEMS = 5


def _style(row: FlightRow) -> StateStyle:
    return appearance_of(row.flight.group, verdict_of(row.outcome))


def _tilt(row: FlightRow) -> float:
    return math.nan if row.outcome is None else row.outcome.flight.tilt_max_deg


def _duration(row: FlightRow) -> float:
    return -1.0 if row.outcome is None else row.outcome.flight.duration_s


COLUMNS: Final = (
    TableColumn[FlightRow](
        marked("Flight"), lambda row: short_name(row.name), widest=lambda: "survey-0000", stretches=True
    ),
    TableColumn[FlightRow](
        marked("Fires"),
        lambda row: verdict_text(row.outcome),
        lambda row: order_of(row.flight.group, row.outcome),
        picture=lambda row: icon(_style(row).icon, _style(row).meaning),
        ink=lambda row: _style(row).meaning,
        widest=lambda: max(
            (tr("unclear"), tr("too late"), tr("not read"), "8888.8 s"), key=QFontMetrics(font()).horizontalAdvance
        ),
    ),
    TableColumn[FlightRow](
        marked("Tilt"),
        lambda row: "—" if math.isnan(_tilt(row)) else f"{_tilt(row):.0f}°",
        lambda row: -1.0 if math.isnan(_tilt(row)) else _tilt(row),
        is_right=True,
        widest=lambda: "180°",
    ),
    TableColumn[FlightRow](
        marked("Fall"),
        lambda row: "—" if row.longest_fall_s < 0 else f"{row.longest_fall_s:.2f} s",
        lambda row: row.longest_fall_s,
        is_right=True,
        widest=lambda: "88.88 s",
    ),
    TableColumn[FlightRow](
        marked("Duration"),
        lambda row: "—" if row.outcome is None else stopwatch(_duration(row)),
        _duration,
        is_right=True,
        widest=lambda: "88:88",
        is_spare=True,
    ),
    TableColumn[FlightRow](
        marked("Problems"),
        lambda row: str(problem_count(row)) if problem_count(row) else "",
        lambda row: float(problem_count(row)),
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if problem_count(row) else None,
        ink=lambda row: Meaning.ATTENTION if problem_count(row) else None,
        widest=lambda: "88",
        is_beside=True,
    ),
)


class FlightList(QWidget):
    opened = Signal(object)
    """`FlightRow`."""
    move_wanted = Signal(object, object)
    """Names, and the target list."""
    remove_wanted = Signal(object)
    """Names."""

    def __init__(self, group: FlightGroup, texts: Texts) -> None:
        super().__init__()
        self._texts = texts
        name = _NAMES[group]
        self.setObjectName(f"{name}_list")
        self.group = group
        self.table = table = RowsTable(texts, f"{name}_table", group.value, COLUMNS, lambda row: row.name, row_text,
                                       row_px=_ROW_PX, sorted_by=FlightColumn.FIRES,
                                       order=Qt.SortOrder.AscendingOrder)  # fmt: skip
        table.setAlternatingRowColors(True)
        table.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # file names mostly differ at the end
        table.setMinimumHeight(3 * _ROW_PX)
        self.picture = IconLabel(f"{name}_icon", _ICON_PX)
        self.caption = named(QLabel(), f"{name}_caption", "strong")
        self.detail = named(ElidedLabel(), f"{name}_detail", "small")
        moving = Icon.CHEVRON_DOWN if group is FlightGroup.MUST_NOT else Icon.CHEVRON_UP
        self.move_button = control(QPushButton(), texts, f"{name}_move", "Move", tip=MOVE_WORD, key="M",
                                   picture=moving, slot=self.move_chosen)  # fmt: skip
        head = in_row(self.picture, self.caption, spacing=Space.XS)
        head.addSpacing(Space.XS)
        head.addWidget(self.detail, 1)
        head.addWidget(self.move_button)
        in_column(head, (self.table, 1), of=self, spacing=Space.XS, margins=0)
        table.opened.connect(self._open)
        table.remove_wanted.connect(self._remove)
        self.opening = self._add_action("open", marked("Open"), Icon.LIVE, self._open)
        self.moving = self._add_action("move", MOVE_WORD, moving, self.move_chosen)
        self.moving.setShortcut("M")
        self.moving.setAutoRepeat(False)
        self.moving.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        self.removing = self._add_action("remove", marked("Remove"), Icon.CROSS, self._remove)
        table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        table.selectionModel().selectionChanged.connect(self._refresh_actions)
        self._refresh_actions()

    def _add_action(self, word: str, english: str, picture: Icon, slot: Callable[[], None]) -> QAction:
        action = named(self.table.addAction(icon(picture), ""), f"{self.table.objectName()}_menu_{word}")
        self._texts.bind(action.setText, english)
        action.triggered.connect(slot)
        return action

    def show_rows(self, rows: Sequence[FlightRow]) -> None:
        self.table.show_rows(rows)
        outcomes = [row.outcome for row in rows if row.outcome is not None]
        text, meaning = list_caption(self.group, outcomes)
        self.caption.setText(text)
        self.detail.setText(list_detail(self.group, outcomes))
        good = Icon.NOT_TRIGGERED if self.group is FlightGroup.MUST_NOT else Icon.PARACHUTE
        bad = Icon.PARACHUTE if self.group is FlightGroup.MUST_NOT else Icon.CROSS
        self.picture.show_icon(good if meaning is None else bad, meaning)
        self._refresh_actions()

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

    def _remove(self) -> None:
        self.remove_wanted.emit(self._names())

    def _refresh_actions(self) -> None:
        count = len(self.table.chosen())
        self.opening.setEnabled(count == 1)
        for action in (self.moving, self.removing, self.move_button):
            action.setEnabled(count > 0)


class FlightLists(QWidget):
    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("flights_lists")
        self.of: dict[FlightGroup, FlightList] = {group: FlightList(group, texts) for group in GROUPS}
        in_column(*((part, 1) for part in self.of.values()), of=self, spacing=Space.S, margins=0)

    def show_rows(self, rows: dict[FlightGroup, list[FlightRow]]) -> None:
        has_problems = any(problem_count(row) for of_group in rows.values() for row in of_group)
        for group, part in self.of.items():
            part.show_rows(rows[group])
            # The same columns in both; without a problem in any flight the names take the column's room.
            if has_problems is part.table.isColumnHidden(FlightColumn.PROBLEMS):
                part.table.setColumnHidden(FlightColumn.PROBLEMS, not has_problems)
                part.table.measure()
