"""Table model of the traffic; rows are formatted only when visible."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from itertools import islice
from typing import Any

from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QWidget

from app.system.wall_clock import clock_text, wall_offset_s
from app.text.i18n import tr
from app.text.sentences import in_brackets
from protocol.events import Answered, Event, Rejected
from protocol.frame import Noise
from protocol.translatable import marked
from ui.forms.table_kit import Index, RowsModel, TableColumn
from ui.pages.diagnosis.traffic_texts import (
    colour_of,
    hex_of,
    icon_of,
    is_rejected,
    is_streamed,
    meaning_of,
    shown,
    words_of,
)
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning

MAX_ROWS = 10_000
MAX_MARKS = 1000
MAX_ROW_BYTES = 1024
"""A longer run of rejected bytes takes several rows, which bounds the memory."""
SHOWN_BYTES = 32
_ANY_INDEX = QModelIndex()


class Column(Enum):
    TIME = 0
    KIND = 1
    BYTES = 2
    MEANING = 3


class Filter(Enum):
    ALL = "all"
    WITHOUT_STREAM = "without_stream"
    REJECTED = "rejected"
    MARKED = "marked"


_COLUMNS = tuple(Column)
_DECORATION, _FONT, _FOREGROUND = (
    int(role) for role in (Qt.ItemDataRole.DecorationRole, Qt.ItemDataRole.FontRole, Qt.ItemDataRole.ForegroundRole)
)
_SPOKEN = int(Qt.ItemDataRole.AccessibleTextRole)
_TOOLTIP = int(Qt.ItemDataRole.ToolTipRole)
_ANSWERED_ROLES = frozenset((_DECORATION, _FONT, _FOREGROUND, int(Qt.ItemDataRole.DisplayRole), _SPOKEN, _TOOLTIP))


def is_shown(row: Event, row_filter: Filter) -> bool:
    """Whether the row passes the filter; ignores marks."""
    if row_filter is Filter.REJECTED:
        return is_rejected(row)
    return row_filter is not Filter.WITHOUT_STREAM or not is_streamed(row)


class TrafficModel(RowsModel[Event]):
    """The rows are the last `MAX_ROWS` events that pass the filter, or the marked ones.

    `append` only stores events; `show_new` makes rows of them and is called when the view is drawn.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        columns = (
            TableColumn[Event](marked("Time"), self.time_of),
            TableColumn[Event](marked("Kind"), lambda row: shown(row).kind),
            TableColumn[Event](marked("Bytes"), lambda row: hex_of(shown(row).raw, SHOWN_BYTES)),
            TableColumn[Event](marked("Meaning"), meaning_of),
        )
        super().__init__(columns, id, words_of, parent)
        self.bytes_font: QFont | None = None
        self._stored: deque[Event] = deque(maxlen=MAX_ROWS)
        self._live: deque[Event] = deque(maxlen=MAX_ROWS)
        self.rows: Sequence[Event] = self._live
        self._marks: dict[int, Event] = {}
        """By their `id`; a marked row outlives its place in the list."""
        self._unseen = 0
        self._filter = Filter.ALL

    @property
    def events(self) -> tuple[Event, ...]:
        """All that are stored, whatever the filter, oldest first."""
        return tuple(self._stored)

    @property
    def unseen(self) -> int:
        """Number of stored events that `show_new` has not shown yet."""
        return min(self._unseen, len(self._stored))

    def append(self, events: Iterable[Event]) -> None:
        """Stores events; cheap, also while hidden."""
        new = list(_rows_of(events))
        self._stored.extend(new)
        self._unseen += len(new)

    def show_new(self) -> int:
        """Adds rows for the events since the last call; returns how many rows were dropped at the top."""
        if self._filter is Filter.MARKED:
            return 0
        unseen = self.unseen
        self._unseen = 0
        if not unseen:
            return 0
        # From the end, because indexing into a deque is slow.
        newest = reversed(list(islice(reversed(self._stored), unseen)))
        fresh = [event for event in newest if is_shown(event, self._filter)]
        if not fresh:
            return 0
        surplus = max(0, len(self._live) + len(fresh) - MAX_ROWS)
        dropped = min(surplus, len(self._live))
        if dropped:
            self.beginRemoveRows(_ANY_INDEX, 0, dropped - 1)
            for _ in range(dropped):
                self._live.popleft()
            self.endRemoveRows()
        first = len(self._live)
        self.beginInsertRows(_ANY_INDEX, first, first + len(fresh) - 1)
        self._live.extend(fresh)
        self.endInsertRows()
        return dropped

    def use_filter(self, row_filter: Filter) -> None:
        self._filter = row_filter
        self.rebuild()

    def rebuild(self) -> None:
        self.beginResetModel()
        self._live.clear()
        if self._filter is Filter.MARKED:
            self.rows = sorted(self._marks.values(), key=lambda event: event.at)
        else:
            self._unseen = 0
            self._live.extend(event for event in self._stored if is_shown(event, self._filter))
            self.rows = self._live
        self.endResetModel()

    def clear(self) -> None:
        """Removes the traffic with its marks."""
        self._stored.clear()
        self._marks.clear()
        self.rebuild()

    # Marks

    def is_marked(self, row: int) -> bool:
        return id(self.rows[row]) in self._marks

    def mark(self, rows: Sequence[int]) -> None:
        """Marks these rows, or unmarks them where all are marked."""
        new = [row for row in rows if not self.is_marked(row)]
        for row in rows if not new else ():
            del self._marks[id(self.rows[row])]
        for row in new[: MAX_MARKS - len(self._marks)]:
            self._marks[id(self.rows[row])] = self.rows[row]
        if self._filter is Filter.MARKED:
            self.rebuild()
        elif rows:
            self.dataChanged.emit(self.index(min(rows), 0), self.index(max(rows), len(self.columns) - 1))

    # Texts

    def time_of(self, row: Event) -> str:
        """Time of day to the millisecond."""
        return clock_text(row.at + wall_offset_s(), 3)

    def as_text(self, rows: Sequence[int]) -> str:
        """Rows as tab-separated text with all bytes."""
        chosen = (self.rows[number] for number in rows)
        return "\n".join(f"{self.time_of(row)}\t{words_of(row)}" for row in chosen)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role not in _ANSWERED_ROLES:  # most calls: a view asks for seven roles of each cell
            return None
        row = self.rows[index.row()]
        column = _COLUMNS[index.column()]
        if role == _DECORATION:
            return self._picture(row, column, is_marked=self.is_marked(index.row()))
        if role == _FONT:
            return self.bytes_font if column is Column.BYTES else None
        if role == _FOREGROUND:
            return colour_of(row, is_time=column is Column.TIME)
        text = self.columns[index.column()].text(row)
        if role == _TOOLTIP and column is Column.BYTES:
            return hex_of(shown(row).raw)
        if role == _SPOKEN and column is Column.TIME and self.is_marked(index.row()):
            return f"{text}{in_brackets(tr('Marked'))}"
        return text

    def _picture(self, row: Event, column: Column, *, is_marked: bool) -> Any:
        if column is Column.KIND:
            return icon_of(row)
        return _MARK if column is Column.TIME and is_marked else None


_MARK = icon(Icon.BOOKMARK, Meaning.INFORMATION)


def _rows_of(events: Iterable[Event]) -> Iterator[Event]:
    """Yields an event per row; splits long runs of rejected bytes."""
    for event in events:
        if isinstance(event, Rejected) and len(event.noise.raw) > MAX_ROW_BYTES:
            noise = event.noise
            for first in range(0, len(noise.raw), MAX_ROW_BYTES):
                raw = noise.raw[first : first + MAX_ROW_BYTES]
                yield Rejected(Noise(raw, noise.fault, noise.offset + first), event.at)
        elif not isinstance(event, Answered):  # its frame has a row already
            yield event
