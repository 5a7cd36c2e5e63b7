"""A list of flights: opened, moved to the other list, removed by mouse and keyboard."""

from typing import Final

from PySide6.QtCore import QModelIndex, QPoint, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHeaderView, QMenu, QTableView

from app.flight_analysis.flight_set import FlightGroup
from app.text.i18n import tr
from ui.forms.table_kit import RowsFilter, list_rows
from ui.pages.flights.controller import FlightRow
from ui.pages.flights.model import COLUMNS, FlightColumn
from ui.pages.flights.texts import MOVE_WORDS
from ui.style.icons import Icon, icon
from ui.style.theme import Size, Space, font, scaled
from ui.widgets.naming import named

ROW_PX: Final = 28
_PAD_PX: Final = 5
_FRAME_PX: Final = 8
"""What the style takes at both sides of a cell."""
_ICON_PX: Final = 22
_NAME_PX: Final = 96


class FlightTable(QTableView):
    opened = Signal()
    move_wanted = Signal()
    remove_wanted = Signal()

    def __init__(self, name: str, group: FlightGroup, model: RowsFilter[FlightRow]) -> None:
        super().__init__()
        named(self, name)
        self._filter, self._group = model, group
        self._duration_px = 0
        self.setModel(model)
        self.setSortingEnabled(True)
        self.sortByColumn(FlightColumn.FIRES, Qt.SortOrder.AscendingOrder)
        self.setAlternatingRowColors(True)
        list_rows(self, row_px=ROW_PX)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # what tells files apart is mostly at their end
        columns = self.horizontalHeader()
        columns.setSectionResizeMode(FlightColumn.NAME, QHeaderView.ResizeMode.Stretch)
        columns.setMinimumSectionSize(44)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.customContextMenuRequested.connect(self._show_menu)
        self.doubleClicked.connect(self._open)
        self.setMinimumHeight(3 * ROW_PX)
        self.measure()

    def measure(self) -> None:
        """Columns as wide as their widest usual text, after a change of language, font or theme."""
        body, strong = QFontMetrics(font(Size.BODY)), QFontMetrics(font(Size.SMALL, is_bold=True))
        fires = max((tr("unclear"), tr("too late"), tr("not read"), "8888.8 s"), key=body.horizontalAdvance)
        texts = {
            FlightColumn.FIRES: fires,
            FlightColumn.TILT: "180°",
            FlightColumn.FALL: "88.88 s",
            FlightColumn.DURATION: "88:88",
            FlightColumn.PROBLEMS: "88",
        }
        for column, text in texts.items():
            head = strong.horizontalAdvance(tr(COLUMNS[column].title)) + Space.XL + 2  # with the arrow of the order
            extra = _ICON_PX if column in (FlightColumn.FIRES, FlightColumn.PROBLEMS) else 0
            width = max(body.horizontalAdvance(text) + extra + 2 * scaled(_PAD_PX) + _FRAME_PX, head)
            self.setColumnWidth(column, width)
            if column is FlightColumn.DURATION:
                self._duration_px = width
        self._share_width()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._share_width()

    def _share_width(self) -> None:
        """The name keeps its room; where there is little, the duration is in the row's tooltip alone."""
        others = [column for column in FlightColumn if column not in (FlightColumn.NAME, FlightColumn.DURATION)]
        taken = sum(self.columnWidth(column) for column in others) + self._duration_px
        self.setColumnHidden(FlightColumn.DURATION, self.viewport().width() - taken < _NAME_PX)

    def chosen(self) -> tuple[FlightRow, ...]:
        """In the order in which they stand."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return tuple(self._filter.row_at(row) for row in rows)

    def choose(self, names: set[str]) -> None:
        """Select these where they are in the list, and show the first."""
        model = self.selectionModel()
        self.clearSelection()
        flags = model.SelectionFlag.Select | model.SelectionFlag.Rows
        found = [row for row in range(self._filter.rowCount()) if self._filter.row_at(row).name in names]
        for row in found:
            model.select(self._filter.index(row, 0), flags)
        if found:
            self.scrollTo(self._filter.index(found[0], 0))

    def menu(self) -> QMenu:
        """For what is chosen."""
        menu = named(QMenu(self), f"{self.objectName()}_menu")
        is_one, is_first = len(self.chosen()) == 1, self._group is FlightGroup.MUST_NOT
        entries = (
            ("open", tr("Open"), Icon.LIVE, self.opened, is_one),
            ("move", tr(MOVE_WORDS[self._group]), Icon.CHEVRON_DOWN if is_first else Icon.CHEVRON_UP,
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

    def _open(self, _index: QModelIndex) -> None:
        self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        match event.key():
            case Qt.Key.Key_Return | Qt.Key.Key_Enter:
                self.opened.emit()
            case Qt.Key.Key_Delete:
                self.remove_wanted.emit()
            case Qt.Key.Key_M if not event.modifiers():
                self.move_wanted.emit()
            case _:
                super().keyPressEvent(event)
