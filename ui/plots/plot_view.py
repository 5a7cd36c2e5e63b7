"""The canvas of the time plots: lanes below each other in one scene of pyqtgraph, their words, and the keyboard."""

from collections import deque
from collections.abc import Hashable, Sequence
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QBuffer, QByteArray, QEvent, QPointF, QRectF, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF, QKeyEvent, QPainter, QPen, QResizeEvent
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QGraphicsItem, QGraphicsPixmapItem, QGraphicsView

from app.text.i18n import tr
from ui.plots.axis import LabelAxis, ago_text, clock_text, fitting_times, times
from ui.plots.front import Front, Scene
from ui.plots.lane_view import LaneView
from ui.plots.lanes import Lane, Mark, reading
from ui.plots.sight import Sight
from ui.plots.words import GAP_PX, Dot, Words, beside
from ui.style import icons
from ui.style.painted_widget import mixed
from ui.style.theme import Size, current, font

# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
_MIN_LANES: Final = 2
_MIN_LINES: Final = 2.5
"""Minimum height of a lane in lines of text, below which the labels of limits overlap; one line for the first two
lanes."""
_ICON_PX: Final = 14
_EDGE_PX: Final = 2
"""Of the view in front around the lanes, for the frame of the focus."""
_NEAR_PX: Final = 6
"""A mark as near to the cursor is named there."""


class PlotView(pg.GraphicsView):  # type: ignore[misc]
    """Draws what is in `sight`. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970."""

    accessible_role: ClassVar = QAccessible.Role.Chart

    def __init__(self, lanes: Sequence[Lane], sight: Sight, wall_offset_s: float) -> None:
        self._is_styled = False
        super().__init__()
        self.sceneObj = Scene(parent=self)
        self.setScene(self.sceneObj)
        self.setObjectName("time-plot-canvas")
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
        self.words, self.cursor_words = Words(self.scene()), Words(self.scene())
        self.front = Front(sight)
        self.all_lanes = [LaneView(lane, self.scene()) for lane in lanes]
        for lane_view in self.all_lanes:
            lane_view.values.dragged.connect(lambda _way_px: sight.changed.emit())
            lane_view.values.double_clicked.connect(sight.changed.emit)
        self.lanes = self.all_lanes
        """Those in sight: only the first ones where there is no room for all."""
        self.times = LabelAxis("bottom", self.front)
        for item in (self.front, self.times):
            self.scene().addItem(item)
        self._drawn: Hashable = None
        """What the last picture depended on; None: it has to be drawn again."""
        self._seen = (0.0, False)
        """The length drawn last, and whether it was live."""
        self._written: object = None
        """What the words, beside those at the cursor, depended on when they were written."""
        self._labelled: object = None
        """What the labels of the time line depended on when they were chosen."""

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self.times.apply_theme(QPen(QColor(theme.border)))
        for number, lane in enumerate(self.all_lanes):
            lane.apply_theme(theme.curves[number % len(theme.curves)], self.devicePixelRatioF())
        self._is_styled = True
        self.arrange()

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        whole = QRectF(self.viewport().rect())
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
        boxes = self.lanes[0].box.united(self.lanes[-1].box)
        self.front.setGeometry(boxes.adjusted(-_EDGE_PX, -_EDGE_PX, _EDGE_PX, _EDGE_PX))
        self._labelled = self._written = None

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
        for lane in self.lanes:
            lane.draw(span, ticks)
        placed = [(mark, mark.time_s - span.end_s) for mark in marks]
        written = self.hasFocus(), placed, [lane.words_key for lane in self.lanes]
        if written != self._written:
            self._written = written
            self._write(marks)
        labelled = ticks, span.length_s, self._write_cursor()
        if labelled != self._labelled:
            self._labelled, second_px = labelled, max(1.0, box.width()) / span.length_s
            self.front.setXRange(-span.length_s - _EDGE_PX / second_px, _EDGE_PX / second_px, padding=0.0)
            self.times.show_labels(fitting_times(ticks, span.length_s, second_px, labelled[-1]))

    def svg(self) -> bytes:
        """All as lines and texts, without the pictures that axes and words are kept as. The exporter of pyqtgraph 0.14
        fails at each path that Qt 6.11 closes."""
        data, drawing = QByteArray(), QSvgGenerator()
        drawing.setOutputDevice(QBuffer(data))
        drawing.setSize(self.size())
        drawing.setResolution(self.logicalDpiX())  # the labels of the axes would be scaled by that
        drawing.setViewBox(self.rect())
        kept = [item for item in self.scene().items() if item.cacheMode() != QGraphicsItem.CacheMode.NoCache]
        for item in kept:
            item.setCacheMode(QGraphicsItem.CacheMode.NoCache)
        painter = QPainter(drawing)
        self.render(painter)
        painter.end()
        for item in kept:
            item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)
        return bytes(data.data())

    def _time_text(self, cursor_s: float, marks: Sequence[Mark]) -> str:
        decimals = 1 if self.sight.span.length_s > 3 else 3
        text = clock_text(cursor_s + self.wall_offset_s, decimals)
        if self.sight.is_live:
            text = f"{ago_text(max(0.0, self.sight.now_s - cursor_s), decimals)} · {text}"
        near_s = _NEAR_PX * self.devicePixelRatioF() * self.sight.pixel_s
        return " · ".join((text, *(tr(mark.word) for mark in marks if abs(mark.time_s - cursor_s) < near_s)))

    def _write(self, marks: Sequence[Mark]) -> None:
        """The important words first, since none may cover another."""
        words, theme = self.words, current()
        words.clear()
        self.front.setBorder(pg.mkPen(theme.information.ink, width=2) if self.hasFocus() else None)
        boxes = self.lanes[0].box.united(self.lanes[-1].box)
        for lane in self.lanes:
            lane.name_limits(words)
        lefts = [boxes.left(), *self._write_marks(marks)]  # the first title is in the row of the marks
        for lane in self.lanes:
            title = words.made(tr(lane.lane.title), lane.ink, is_bold=True)
            placed = words.put(title, *(QPointF(left, lane.title_top) for left in lefts))
            if placed is not None:
                words.put(words.made(lane.lane.unit, theme.muted), QPointF(placed.right() + 6, lane.title_top))
            lefts = lefts[:1]
        for lane in self.lanes:
            lane.name_past(words)
        hidden = ", ".join(tr(lane.lane.title) for lane in self.all_lanes[len(self.lanes) :])
        if hidden:
            note = words.made(tr("A higher window also shows: {plots}", plots=hidden), theme.muted)
            place = QPointF(boxes.left(), self.viewport().height() - note.boundingRect().height() - 2)
            words.put(note, place, is_above=True)

    def _write_marks(self, marks: Sequence[Mark]) -> list[float]:
        """Lines, icons, then words; the most important and the newest first. Returns where they end."""
        words, theme, first, end_s = self.words, current(), self.lanes[0], self.sight.span.end_s
        shown, ends, columns, lines = [], [], set[int](), []
        for mark in sorted(marks, key=lambda mark: (mark.rank, -mark.time_s)):
            x, ink = first.x(mark.time_s), theme.ink(mark.meaning)
            if round(x) not in columns:
                columns.add(round(x))
                # Fainter than cursor and curves; mixed, since transparent pens are slow.
                lines.append((mark.time_s - end_s, ink if theme.line_px > 1 else mixed(ink, theme.surface, 0.4)))
            icon = QGraphicsPixmapItem(icons.pixmap(mark.icon, _ICON_PX, ink, ratio=self.devicePixelRatioF()))
            room = words.put(icon, QPointF(x - _ICON_PX / 2, first.title_top))
            if room is not None:
                shown.append((mark, room))
        self.front.show_marks(lines)
        for mark, room in shown:
            word = words.made(tr(mark.word), theme.ink(mark.meaning).name(), is_bold=True)
            fits = room.right() + GAP_PX + 1 + word.boundingRect().width() < self.viewport().width()
            placed = words.put(word, QPointF(room.right() + GAP_PX + 1, first.title_top)) if fits else None
            ends.append((placed or room).right() + 2 * GAP_PX)
        return sorted(ends)

    def _write_cursor(self) -> list[tuple[float, float]]:
        """Its line, the values beside the samples, and the time below. Returns what that takes of the row of the times,
        in pixels from its end: a label that it covered partly would show another time."""
        words, theme, cursor_s, span = self.cursor_words, current(), self.sight.cursor_s, self.sight.span
        if words.shown:
            words.clear()
        self.front.show_cursor(None if cursor_s is None else cursor_s - span.end_s)
        if cursor_s is None:
            return []
        x, last = self.lanes[0].x(cursor_s), self.lanes[-1].box
        for lane, value in zip(self.lanes, self.readings, strict=False):
            near = lane.lane.series.around(cursor_s, within_s=lane.lane.gap_s)
            if near is not None:
                dot = Dot(lane.ink)
                words.put(dot, QPointF(x, lane.y(near.high)) + dot.boundingRect().topLeft(), is_above=True)
            tag = words.made(value, theme.window, is_bold=True, ground=theme.text)
            y = lane.box.top() + 12 if near is None else lane.y(near.high) - 14
            words.put(tag, beside(x, y, tag.boundingRect().size(), lane.box), is_above=True)
        tag = words.made(self.cursor_time, theme.window, is_bold=True, ground=theme.text)
        size = tag.boundingRect().size()
        row = QRectF(last.left(), last.bottom() + 2, self.viewport().width() - last.left(), size.height())
        room = words.put(tag, beside(x, row.center().y(), size, row), is_above=True)
        return [] if room is None else [(room.left() - last.right(), room.right() - last.right())]

    # Keyboard

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
