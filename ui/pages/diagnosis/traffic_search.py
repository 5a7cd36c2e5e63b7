"""Search in the traffic list: bytes ("41 75", with or without spaces) or words."""

import time
from collections.abc import Callable, Hashable

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit, QToolButton, QWidget

from ui.core.texts import Texts
from ui.pages.diagnosis.traffic_model import TrafficModel
from ui.pages.diagnosis.traffic_texts import Row, meaning_of, shown
from ui.style.icons import Icon, set_icon_size
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.layouts import in_row

_SLICE_S = 0.01
"""Time slice of the search in the window's thread."""
_ROWS_AT_ONCE = 100
_MAX_KNOWN = 50_000


def matches(row: Row, query: str, query_hex: str) -> bool:
    """`query`: lower case. `query_hex`: its hex digits, "" where it is not hex."""
    seen = shown(row)
    if query_hex and query_hex in seen.raw.hex():
        return True
    return query in meaning_of(row).lower() or query in seen.kind.lower()


def hex_part(text: str) -> str:
    """The digits of a text of pairs of hex digits, else ""."""
    digits = "".join(text.lower().split())
    is_hex = len(digits) % 2 == 0 and all(digit in "0123456789abcdef" for digit in digits)
    return digits if is_hex else ""


class TrafficSearch(QWidget):
    """Search field with two buttons. `show_row` gets the row found, `say` whether there was one."""

    def __init__(
        self,
        model: TrafficModel,
        texts: Texts,
        *,
        find_start: Callable[[], int],
        show_row: Callable[[int], None],
        say: Callable[[bool], None],
    ) -> None:
        super().__init__()
        self.setObjectName("traffic_search")
        self._model, self._find_start, self._show_row, self._say = model, find_start, show_row, say
        self.field = control(QLineEdit(), texts, "traffic_search_text", says="Search",
                             tip="Bytes (41 75) or words", key="Ctrl+F")  # fmt: skip
        self.field.setClearButtonEnabled(True)
        self.clear = self.field.findChild(QToolButton)
        self.field.setMinimumWidth(120)
        self.field.setMaximumWidth(200)
        self.next = control(QToolButton(), texts, "traffic_search_next", says="Next match", key="Enter",
                            picture=Icon.CHEVRON_DOWN, slot=self.find_next)  # fmt: skip
        self.before = control(QToolButton(), texts, "traffic_search_before", says="Previous match",
                              key="Shift+Enter", picture=Icon.CHEVRON_UP,
                              slot=self.find_before)  # fmt: skip
        for button in (self.next, self.before):
            set_icon_size(button, 14)
            button.setStyleSheet("QToolButton { padding: 4px; }")
        texts.bind(self.field.setPlaceholderText, "Search")
        if isinstance(self.clear, QToolButton):  # made by Qt
            control(self.clear, texts, "traffic_search_clear", says="Clear", tip="Clear")
        self.field.textEdited.connect(self._reset)
        in_row((self.field, 1), self.next, self.before, of=self, spacing=Space.XS, margins=0)
        self._left = 0
        self._place = 0
        self._step = 1
        self._known: dict[Hashable, bool] = {}
        """Matches by `same_text_key`: the many rows of a capture have few different texts."""
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._search_slice)

    @property
    def is_searching(self) -> bool:
        return self._timer.isActive()

    @property
    def share(self) -> float:
        """Share of the rows searched, 0 … 1."""
        rows = self._model.rowCount()
        return 1.0 - self._left / rows if rows else 1.0

    def find_next(self) -> None:
        self._begin(1, self._find_start())

    def find_before(self) -> None:
        self._begin(-1, self._find_start())

    def _reset(self) -> None:
        """Searches while typing, from the start row, included."""
        self._begin(1, self._find_start() - 1)

    def _begin(self, step: int, start: int) -> None:
        self._timer.stop()
        if not self.field.text().strip():
            self._say(True)
            return
        self._known.clear()
        self._step, self._place, self._left = step, start, self._model.rowCount()
        self._timer.start()

    def _search_slice(self) -> None:
        """Searches some rows, wrapping around at the end."""
        query = self.field.text().strip().lower()
        query_hex = hex_part(query)
        count = self._model.rowCount()
        ends_s = time.perf_counter() + _SLICE_S
        while count and self._left > 0 and time.perf_counter() < ends_s:
            for _ in range(min(_ROWS_AT_ONCE, self._left)):
                self._left -= 1
                self._place = (self._place + self._step) % count
                if self._fits(self._place, query, query_hex):
                    self._timer.stop()
                    self._say(True)
                    self._show_row(self._place)
                    return
        if self._left <= 0 or not count:
            self._timer.stop()
            self._say(False)

    def _fits(self, place: int, query: str, query_hex: str) -> bool:
        key = self._model.same_text_key(place)
        if key is None:
            return matches(self._model.rows[place], query, query_hex)
        fits = self._known.get(key)
        if fits is None:
            if len(self._known) >= _MAX_KNOWN:
                self._known.clear()
            fits = self._known[key] = matches(self._model.rows[place], query, query_hex)
        return fits

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            is_back = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            (self.find_before if is_back else self.find_next)()
            return
        super().keyPressEvent(event)
