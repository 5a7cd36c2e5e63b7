"""Plots several quantities over time below each other, with limits, marks and a cursor, by mouse and keyboard.

The page fills the series, adds marks, and calls `draw`. Importing this module loads numpy and pyqtgraph, so import it
after the window's first paint.
"""

from collections import deque
from collections.abc import Sequence
from functools import partial
from math import ceil
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QKeyEvent, QMouseEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QGraphicsView, QPushButton, QToolButton, QWidget

from app.samples.samples import SeriesSample
from app.system.clock import clock_text
from app.text.i18n import tr
from app.text.messages import duration, in_brackets
from ui.plots.charts import TimeAxis, ago_text
from ui.plots.lane_view import EDGE_PX, GAP_PX, ICON_PX, LaneView, Overlay
from ui.plots.lanes import Lane, Mark, Span, TimeRange, value_text
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space, current, is_text_large
from ui.widgets.controls import in_column, in_row, named
from ui.widgets.readout import StateChip
from ui.widgets.visibility_timer import VisibilityTimer

_LENGTHS_S: Final = (10.0, 60.0, 600.0)
# In ten hours one every 36 s.
_MAX_MARKS: Final = 1000
# Least height of a lane in lines of text, below which the labels of limits overlap.
_MIN_LINES: Final = 2.5
# A mark as near to the cursor is named there.
_NEAR_PX: Final = 6
# The label of a limit from its line.
_FURTHEST_PX: Final = 60
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
        self.setAccessibleName(tr("Plots"))
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        # With marks in sight the least region has hundreds of corners, which costs more than it saves.
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.viewport().setObjectName("time-plot-viewport")
        self.viewport().setMouseTracking(True)
        self.time_range, self.wall_offset_s = time_range, wall_offset_s
        self.marks: deque[Mark] = deque(maxlen=_MAX_MARKS)
        # At the cursor: its age and the time of day with the events there, and what each lane reads.
        self.cursor_time = ""
        self.readings: list[tuple[str, SeriesSample | None]] = []
        self.lanes = [LaneView(lane, self.scene()) for lane in lanes]
        # Of all lanes.
        self.bounds = QRectF()
        self.times, self.overlay = TimeAxis(self.lanes[0].view), Overlay()
        for item in (self.times, self.overlay):
            self.scene().addItem(item)
        # What the last picture depended on; None: it has to be drawn again.
        self._drawn: object = None
        self._pressed = self._last = QPointF()

    def apply_theme(self) -> None:
        theme = current()
        self.setBackgroundBrush(QColor(theme.surface))
        self.times.apply_theme(QPen(QColor(theme.border)))
        self.overlay.apply_theme()
        for number, lane in enumerate(self.lanes):
            lane.apply_theme(theme.curves[number % len(theme.curves)], self.devicePixelRatioF())
        self.arrange()

    def arrange(self) -> None:
        whole, line = QRectF(self.viewport().rect()), self.overlay.line_px
        labels = (tr(limit.label, value="000") for lane in self.lanes for limit in lane.lane.limits)
        labels_px = max((self.overlay.size(label, is_bold=True).width() for label in labels), default=0.0)
        left = self.overlay.size("−180").width() + 8
        right = max(left + 50, whole.right() - labels_px - 12)
        title = line + 6
        around = line + 4 + len(self.lanes) * title
        weights = [lane.lane.weight for lane in self.lanes]
        self.setMinimumHeight(ceil(around + _MIN_LINES * line * sum(weights) / min(weights)))
        room = max(line, whole.height() - around)
        top = 0.0
        for lane, weight in zip(self.lanes, weights, strict=True):
            height = round(room * weight / sum(weights))
            lane.place(QRectF(round(left), top + title, round(right - left), height))
            top += title + height
        self.overlay.setRect(whole)
        self.times.setHeight(line + 4)
        self.times.setGeometry(QRectF(round(left), top - 1, round(right - left) + EDGE_PX, line + 4))
        self.bounds = self.lanes[0].box.united(self.lanes[-1].box)
        self.time_range.width_px = max(1.0, self.bounds.width() * self.devicePixelRatioF())

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
        limits = [limit.steps.value for lane in self.lanes for limit in lane.lane.limits]
        if self.time_range.is_live:  # new samples are within the last pixel
            return span, limits
        newest = (lane.lane.series.last for lane in self.lanes)
        return span, limits, [None if sample is None else min(sample.time_s, span.end_s) for sample in newest]

    def draw(self) -> None:
        time_range, span, cursor_s = self.time_range, self.time_range.span, self.time_range.cursor_s
        marks = [mark for mark in self.marks if span.start_s <= mark.time_s <= span.end_s]
        self.readings = [] if cursor_s is None else [lane.reading(cursor_s) for lane in self.lanes]
        self.cursor_time = "" if cursor_s is None else self._time_text(cursor_s, marks)
        if not self.isVisible():
            self.forget()
            return
        self._drawn = self._appearance_key(time_range.now_s)
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
        """The important words first, since none may cover another: limits beside the lane, as near to their lines as
        there is room; marks, titles, and gaps where there is room."""
        overlay, theme = self.overlay, current()
        for lane in self.lanes:
            for line in lane.limits:
                if line.value is not None:
                    text = tr(line.limit.label, value=value_text(line.value, line.limit.decimals))
                    left, top = lane.box.right() + 6, lane.y(line.value) - overlay.line_px / 2
                    ways = (sign * way for way in range(_FURTHEST_PX) for sign in (1, -1))
                    overlay.put(text, line.ink(), (QPointF(left, top + way) for way in ways), is_bold=True)
        first = self.lanes[0].box.left()
        lefts = [first, *self._write_marks(marks)]  # the first title is in the row of the marks
        for lane in self.lanes:
            top = lane.box.top() - overlay.line_px - 4
            title = overlay.put(tr(lane.lane.title), lane.ink, (QPointF(left, top) for left in lefts), is_bold=True)
            if title is not None:
                overlay.put(lane.lane.unit, theme.muted, [QPointF(title.right() + 6, top)])
            lefts = [first]
        word = tr("no data")
        size = overlay.size(word, is_on_ground=True)
        for lane in self.lanes:
            box = lane.box
            for gap in lane.gaps:
                left, right = max(box.left(), lane.x(gap.start_s)), min(box.right(), lane.x(gap.end_s))
                if right - left > size.width():
                    tops = (box.top() + part * box.height() - size.height() / 2 for part in (0.5, 0.25, 0.75))
                    middles = (QPointF((left + right - size.width()) / 2, top) for top in tops)
                    overlay.put(word, theme.text, middles, ground=theme.surface)

    def _write_marks(self, marks: Sequence[Mark]) -> list[float]:
        """Lines, icons, then words; the most important and the newest first. Returns where they end."""
        overlay, theme, first = self.overlay, current(), self.lanes[0]
        shown, ends, columns, top = [], [], set[int](), first.box.top() - overlay.line_px - 4
        for mark in sorted(marks, key=lambda mark: (mark.rank, -mark.time_s)):
            x, ink = first.x(mark.time_s), theme.ink(mark.meaning)
            if round(x) not in columns:
                columns.add(round(x))
                # Fainter than cursor and curves; mixed with the ground, since transparent pens are slow.
                both = zip(ink.getRgbF()[:3], QColor(theme.surface).getRgbF()[:3], strict=True)  # type: ignore[index]
                faint = QColor.fromRgbF(*(0.6 * of_ink + 0.4 * of_ground for of_ink, of_ground in both))
                overlay.lines.append((x, ink if theme.line_px > 1 else faint))
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
            """At the right of the line, or at its left where there is no room."""
            size = overlay.size(text, is_bold=True, is_on_ground=True)
            left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
            lowest = max(within.top(), within.bottom() - size.height())
            place = QPointF(left, min(max(y - size.height() / 2, within.top()), lowest))
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
            self.time_range.cursor = self._part(place)
            self.time_range.pan(-way.x() / self.bounds.width())
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
        """Zooms with Ctrl, and after a click; else the page scrolls."""
        way = event.angleDelta()
        event.setAccepted(self.hasFocus() or bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier))
        if not event.isAccepted():
            return
        if abs(way.x()) > abs(way.y()):
            self.time_range.pan(-way.x() / 1200)
        else:
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


class TimePlot(QWidget):
    """The plots below their controls: state, length of the time line, pause.

    `lanes` from top to bottom. `wall_offset_s` added to the samples' monotonic time gives seconds since 1970. `bounds`
    are those of a recording; see `TimeRange`.
    """

    def __init__(self, lanes: Sequence[Lane], *, wall_offset_s: float, bounds: Span | None = None) -> None:
        super().__init__()
        self.setObjectName("time-plot")
        self.time_range = TimeRange(bounds)
        # The values at the cursor in words.
        self.reading = ""
        self.canvas = PlotView(lanes, self.time_range, wall_offset_s)
        self.chip = named(StateChip(tr("Plots"), is_measured=True), "time-plot-state")
        self._lengths: dict[float, QToolButton] = {}
        for length_s in _LENGTHS_S:
            button = self._lengths[length_s] = named(QToolButton(), f"time-plot-window-{length_s:g}", "segment")
            button.setCheckable(True)
            button.setText(duration(length_s))
            button.setToolTip(tr("Length of the time line"))
            button.setAccessibleDescription(tr("Length of the time line"))
            button.clicked.connect(partial(self.time_range.choose_length, length_s))
        self._whole = named(QToolButton(), "time-plot-whole", "segment")
        self._whole.setText(tr("All"))
        self._whole.setCheckable(True)
        self._whole.clicked.connect(self.time_range.back_to_live)
        self._whole.setVisible(self.time_range.is_recorded)
        self.pause = named(QPushButton(), "time-plot-pause")
        self.pause.setAutoDefault(False)
        self.pause.clicked.connect(self.time_range.toggle_pause)
        self.pause.setVisible(not self.time_range.is_recorded)
        controls = in_row(1, *self._lengths.values(), self._whole, self.pause, spacing=Space.XS)
        head = (in_column if is_text_large() else in_row)(self.chip, (controls, 1), spacing=Space.XS)
        in_column(head, (self.canvas, 1), of=self, spacing=Space.XS, margins=0)
        self.time_range.changed.connect(self._redraw)
        self.apply_theme()
        VisibilityTimer(self, self._redraw, restyle=self.apply_theme)

    def add_marks(self, marks: Sequence[Mark]) -> None:
        if marks:
            self.canvas.marks.extend(marks)
            self.canvas.forget()

    def reset(self) -> None:
        self.canvas.marks.clear()
        self.time_range.back_to_live()

    def draw(self, now_s: float) -> None:
        self.time_range.follow(now_s)
        self._redraw()

    def apply_theme(self) -> None:
        self.canvas.apply_theme()
        self._redraw()

    def _redraw(self) -> None:
        canvas = self.canvas
        canvas.draw()
        read = zip(canvas.lanes, canvas.readings, strict=False)
        values = [f"{tr(lane.lane.title)} {text}" for lane, (text, _near) in read]
        self.reading = ", ".join(filter(None, (canvas.cursor_time, *values)))
        if canvas.hasFocus():
            canvas.setAccessibleDescription(self.reading)
        self.show_age(self.time_range.now_s)

    def show_age(self, now_s: float) -> None:
        """Shows the length in sight and how far a paused picture is behind, without drawing."""
        time_range = self.time_range
        time_range.follow(now_s)
        for length_s, segment in self._lengths.items():
            segment.setChecked(not time_range.is_whole and abs(time_range.span.length_s - length_s) < 1e-6)
        self._whole.setChecked(time_range.is_whole)
        word = tr("Pause") if time_range.is_live else tr("Live")
        if self.pause.accessibleName() != word:
            self.pause.setAccessibleName(word)
            self.pause.setText("" if is_text_large() else word)
            self.pause.setIcon(icon(Icon.PAUSE if time_range.is_live else Icon.TO_LIVE))
            tip = tr("Pause; recording continues") if time_range.is_live else word
            self.pause.setToolTip(tip + in_brackets("Space" if time_range.is_live else "End"))
        if self.chip.isHidden() is not time_range.is_live:
            self.chip.setHidden(time_range.is_live)  # the title of the page says it
        if time_range.is_recorded:
            self.chip.show_state(tr("recorded"), Icon.HISTORY, Meaning.INFORMATION)
        elif not time_range.is_live:
            text = tr("paused, {time} behind", time=duration(max(0.0, time_range.now_s - time_range.span.end_s)))
            self.chip.show_state(text, Icon.PAUSE, Meaning.ATTENTION)
