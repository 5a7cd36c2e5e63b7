"""Table view of the trigger records: decoded cells above, the sentence below across the row."""

from typing import Final

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QColor, QFont, QFontMetrics, QPainter
from PySide6.QtWidgets import (
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from app.text.i18n import tr
from ui.forms.table_kit import Index, RowsFilter, list_rows
from ui.pages.triggers.controller import TriggerRow
from ui.pages.triggers.model import COLUMNS, Column
from ui.style.theme import Size, Space, current, font
from ui.widgets.naming import named

CELL_PX: Final = 24
SENTENCE_PX: Final = 22
_INSET_PX: Final = 8


class SentenceDelegate(QStyledItemDelegate):
    """Each cell paints its own part of the sentence, so that it runs through the row without a break."""

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        table = option.widget
        if not isinstance(table, QTableView):
            return
        theme, rect = current(), option.rect
        is_selected = bool(option.state & QStyle.StateFlag.State_Selected)
        is_odd = index.row() % 2 == 1
        ground = theme.selection if is_selected else (theme.window if is_odd else theme.surface)
        painter.save()
        painter.setClipRect(rect)
        painter.fillRect(rect, QColor(ground))
        painter.setPen(QColor(theme.divider))
        painter.drawLine(rect.bottomLeft(), rect.bottomRight())
        cell = QRect(rect.left() + _INSET_PX, rect.top() + 3, rect.width() - _INSET_PX - 4, CELL_PX)
        self._paint_cell(painter, cell, index)
        start = table.columnViewportPosition(0) + _INSET_PX
        end = sum(table.columnWidth(column) for column in range(len(Column)))
        line = QRect(start, rect.top() + CELL_PX, min(end, table.viewport().width()) - 2 * _INSET_PX, SENTENCE_PX)
        one = font(Size.SMALL)
        text = QFontMetrics(one).elidedText(
            str(index.data(Qt.ItemDataRole.ToolTipRole)), Qt.TextElideMode.ElideRight, line.width()
        )
        painter.setFont(one)
        painter.setPen(QColor(theme.muted))
        painter.drawText(line, int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter), text)
        painter.restore()

    def _paint_cell(self, painter: QPainter, cell: QRect, index: Index) -> None:
        theme = current()
        picture = index.data(Qt.ItemDataRole.DecorationRole)
        if picture is not None:
            square = QRect(cell.left(), cell.top() + (cell.height() - 14) // 2, 14, 14)
            picture.paint(painter, square)
            cell = cell.adjusted(18, 0, 0, 0)
        is_main = index.column() in (Column.WHEN, Column.WHY)
        one = _strong() if is_main else font(Size.SMALL)
        painter.setFont(one)
        ink = index.data(Qt.ItemDataRole.ForegroundRole)
        painter.setPen(ink if isinstance(ink, QColor) else QColor(theme.text))
        text = QFontMetrics(one).elidedText(
            str(index.data(Qt.ItemDataRole.DisplayRole)), Qt.TextElideMode.ElideRight, cell.width()
        )
        flags = int(index.data(Qt.ItemDataRole.TextAlignmentRole))
        painter.drawText(cell, flags, text)

    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:
        return QSize(80, CELL_PX + SENTENCE_PX + 4)


class TriggersTable(QTableView):
    def __init__(self, model: RowsFilter[TriggerRow], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "triggers_table")
        self.setModel(model)
        self.setItemDelegate(SentenceDelegate(self))
        self.setSortingEnabled(True)
        self.sortByColumn(Column.WHEN, Qt.SortOrder.DescendingOrder)
        list_rows(self, row_px=CELL_PX + SENTENCE_PX + 4)
        columns = self.horizontalHeader()
        columns.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        columns.setStretchLastSection(True)
        columns.sectionResized.connect(self._paint_again)
        self.horizontalScrollBar().valueChanged.connect(self._paint_again)
        self.measure()

    def measure(self) -> None:
        """Columns as wide as their widest usual text, after a change of language, font or theme."""
        small, strong = QFontMetrics(font(Size.SMALL)), QFontMetrics(_strong())
        when = "   " + tr("boot {boot} · {uptime}", boot=255, uptime="0:00:00")
        texts = {
            Column.WHY: max(
                f"{tr('attitude')} + {tr('free fall')}", f"{tr('serial')} + PWM", key=strong.horizontalAdvance
            ),
            Column.SETTINGS: "180° 2.5 g 2.55 s",
            Column.LINK: tr("connected"),
            Column.CHARGE: tr("charging"),
            Column.LIGHT: "25.5 V",
            Column.CELL: "     " + tr("{voltage} implausible", voltage="4.70 V"),
        }
        judged = strong.horizontalAdvance(tr(COLUMNS[Column.JUDGED].title)) + Space.L + 2
        self.setColumnWidth(Column.JUDGED, judged)  # and what is left
        self.setColumnWidth(Column.WHEN, strong.horizontalAdvance(when) + Space.L)
        for column, text in texts.items():
            head = strong.horizontalAdvance(tr(COLUMNS[column].title)) + Space.L + 2
            metrics = strong if column is Column.WHY else small
            self.setColumnWidth(column, max(metrics.horizontalAdvance(text) + _INSET_PX + 5, head))
        self.viewport().update()

    def _paint_again(self) -> None:
        self.viewport().update()


def _strong() -> QFont:
    one = font(Size.SMALL)
    one.setWeight(QFont.Weight.DemiBold)
    return one
