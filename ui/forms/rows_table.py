"""A table of whole rows, which are opened by double click or Enter and removed by Del; rows of facts."""

from collections.abc import Callable, Collection, Mapping
from typing import Final, Generic

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHeaderView, QLabel, QTableView, QWidget

from ui.core.texts import Texts
from ui.forms.table_kit import Row, RowsFilter, list_rows
from ui.style.theme import Size, Space, font, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.visibility_timer import VisibilityTimer

_PAD_PX: Final = 5
"""Padding at each side of a cell, in the style sheet."""
_FRAME_PX: Final = 8
"""Frame of the style, both sides together."""
_ICON_PX: Final = 24


class RowsTable(QTableView, Generic[Row]):
    """`stretched`: the column that takes the remaining width; `spare`: the column that is hidden where there is no room
    for it."""

    opened = Signal()
    remove_wanted = Signal()

    def __init__(
        self, name: str, model: RowsFilter[Row], *, row_px: int, sorted_by: int, stretched: int,
        order: Qt.SortOrder = Qt.SortOrder.DescendingOrder, hidden: Collection[int] = (),
        spare: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__()
        named(self, name)
        self._filter, self._spare = model, spare
        self._widths: dict[int, int] = {}
        self.setModel(model)
        self.setSortingEnabled(True)
        self.sortByColumn(sorted_by, order)
        list_rows(self, row_px=row_px)
        for column in hidden:
            self.setColumnHidden(column, True)
        self.horizontalHeader().setSectionResizeMode(stretched, QHeaderView.ResizeMode.Stretch)
        self.doubleClicked.connect(self._open)
        VisibilityTimer(self, self.measure, restyle=self.measure)

    def measure(self) -> None:
        """Sets the widths of the columns; called again after a change of language, font or theme."""

    def chosen(self) -> tuple[Row, ...]:
        """The selected rows in the order shown."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return tuple(self._filter.row_at(row) for row in rows)

    def choose(self, is_wanted: Callable[[Row], bool]) -> None:
        """Selects the rows for which `is_wanted` is true."""
        model = self.selectionModel()
        self.clearSelection()
        for row in range(self._filter.rowCount()):
            if is_wanted(self._filter.row_at(row)):
                model.select(self._filter.index(row, 0), model.SelectionFlag.Select | model.SelectionFlag.Rows)

    def fit_columns(
        self, texts: Mapping[int, str], *, with_icon: Collection[int] = (), fixed_px: Mapping[int, int] | None = None
    ) -> None:
        """Makes columns as wide as these texts, and at least as their headers with the sort arrow."""
        self._widths = dict(fixed_px or {})
        body, heads = QFontMetrics(font(Size.BODY)), QFontMetrics(font(Size.SMALL, is_bold=True))
        for column, text in texts.items():
            title = str(self._filter.headerData(column, Qt.Orientation.Horizontal))
            icon_px = _ICON_PX if column in with_icon else 0
            self._widths[column] = max(
                body.horizontalAdvance(text) + icon_px + 2 * scaled(_PAD_PX) + _FRAME_PX,
                heads.horizontalAdvance(title) + Space.XL + 2,
            )
        for column, width in self._widths.items():
            self.setColumnWidth(column, width)
        self._share_width()
        self.viewport().update()

    def _share_width(self) -> None:
        if self._spare in self._widths:
            # Whether it scrolls or not, so that lists of the same width have the same columns.
            room = self.width() - 2 * self.frameWidth() - self.verticalScrollBar().sizeHint().width()
            self.setColumnHidden(self._spare, sum(self._widths.values()) > room)
            self.setColumnWidth(self._spare, self._widths[self._spare])

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._share_width()

    def _open(self) -> None:
        self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        match event.key():
            case Qt.Key.Key_Return | Qt.Key.Key_Enter:
                self.opened.emit()
            case Qt.Key.Key_Delete:
                self.remove_wanted.emit()
            case _:
                super().keyPressEvent(event)


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
