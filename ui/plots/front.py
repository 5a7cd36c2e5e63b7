"""The view in front of all lanes: it takes the mouse, and holds the lines that go through all of them."""

from collections.abc import Sequence
from typing import Final

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractScrollArea,
    QGraphicsItem,
    QGraphicsSceneHoverEvent,
    QGraphicsSceneMouseEvent,
    QGraphicsSceneWheelEvent,
    QWidget,
)

from ui.plots.sight import Sight
from ui.style.theme import current

_DRAG_PX: Final = 3
_LEFT_BUTTON: Final = Qt.MouseButton.LeftButton


class Scene(pg.GraphicsScene):  # type: ignore[misc]
    """Without hover events of pyqtgraph's own, which nothing here uses and which take long with each move."""

    def sendHoverEvents(self, *_: object, **_options: object) -> None:
        """With options where the mouse leaves."""


class Front(pg.ViewBox):  # type: ignore[misc]
    """Its range is that of the time line; what the mouse does goes to `sight`.

    The events are those of Qt and not of pyqtgraph's scene, which prints errors instead of raising them.
    """

    def __init__(self, sight: Sight) -> None:
        super().__init__(enableMouse=False, enableMenu=False)
        self.disableAutoRange()
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemIsFocusable, False)
        self.setAcceptHoverEvents(True)
        self.setZValue(5)
        self._sight = sight
        self.marks: list[pg.InfiniteLine] = []
        self.cursor_line = pg.InfiniteLine()
        self.addItem(self.cursor_line, ignoreBounds=True)

    def show_cursor(self, time_s: float | None) -> None:
        self.cursor_line.setVisible(time_s is not None)
        if time_s is not None:
            self.cursor_line.setPos(time_s)
            self.cursor_line.setPen(current().text, width=self.getViewWidget().devicePixelRatioF())

    def show_marks(self, lines: Sequence[tuple[float, QColor]]) -> None:
        """A line at each of these times before the end of the span."""
        width = self.getViewWidget().devicePixelRatioF()
        for number, (time_s, ink) in enumerate(lines):
            if number == len(self.marks):
                self.marks.append(pg.InfiniteLine())
                self.addItem(self.marks[-1], ignoreBounds=True)
            self.marks[number].setPos(time_s)
            self.marks[number].setPen(ink, width=width)
        for number, line in enumerate(self.marks):
            line.setVisible(number < len(lines))

    def _part(self, place: QPointF) -> float:
        """A place of the mouse as a part of the width of the lanes."""
        return float(self.mapToView(place).x() / self._sight.span.length_s + 1)

    def hoverMoveEvent(self, event: QGraphicsSceneHoverEvent) -> None:
        self._sight.point(self._part(event.pos()))

    def hoverLeaveEvent(self, _event: QGraphicsSceneHoverEvent) -> None:
        self._sight.point(None)

    def mousePressEvent(self, event: QGraphicsSceneMouseEvent) -> None:
        event.setAccepted(event.button() == _LEFT_BUTTON)

    def mouseMoveEvent(self, event: QGraphicsSceneMouseEvent) -> None:
        way, part = event.screenPos() - event.buttonDownScreenPos(_LEFT_BUTTON), self._part(event.pos())
        if way.manhattanLength() >= _DRAG_PX and event.pos().x() != event.lastPos().x():
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
            self._sight.pan(self._part(event.lastPos()) - part, min(1.0, max(0.0, part)))

    def mouseReleaseEvent(self, _event: QGraphicsSceneMouseEvent) -> None:
        self.unsetCursor()

    def mouseDoubleClickEvent(self, _event: QGraphicsSceneMouseEvent) -> None:
        self._sight.back_to_live()

    def wheelEvent(self, event: QGraphicsSceneWheelEvent, _axis: object = None) -> None:
        """Zooms with Ctrl, after a click, and where nothing else can be scrolled."""
        view = self.getViewWidget()
        is_meant = view.hasFocus() or event.modifiers() & Qt.KeyboardModifier.ControlModifier
        event.setAccepted(bool(is_meant) or not _page_scrolls(view))
        if event.isAccepted() and event.orientation() == Qt.Orientation.Horizontal:
            self._sight.pan(-event.delta() / 1200)
        elif event.isAccepted():
            self._sight.zoom(0.8 ** (event.delta() / 120), self._part(event.pos()))


def _page_scrolls(view: QWidget) -> bool:
    above = view.parentWidget()
    while above is not None:
        if isinstance(above, QAbstractScrollArea) and above.verticalScrollBar().maximum() > 0:
            return True
        above = above.parentWidget()
    return False
