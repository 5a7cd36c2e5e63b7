"""A list of flights: opened, moved to the other list, removed by mouse and keyboard."""

from typing import Final

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu

from app.flight_analysis.flight_set import FlightGroup
from app.text.i18n import tr
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import RowsFilter
from ui.pages.flights.controller import FlightRow
from ui.pages.flights.model import FlightColumn
from ui.pages.flights.texts import MOVE_WORD
from ui.style.icons import Icon, icon
from ui.widgets.naming import named

ROW_PX: Final = 28


class FlightTable(RowsTable[FlightRow]):
    move_wanted = Signal()

    def __init__(self, name: str, group: FlightGroup, model: RowsFilter[FlightRow]) -> None:
        super().__init__(name, model, row_px=ROW_PX, sorted_by=FlightColumn.FIRES, stretched=FlightColumn.NAME,
                         order=Qt.SortOrder.AscendingOrder, spare=FlightColumn.DURATION)  # fmt: skip
        self._group = group
        self._has_problems = False
        self.setAlternatingRowColors(True)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # file names mostly differ at the end
        self.horizontalHeader().setMinimumSectionSize(44)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.customContextMenuRequested.connect(self._show_menu)
        self.setMinimumHeight(3 * ROW_PX)
        self.measure()

    def show_problems(self, *, has_problems: bool) -> None:
        """Without a problem in any flight the names take the column's room."""
        if has_problems != self._has_problems:
            self._has_problems = has_problems
            self.measure()

    def measure(self) -> None:
        words = tr("unclear"), tr("too late"), tr("not read"), "8888.8 s"
        texts: dict[int, str] = {
            FlightColumn.NAME: "survey-0000",
            FlightColumn.FIRES: max(words, key=self.fontMetrics().horizontalAdvance),
            FlightColumn.TILT: "180°", FlightColumn.FALL: "88.88 s",
            FlightColumn.DURATION: "88:88",
        }  # fmt: skip
        self.setColumnHidden(FlightColumn.PROBLEMS, not self._has_problems)
        if self._has_problems:
            texts[FlightColumn.PROBLEMS] = "88"
        self.fit_columns(texts, with_icon=(FlightColumn.FIRES, FlightColumn.PROBLEMS))

    def menu(self) -> QMenu:
        """Context menu for the selection."""
        menu = named(QMenu(self), f"{self.objectName()}_menu")
        is_one, is_first = len(self.chosen()) == 1, self._group is FlightGroup.MUST_NOT
        entries = (
            ("open", tr("Open"), Icon.LIVE, self.opened, is_one),
            ("move", tr(MOVE_WORD), Icon.CHEVRON_DOWN if is_first else Icon.CHEVRON_UP,
             self.move_wanted, bool(self.chosen())),
            ("remove", tr("Remove"), Icon.CROSS, self.remove_wanted, bool(self.chosen())),
        )  # fmt: skip
        for name, text, picture, wanted, is_on in entries:
            action = menu.addAction(icon(picture), text)
            action.setObjectName(f"{self.objectName()}_menu_{name}")
            action.setEnabled(is_on)
            action.triggered.connect(wanted)
        return menu

    def _show_menu(self, place: QPoint) -> None:
        menu = self.menu()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(self.viewport().mapToGlobal(place))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_M and not event.modifiers():
            self.move_wanted.emit()
        else:
            super().keyPressEvent(event)
