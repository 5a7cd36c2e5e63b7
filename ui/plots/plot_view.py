"""The canvas of the time plots: lanes below each other in one scene of pyqtgraph, mouse and keyboard.

The mouse is handled here and not by pyqtgraph's scene, which prints errors instead of raising them.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QColor,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPaintDevice,
    QPainter,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QAbstractScrollArea, QGraphicsItem, QGraphicsView

from app.text.i18n import tr
from ui.plots.lane_view import LaneView, style_axis
from ui.plots.lanes import Frame, Lane, Mark, Span
from ui.plots.overlay import ICON_PX, Overlay, Tag, beside
from ui.style.painted_widget import mixed
from ui.style.theme import Meaning, Size, current, font

if TYPE_CHECKING:  # pyqtgraph has no types
    from PySide6.QtWidgets import QGraphicsView as _GraphicsView
else:
    _GraphicsView = pg.GraphicsView

# Limit of zooming in: some forty status frames at line rate.
SHORTEST_S: Final = 0.03
_MIN_LANES: Final = 2
_MIN_LINES: Final = 2.5
"""Minimum height of a lane in lines of text, below which the labels of limits overlap; one line for the first two
lanes."""
_GAP_PX: Final = 4
_DRAG_PX: Final = 3
_LEFT_BUTTON: Final = Qt.MouseButton.LeftButton


class PlotView(_GraphicsView):
    """Draws a `Frame`; the signals are what the user wants."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    moved = Signal(float, float, object)
    """Show from this to that part of the span in sight, with the cursor at a part of the new one (None: nowhere)."""
    cursor_wanted = Signal(object)
    """The part of the span under the pointer or chosen by key, 0 to 1; None outside."""
    pause_wanted = Signal()
    live_wanted = Signal()
    fit_wanted = Signal()
    """Vertically."""
    changed = Signal()
    """Size, focus or a vertical scale changed: it has to be drawn again."""

    def __init__(self, lanes: Sequence[Lane]) -> None:
        self.is_styled = False
        super().__init__()
        self.setObjectName("time-plot-canvas")
        self.setMouseTracking(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        # With marks in sight the least region has hundreds of corners, which costs more than it saves.
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.viewport().setObjectName("time-plot-viewport")
        self.overlay = Overlay()
        self.scene().addItem(self.overlay)
        self.all_lanes = [LaneView(lane, number, self.scene()) for number, lane in enumerate(lanes)]
        self.lanes = self.all_lanes
        """Those in sight: only the first ones where there is no room for all."""
        self.times = pg.AxisItem("bottom")
        style_axis(self.times, self.lanes[0].view)
        self.scene().addItem(self.times)
        self.frame = Frame(Span(-1.0, 0.0), (), (), None, "", ())
        """What was drawn last."""
        self._ticks: object = None
        self._words: object = None
        """What the words depended on when they were written."""
        self._title_px = 0.0
        self._dragged_from: QPointF | None = None
        self._dragged_lane: LaneView | None = None
        """The lane whose vertical scale is dragged."""

    @property
    def width_px(self) -> float:
        """Of the lanes."""
        return self.lanes[0].box.width()

    @property
    def cursor_part(self) -> float | None:
        frame = self.frame
        return None if frame.cursor_s is None else (frame.cursor_s - frame.span.start_s) / frame.span.length_s

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self.times.setTickFont(font(Size.SMALL))
        self.times.setTextPen(QColor(theme.muted))
        self.times.setPen(QColor(theme.border))
        for lane in self.all_lanes:
            lane.apply_theme(theme, self.devicePixelRatioF())
        self.is_styled = True
        self.arrange()

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        whole = QRectF(self.viewport().rect())
        self.overlay.restyle(whole)
        self._ticks = self._words = None
        metrics = QFontMetricsF(font(Size.SMALL))
        line = metrics.height()
        left = metrics.horizontalAdvance("−180") + 8
        right = max(left + 50, whole.right() - max(lane.limit_labels_px(self.overlay) for lane in self.all_lanes) - 12)
        self._title_px = title = line + 6
        for count in range(len(self.all_lanes), 0, -1):
            self.lanes = self.all_lanes[:count]
            axis = line + (4 if count == len(self.all_lanes) else line + 8)  # a line that names the hidden ones
            room = whole.height() - axis - count * title
            weights = sum(lane.lane.weight for lane in self.lanes)
            least = _MIN_LINES if count > _MIN_LANES else 1.0
            if room * self.lanes[-1].lane.weight / weights >= least * line:
                break
        room = max(line, room)
        top = 0.0
        for number, lane in enumerate(self.all_lanes):
            lane.set_visible(number < count)
            if number < count:
                height = round(room * lane.lane.weight / weights)
                lane.place(QRectF(round(left), top + title, round(right - left), height))
                top += title + height
        self.times.setHeight(line + 4)
        self.times.setGeometry(QRectF(round(left), top - 1, round(right - left) + 2, line + 4))

    def fit_scales(self, *, is_manual_too: bool = False) -> None:
        """Lets the vertical scales shrink with the next draw."""
        for lane in self.all_lanes:
            lane.fit_scale(is_manual_too=is_manual_too)

    def draw(self, frame: Frame) -> None:
        self.frame = frame
        for lane in self.lanes:
            lane.draw(frame.span)
        if frame.ticks != self._ticks:
            self._ticks = frame.ticks
            last, labels = self.lanes[-1].box, self.tick_labels()
            second_px = last.width() / frame.span.length_s
            self.times.setTicks([[((room.center().x() - last.right()) / second_px, text) for room, text in labels]])
            for lane in self.lanes:
                lane.set_ticks(frame.ticks)
        words = (frame.marks, frame.cursor_s, frame.readings, self.hasFocus(), [lane.words_key for lane in self.lanes])
        if words != self._words or frame.marks or frame.cursor_s is not None:
            self._words = words
            self._write()

    def draw_on(self, device: QPaintDevice) -> None:
        """Draws all as lines and texts, without the pictures that items are kept as."""
        kept = {item: item.cacheMode() for item in self.scene().items()}
        for item in kept:
            item.setCacheMode(QGraphicsItem.CacheMode.NoCache)
        painter = QPainter(device)
        self.render(painter)
        painter.end()
        for item, mode in kept.items():
            item.setCacheMode(mode)

    def _write(self) -> None:
        """All words: the important ones first, since none may cover another."""
        overlay, theme = self.overlay, current()
        overlay.begin()
        boxes = self.lanes[0].box.united(self.lanes[-1].box)
        overlay.frame = boxes.adjusted(-2, -2, 2, 2) if self.hasFocus() else None
        for lane in self.lanes:
            lane.name_limits(overlay, theme)
        mark_ends = self._write_marks()
        for lane in self.lanes:
            # That of the first lane is in the row of the marks.
            lefts = (lane.box.left(), *(mark_ends if lane is self.lanes[0] else ()))
            top = lane.box.top() - self._title_px + 2
            overlay.put(lane.title(), *(QPointF(left, top) for left in lefts), gap_px=_GAP_PX)
        for lane in self.lanes:
            lane.name_past(overlay, theme)
        hidden = ", ".join(tr(lane.lane.title) for lane in self.all_lanes[len(self.lanes) :])
        if hidden:
            note = Tag(tr("No room for: {plots}", plots=hidden), theme.muted)
            place = QPointF(boxes.left(), self.viewport().height() - overlay.size(note).height() - 2)
            overlay.put(note, place, is_above=True)
        self._write_cursor()

    def _write_marks(self) -> list[float]:
        """Icons, then words; the most important and the newest first. Returns where they end."""
        overlay, theme, first = self.overlay, current(), self.lanes[0]
        top, shown = first.box.top() - self._title_px + 2, []
        marks = sorted(self.frame.marks, key=lambda mark: (mark.rank, -mark.time_s))
        self._draw_lines(marks)
        for mark in marks:
            tag = Tag("", theme.ink(mark.meaning).name(), icon=mark.icon)
            room = overlay.put(tag, QPointF(first.x(mark.time_s) - ICON_PX / 2, top), gap_px=_GAP_PX)
            if room is not None:
                shown.append((mark, room))
        ends = []
        for mark, room in shown:
            word = Tag(tr(mark.word), theme.ink(mark.meaning).name(), is_bold=True)
            fits = room.right() + 3 + overlay.size(word).width() < self.viewport().width()
            placed = overlay.put(word, QPointF(room.right() + 3, top), gap_px=2) if fits else None
            ends.append((placed or room).right() + 2 * _GAP_PX)
        return sorted(ends)

    def _draw_lines(self, marks: Sequence[Mark]) -> None:
        """One at each pixel where marks are, in the colour of the most important one."""
        theme = current()
        columns: dict[int, Meaning | None] = {}
        for mark in marks:
            columns.setdefault(round(self.lanes[0].x(mark.time_s)), mark.meaning)
        for x, meaning in columns.items():
            ink = theme.ink(meaning)
            # Fainter than cursor and curves; mixed, since transparent pens are slow.
            self._draw_line(x + 0.5, ink if theme.line_px > 1 else mixed(ink, theme.surface, 0.4))

    def _draw_line(self, x: float, colour: QColor) -> None:
        self.overlay.lines += [(QLineF(x, lane.box.top(), x, lane.box.bottom()), QPen(colour)) for lane in self.lanes]

    def _write_cursor(self) -> None:
        """Its line, the values beside the samples, and the time below."""
        frame, overlay, theme = self.frame, self.overlay, current()
        if frame.cursor_s is None:
            return
        x = self.lanes[0].x(frame.cursor_s)
        self._draw_line(x, QColor(theme.text))
        for lane, reading in zip(self.lanes, frame.readings, strict=False):
            near = lane.lane.series.around(frame.cursor_s, within_s=lane.lane.gap_s)
            tag = Tag(reading, theme.window, is_bold=True, ground=theme.text)
            y = lane.box.top() + 12
            if near is not None:
                y = lane.y(near.high) - 14
                overlay.dots.append((QPointF(x, lane.y(near.high)), lane.ink))
            overlay.put(tag, beside(x, y, overlay.size(tag), lane.box), is_above=True)
        last = self.lanes[-1].box
        tag = Tag(frame.cursor_time, theme.window, is_bold=True, ground=theme.text)
        size = overlay.size(tag)
        row = QRectF(last.left(), last.bottom() + 2, self.viewport().width() - last.left(), size.height())
        room = QRectF(beside(x, row.center().y(), size, row), size)
        overlay.put(tag, room.topLeft(), is_above=True)
        for label, _ in self.tick_labels():
            if label.intersects(room):  # partly covered it would show another time
                overlay.cover = overlay.cover.united(label)

    def tick_labels(self) -> list[tuple[QRectF, str]]:
        """The labels of the time line and their rooms: none below the values' axis, none touching another."""
        frame, metrics, last = self.frame, QFontMetricsF(font(Size.SMALL)), self.lanes[-1].box
        free_from, labels = last.left(), []
        for time_s, label in sorted(frame.ticks):
            width = metrics.horizontalAdvance(label) + 4
            middle = last.right() + time_s / frame.span.length_s * last.width()
            left = last.left() if abs(middle - last.left()) < 1 else middle - width / 2
            if left >= free_from:
                free_from = left + width + _GAP_PX
                labels.append((QRectF(left, last.bottom() + 2, width, metrics.height() + 4), label))
        return labels

    # Mouse and keyboard

    def pan(self, part: float, cursor_part: float | None = None) -> None:
        """By a part of the span in sight, negative to the past."""
        self.moved.emit(part, 1 + part, cursor_part)

    def zoom(self, factor: float, part: float) -> None:
        """So many times as much time, around a part of the span in sight."""
        factor = max(factor, SHORTEST_S / self.frame.span.length_s)
        self.fit_scales()
        self.moved.emit(part * (1 - factor), part * (1 - factor) + factor, self.cursor_part)

    def _part(self, position: QPointF) -> float | None:
        """The position within the width of the view, 0 to 1; None outside the lanes."""
        box = self.lanes[0].box
        if not box.left() <= position.x() <= box.right():
            return None
        return float((position.x() - box.left()) / max(1.0, box.width()))

    def _lane_of_axis(self, position: QPointF) -> LaneView | None:
        """The lane whose values are at the left of a position."""
        if position.x() >= self.lanes[0].box.left():
            return None
        return next((lane for lane in self.lanes if lane.box.top() <= position.y() <= lane.box.bottom()), None)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.DevicePixelRatioChange and self.is_styled:
            self.apply_theme()
        is_handled = bool(super().event(event))
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.changed.emit()
        return is_handled

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.is_styled:
            self.arrange()
            self.changed.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == _LEFT_BUTTON:
            self._dragged_lane = self._lane_of_axis(event.position())
            if self._dragged_lane is not None or self._part(event.position()) is not None:
                self._dragged_from = event.position()
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        position, begun, part = event.position(), self._dragged_from, self._part(event.position())
        if begun is not None and event.buttons() & _LEFT_BUTTON and (position - begun).manhattanLength() >= _DRAG_PX:
            self._dragged_from = position
            if self._dragged_lane is not None:
                self._dragged_lane.zoom_values(1.01 ** (position.y() - begun.y()))
                self.changed.emit()
            elif position.x() != begun.x():
                self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
                self.pan((begun.x() - position.x()) / max(1.0, self.width_px), part)
        elif part is not None or event.buttons() == Qt.MouseButton.NoButton:
            over_axis = self._lane_of_axis(position) is not None
            self.viewport().setCursor(Qt.CursorShape.SizeVerCursor if over_axis else Qt.CursorShape.ArrowCursor)
            self.cursor_wanted.emit(part)
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._dragged_from = self._dragged_lane = None
        self.viewport().unsetCursor()
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        lane = self._lane_of_axis(event.position())
        if lane is None:
            self.live_wanted.emit()
        else:
            lane.fit_scale(is_manual_too=True)
            self.changed.emit()
        event.accept()

    def leaveEvent(self, _event: QEvent) -> None:
        self.cursor_wanted.emit(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zooms with Ctrl, after a click, and where nothing else can be scrolled."""
        part = self._part(event.position())
        zooms = self.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier or not self._page_scrolls()
        if part is None or not zooms:
            event.ignore()
            return
        if event.angleDelta().x():
            self.pan(-event.angleDelta().x() / 1200, self.cursor_part)
        else:
            self.zoom(0.8 ** (event.angleDelta().y() / 120), part)
        event.accept()

    def _page_scrolls(self) -> bool:
        above = self.parentWidget()
        while above is not None:
            if isinstance(above, QAbstractScrollArea) and above.verticalScrollBar().maximum() > 0:
                return True
            above = above.parentWidget()
        return False

    def keyPressEvent(self, event: QKeyEvent) -> None:
        is_shifted = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        cursor_part = 1.0 if self.cursor_part is None else self.cursor_part
        match event.key():
            case Qt.Key.Key_Left | Qt.Key.Key_Right:
                sign = -1 if event.key() == Qt.Key.Key_Left else 1
                if is_shifted:
                    self.cursor_wanted.emit(cursor_part + sign / max(50.0, self.width_px / 4))
                else:
                    self.pan(sign * 0.1, self.cursor_part)
            case Qt.Key.Key_Up | Qt.Key.Key_Down if is_shifted:
                for lane in self.lanes:
                    lane.zoom_values(0.8 if event.key() == Qt.Key.Key_Up else 1.25)
                self.changed.emit()
            case Qt.Key.Key_Plus | Qt.Key.Key_Equal | Qt.Key.Key_Minus:
                self.zoom(1.25 if event.key() == Qt.Key.Key_Minus else 0.8, cursor_part)
            case Qt.Key.Key_Space:
                self.pause_wanted.emit()
            case Qt.Key.Key_Home:
                self.fit_wanted.emit()
            case Qt.Key.Key_End:
                self.live_wanted.emit()
            case _:
                event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        event.ignore()
