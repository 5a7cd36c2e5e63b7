"""Traffic list: every frame sent and received, invalid bytes and why; and its search."""

from collections.abc import Callable
from itertools import chain, islice

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QFontMetrics, QGuiApplication, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QComboBox, QLabel, QLineEdit, QTableView, QToolButton, QWidget

from app.engine.worker import Batch
from app.text.i18n import tr
from protocol.events import Event
from protocol.translatable import marked
from ui.forms.table_kit import list_rows, select_row
from ui.pages.diagnosis.traffic_model import MAX_MARKS, Column, Filter, TrafficModel
from ui.pages.diagnosis.traffic_texts import hex_of, meaning_of, shown
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import Size, Space, fixed_font, font
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import FlowRow, in_column, in_row
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer


def matches(row: Event, query: str, query_hex: str) -> bool:
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
        *,
        find_start: Callable[[], int],
        show_row: Callable[[int], None],
        say: Callable[[bool], None],
    ) -> None:
        super().__init__()
        self.setObjectName("traffic_search")
        self._model, self._find_start, self._show_row, self._say = model, find_start, show_row, say
        self.field = control(
            QLineEdit(), "traffic_search_text", says=tr("Search"), tip=tr("Bytes (41 75) or words"), keys="Ctrl+F"
        )
        self.field.setClearButtonEnabled(True)
        self.clear = self.field.findChild(QToolButton)
        self.field.setMinimumWidth(120)
        self.field.setMaximumWidth(200)
        self.next = control(
            QToolButton(),
            "traffic_search_next",
            says=tr("Next match"),
            key="Enter",
            picture=Icon.CHEVRON_DOWN,
            slot=self.find_next,
        )
        self.before = control(
            QToolButton(),
            "traffic_search_before",
            says=tr("Previous match"),
            key="Shift+Enter",
            picture=Icon.CHEVRON_UP,
            slot=self.find_before,
        )
        for button in (self.next, self.before):
            set_icon_size(button, 14)
            button.setStyleSheet("QToolButton { padding: 4px; }")
        self.field.setPlaceholderText(tr("Search"))
        if isinstance(self.clear, QToolButton):  # made by Qt
            control(self.clear, "traffic_search_clear", says=tr("Clear"), tip=tr("Clear"))
        self.field.textEdited.connect(self._reset)
        in_row((self.field, 1), self.next, self.before, of=self, spacing=Space.XS, margins=0)

    def find_next(self) -> None:
        self._search(1, self._find_start())

    def find_before(self) -> None:
        self._search(-1, self._find_start())

    def _reset(self) -> None:
        """Searches while typing, from the start row, included."""
        self._search(1, self._find_start() - 1)

    def _search(self, step: int, start: int) -> None:
        """From the row behind `start`, wrapping around at the end."""
        query = self.field.text().strip().lower()
        if not query:
            self._say(True)
            return
        query_hex = hex_part(query)
        count = self._model.rowCount()
        for distance in range(1, count + 1):
            place = (start + step * distance) % count
            if matches(self._model.rows[place], query, query_hex):
                self._say(True)
                self._show_row(place)
                return
        self._say(False)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            is_back = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            (self.find_before if is_back else self.find_next)()
            return
        super().keyPressEvent(event)


DRAW_EVERY_MS = 160
"""Interval of adding rows; a person cannot read more."""
MAX_COPIED = 10_000
"""Rows copied at once."""
_ROW_PX = 24
_FILTERS = (
    (Filter.ALL, marked("All")),
    (Filter.WITHOUT_STREAM, marked("Without stream")),
    (Filter.REJECTED, marked("Invalid bytes")),
    (Filter.MARKED, marked("Marked")),
)


class TrafficPage(QWidget):
    """Collects frames while hidden; while visible it draws every `DRAW_EVERY_MS`."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("traffic_page")
        self._is_paused = False
        self._follows = True
        self._is_not_found = False
        self.model = TrafficModel(self)
        self.table = self._make_table()
        self.detail = self._make_detail()
        self._count = named(QLabel(), "traffic_count", "muted")
        self.filter = self._make_filter()
        self.search = TrafficSearch(
            self.model, find_start=self._search_start, show_row=self._show_match, say=self._on_search_end
        )
        self.pause = control(
            QToolButton(), "traffic_pause", text=tr("Pause"), keys="Ctrl+P", picture=Icon.PAUSE, is_checkable=True
        )
        self.mark = control(
            QToolButton(), "traffic_mark", text=tr("Mark"), keys="Ctrl+M", picture=Icon.BOOKMARK, slot=self.mark_rows
        )
        self.copy = control(
            QToolButton(), "traffic_copy", text=tr("Copy"), keys="Ctrl+C", picture=Icon.COPY, slot=self.copy_rows
        )
        self.clear = control(
            QToolButton(),
            "traffic_clear",
            text=tr("Clear"),
            keys="Ctrl+Shift+X",
            picture=Icon.ERASE,
            slot=self.model.clear,
        )
        for button in (self.mark, self.copy, self.clear):
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        self.pause.toggled.connect(self._pause)
        foot = in_row((self.detail, 1), (self._count, Qt.AlignmentFlag.AlignTop), spacing=Space.M)
        bar = FlowRow(self.filter, self.search, right=(self.pause, self.mark, self.copy, self.clear))
        in_column(bar, (self.table, 1), foot, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self._show_again, tick=self.draw, every_ms=DRAW_EVERY_MS, restyle=self._apply_theme)
        self._apply_theme()
        self._show_detail()

    def on_batch(self, batch: Batch) -> None:
        if batch.events:
            self.model.append(batch.events)

    def draw(self) -> None:
        """Shows the new rows unless paused."""
        if self._is_paused:
            self._show_count()
            return
        follows = self._follows
        bar = self.table.verticalScrollBar()
        position = bar.value()
        dropped = self.model.show_new()
        if dropped and not follows:
            bar.setValue(position - dropped * self.table.verticalHeader().defaultSectionSize())
        self._show_count()

    def _notice_scrolling(self, position: int) -> None:
        self._follows = position >= self.table.verticalScrollBar().maximum()

    def _stay_at_end(self, _lowest: int, highest: int) -> None:
        """Stays at the end when rows are added or the table shrinks."""
        if self._follows:
            self.table.verticalScrollBar().setValue(highest)

    # Making

    def _make_table(self) -> QTableView:
        table = control(QTableView(), "traffic_table", says=tr("Traffic"))
        table.setModel(self.model)
        list_rows(table, row_px=_ROW_PX)
        table.setIconSize(QSize(14, 14))
        columns = table.horizontalHeader()
        columns.setStretchLastSection(True)
        bar = table.verticalScrollBar()
        bar.valueChanged.connect(self._notice_scrolling)
        bar.rangeChanged.connect(self._stay_at_end)
        table.selectionModel().selectionChanged.connect(self._show_detail)
        self.model.modelReset.connect(self._on_other_rows)
        return table

    def _on_other_rows(self) -> None:
        """A reset clears the selection without a signal."""
        self._is_not_found = False
        self._show_detail()
        self._show_count()

    def _make_detail(self) -> QLabel:
        label = text_label("traffic_detail", "muted", is_selectable=True)
        label.setMinimumHeight(2 * label.fontMetrics().lineSpacing() + Space.XS)
        label.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        return label

    def _make_filter(self) -> QComboBox:
        box = control(QComboBox(), "traffic_filter", says=tr("Filter"), tip=tr("Filter"))
        for row_filter, title in _FILTERS:
            box.addItem(tr(title), row_filter)
        WheelGuard(box)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        box.currentIndexChanged.connect(self._use_filter)
        return box

    def copy_rows(self) -> None:
        """Copies the selected rows, else all, as tab-separated text; at most `MAX_COPIED`."""
        ranges = self._selected() or [range(self.model.rowCount())]
        rows = list(islice(chain.from_iterable(ranges), MAX_COPIED))
        QGuiApplication.clipboard().setText(self.model.as_text(rows))
        count = sum(map(len, ranges))
        if count > len(rows):
            self.detail.setText(tr("{n} of {all} rows copied.", n=f"{len(rows):,}", all=f"{count:,}"))

    def mark_rows(self) -> None:
        """Marks or unmarks the selected rows, at most `MAX_MARKS`."""
        rows = list(islice(chain.from_iterable(self._selected()), MAX_MARKS))
        if rows:
            self.model.mark(rows)
        self._show_count()

    def _selected(self) -> list[range]:
        ranges = [range(part.top(), part.bottom() + 1) for part in self.table.selectionModel().selection().toList()]
        return sorted(ranges, key=lambda rows: rows.start)

    def _search_start(self) -> int:
        """The selected row, else the one before the first visible row."""
        selected = self._selected()
        return selected[-1][-1] if selected else self.table.rowAt(0) - 1

    def _show_match(self, row: int) -> None:
        self._follows = False
        select_row(self.table, row)
        self.table.scrollTo(self.model.index(row, 0), QAbstractItemView.ScrollHint.EnsureVisible)

    def _on_search_end(self, is_found: bool) -> None:
        self._is_not_found = not is_found
        self._show_count()

    def _use_filter(self, number: int) -> None:
        self.model.use_filter(_FILTERS[number][0])
        self.table.scrollToBottom()

    def _pause(self, is_paused: bool) -> None:
        self._is_paused = is_paused
        self.pause.setIcon(icon(Icon.PLAY if is_paused else Icon.PAUSE))
        self.pause.setText(tr("Continue" if is_paused else "Pause"))
        self.draw()

    def _show_count(self) -> None:
        rows = self.model.rowCount()
        if self._is_not_found:
            text = tr("No matches")
        elif self._is_paused:
            text = tr("{count} new", count=f"{self.model.unseen:,}")
        else:
            text = tr("rows: {rows}", rows=f"{rows:,}")
        if text != self._count.text():
            self._count.setText(text)
            self._count.setToolTip(text)

    def _show_detail(self) -> None:
        selected = self._selected()
        count = sum(map(len, selected))
        if count != 1:
            self.detail.setText(tr("{count} selected", count=f"{count:,}") if count else tr("Select a row."))
            return
        event = self.model.rows[selected[0][0]]
        seen = shown(event)
        self.detail.setText(f"{seen.kind}  {hex_of(seen.raw, 96)}\n{meaning_of(event)}")

    def _apply_theme(self) -> None:
        fixed = fixed_font(Size.SMALL)
        small = font(Size.SMALL)
        self.table.setFont(small)
        self.model.bytes_font = fixed
        metrics = self.table.fontMetrics()
        width = metrics.horizontalAdvance
        mark_px = self.table.iconSize().width() + Space.S
        self.table.setColumnWidth(Column.TIME.value, width("00:00:00.000") + mark_px + Space.L)
        self.table.setColumnWidth(Column.KIND.value, 14 + width("rejected, again") + Space.XL)
        eight_bytes = QFontMetrics(fixed).horizontalAdvance("00 " * 8)
        self.table.setColumnWidth(Column.BYTES.value, eight_bytes + Space.XL + Space.L)
        self.table.horizontalHeader().setMinimumSectionSize(width(tr("Meaning")) + 2 * Space.L)
        self._fit_columns()
        self.table.viewport().update()

    def _fit_columns(self) -> None:
        """Where the meaning would scroll away the bytes are only below the table."""
        columns = self.table.horizontalHeader()
        columns.setSectionHidden(Column.BYTES.value, False)
        needed = columns.sectionPosition(Column.MEANING.value) + columns.minimumSectionSize()
        columns.setSectionHidden(Column.BYTES.value, needed > self.table.viewport().width())

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_columns()

    def _show_again(self) -> None:
        if not self._is_paused:
            self.model.rebuild()
            self.table.scrollToBottom()
        self._show_count()
