"""The traffic: every frame sent and received, every invalid byte and why, in a table that follows its end."""

from collections import deque
from collections.abc import Iterable
from enum import Enum, IntEnum
from typing import Any, Final, NamedTuple

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QSortFilterProxyModel, Qt
from PySide6.QtGui import QFontMetrics, QGuiApplication
from PySide6.QtWidgets import QComboBox, QHeaderView, QLabel, QLineEdit, QTableView, QToolButton, QWidget

from app.captures.explain import event_sentence
from app.system.clock import clock_text, wall_offset_s
from app.text.i18n import tr
from app.text.messages import in_brackets
from protocol.events import Answered, Ended, Event, Received, Rejected, Role, Sent, Unanswered
from protocol.translatable import marked
from ui.forms.tables import Index, list_rows
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, RowHeight, Size, Space, current, fixed_font, font, is_text_large
from ui.widgets.controls import Shortcut, control, in_column, in_row, name_key, named, text_label
from ui.widgets.number_line import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

MAX_ROWS: Final = 10_000
# Of a row, and of the row that is chosen.
SHOWN_BYTES: Final = 32
CHOSEN_BYTES: Final = 96
# A person cannot read more.
DRAW_EVERY_MS: Final = 160
_ANYWHERE: Final = QModelIndex()
_ROLES: Final = {
    Role.ANSWER: marked("reply"),
    Role.STREAMED: marked("stream"),
    Role.LATE: marked("late"),
    Role.DUPLICATE: marked("doubled"),
    Role.UNSOLICITED: marked("unasked"),
    Role.ECHO: marked("echo"),
}
_TITLES: Final = (marked("Time"), marked("Kind"), marked("Bytes"), marked("Meaning"))


class Column(IntEnum):
    TIME = 0
    KIND = 1
    BYTES = 2
    MEANING = 3


class Filter(Enum):
    ALL = marked("All")
    WITHOUT_STREAM = marked("Without stream")
    REJECTED = marked("Invalid bytes")


class Shown(NamedTuple):
    """The parts of a row besides its meaning."""

    kind: str
    picture: Icon
    raw: bytes = b""
    emphasis: Meaning | None = None  # the colour of rows that need attention


def shown(row: Event) -> Shown:
    match row:
        case Rejected(noise=noise):
            return Shown(tr("invalid"), Icon.WARNING, noise.raw, Meaning.ATTENTION)
        case Sent(attempt=attempt, raw=raw):
            return Shown(tr("sent") + (in_brackets(str(attempt)) if attempt > 1 else ""), Icon.CHEVRON_RIGHT, raw)
        case Received(role=role, frame=frame):
            is_odd = role in (Role.LATE, Role.DUPLICATE, Role.ECHO)
            return Shown(tr(_ROLES[role]), Icon.CHEVRON_LEFT, frame.raw, Meaning.INFORMATION if is_odd else None)
        case Unanswered() | Ended():
            return Shown(tr("link"), Icon.WARNING, emphasis=Meaning.ATTENTION)
    return Shown(tr("link"), Icon.INFORMATION)


def is_streamed(row: Event) -> bool:
    """Whether it is an unasked status."""
    return isinstance(row, Received) and row.role is Role.STREAMED


def cell_text(row: Event, column: int, longest: int | None = None) -> str:
    """Bytes as "41 75 32", of which those after `longest` are only counted."""
    match column:
        case Column.TIME:
            return clock_text(row.at + wall_offset_s(), 3)
        case Column.KIND:
            return shown(row).kind
        case Column.BYTES:
            raw = shown(row).raw
            cut = f" … +{len(raw) - longest}" if longest and len(raw) > longest else ""
            return raw[:longest].hex(" ").upper() + cut
    return event_sentence(row)


class TrafficModel(QAbstractTableModel):
    """The rows are the last `MAX_ROWS` events. `append` only stores events; `show_new` makes rows of them, which are
    formatted when they are seen."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.rows: deque[Event] = deque()
        self.new: deque[Event] = deque(maxlen=MAX_ROWS)
        self.bytes_font = fixed_font(Size.SMALL)

    def append(self, events: Iterable[Event]) -> None:
        self.new.extend(event for event in events if not isinstance(event, Answered))  # its frame has a row already

    def show_new(self) -> None:
        surplus = min(len(self.rows), len(self.rows) + len(self.new) - MAX_ROWS)
        if surplus > 0:
            self.beginRemoveRows(_ANYWHERE, 0, surplus - 1)
            for _ in range(surplus):
                self.rows.popleft()
            self.endRemoveRows()
        if self.new:
            self.beginInsertRows(_ANYWHERE, len(self.rows), len(self.rows) + len(self.new) - 1)
            self.rows.extend(self.new)
            self.new.clear()
            self.endInsertRows()

    def clear(self) -> None:
        self.beginResetModel()
        self.rows.clear()
        self.new.clear()
        self.endResetModel()

    # Qt

    def rowCount(self, parent: Index = _ANYWHERE) -> int:
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = _ANYWHERE) -> int:
        return 0 if parent.isValid() else len(Column)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        is_title = orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole
        return tr(_TITLES[section]) if is_title else None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self.rows[index.row()], index.column()
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return cell_text(row, column, SHOWN_BYTES)
            case Qt.ItemDataRole.ToolTipRole:
                return cell_text(row, column, CHOSEN_BYTES)
            case Qt.ItemDataRole.FontRole if column == Column.BYTES:
                return self.bytes_font
            case Qt.ItemDataRole.DecorationRole if column == Column.KIND:
                return icon(shown(row).picture, shown(row).emphasis)
            case Qt.ItemDataRole.ForegroundRole:
                is_muted = column == Column.TIME or is_streamed(row)
                meaning = shown(row).emphasis or (Meaning.UNKNOWN if is_muted else None)
                return None if meaning is None else current().ink(meaning)
        return None


class TrafficFilter(QSortFilterProxyModel):
    """Shows the rows of one kind in which the searched text stands."""

    def __init__(self, model: TrafficModel) -> None:
        super().__init__(model)
        self._model = model
        self._kind = Filter.ALL
        self._text = ""
        self.setSourceModel(model)

    def use(self, kind: Filter, text: str) -> None:
        self.beginFilterChange()
        self._kind, self._text = kind, text.strip().lower()
        self.endFilterChange(QSortFilterProxyModel.Direction.Rows)

    def filterAcceptsRow(self, source_row: int, _source_parent: Index) -> bool:
        row = self._model.rows[source_row]
        if self._kind is Filter.REJECTED and not isinstance(row, Rejected):
            return False
        if self._kind is Filter.WITHOUT_STREAM and is_streamed(row):
            return False
        if not self._text:
            return True
        entry = shown(row)
        return self._text in f"{event_sentence(row)}\n{entry.raw.hex(' ')}\n{entry.kind}".lower()


class TrafficView(QWidget):
    """Collects frames while hidden; while visible it draws every `DRAW_EVERY_MS`."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("traffic_page")
        # While the last row is in sight the table follows it.
        self._follows = True
        self.model = TrafficModel(self)
        self.shown = TrafficFilter(self.model)
        self.table = self._make_table()
        self.detail = text_label("traffic_detail", "muted", is_selectable=True)
        self.detail.setMinimumHeight(2 * self.detail.fontMetrics().lineSpacing())
        self.detail.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.count = named(QLabel(), "traffic_count", "muted")
        self.filter = named(QComboBox(), "traffic_filter", says=tr("Filter"), tip=tr("Filter"))
        for kind in Filter:
            self.filter.addItem(tr(kind.value), kind)
        WheelGuard(self.filter)
        hint = tr("Bytes (41 75) or words")
        self.search = named(QLineEdit(), "traffic_search", says=tr("Search"), tip=hint)
        Shortcut(self.search, "Ctrl+F")
        name_key(self.search, "Ctrl+F")
        self.search.setPlaceholderText(hint)
        self.search.setClearButtonEnabled(True)
        for button in self.search.findChildren(QToolButton):  # made by Qt, without a name
            named(button, "traffic_search_clear").setAccessibleName(tr("Clear"))
        copy, says = QToolButton(), tr("Copy")
        self.copy = control(copy, "traffic_copy", says=says, keys="Ctrl+C", picture=Icon.COPY, slot=self.copy_rows)
        self.filter.currentIndexChanged.connect(self._use_filter)
        self.search.textChanged.connect(self._use_filter)
        bar = in_row(self.filter, (self.search, 1), self.copy, spacing=Space.S)
        foot = in_row((self.detail, 1), (self.count, Qt.AlignmentFlag.AlignTop), spacing=Space.M)
        in_column(bar, (self.table, 1), foot, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.draw, every_ms=DRAW_EVERY_MS)
        self._show_detail()

    def _make_table(self) -> QTableView:
        table = named(QTableView(), "traffic_table", says=tr("Traffic"))
        table.setModel(self.shown)
        table.setFont(font(Size.SMALL))
        list_rows(table, row_px=RowHeight.DENSE)
        head = table.horizontalHeader()
        for column in (Column.BYTES, Column.MEANING) if is_text_large() else (Column.MEANING,):
            head.setSectionResizeMode(column, QHeaderView.ResizeMode.Stretch)
        table.setColumnWidth(Column.TIME, table.fontMetrics().horizontalAdvance("00:00:00.000 000"))
        table.setColumnWidth(Column.KIND, table.fontMetrics().horizontalAdvance("unasked (2) 000"))
        # All but a trigger record.
        table.setColumnWidth(Column.BYTES, QFontMetrics(self.model.bytes_font).horizontalAdvance("00 " * 9))
        bar = table.verticalScrollBar()
        bar.valueChanged.connect(self._note_scrolling)
        bar.rangeChanged.connect(self._stay_at_end)
        table.selectionModel().selectionChanged.connect(lambda _new, _old: self._show_detail())
        self.model.modelReset.connect(self._show_detail)  # a reset clears the selection without a signal
        return table

    def begin_again(self) -> None:
        """Another connection."""
        self.model.clear()
        self.search.clear()

    def draw(self) -> None:
        """Shows the new rows, unless it is scrolled to earlier ones, which stay where they are."""
        if self._follows:
            self.model.show_new()
        rows = self.shown.rowCount()
        text = tr("rows: {rows}", rows=f"{rows:,}")
        if not self._follows:
            text = tr("{count} new", count=f"{len(self.model.new):,}")
        self.count.setText(text)

    def _note_scrolling(self, position: int) -> None:
        self._follows = position >= self.table.verticalScrollBar().maximum()

    def _stay_at_end(self, _lowest: int, highest: int) -> None:
        """When rows come or go, or the table changes its height."""
        self._follows |= self.table.verticalScrollBar().value() >= highest
        if self._follows:
            self.table.verticalScrollBar().setValue(highest)

    def copy_rows(self) -> None:
        """Copies the selected rows, else all that are shown, with all bytes, as tab-separated text."""
        rows = self._selected() or range(self.shown.rowCount())
        lines = ("\t".join(cell_text(self._event(row), column) for column in Column) for row in rows)
        QGuiApplication.clipboard().setText("\n".join(lines))

    def _event(self, row: int) -> Event:
        return self.model.rows[self.shown.mapToSource(self.shown.index(row, 0)).row()]

    def _selected(self) -> list[int]:
        ranges = self.table.selectionModel().selection().toList()
        return sorted(row for part in ranges for row in range(part.top(), part.bottom() + 1))

    def _use_filter(self) -> None:
        self.shown.use(self.filter.currentData(), self.search.text())
        self.table.scrollToBottom()
        self._show_detail()
        self.draw()

    def _show_detail(self) -> None:
        selected = self._selected()
        text = tr("{count} selected", count=f"{len(selected):,}") if selected else tr("Select a row.")
        if len(selected) == 1:
            event = self._event(selected[0])
            text = f"{shown(event).kind}  {cell_text(event, Column.BYTES, CHOSEN_BYTES)}\n{event_sentence(event)}"
        self.detail.setText(text)
