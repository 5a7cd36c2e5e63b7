"""The canvas of the time plots: lanes below each other in one scene of pyqtgraph, mouse and keyboard."""

from collections import deque
from collections.abc import Sequence
from math import ceil
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QKeyEvent, QMouseEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QAbstractScrollArea, QGraphicsView, QWidget

from app.system.clock import clock_text
from app.text.i18n import tr
from ui.plots.axis import TimeAxis, ago_text
from ui.plots.lane_view import EDGE_PX, GAP_PX, ICON_PX, LaneView, Overlay, beside
from ui.plots.lanes import Lane, Mark, Reading, TimeRange, reading
from ui.style.theme import current
from ui.widgets.readout import mixed

# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
_MIN_LINES: Final = 2.5
"""Minimum height of a lane in lines of text, below which the labels of limits overlap."""
_NEAR_PX: Final = 6
"""A mark as near to the cursor is named there."""
_DRAG_PX: Final = 3
_LEFT_BUTTON: Final = Qt.MouseButton.LeftButton


class PlotView(pg.GraphicsView):  # type: ignore[misc]
    """Draws what is in `time_range`. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970.

    Mouse and wheel are handled here and never reach the scene: pyqtgraph's prints errors instead of raising them, and
    looks for what is below the pointer with each move.
    """

    accessible_role: ClassVar = QAccessible.Role.Chart

    def __init__(self, lanes: Sequence[Lane], time_range: TimeRange, wall_offset_s: float) -> None:
        super().__init__()
        self.setObjectName("time-plot-canvas")
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        # With marks in sight the least region has hundreds of corners, which costs more than it saves.
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.viewport().setObjectName("time-plot-viewport")
        self.viewport().setMouseTracking(True)
        self.time_range, self.wall_offset_s = time_range, wall_offset_s
        self.marks: deque[Mark] = deque(maxlen=_MAX_MARKS)
        self.cursor_time = ""
        """The age and the time of day at the cursor, and the events there."""
        self.readings: list[Reading] = []
        """The values at the cursor."""
        self.lanes = [LaneView(lane, self.scene()) for lane in lanes]
        self.bounds = QRectF()
        """Of all lanes."""
        self.times, self.overlay = TimeAxis(self.lanes[0].view), Overlay()
        for item in (self.times, self.overlay):
            self.scene().addItem(item)
        self._drawn: object = None
        """What the last picture depended on; None: it has to be drawn again."""
        self._seen = (0.0, False)
        """The length drawn last, and whether it was live."""
        self._pressed = self._last = QPointF()
        """Where the mouse was pressed, and where it was last."""

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self.times.apply_theme(QPen(QColor(theme.border)))
        self.overlay.apply_theme()
        for number, lane in enumerate(self.lanes):
            lane.apply_theme(theme.curves[number % len(theme.curves)], self.devicePixelRatioF())
        self.arrange()

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        whole, line = QRectF(self.viewport().rect()), self.overlay.line_px
        labels = (tr(line.label, value="000") for lane in self.lanes for line in lane.limits)
        labels_px = max((self.overlay.size(label, is_bold=True).width() for label in labels), default=0.0)
        left = self.overlay.size("−180").width() + 8
        right = max(left + 50, whole.right() - labels_px - 12)
        title = line + 6
        around = line + 4 + len(self.lanes) * title
        weights = sum(lane.lane.weight for lane in self.lanes)
        lowest = min(lane.lane.weight for lane in self.lanes)
        self.setMinimumHeight(ceil(around + _MIN_LINES * line * weights / lowest))
        room = max(line, whole.height() - around)
        top = 0.0
        for lane in self.lanes:
            height = round(room * lane.lane.weight / weights)
            lane.place(QRectF(round(left), top + title, round(right - left), height))
            top += title + height
        self.overlay.setRect(whole)
        self.times.setHeight(line + 4)
        self.times.setGeometry(QRectF(round(left), top - 1, round(right - left) + EDGE_PX, line + 4))
        self.bounds = self.lanes[0].box.united(self.lanes[-1].box)
        self.time_range.width_px = max(1.0, self.bounds.width() * self.devicePixelRatioF())

    def fit(self) -> None:
        """Shows all values vertically."""
        for lane in self.lanes:
            lane.fit()
        self.time_range.changed.emit()

    # Drawing

    def forget(self) -> None:
        """The next `is_due` is true."""
        self._drawn = None

    def is_due(self, now_s: float) -> bool:
        """Whether `draw` would change the picture: it moved by a pixel, or something else changed."""
        return self._appearance_key(now_s) != self._drawn

    def _appearance_key(self, now_s: float) -> object:
        """What the picture depends on and may change by itself."""
        span = self.time_range.span_at(now_s)
        limits = [line.value for lane in self.lanes for line in lane.limits]
        if self.time_range.is_live:  # new samples are within the last pixel
            return span, limits
        newest = (lane.lane.series.last for lane in self.lanes)
        return span, limits, [None if sample is None else min(sample.time_s, span.end_s) for sample in newest]

    def draw(self) -> None:
        """Draws all again, unless it is hidden."""
        time_range, span, cursor_s = self.time_range, self.time_range.span, self.time_range.cursor_s
        marks = [mark for mark in self.marks if span.start_s <= mark.time_s <= span.end_s]
        self.readings = [] if cursor_s is None else [reading(lane.lane, cursor_s) for lane in self.lanes]
        self.cursor_time = "" if cursor_s is None else self._time_text(cursor_s, marks)
        if not self.isVisible():
            self.forget()
            return
        self._drawn = self._appearance_key(time_range.now_s)
        seen, self._seen = self._seen, (span.length_s, time_range.is_live)
        if seen[0] != span.length_s or time_range.is_live > seen[1]:
            for lane in self.lanes:
                lane.fit()
        # A paused picture is labelled by the clock: "10 s before now" would soon be wrong.
        times = self.times.show_span(span.length_s, None if time_range.is_live else span.end_s + self.wall_offset_s)
        for lane in self.lanes:
            lane.draw(span, times)
        self.overlay.clear(self.bounds, has_focus=self.hasFocus())
        self._write(marks)
        self.times.keep_off(QRectF() if cursor_s is None else self._write_cursor(cursor_s))

    def _time_text(self, cursor_s: float, marks: Sequence[Mark]) -> str:
        decimals = 1 if self.time_range.span.length_s > 3 else 3
        text = clock_text(cursor_s + self.wall_offset_s, decimals)
        if self.time_range.is_live:
            text = f"{ago_text(max(0.0, self.time_range.now_s - cursor_s), decimals)} · {text}"
        near_s = _NEAR_PX * self.devicePixelRatioF() * self.time_range.pixel_s
        return " · ".join((text, *(tr(mark.word) for mark in marks if abs(mark.time_s - cursor_s) < near_s)))

    def _write(self, marks: Sequence[Mark]) -> None:
        """The important words first, since none may cover another."""
        overlay, theme = self.overlay, current()
        for lane in self.lanes:
            lane.name_limits(overlay)
        first = self.lanes[0].box.left()
        lefts = [first, *self._write_marks(marks)]  # the first title is in the row of the marks
        for lane in self.lanes:
            top = lane.box.top() - overlay.line_px - 4
            title = overlay.put(tr(lane.lane.title), lane.ink, (QPointF(left, top) for left in lefts), is_bold=True)
            if title is not None:
                overlay.put(lane.lane.unit, theme.muted, [QPointF(title.right() + 6, top)])
            lefts = [first]
        for lane in self.lanes:
            lane.name_past(overlay)

    def _write_marks(self, marks: Sequence[Mark]) -> list[float]:
        """Lines, icons, then words; the most important and the newest first. Returns where they end."""
        overlay, theme, first = self.overlay, current(), self.lanes[0]
        shown, ends, columns, top = [], [], set[int](), first.box.top() - overlay.line_px - 4
        for mark in sorted(marks, key=lambda mark: (mark.rank, -mark.time_s)):
            x, ink = first.x(mark.time_s), theme.ink(mark.meaning)
            if round(x) not in columns:
                columns.add(round(x))
                # Fainter than cursor and curves; mixed, since transparent pens are slow.
                overlay.lines.append((x, ink if theme.line_px > 1 else mixed(ink, theme.surface, 0.4)))
            room = overlay.put(mark.icon, ink, [QPointF(x - ICON_PX / 2, top)])
            if room is not None:
                shown.append((mark, room))
        for mark, room in shown:
            left, word = room.right() + GAP_PX + 1, tr(mark.word)
            fits = left + overlay.size(word, is_bold=True).width() < self.viewport().width()
            placed = overlay.put(word, theme.ink(mark.meaning), [QPointF(left, top)], is_bold=True) if fits else None
            ends.append((placed or room).right() + 2 * GAP_PX)
        return sorted(ends)

    def _write_cursor(self, cursor_s: float) -> QRectF:
        """Its line, the values beside the samples, and the time below. Returns the room of the time: a label that it
        covered partly would show another one."""
        overlay, theme = self.overlay, current()
        x, last = self.lanes[0].x(cursor_s), self.lanes[-1].box

        def tag(text: str, y: float, within: QRectF) -> QRectF:
            size = overlay.size(text, is_bold=True, is_on_ground=True)
            place = beside(x, y, size, within)
            return overlay.put(text, theme.window, [place], is_bold=True, ground=theme.text, is_above=True) or QRectF()

        overlay.lines.append((x, theme.text))
        for lane, (text, near) in zip(self.lanes, self.readings, strict=False):
            y = lane.box.top() + 26 if near is None else lane.y(near.value)
            if near is not None and last.left() <= lane.x(near.time_s) <= last.right():
                overlay.dots.append((QPointF(lane.x(near.time_s), y), lane.ink))
            tag(text, y - 14, lane.box)
        row = QRectF(last.left(), last.bottom(), self.viewport().width() - last.left(), self.times.height())
        return tag(self.cursor_time, row.center().y(), row)

    # Mouse and keyboard

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.setAccepted(event.button() == _LEFT_BUTTON)
        self._pressed = self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        place, way = event.position(), event.position() - self._last
        if not event.buttons() & _LEFT_BUTTON:
            self.time_range.point(self._part(place) if self.bounds.contains(place) else None)
        elif (place - self._pressed).manhattanLength() >= _DRAG_PX and way.x():
            self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
            self.time_range.pan(-way.x() / self.bounds.width(), self._part(place))
        self._last = place

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        self.viewport().unsetCursor()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.setAccepted(event.button() == _LEFT_BUTTON)
        if event.isAccepted():
            self.time_range.back_to_live()

    def leaveEvent(self, _event: QEvent) -> None:
        self.time_range.point(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zooms with Ctrl, after a click, and where nothing else can be scrolled."""
        way, is_meant = event.angleDelta(), self.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier
        event.setAccepted(bool(is_meant) or not _page_scrolls(self))
        if event.isAccepted() and abs(way.x()) > abs(way.y()):
            self.time_range.pan(-way.x() / 1200)
        elif event.isAccepted():
            self.time_range.zoom(0.8 ** (way.y() / 120), self._part(event.position()))

    def _part(self, place: QPointF) -> float:
        """As a part of the width of the lanes."""
        return min(1.0, max(0.0, (place.x() - self.bounds.left()) / self.bounds.width()))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        time_range, is_shifted = self.time_range, bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        part = 1.0 if time_range.cursor is None else time_range.cursor
        match event.key():
            case Qt.Key.Key_Left | Qt.Key.Key_Right:
                sign = -1 if event.key() == Qt.Key.Key_Left else 1
                if is_shifted:
                    time_range.point(part + sign / max(50.0, self.bounds.width() / 4))
                else:
                    time_range.pan(sign * 0.1)
            case Qt.Key.Key_Plus | Qt.Key.Key_Equal | Qt.Key.Key_Minus:
                time_range.zoom(1.25 if event.key() == Qt.Key.Key_Minus else 0.8, part)
            case Qt.Key.Key_Space:
                time_range.toggle_pause()
            case Qt.Key.Key_Home:
                self.fit()
            case Qt.Key.Key_End:
                time_range.back_to_live()
            case _:
                event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        event.ignore()

    # Qt

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self.apply_theme()
        is_handled = bool(super().event(event))
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.time_range.changed.emit()
        return is_handled

    def sizeHint(self) -> QSize:
        return QSize(self.minimumSize())  # that of a scene is what it was laid out in

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        super().resizeEvent(event)
        if event is not None:  # pyqtgraph's own call, before there are lanes
            self.arrange()
            self.time_range.changed.emit()


def _page_scrolls(view: QWidget) -> bool:
    above = view.parentWidget()
    while above is not None:
        if isinstance(above, QAbstractScrollArea) and above.verticalScrollBar().maximum() > 0:
            return True
        above = above.parentWidget()
    return False
