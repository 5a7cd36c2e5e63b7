"""The traffic: every frame sent and received, every invalid byte and why, in a table that follows its end."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from functools import cache
from typing import Any, Final, NamedTuple

from PySide6.QtCore import QAbstractTableModel, QItemSelection, QModelIndex, QObject, QSortFilterProxyModel, Qt
from PySide6.QtGui import QColor, QFontMetrics, QGuiApplication, QIcon
from PySide6.QtWidgets import QComboBox, QHeaderView, QLabel, QLineEdit, QTableView, QToolButton, QWidget

from app.captures.explain import event_sentence
from app.engine.worker import Batch
from app.system.clock import clock_text, wall_offset_s
from app.text.i18n import tr
from protocol.events import Answered, Ended, Event, OutcomeUnknown, Received, Rejected, Role, Sent, Unanswered
from protocol.messages import Noise
from protocol.translatable import marked
from ui.forms.tables import Index, list_rows
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, RowHeight, Size, Space, current, fixed_font, font, is_text_large
from ui.widgets.controls import control, in_column, in_row, named, text_label
from ui.widgets.number_line import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_ROLES = {
    Role.ANSWER: marked("reply"),
    Role.STREAMED: marked("stream"),
    Role.LATE: marked("late"),
    Role.DUPLICATE: marked("doubled"),
    Role.UNSOLICITED: marked("unasked"),
    Role.ECHO: marked("echo"),
}


class Shown(NamedTuple):
    """What a row shows besides its meaning: its kind, in one word; its bytes, which may be none; a picture for its
    direction or a warning; and the colour of rows that need attention."""

    kind: str
    raw: bytes
    picture: Icon
    emphasis: Meaning | None = None


def shown(row: Event) -> Shown:
    match row:
        case Rejected(noise=noise):
            return Shown(tr("invalid"), noise.raw, Icon.WARNING, Meaning.ATTENTION)
        case Sent(attempt=attempt, raw=raw):
            return Shown(tr("sent") if attempt == 1 else f"{tr('sent')} ({attempt})", raw, Icon.CHEVRON_RIGHT)
        case Received(role=role, frame=frame):
            is_odd = role in (Role.LATE, Role.DUPLICATE, Role.ECHO)
            return Shown(tr(_ROLES[role]), frame.raw, Icon.CHEVRON_LEFT, Meaning.INFORMATION if is_odd else None)
        case OutcomeUnknown() | Unanswered():
            return Shown(tr("link"), b"", Icon.WARNING, Meaning.ATTENTION)
        case Ended():
            return Shown(tr("link"), b"", Icon.INFORMATION, Meaning.ATTENTION)
        case _:
            return Shown(tr("link"), b"", Icon.INFORMATION)


def hex_of(raw: bytes, longest: int | None = None) -> str:
    """ "41 75 32"; longer ones are cut after `longest` bytes, with the number of the rest."""
    if longest is None or len(raw) <= longest:
        return raw.hex(" ").upper()
    return f"{raw[:longest].hex(' ').upper()} … +{len(raw) - longest}"


def words_of(row: Event) -> str:
    """Kind, all bytes and meaning, separated by tabs."""
    seen = shown(row)
    return "\t".join((seen.kind, hex_of(seen.raw), event_sentence(row)))


def is_rejected(row: Event) -> bool:
    return isinstance(row, Rejected)


def is_streamed(row: Event) -> bool:
    """Whether it is an unasked status."""
    return isinstance(row, Received) and row.role is Role.STREAMED


_picture = cache(icon)


def icon_of(row: Event) -> QIcon:
    seen = shown(row)
    return _picture(seen.picture, seen.emphasis)


def colour_of(row: Event, *, is_time: bool) -> QColor | None:
    emphasis = shown(row).emphasis
    if emphasis is not None:
        return current().ink(emphasis)
    return current().ink(Meaning.UNKNOWN) if is_time or is_streamed(row) else None


MAX_ROWS: Final = 10_000
# A longer run of rejected bytes takes several rows, which bounds the memory.
MAX_ROW_BYTES: Final = 1024
SHOWN_BYTES: Final = 32
# A person cannot read more.
DRAW_EVERY_MS: Final = 160
_ANYWHERE: Final = QModelIndex()


class Column(Enum):
    TIME = 0
    KIND = 1
    BYTES = 2
    MEANING = 3


class Filter(Enum):
    ALL = marked("All")
    WITHOUT_STREAM = marked("Without stream")
    REJECTED = marked("Invalid bytes")


_TITLES: Final = (marked("Time"), marked("Kind"), marked("Bytes"), marked("Meaning"))


class TrafficModel(QAbstractTableModel):
    """The rows are the last `MAX_ROWS` events. `append` only stores events; `show_new` makes rows of them, which are
    formatted when they are seen."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.rows: deque[Event] = deque()
        self.bytes_font = fixed_font(Size.SMALL)
        self._new: deque[Event] = deque(maxlen=MAX_ROWS)

    @property
    def events(self) -> tuple[Event, ...]:
        """All that are stored, oldest first."""
        return (*self.rows, *self._new)

    @property
    def unseen(self) -> int:
        """Number of stored events that `show_new` has not shown yet."""
        return len(self._new)

    def append(self, events: Iterable[Event]) -> None:
        self._new.extend(_rows_of(events))

    def show_new(self) -> None:
        surplus = min(len(self.rows), len(self.rows) + len(self._new) - MAX_ROWS)
        if surplus > 0:
            self.beginRemoveRows(_ANYWHERE, 0, surplus - 1)
            for _ in range(surplus):
                self.rows.popleft()
            self.endRemoveRows()
        if self._new:
            self.beginInsertRows(_ANYWHERE, len(self.rows), len(self.rows) + len(self._new) - 1)
            self.rows.extend(self._new)
            self._new.clear()
            self.endInsertRows()

    def clear(self) -> None:
        self.beginResetModel()
        self.rows.clear()
        self._new.clear()
        self.endResetModel()

    def as_text(self, rows: Iterable[int]) -> str:
        """Rows as tab-separated text with all bytes."""
        return "\n".join(f"{_time_of(self.rows[row])}\t{words_of(self.rows[row])}" for row in rows)

    # Qt

    def rowCount(self, parent: Index = _ANYWHERE) -> int:
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = _ANYWHERE) -> int:
        return 0 if parent.isValid() else len(_TITLES)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return tr(_TITLES[section])
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self.rows[index.row()], index.column()
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return _text_of(row, column)
            case Qt.ItemDataRole.ToolTipRole:
                return hex_of(shown(row).raw) if column == Column.BYTES.value else _text_of(row, column)
            case Qt.ItemDataRole.DecorationRole:
                return icon_of(row) if column == Column.KIND.value else None
            case Qt.ItemDataRole.FontRole:
                return self.bytes_font if column == Column.BYTES.value else None
            case Qt.ItemDataRole.ForegroundRole:
                return colour_of(row, is_time=column == Column.TIME.value)
        return None


class TrafficFilter(QSortFilterProxyModel):
    """Shows the rows of one kind that contain the searched words or bytes."""

    def __init__(self, model: TrafficModel) -> None:
        super().__init__(model)
        self._model = model
        self._kind = Filter.ALL
        self._query = self._query_hex = ""
        self.setSourceModel(model)

    def use(self, kind: Filter, query: str) -> None:
        self.beginFilterChange()
        self._kind, self._query = kind, query.strip().lower()
        self._query_hex = hex_part(self._query)
        self.endFilterChange(QSortFilterProxyModel.Direction.Rows)

    def filterAcceptsRow(self, source_row: int, _source_parent: Index) -> bool:
        row = self._model.rows[source_row]
        if self._kind is Filter.REJECTED and not is_rejected(row):
            return False
        if self._kind is Filter.WITHOUT_STREAM and is_streamed(row):
            return False
        return not self._query or matches(row, self._query, self._query_hex)


def matches(row: Event, query: str, query_hex: str) -> bool:
    """`query`: lower case. `query_hex`: its hex digits, "" where it is not hex."""
    seen = shown(row)
    if query_hex and query_hex in seen.raw.hex():
        return True
    return query in event_sentence(row).lower() or query in seen.kind.lower()


def hex_part(text: str) -> str:
    """The digits of a text of pairs of hex digits, else ""."""
    digits = "".join(text.lower().split())
    is_hex = len(digits) % 2 == 0 and all(digit in "0123456789abcdef" for digit in digits)
    return digits if is_hex else ""


def _time_of(row: Event) -> str:
    """Time of day to the millisecond."""
    return clock_text(row.at + wall_offset_s(), 3)


def _text_of(row: Event, column: int) -> str:
    match Column(column):
        case Column.TIME:
            return _time_of(row)
        case Column.KIND:
            return shown(row).kind
        case Column.BYTES:
            return hex_of(shown(row).raw, SHOWN_BYTES)
        case Column.MEANING:
            return event_sentence(row)


def _rows_of(events: Iterable[Event]) -> Iterator[Event]:
    """Yields an event per row; splits long runs of rejected bytes."""
    for event in events:
        if isinstance(event, Rejected) and len(event.noise.raw) > MAX_ROW_BYTES:
            noise = event.noise
            for first in range(0, len(noise.raw), MAX_ROW_BYTES):
                raw = noise.raw[first : first + MAX_ROW_BYTES]
                yield Rejected(Noise(raw, noise.reason, noise.offset + first), event.at)
        elif not isinstance(event, Answered):  # its frame has a row already
            yield event


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
        self.filter = control(QComboBox(), "traffic_filter", says=tr("Filter"), tip=tr("Filter"))
        for kind in Filter:
            self.filter.addItem(tr(kind.value), kind)
        WheelGuard(self.filter)
        self.search = control(
            QLineEdit(), "traffic_search", says=tr("Search"), tip=tr("Bytes (41 75) or words"), keys="Ctrl+F"
        )
        self.search.setPlaceholderText(tr("Bytes (41 75) or words"))
        self.search.setClearButtonEnabled(True)
        for button in self.search.findChildren(QToolButton):  # made by Qt, without a name
            named(button, "traffic_search_clear").setAccessibleName(tr("Clear"))
        self.pause = control(
            QToolButton(), "traffic_pause", text=tr("Pause"), keys="Ctrl+P", picture=Icon.PAUSE, is_checkable=True
        )
        self.copy = control(
            QToolButton(), "traffic_copy", says=tr("Copy"), keys="Ctrl+C", picture=Icon.COPY, slot=self.copy_rows
        )
        self.filter.currentIndexChanged.connect(self._use_filter)
        self.search.textChanged.connect(self._use_filter)
        self.pause.toggled.connect(self._pause)
        bar = in_row(self.filter, (self.search, 1), self.pause, self.copy, spacing=Space.S)
        foot = in_row((self.detail, 1), (self.count, Qt.AlignmentFlag.AlignTop), spacing=Space.M)
        in_column(bar, (self.table, 1), foot, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.draw, every_ms=DRAW_EVERY_MS, restyle=self._apply_theme)
        self._apply_theme()
        self._show_detail()

    def _make_table(self) -> QTableView:
        table = control(QTableView(), "traffic_table", says=tr("Traffic"))
        table.setModel(self.shown)
        list_rows(table, row_px=RowHeight.DENSE)
        head = table.horizontalHeader()
        for column in (Column.BYTES, Column.MEANING) if is_text_large() else (Column.MEANING,):
            head.setSectionResizeMode(column.value, QHeaderView.ResizeMode.Stretch)
        bar = table.verticalScrollBar()
        bar.valueChanged.connect(self._note_scrolling)
        bar.rangeChanged.connect(self._stay_at_end)
        table.selectionModel().selectionChanged.connect(self._show_detail)
        self.model.modelReset.connect(self._show_detail)  # a reset clears the selection without a signal
        return table

    def on_batch(self, batch: Batch) -> None:
        self.model.append(batch.events)

    def begin_again(self) -> None:
        """Another connection."""
        self.model.clear()
        self.pause.setChecked(False)
        self.search.clear()

    def draw(self) -> None:
        """Shows the new rows, unless it is held."""
        if not self._is_held:
            self.model.show_new()
        self._show_count()

    @property
    def _is_held(self) -> bool:
        """Paused, or scrolled to earlier rows, which stay where they are."""
        return self.pause.isChecked() or not self._follows

    def _note_scrolling(self, position: int) -> None:
        self._follows = position >= self.table.verticalScrollBar().maximum()

    def _stay_at_end(self, _lowest: int, highest: int) -> None:
        """When rows come or go, or the table changes its height."""
        self._follows |= self.table.verticalScrollBar().value() >= highest
        if self._follows:
            self.table.verticalScrollBar().setValue(highest)

    def copy_rows(self) -> None:
        """Copies the selected rows, else all that are shown, as tab-separated text."""
        rows = self._selected() or range(self.shown.rowCount())
        source = [self.shown.mapToSource(self.shown.index(row, 0)).row() for row in rows]
        QGuiApplication.clipboard().setText(self.model.as_text(source))

    def _selected(self) -> Sequence[int]:
        ranges = self.table.selectionModel().selection().toList()
        return sorted(row for part in ranges for row in range(part.top(), part.bottom() + 1))

    def _use_filter(self) -> None:
        self.shown.use(self.filter.currentData(), self.search.text())
        self.table.scrollToBottom()
        self._show_detail()
        self._show_count()

    def _pause(self, is_paused: bool) -> None:
        self.pause.setIcon(icon(Icon.PLAY if is_paused else Icon.PAUSE))
        self.pause.setText(tr("Continue") if is_paused else tr("Pause"))
        self.draw()

    def _show_count(self) -> None:
        rows = self.shown.rowCount()
        if self._is_held:
            self.count.setText(tr("{count} new", count=f"{self.model.unseen:,}"))
        elif self.search.text() and not rows:
            self.count.setText(tr("No matches"))
        else:
            self.count.setText(tr("rows: {rows}", rows=f"{rows:,}"))

    def _show_detail(self, _new: QItemSelection | None = None, _old: QItemSelection | None = None) -> None:
        selected = self._selected()
        if len(selected) != 1:
            count = tr("{count} selected", count=f"{len(selected):,}")
            self.detail.setText(count if selected else tr("Select a row."))
            return
        event = self.model.rows[self.shown.mapToSource(self.shown.index(selected[0], 0)).row()]
        seen = shown(event)
        self.detail.setText(f"{seen.kind}  {hex_of(seen.raw, 96)}\n{event_sentence(event)}")

    def _apply_theme(self) -> None:
        self.table.setFont(font(Size.SMALL))
        self.model.bytes_font = fixed_font(Size.SMALL)
        width = self.table.fontMetrics().horizontalAdvance
        self.table.setColumnWidth(Column.TIME.value, width("00:00:00.000 000"))
        self.table.setColumnWidth(Column.KIND.value, width("unasked (2) 000"))
        usual = QFontMetrics(self.model.bytes_font).horizontalAdvance("00 " * 9)  # all but a trigger record
        self.table.setColumnWidth(Column.BYTES.value, usual)
