"""Table model of the traffic; rows are formatted only when visible."""

from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Sequence
from enum import Enum
from itertools import islice
from typing import Any

from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QWidget

from app.captures.rows import CaptureRows
from app.system.wall_clock import WallClock, clock_text
from app.text.i18n import tr
from app.text.sentences import in_brackets
from protocol.events import Answered, Event, Rejected
from protocol.frame import Noise
from protocol.translatable import marked
from ui.forms.table_kit import Index, RowsModel, TableColumn
from ui.pages.diagnosis.traffic_texts import (
    Row,
    at_of,
    colour_of,
    hex_of,
    icon_of,
    is_rejected,
    is_streamed,
    meaning_of,
    shown,
    since_start,
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


def is_shown(row: Row, row_filter: Filter) -> bool:
    """Whether the row passes the filter; ignores marks."""
    if row_filter is Filter.REJECTED:
        return is_rejected(row)
    return row_filter is not Filter.WITHOUT_STREAM or not is_streamed(row)


class TrafficModel(RowsModel[Row]):
    """The rows are the last `MAX_ROWS` events that pass the filter, or those of a capture (`show_recorded`).

    `append` only stores events; `show_new` makes rows of them and is called when the view is drawn.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        columns = (
            TableColumn[Row](marked("Time"), self.time_of),
            TableColumn[Row](marked("Kind"), lambda row: shown(row).kind),
            TableColumn[Row](marked("Bytes"), lambda row: hex_of(shown(row).raw, SHOWN_BYTES)),
            TableColumn[Row](marked("Meaning"), meaning_of),
        )
        super().__init__(columns, id, words_of, parent)
        self.bytes_font: QFont | None = None
        self._stored: deque[Event] = deque(maxlen=MAX_ROWS)
        self._recorded: CaptureRows | None = None
        self._live: deque[Row] = deque(maxlen=MAX_ROWS)
        """The rows of the live traffic."""
        self.rows = self._live
        self._keys: Sequence[int] | None = None
        """Keys of marked rows; None: their `id`."""
        self._marks: dict[int, Row] = {}
        self._unseen = 0
        self._filter = Filter.ALL
        self.wall = WallClock()

    @property
    def unseen(self) -> int:
        """Number of stored events that `show_new` has not shown yet."""
        return min(self._unseen, len(self._stored))

    @property
    def is_recorded(self) -> bool:
        return self._recorded is not None

    def append(self, events: Iterable[Event]) -> None:
        """Stores events; cheap, also while hidden."""
        self.wall.poll()
        new = list(_rows_of(events))
        self._stored.extend(new)
        self._unseen += len(new)

    def show_new(self) -> int:
        """Adds rows for the events since the last call; returns how many rows were dropped at the top."""
        if self._recorded is not None or self._filter is Filter.MARKED:
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
            marks = sorted(self._marks.items(), key=lambda mark: at_of(mark[1]))
            self._keys, self.rows = [key for key, _ in marks], [row for _, row in marks]
        elif self._recorded is not None:
            self._keys, self.rows = self._passing(self._recorded)
        else:
            self._unseen = 0
            self._live.extend(event for event in self._stored if is_shown(event, self._filter))
            self._keys, self.rows = None, self._live
        self.endResetModel()

    def _passing(self, recorded: CaptureRows) -> tuple[Sequence[int], Sequence[Row]]:
        """The rows of a capture that pass the filter, and their positions in it."""
        if self._filter is Filter.ALL:
            return range(len(recorded)), recorded
        places = recorded.rejected() if self._filter is Filter.REJECTED else recorded.without_status()
        return places.data, recorded.chosen(places)

    def clear(self) -> None:
        """Removes the live traffic with its marks; a capture stays as it is."""
        self._stored.clear()
        if self._recorded is None:
            self._marks.clear()
            self.rebuild()

    def show_recorded(self, rows: CaptureRows | None) -> None:
        """Shows the rows of a capture; None returns to the live traffic. Removes all marks."""
        self._recorded = rows
        self._marks.clear()
        self.rebuild()

    # Marks

    def is_marked(self, row: int) -> bool:
        return self._key(row) in self._marks

    def _key(self, row: int) -> int:
        return id(self.rows[row]) if self._keys is None else self._keys[row]

    def mark(self, rows: Sequence[int]) -> None:
        """Marks these rows, or unmarks them where all are marked. A marked row outlives its place in the list."""
        keys = [self._key(row) for row in rows]
        if all(key in self._marks for key in keys):
            for key in keys:
                del self._marks[key]
        else:
            new = [(key, row) for key, row in zip(keys, rows, strict=True) if key not in self._marks]
            for key, row in new[: MAX_MARKS - len(self._marks)]:
                self._marks[key] = self.rows[row]
        if self._filter is Filter.MARKED:
            self.rebuild()
        elif rows:
            self.dataChanged.emit(self.index(min(rows), 0), self.index(max(rows), len(self.columns) - 1))

    # Texts

    def same_text_key(self, row: int) -> Hashable | None:
        """Key that is equal for rows of equal text; None for live rows."""
        return self.rows.same_text_key(row) if isinstance(self.rows, CaptureRows) else None

    def time_of(self, row: Row) -> str:
        """Time of day to the millisecond; in a capture the seconds since its beginning."""
        if self._recorded is not None:
            return since_start(at_of(row))
        return clock_text(self.wall.at(at_of(row)), 3)

    def as_text(self, rows: Sequence[int]) -> str:
        """Rows as tab-separated text with all bytes."""
        recorded = self.rows
        if not isinstance(recorded, CaptureRows):
            chosen = (self.rows[number] for number in rows)
            return "\n".join(f"{self.time_of(row)}\t{words_of(row)}" for row in chosen)
        known_words: dict[Hashable, str] = {}
        lines = []
        for number in rows:
            key = recorded.same_text_key(number)
            words = known_words.get(key)
            if words is None:
                words = known_words[key] = words_of(recorded[number])
            lines.append(f"{since_start(recorded.at_s(number))}\t{words}")
        return "\n".join(lines)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role not in _ANSWERED_ROLES:  # most calls: a view asks for seven roles of each cell
            return None
        row = self.rows[index.row()]
        column = _COLUMNS[index.column()]
        if role == _DECORATION:
            return self._picture(row, column, is_marked=self._key(index.row()) in self._marks)
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

    def _picture(self, row: Row, column: Column, *, is_marked: bool) -> Any:
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
