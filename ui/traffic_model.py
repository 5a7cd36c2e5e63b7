"""The frames that went over the line, as rows of a table: kept as they came, put into words only where seen."""

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from enum import Enum
from functools import cache
from itertools import islice
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QColor, QFont, QIcon

from app.explain import Asked, sentence
from app.i18n import tr
from protocol.events import (
    Answered,
    Event,
    OutcomeUnknown,
    Received,
    Rejected,
    Restarted,
    Role,
    Sent,
    Unanswered,
    WentOffline,
    WentOnline,
)
from protocol.frame import Direction, Frame, Noise
from protocol.messages import Acknowledgement, Reading
from protocol.text import marked
from ui.icons import Icon, icon
from ui.theme import Meaning, current

KEPT_ROWS = 10_000
LONGEST_ROW_BYTES = 1024
"""So that a line full of garbage cannot fill the memory: a longer run of rejected bytes takes several rows."""
SHOWN_BYTES = 32
_ANY_INDEX = QModelIndex()
_Index = QModelIndex | QPersistentModelIndex


class Column(Enum):
    TIME = 0
    KIND = 1
    BYTES = 2
    MEANING = 3


class Filter(Enum):
    ALL = "all"
    WITHOUT_STREAM = "without_stream"
    REJECTED = "rejected"


_COLUMNS = tuple(Column)
_DECORATION, _FONT, _FOREGROUND = (
    int(role) for role in (Qt.ItemDataRole.DecorationRole, Qt.ItemDataRole.FontRole, Qt.ItemDataRole.ForegroundRole)
)
_ANSWERED_ROLES = frozenset(
    (_DECORATION, _FONT, _FOREGROUND, int(Qt.ItemDataRole.DisplayRole), int(Qt.ItemDataRole.AccessibleTextRole))
)
_HEADERS = {
    Column.TIME: marked("Time"),
    Column.KIND: marked("Kind"),
    Column.BYTES: marked("Bytes"),
    Column.MEANING: marked("Meaning"),
}
_ROLES = {
    Role.ANSWER: marked("answer"),
    Role.STREAMED: marked("stream"),
    Role.LATE: marked("late"),
    Role.DOUBLED: marked("doubled"),
    Role.UNASKED: marked("unasked"),
    Role.ECHO: marked("echo"),
}


def is_shown(event: Event, wanted: Filter) -> bool:
    """Whether a row of this event passes the filter."""
    if wanted is Filter.REJECTED:
        return isinstance(event, Rejected)
    return wanted is Filter.ALL or not (isinstance(event, Received) and event.role is Role.STREAMED)


def kind_of(event: Event) -> str:
    """One word for what it is, in the language in use."""
    match event:
        case Sent():
            return tr("sent") if event.attempt == 1 else tr("sent, {n}.", n=event.attempt)
        case Received():
            return tr(_ROLES[event.role])
        case Rejected():
            return tr("rejected")
        case _:
            return tr("link")


def raw_of(event: Event) -> bytes:
    match event:
        case Sent():
            return event.raw
        case Received():
            return event.frame.raw
        case Rejected():
            return event.noise.raw
        case _:
            return b""


def meaning_of(event: Event) -> str:
    """One sentence, in the language in use."""
    match event:
        case Sent():
            return sentence(Frame(Direction.HOST_TO_MODULE, event.raw))
        case Received():
            return sentence(event.frame, _asked(event))
        case Rejected():
            return sentence(event.noise)
        case Unanswered() if event.attempts == 0:
            return tr("not sent: the module did not answer the heartbeat before it")
        case Unanswered():
            return tr("no answer within {seconds:.2f} s, asked {n} times", seconds=event.waited_s, n=event.attempts)
        case OutcomeUnknown():
            wait_s = event.waited_s
            return tr("sent, not confirmed within {seconds:.2f} s: it may have been carried out", seconds=wait_s)
        case Restarted():
            return tr("the module restarted") if event.is_certain else tr("the module probably restarted")
        case WentOnline():
            return tr("the module answers: online")
        case WentOffline():
            return tr("a heartbeat was not answered: offline")
        case Answered():
            return ""


def _asked(received: Received) -> Asked:
    """What the frame was taken to answer."""
    match received.message:
        case Acknowledgement(request=request):
            return request
        case Reading(command=command) if received.role is not Role.UNASKED and command.can_be_asked:
            return command.query()
        case _:
            return None


def hex_of(raw: bytes, longest: int | None = None) -> str:
    """"41 75 32", cut after `longest` bytes with the number of those left out."""
    if longest is None or len(raw) <= longest:
        return raw.hex(" ").upper()
    return f"{raw[:longest].hex(' ').upper()} … +{len(raw) - longest}"


class TrafficModel(QAbstractTableModel):
    """The last `KEPT_ROWS` events; of them the ones that pass the filter are rows.

    `keep` only remembers. `show_new` turns what came since into rows: the owner calls it as often as it wants to draw.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.bytes_font: QFont | None = None
        self._kept: deque[Event] = deque(maxlen=KEPT_ROWS)
        self._rows: deque[Event] = deque(maxlen=KEPT_ROWS)
        self._unseen = 0
        self._filter = Filter.ALL
        self._wall_offset_s = time.time() - time.monotonic()

    @property
    def unseen(self) -> int:
        """Events that `keep` took and `show_new` has not shown yet; at most `KEPT_ROWS`."""
        return min(self._unseen, len(self._kept))

    def keep(self, events: Iterable[Event]) -> None:
        """Cheap; may be called while nobody looks."""
        new = list(_rows_of(events))
        self._kept.extend(new)
        self._unseen += len(new)

    def show_new(self) -> int:
        """Add rows for what came since the last call; how many rows were dropped at the top to make room."""
        unseen = self.unseen
        self._unseen = 0
        if not unseen:
            return 0
        # From the end: the head of a full deque is far from what is new.
        newest = reversed(list(islice(reversed(self._kept), unseen)))
        fresh = [event for event in newest if is_shown(event, self._filter)]
        if not fresh:
            return 0
        surplus = max(0, len(self._rows) + len(fresh) - KEPT_ROWS)
        dropped = min(surplus, len(self._rows))
        if dropped:
            self.beginRemoveRows(_ANY_INDEX, 0, dropped - 1)
            for _ in range(dropped):
                self._rows.popleft()
            self.endRemoveRows()
        first = len(self._rows)
        self.beginInsertRows(_ANY_INDEX, first, first + len(fresh) - 1)
        self._rows.extend(fresh)
        self.endInsertRows()
        return dropped

    def use_filter(self, wanted: Filter) -> None:
        self._filter = wanted
        self.rebuild()

    def rebuild(self) -> None:
        """Make all rows anew from what is kept."""
        self.beginResetModel()
        self._unseen = 0
        self._rows = deque((event for event in self._kept if is_shown(event, self._filter)), maxlen=KEPT_ROWS)
        self.endResetModel()

    def clear(self) -> None:
        self._kept.clear()
        self.rebuild()

    def event_at(self, row: int) -> Event:
        return self._rows[row]

    def time_of(self, event: Event) -> str:
        """Time of day to the millisecond."""
        moment = datetime.fromtimestamp(event.at + self._wall_offset_s).astimezone()
        return moment.strftime("%H:%M:%S.") + f"{moment.microsecond // 1000:03d}"

    def as_text(self, rows: Sequence[int]) -> str:
        """Rows as lines of tab-separated text, with all their bytes."""
        lines = []
        for row in rows:
            event = self._rows[row]
            lines.append("\t".join((self.time_of(event), kind_of(event), hex_of(raw_of(event)), meaning_of(event))))
        return "\n".join(lines)

    def retranslate(self) -> None:
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(Column) - 1)
        if self._rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._rows) - 1, len(Column) - 1))

    # QAbstractTableModel

    def rowCount(self, parent: _Index = _ANY_INDEX) -> int:
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = _ANY_INDEX) -> int:
        return 0 if parent.isValid() else len(Column)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return tr(_HEADERS[Column(section)])
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role not in _ANSWERED_ROLES:  # most calls: a view asks for seven roles of each cell
            return None
        event = self._rows[index.row()]
        column = _COLUMNS[index.column()]
        if role == _DECORATION:
            return _icon(event) if column is Column.KIND else None
        if role == _FONT:
            return self.bytes_font if column is Column.BYTES else None
        return _colour(event, column) if role == _FOREGROUND else self._text(event, column)

    def _text(self, event: Event, column: Column) -> str:
        match column:
            case Column.TIME:
                return self.time_of(event)
            case Column.KIND:
                return kind_of(event)
            case Column.BYTES:
                return hex_of(raw_of(event), SHOWN_BYTES)
            case Column.MEANING:
                return meaning_of(event)


def _rows_of(events: Iterable[Event]) -> Iterator[Event]:
    """An event a row; an answer was a row already when its frame came, and long rejected runs take several."""
    for event in events:
        if isinstance(event, Rejected) and len(event.noise.raw) > LONGEST_ROW_BYTES:
            noise = event.noise
            for first in range(0, len(noise.raw), LONGEST_ROW_BYTES):
                raw = noise.raw[first : first + LONGEST_ROW_BYTES]
                yield Rejected(Noise(raw, noise.fault, noise.offset + first), event.at)
        elif not isinstance(event, Answered):
            yield event


def _meaning(event: Event) -> Meaning | None:
    match event:
        case Rejected() | OutcomeUnknown() | Unanswered() | WentOffline():
            return Meaning.ATTENTION
        case Received(role=Role.LATE | Role.DOUBLED | Role.ECHO) | Restarted():
            return Meaning.INFORMATION
        case _:
            return None


_picture = cache(icon)


def _icon(event: Event) -> QIcon:
    meaning = _meaning(event)
    match event:
        case Rejected() | OutcomeUnknown() | Unanswered():
            return _picture(Icon.WARNING, meaning)
        case Sent():
            return _picture(Icon.CHEVRON_RIGHT, None)
        case Received():
            return _picture(Icon.CHEVRON_LEFT, meaning)
        case _:
            return _picture(Icon.INFORMATION, meaning)


def _colour(event: Event, column: Column) -> QColor | None:
    meaning = _meaning(event)
    if meaning is not None:
        return current().ink(meaning)
    is_quiet = column is Column.TIME or (isinstance(event, Received) and event.role is Role.STREAMED)
    return current().ink(Meaning.UNKNOWN) if is_quiet else None
