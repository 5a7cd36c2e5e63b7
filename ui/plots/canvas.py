"""Plot surface: lanes below each other, mouse and keyboard.

The wheel zooms only when the plots have the focus or Ctrl is held; else it scrolls the page.
"""

from collections.abc import Sequence
from typing import ClassVar

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QFocusEvent,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from ui.plots.background import PlotBackground
from ui.plots.curve import LaneCurve
from ui.plots.limits import gutter_px
from ui.plots.paint import Picture, paint_front
from ui.plots.view import Lane, Span
from ui.style.theme import Size, Theme, current, font

_MIN_LANES = 2
_MIN_LINES = 2.5
"""Minimum height of a lane in lines of text, below which the labels of limits overlap; one line for the first two
lanes."""


class Canvas(QWidget):
    """Draws a `Picture`; the signals are what the user wants."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    panned = Signal(float)
    """By this part of the view, negative to the past."""
    zoomed = Signal(float, float)
    """Show so many times as much time, around this part of the view (0 left, 1 right)."""
    pause_wanted = Signal()
    live_wanted = Signal()
    cursor_moved = Signal()
    """`cursor_part` or the size changed."""

    def __init__(self, lanes: Sequence[Lane]) -> None:
        super().__init__()
        self.setObjectName("time-plot-canvas")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.cursor_part: float | None = None
        self.retains_cursor = False
        """Keep the cursor where the pointer left the canvas."""
        self._dragged_from: float | None = None
        self._picture: Picture | None = None
        self._ground = PlotBackground()
        self.all_lanes = [LaneCurve(lane, number) for number, lane in enumerate(lanes)]
        self.lanes = self.all_lanes
        """Those in sight: only the first ones where there is no room for all."""
        self.marks = QRectF()
        """The row of the marks' icons and words, which is that of the first title."""
        self.axis = QRectF()
        """The row of the ticks' labels."""

    def apply_theme(self, theme: Theme) -> None:
        for lane in self.all_lanes:
            lane.apply_theme(theme)

    def arrange(self) -> None:
        """Places the lanes, after a change of size, language or font."""
        self._ground.invalidate()
        whole = QRectF(self.rect())
        line = QFontMetricsF(font(Size.SMALL)).height()
        left = QFontMetricsF(font(Size.SMALL)).horizontalAdvance("−180") + 8
        right = max(left + 50, whole.right() - gutter_px(self.all_lanes))
        title = line + 6
        axis = line + 4
        for count in range(len(self.all_lanes), 0, -1):
            self.lanes = self.all_lanes[:count]
            room = whole.height() - axis - count * title
            weights = sum(lane.lane.weight for lane in self.lanes)
            least = _MIN_LINES if count > _MIN_LANES else 1.0
            if room * self.lanes[-1].lane.weight / weights >= least * line:
                break
        room = max(line, room)
        top = 0.0
        for lane in self.lanes:
            height = round(room * lane.lane.weight / weights)
            lane.place(QRectF(left, top + title, right - left, height))
            top += title + height
        self.marks = QRectF(left, 0, right - left, title)
        self.axis = QRectF(left, top, right - left, axis)

    def show_picture(self, picture: Picture) -> None:
        """Draws `picture`; call `draw_curves` before."""
        self._picture = picture
        self.update()

    @property
    def shown(self) -> Span | None:
        """The span of the last draw, None before the first."""
        return None if self._picture is None else self._picture.span

    def fit_scales(self) -> None:
        """Lets the vertical scales shrink with the next draw."""
        for lane in self.lanes:
            lane.fit_scale()

    def draw_curves(self, span: Span) -> None:
        """Computes all curves for a span."""
        for lane in self.lanes:
            lane.draw(span)

    def paintEvent(self, _event: QPaintEvent) -> None:
        picture, ratio = self._picture, self.devicePixelRatioF()
        painter = QPainter(self)
        # No antialiasing: lines are on pixels, and antialiased dashes cost more than the curves.
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        if picture is None:
            painter.fillRect(self.rect(), current().surface)
        else:
            self._ground.paint(painter, picture, self.size(), ratio)
            for lane in self.lanes:
                lane.paint(painter, ratio=ratio)
            paint_front(painter, picture)
        painter.end()

    def _part(self, position: QPointF) -> float | None:
        """The position within the width of the view, 0 to 1; None outside the lanes."""
        box = self.lanes[0].box
        if not box.left() <= position.x() <= box.right():
            return None
        return float((position.x() - box.left()) / max(1.0, box.width()))

    def set_cursor(self, part: float | None) -> None:
        """Puts the cursor at a part of the view's width; None removes it."""
        if part != self.cursor_part:
            self.cursor_part = None if part is None else min(1.0, max(0.0, part))
            self.cursor_moved.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.arrange()
        self.cursor_moved.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton and self._part(event.position()) is not None:
            self._dragged_from = event.position().x()
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._dragged_from is not None and event.buttons() & Qt.MouseButton.LeftButton:
            by = event.position().x() - self._dragged_from
            if abs(by) >= 3:
                self.setCursor(Qt.CursorShape.ClosedHandCursor)
                self._dragged_from = event.position().x()
                # First, so that one draw shows both.
                self.cursor_part = self._part(event.position())
                self.panned.emit(-by / max(1.0, self.lanes[0].box.width()))
        part = self._part(event.position())
        if part is not None or not self.retains_cursor:
            self.set_cursor(part)
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._dragged_from = None
        self.unsetCursor()
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.live_wanted.emit()
        event.accept()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        if not self.retains_cursor:
            self.set_cursor(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        zooms = self.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier
        part = self._part(event.position())
        if not zooms or part is None:
            event.ignore()
            return
        if event.angleDelta().x():
            self.panned.emit(-event.angleDelta().x() / 1200)
        else:
            self.zoomed.emit(0.8 ** (event.angleDelta().y() / 120), part)
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        is_shifted = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        key = event.key()
        if key in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            sign = -1 if key == Qt.Key.Key_Left else 1
            if is_shifted:
                part = 1.0 if self.cursor_part is None else self.cursor_part
                self.set_cursor(min(1.0, max(0.0, part + sign / max(50.0, self.lanes[0].box.width() / 4))))
            else:
                self.panned.emit(sign * 0.1)
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal, Qt.Key.Key_Minus):
            factor = 1.25 if key == Qt.Key.Key_Minus else 0.8
            self.zoomed.emit(factor, 1.0 if self.cursor_part is None else self.cursor_part)
        elif key == Qt.Key.Key_Space:
            self.pause_wanted.emit()
        elif key == Qt.Key.Key_End:
            self.live_wanted.emit()
        else:
            event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        event.ignore()

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self.cursor_moved.emit()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.cursor_moved.emit()
