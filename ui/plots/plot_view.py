"""The canvas of the time plots: lanes below each other in one scene of pyqtgraph, mouse and keyboard.

The mouse is handled here and not by pyqtgraph's scene, which prints errors instead of raising them.
"""

from collections import deque
from collections.abc import Hashable, Sequence
from typing import TYPE_CHECKING, ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt
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
from ui.plots.axis import ago_text, cached_axis, clock_text, fitting_labels, times
from ui.plots.lane_view import LaneView
from ui.plots.lanes import Lane, Mark, Tick, reading
from ui.plots.overlay import ICON_PX, Overlay, Tag, beside
from ui.plots.sight import Sight
from ui.style.painted_widget import mixed
from ui.style.theme import Meaning, Size, current, font

if TYPE_CHECKING:  # pyqtgraph has no types
    from PySide6.QtWidgets import QGraphicsView as _GraphicsView
else:
    _GraphicsView = pg.GraphicsView

# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
_MIN_LANES: Final = 2
_MIN_LINES: Final = 2.5
"""Minimum height of a lane in lines of text, below which the labels of limits overlap; one line for the first two
lanes."""
_GAP_PX: Final = 4
_DRAG_PX: Final = 3
_NEAR_PX: Final = 6
"""A mark as near to the cursor is named there."""
_LEFT_BUTTON: Final = Qt.MouseButton.LeftButton


class PlotView(_GraphicsView):
    """Draws what is in `sight`. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970."""

    accessible_role: ClassVar = QAccessible.Role.Chart

    def __init__(self, lanes: Sequence[Lane], sight: Sight, wall_offset_s: float) -> None:
        self._is_styled = False
        super().__init__()
        self.setObjectName("time-plot-canvas")
        self.setMouseTracking(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        # With marks in sight the least region has hundreds of corners, which costs more than it saves.
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.viewport().setObjectName("time-plot-viewport")
        self.sight, self.wall_offset_s = sight, wall_offset_s
        self.marks: deque[Mark] = deque(maxlen=_MAX_MARKS)
        self.shows_clock = False
        self.cursor_time = ""
        """The age and the time of day at the cursor, and the events there."""
        self.readings: list[str] = []
        """The values at the cursor, also of lanes that a low window does not show."""
        self.overlay = Overlay()
        self.all_lanes = [LaneView(lane, self.scene()) for lane in lanes]
        self.lanes = self.all_lanes
        """Those in sight: only the first ones where there is no room for all."""
        self.times = cached_axis("bottom", self.lanes[0].view)
        for item in (self.overlay, self.times):
            self.scene().addItem(item)
        self._drawn: Hashable = None
        """What the last picture depended on; None: it has to be drawn again."""
        self._seen = (0.0, False)
        """The length drawn last, and whether it was live."""
        self._words: object = None
        """What the words depended on when they were written, if nothing else than these lets them change."""
        self._ticks: list[Tick] = []
        self._labels: list[tuple[QRectF, str]] = []
        self._dragged_from: QPointF | None = None
        self._dragged_lane: LaneView | None = None
        """The lane whose vertical scale is dragged."""

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self.times.setTickFont(font(Size.SMALL))
        self.times.setTextPen(QColor(theme.muted))
        self.times.setPen(QColor(theme.border))
        for number, lane in enumerate(self.all_lanes):
            lane.apply_theme(theme.curves[number % len(theme.curves)], self.devicePixelRatioF())
        self._is_styled = True
        self.arrange()

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        whole = QRectF(self.viewport().rect())
        self.overlay.restyle(whole)
        metrics = QFontMetricsF(font(Size.SMALL))
        line = metrics.height()
        left = metrics.horizontalAdvance("−180") + 8
        right = max(left + 50, whole.right() - max(lane.limit_labels_px() for lane in self.all_lanes) - 12)
        title = line + 6
        for count in range(len(self.all_lanes), 0, -1):
            self.lanes = self.all_lanes[:count]
            axis = line + (4 if count == len(self.all_lanes) else line + 8)  # a line that names the hidden ones
            room = max(line, whole.height() - axis - count * title)
            weights = sum(lane.lane.weight for lane in self.lanes)
            least = _MIN_LINES if count > _MIN_LANES else 1.0
            if room * self.lanes[-1].lane.weight / weights >= least * line:
                break
        top = 0.0
        for lane in self.all_lanes:
            lane.set_visible(lane in self.lanes)
            if lane in self.lanes:
                height = round(room * lane.lane.weight / weights)
                lane.place(QRectF(round(left), top + title, round(right - left), height), top + 2)
                top += title + height
        self.times.setHeight(line + 4)
        self.times.setGeometry(QRectF(round(left), top - 1, round(right - left) + 2, line + 4))
        self.sight.width_px = max(1.0, self.lanes[0].box.width() * self.devicePixelRatioF())
        self._labels, self._words = [], None

    def fit(self, *, is_chosen_too: bool = False) -> None:
        """Lets the vertical scales shrink with the next draw."""
        for lane in self.all_lanes:
            lane.fit(is_chosen_too=is_chosen_too)

    # Drawing

    def forget(self) -> None:
        """The next `is_due` is true."""
        self._drawn = None

    def is_due(self, now_s: float) -> bool:
        """Whether `draw` would change the picture: it moved by a pixel, or something else changed."""
        return self._appearance_key(now_s) != self._drawn

    def _appearance_key(self, now_s: float) -> Hashable:
        """What the picture depends on and may change by itself."""
        span = self.sight.span_at(now_s)
        lanes = [lane.lane for lane in self.all_lanes]
        limits = tuple(
            (limit.steps.value, None if limit.stale is None else limit.stale.value)
            for lane in lanes
            for limit in lane.limits
        )
        if self.sight.is_live:  # new samples are within the last pixel
            return span, limits
        newest = (lane.series.last for lane in lanes)
        return span, limits, tuple(None if sample is None else min(sample.time_s, span.end_s) for sample in newest)

    def draw(self) -> None:
        """Draws all anew, unless it is hidden."""
        sight, span, cursor_s = self.sight, self.sight.span, self.sight.cursor_s
        marks = [mark for mark in self.marks if span.start_s <= mark.time_s <= span.end_s]
        self.readings = [] if cursor_s is None else [reading(lane.lane, cursor_s, span) for lane in self.all_lanes]
        self.cursor_time = "" if cursor_s is None else self._time_text(cursor_s, marks)
        if not self.isVisible():
            self.forget()
            return
        self._drawn = self._appearance_key(sight.now_s)
        seen, self._seen = self._seen, (span.length_s, sight.is_live)
        if seen[0] != span.length_s or sight.is_live > seen[1]:
            self.fit()
        box = self.lanes[-1].box
        most = max(2, int(box.width() / QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000")))
        # A paused picture is labelled by the clock: "10 s before now" would soon be wrong.
        is_clock = self.shows_clock or not sight.is_live
        ticks = times(span.length_s, most, span.end_s + self.wall_offset_s if is_clock else None)
        if ticks != self._ticks or not self._labels:
            self._ticks, self._labels = ticks, fitting_labels(ticks, box, span.length_s)
            second_px = box.width() / span.length_s
            self.times.setTicks([[((at.center().x() - box.right()) / second_px, text) for at, text in self._labels]])
        for lane in self.lanes:
            lane.draw(span, ticks)
        words = self.hasFocus(), [lane.words_key for lane in self.lanes]
        if marks or cursor_s is not None or words != self._words:
            self._words = None if marks or cursor_s is not None else words
            self._write(marks)

    def draw_on(self, device: QPaintDevice) -> None:
        """Draws all as lines and texts, without the pictures that the axes are kept as."""
        axes = [self.times, *(lane.values for lane in self.all_lanes)]
        for axis in axes:
            axis.setCacheMode(QGraphicsItem.CacheMode.NoCache)
        painter = QPainter(device)
        self.render(painter)
        painter.end()
        for axis in axes:
            axis.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)

    def _time_text(self, cursor_s: float, marks: Sequence[Mark]) -> str:
        decimals = 1 if self.sight.span.length_s > 3 else 3
        text = clock_text(cursor_s + self.wall_offset_s, decimals)
        if self.sight.is_live:
            text = f"{ago_text(max(0.0, self.sight.now_s - cursor_s), decimals)} · {text}"
        near_s = _NEAR_PX * self.devicePixelRatioF() * self.sight.pixel_s
        return " · ".join((text, *(tr(mark.word) for mark in marks if abs(mark.time_s - cursor_s) < near_s)))

    def _write(self, marks: Sequence[Mark]) -> None:
        """All words: the important ones first, since none may cover another."""
        overlay, theme = self.overlay, current()
        overlay.begin()
        boxes = self.lanes[0].box.united(self.lanes[-1].box)
        overlay.frame = boxes.adjusted(-2, -2, 2, 2) if self.hasFocus() else None
        for lane in self.lanes:
            lane.name_limits(overlay)
        lefts = [boxes.left(), *self._write_marks(marks)]  # the first title is in the row of the marks
        for lane in self.lanes:
            title = Tag(tr(lane.lane.title), lane.ink, is_bold=True)
            placed = overlay.put(title, *(QPointF(left, lane.title_top) for left in lefts), gap_px=_GAP_PX)
            if placed is not None:
                overlay.put(Tag(lane.lane.unit, theme.muted), QPointF(placed.right() + 6, lane.title_top))
            lefts = lefts[:1]
        for lane in self.lanes:
            lane.name_past(overlay)
        hidden = ", ".join(tr(lane.lane.title) for lane in self.all_lanes[len(self.lanes) :])
        if hidden:
            note = Tag(tr("A higher window also shows: {plots}", plots=hidden), theme.muted)
            place = QPointF(boxes.left(), self.viewport().height() - overlay.size(note).height() - 2)
            overlay.put(note, place, is_above=True)
        if self.sight.cursor_s is not None:
            self._write_cursor(self.sight.cursor_s)

    def _write_marks(self, marks: Sequence[Mark]) -> list[float]:
        """Lines, icons, then words; the most important and the newest first. Returns where they end."""
        overlay, theme, first = self.overlay, current(), self.lanes[0]
        columns: dict[int, Meaning | None] = {}
        shown, ends = [], []
        for mark in sorted(marks, key=lambda mark: (mark.rank, -mark.time_s)):
            x, tag = first.x(mark.time_s), Tag("", theme.ink(mark.meaning).name(), icon=mark.icon)
            columns.setdefault(round(x), mark.meaning)
            room = overlay.put(tag, QPointF(x - ICON_PX / 2, first.title_top), gap_px=_GAP_PX)
            if room is not None:
                shown.append((mark, room))
        for x, meaning in columns.items():
            ink = theme.ink(meaning)
            # Fainter than cursor and curves; mixed, since transparent pens are slow.
            self._draw_line(x + 0.5, ink if theme.line_px > 1 else mixed(ink, theme.surface, 0.4))
        for mark, room in shown:
            word = Tag(tr(mark.word), theme.ink(mark.meaning).name(), is_bold=True)
            fits = room.right() + 3 + overlay.size(word).width() < self.viewport().width()
            placed = overlay.put(word, QPointF(room.right() + 3, first.title_top), gap_px=2) if fits else None
            ends.append((placed or room).right() + 2 * _GAP_PX)
        return sorted(ends)

    def _draw_line(self, x: float, colour: QColor) -> None:
        self.overlay.lines += [(QLineF(x, lane.box.top(), x, lane.box.bottom()), QPen(colour)) for lane in self.lanes]

    def _write_cursor(self, cursor_s: float) -> None:
        """Its line, the values beside the samples, and the time below."""
        overlay, theme, x = self.overlay, current(), self.lanes[0].x(cursor_s)
        self._draw_line(x, QColor(theme.text))
        for lane, value in zip(self.lanes, self.readings, strict=False):
            near = lane.lane.series.around(cursor_s, within_s=lane.lane.gap_s)
            tag = Tag(value, theme.window, is_bold=True, ground=theme.text)
            y = lane.box.top() + 12
            if near is not None:
                y = lane.y(near.high) - 14
                overlay.dots.append((QPointF(x, lane.y(near.high)), lane.ink))
            overlay.put(tag, beside(x, y, overlay.size(tag), lane.box), is_above=True)
        last = self.lanes[-1].box
        tag = Tag(self.cursor_time, theme.window, is_bold=True, ground=theme.text)
        size = overlay.size(tag)
        row = QRectF(last.left(), last.bottom() + 2, self.viewport().width() - last.left(), size.height())
        room = QRectF(beside(x, row.center().y(), size, row), size)
        overlay.put(tag, room.topLeft(), is_above=True)
        for label, _ in self._labels:
            if label.intersects(room):  # partly covered it would show another time
                overlay.cover = overlay.cover.united(label)

    # Mouse and keyboard

    def _part(self, position: QPointF) -> float | None:
        """The position within the width of the view, 0 to 1; None outside the lanes."""
        box = self.lanes[0].box
        part = (position.x() - box.left()) / max(1.0, box.width())
        return float(part) if 0 <= part <= 1 else None

    def _lane_of_axis(self, position: QPointF) -> LaneView | None:
        """The lane whose values are at the left of a position."""
        if position.x() >= self.lanes[0].box.left():
            return None
        return next((lane for lane in self.lanes if lane.box.top() <= position.y() <= lane.box.bottom()), None)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.DevicePixelRatioChange and self._is_styled:
            self.apply_theme()
        is_handled = bool(super().event(event))
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.sight.changed.emit()
        return is_handled

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._is_styled:
            self.arrange()
            self.sight.changed.emit()

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
                self._dragged_lane.zoom(1.01 ** (position.y() - begun.y()))
                self.sight.changed.emit()
            elif position.x() != begun.x():
                self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
                self.sight.pan((begun.x() - position.x()) / max(1.0, self.lanes[0].box.width()), part)
        elif part is not None or event.buttons() == Qt.MouseButton.NoButton:
            over_axis = self._lane_of_axis(position) is not None
            self.viewport().setCursor(Qt.CursorShape.SizeVerCursor if over_axis else Qt.CursorShape.ArrowCursor)
            self.sight.point(part)
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._dragged_from = self._dragged_lane = None
        self.viewport().unsetCursor()
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        lane = self._lane_of_axis(event.position())
        if lane is None:
            self.sight.back_to_live()
        else:
            lane.fit(is_chosen_too=True)
            self.sight.changed.emit()
        event.accept()

    def leaveEvent(self, _event: QEvent) -> None:
        self.sight.point(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zooms with Ctrl, after a click, and where nothing else can be scrolled."""
        part = self._part(event.position())
        zooms = self.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier or not self._page_scrolls()
        event.setAccepted(part is not None and bool(zooms))
        if part is None or not zooms:
            return
        if event.angleDelta().x():
            self.sight.pan(-event.angleDelta().x() / 1200)
        else:
            self.sight.zoom(0.8 ** (event.angleDelta().y() / 120), part)

    def _page_scrolls(self) -> bool:
        above = self.parentWidget()
        while above is not None:
            if isinstance(above, QAbstractScrollArea) and above.verticalScrollBar().maximum() > 0:
                return True
            above = above.parentWidget()
        return False

    def keyPressEvent(self, event: QKeyEvent) -> None:
        sight, is_shifted = self.sight, bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        part = 1.0 if sight.cursor is None else sight.cursor
        match event.key():
            case Qt.Key.Key_Left | Qt.Key.Key_Right:
                sign = -1 if event.key() == Qt.Key.Key_Left else 1
                if is_shifted:
                    sight.point(part + sign / max(50.0, self.lanes[0].box.width() / 4))
                else:
                    sight.pan(sign * 0.1)
            case Qt.Key.Key_Up | Qt.Key.Key_Down if is_shifted:
                for lane in self.lanes:
                    lane.zoom(0.8 if event.key() == Qt.Key.Key_Up else 1.25)
                sight.changed.emit()
            case Qt.Key.Key_Plus | Qt.Key.Key_Equal | Qt.Key.Key_Minus:
                sight.zoom(1.25 if event.key() == Qt.Key.Key_Minus else 0.8, part)
            case Qt.Key.Key_Space:
                sight.toggle_pause()
            case Qt.Key.Key_Home:
                self.fit(is_chosen_too=True)
                sight.changed.emit()
            case Qt.Key.Key_End:
                sight.back_to_live()
            case _:
                event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        event.ignore()
