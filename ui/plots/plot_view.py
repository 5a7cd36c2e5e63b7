"""The canvas of the time plots: lanes below each other in one scene of pyqtgraph, mouse and keyboard.

The mouse is handled here and not by pyqtgraph's scene, which prints errors instead of raising them.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QColor,
    QContextMenuEvent,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPaintDevice,
    QPainter,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QAbstractScrollArea, QGraphicsItem, QGraphicsLineItem, QGraphicsRectItem, QGraphicsView

from app.text.i18n import tr
from ui.plots.lane_view import LaneView
from ui.plots.lanes import Frame, Lane, Mark
from ui.plots.tags import ICON_PX, Tag, Tags, beside
from ui.style.shapes import mixed
from ui.style.theme import Meaning, Size, current, font

if TYPE_CHECKING:  # pyqtgraph has no types
    from PySide6.QtWidgets import QGraphicsView as _GraphicsView
else:
    _GraphicsView = pg.GraphicsView

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
    panned = Signal(float)
    """By this part of the view, negative to the past."""
    dragged = Signal(float, object)
    """The same, with the part of the view under the pointer."""
    zoomed = Signal(float, float)
    """Show so many times as much time, around this part of the view (0 left, 1 right; −1: the cursor)."""
    pointed = Signal(object)
    """The part of the view under the pointer, None outside."""
    cursor_stepped = Signal(float)
    """By this part of the view."""
    pause_wanted = Signal()
    live_wanted = Signal()
    fit_wanted = Signal()
    """Vertically."""
    changed = Signal()
    """Size, focus or a vertical scale changed: it has to be drawn again."""
    menu_wanted = Signal(QPoint)

    def __init__(self, lanes: Sequence[Lane]) -> None:
        self.is_styled = False
        super().__init__()
        self.setObjectName("time-plot-canvas")
        self.setMouseTracking(True)
        # With marks in sight the least region has hundreds of corners, which costs more than it saves.
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.viewport().setObjectName("time-plot-viewport")
        scene = self.scene()
        self.tags = Tags(scene)
        self.all_lanes = [LaneView(lane, number, scene) for number, lane in enumerate(lanes)]
        self.lanes = self.all_lanes
        """Those in sight: only the first ones where there is no room for all."""
        self._focus, self.cover = QGraphicsRectItem(), QGraphicsRectItem()
        self.cover.setPen(Qt.PenStyle.NoPen)
        for item in (self._focus, self.cover):
            scene.addItem(item)
        self.mark_lines: list[QGraphicsLineItem] = []
        self.frame: Frame | None = None
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

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self._focus.setPen(QPen(QColor(theme.information.ink), 2))
        self.cover.setBrush(QColor(theme.surface))
        for lane in self.all_lanes:
            lane.apply_theme(theme, self.devicePixelRatioF())
        self.is_styled = True
        self.arrange()

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        self.tags.apply_theme()
        self._ticks = self._words = None
        whole = QRectF(self.viewport().rect())
        metrics = QFontMetricsF(font(Size.SMALL))
        line = metrics.height()
        left = metrics.horizontalAdvance("−180") + 8
        right = max(left + 50, whole.right() - max(lane.limit_labels_px(self.tags) for lane in self.all_lanes) - 12)
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
                is_last = number + 1 == count
                lane.place(QRectF(round(left), top + title, round(right - left), height), line + 4 if is_last else None)
                top += title + height
        self._focus.setRect(self.lanes[0].box.united(self.lanes[-1].box).adjusted(-2, -2, 2, 2))

    def fit_scales(self, *, is_manual_too: bool = False) -> None:
        """Lets the vertical scales shrink with the next draw."""
        for lane in self.all_lanes:
            lane.fit_scale()
            if is_manual_too:
                lane.manual = None

    def draw(self, frame: Frame) -> None:
        self.frame = frame
        for lane in self.lanes:
            lane.draw(frame.span)
            lane.show_cursor(frame.cursor_s)
        if frame.ticks != self._ticks:
            self._ticks = frame.ticks
            labels = [(room.center().x(), label) for room, label in self.tick_labels(frame)]
            for lane in self.lanes:
                lane.set_ticks(frame.ticks, labels)
        self._focus.setVisible(self.hasFocus())
        words = (frame.marks, frame.cursor_s, frame.readings, [lane.words_key for lane in self.lanes])
        if words != self._words or frame.marks:
            self._words = words
            self._write(frame)

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

    def _write(self, frame: Frame) -> None:
        """All words: the important ones first, since none may cover another."""
        tags, theme = self.tags, current()
        tags.begin()
        for lane in self.lanes:
            lane.name_limits(tags, theme)
        mark_ends = self._write_marks(frame)
        for lane in self.lanes:
            # That of the first lane is in the row of the marks.
            lefts = (lane.box.left(), *(mark_ends if lane is self.lanes[0] else ()))
            top = lane.box.top() - self._title_px + 2
            tags.put(lane.title(), *(QPointF(left, top) for left in lefts), gap_px=_GAP_PX)
        for lane in self.lanes:
            lane.name_past(tags, theme)
        hidden = ", ".join(tr(lane.lane.title) for lane in self.all_lanes[len(self.lanes) :])
        if hidden:
            note = Tag(tr("No room for: {plots}", plots=hidden), theme.muted)
            place = QPointF(self.lanes[0].box.left(), self.viewport().height() - tags.size(note).height() - 2)
            tags.put(note, place, is_above=True)
        self._write_cursor(frame)
        tags.end()

    def _write_marks(self, frame: Frame) -> list[float]:
        """Icons, then words; the most important and the newest first. Returns where they end."""
        tags, theme, first = self.tags, current(), self.lanes[0]
        top, shown = first.box.top() - self._title_px, []
        marks = sorted(frame.marks, key=lambda mark: (mark.rank, -mark.time_s))
        self._draw_lines(marks)
        for mark in marks:
            tag = Tag("", theme.ink(mark.meaning).name(), icon=mark.icon)
            corner = QPointF(first.x(mark.time_s) - ICON_PX / 2, top + 2)
            room = tags.put(tag, corner, gap_px=_GAP_PX)
            if room is not None:
                shown.append((mark, room))
        ends = []
        for mark, room in shown:
            word = Tag(tr(mark.word), theme.ink(mark.meaning).name(), is_bold=True)
            fits = room.right() + 3 + tags.size(word).width() < self.viewport().width()
            placed = tags.put(word, QPointF(room.right() + 3, top + 2), gap_px=2) if fits else None
            ends.append((placed or room).right() + 2 * _GAP_PX)
        return sorted(ends)

    def _draw_lines(self, marks: Sequence[Mark]) -> None:
        """One at each pixel where marks are, in the colour of the most important one. Qt's own items, since a line of
        pyqtgraph is painted by Python and there may be hundreds."""
        theme = current()
        columns: dict[int, Meaning | None] = {}
        for mark in marks:
            columns.setdefault(round(self.lanes[0].x(mark.time_s)), mark.meaning)
        count = 0
        for x, meaning in columns.items():
            ink = theme.ink(meaning)
            # Fainter than cursor and curves; mixed, since transparent pens are slow.
            line = QPen(ink if theme.line_px > 1 else mixed(ink, theme.surface, 0.4), 1)
            for lane in self.lanes:
                if count == len(self.mark_lines):
                    self.mark_lines.append(QGraphicsLineItem())
                    self.scene().addItem(self.mark_lines[-1])
                item = self.mark_lines[count]
                item.setPen(line)
                item.setLine(x + 0.5, lane.box.top(), x + 0.5, lane.box.bottom())
                item.show()
                count += 1
        for item in self.mark_lines[count:]:
            item.hide()

    def _write_cursor(self, frame: Frame) -> None:
        """The values beside the samples, and the time below."""
        self.cover.hide()
        if frame.cursor_s is None:
            return
        tags, theme = self.tags, current()
        x = self.lanes[0].x(frame.cursor_s)
        for lane, reading in zip(self.all_lanes, frame.readings, strict=True):
            if lane in self.lanes:
                tag = Tag(reading, theme.window, is_bold=True, ground=theme.text)
                y = lane.dot.y() - 14 if lane.dot.isVisible() else lane.box.top() + 12
                tags.put(tag, beside(x, y, tags.size(tag), lane.box), is_above=True)
        last = self.lanes[-1].box
        tag = Tag(frame.cursor_time, theme.window, is_bold=True, ground=theme.text)
        size = tags.size(tag)
        row = QRectF(last.left(), last.bottom() + 2, self.viewport().width() - last.left(), size.height())
        room = tags.put(tag, beside(x, row.center().y(), size, row), is_above=True)
        covered = QRectF()
        for label, _ in self.tick_labels(frame):
            # A partly covered label would show another time.
            covered = covered.united(label) if room is not None and label.intersects(room) else covered
        self.cover.setRect(covered)
        self.cover.setVisible(not covered.isEmpty())

    def tick_labels(self, frame: Frame) -> list[tuple[QRectF, str]]:
        """The labels of the time line and their rooms: none below the values' axis, none touching another."""
        metrics, last = QFontMetricsF(font(Size.SMALL)), self.lanes[-1].box
        free_from, labels = last.left(), []
        for tick in sorted(frame.ticks):
            width = metrics.horizontalAdvance(tick.label) + 4
            middle = last.right() + tick.time_s / frame.span.length_s * last.width()
            left = last.left() if abs(middle - last.left()) < 1 else middle - width / 2
            if left >= free_from:
                free_from = left + width + _GAP_PX
                labels.append((QRectF(left, last.bottom() + 2, width, metrics.height() + 4), tick.label))
        return labels

    # Mouse and keyboard

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
                self.dragged.emit((begun.x() - position.x()) / max(1.0, self.width_px), part)
        elif part is not None or event.buttons() == Qt.MouseButton.NoButton:
            over_axis = self._lane_of_axis(position) is not None
            self.viewport().setCursor(Qt.CursorShape.SizeVerCursor if over_axis else Qt.CursorShape.ArrowCursor)
            self.pointed.emit(part)
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
            lane.fit_scale()
            lane.manual = None
            self.changed.emit()
        event.accept()

    def leaveEvent(self, _event: QEvent) -> None:
        self.pointed.emit(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zooms with Ctrl, after a click, and where nothing else can be scrolled."""
        part = self._part(event.position())
        zooms = self.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier or not self._page_scrolls()
        if part is None or not zooms:
            event.ignore()
            return
        if event.angleDelta().x():
            self.panned.emit(-event.angleDelta().x() / 1200)
        else:
            self.zoomed.emit(0.8 ** (event.angleDelta().y() / 120), part)
        event.accept()

    def _page_scrolls(self) -> bool:
        above = self.parentWidget()
        while above is not None:
            if isinstance(above, QAbstractScrollArea) and above.verticalScrollBar().maximum() > 0:
                return True
            above = above.parentWidget()
        return False

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        self.menu_wanted.emit(event.globalPos())
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        is_shifted = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        match event.key():
            case Qt.Key.Key_Left | Qt.Key.Key_Right:
                sign = -1 if event.key() == Qt.Key.Key_Left else 1
                if is_shifted:
                    self.cursor_stepped.emit(sign / max(50.0, self.width_px / 4))
                else:
                    self.panned.emit(sign * 0.1)
            case Qt.Key.Key_Up | Qt.Key.Key_Down if is_shifted:
                for lane in self.lanes:
                    lane.zoom_values(0.8 if event.key() == Qt.Key.Key_Up else 1.25)
                self.changed.emit()
            case Qt.Key.Key_Plus | Qt.Key.Key_Equal | Qt.Key.Key_Minus:
                self.zoomed.emit(1.25 if event.key() == Qt.Key.Key_Minus else 0.8, -1.0)
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
