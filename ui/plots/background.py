"""Caches grid, scales, labels and steady limits of the plots as a pixmap.

None of it moves while the plots are live, and painting it each time would cost as much as the curves.
"""

from collections.abc import Hashable

from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtGui import QPainter, QPixmap

from app.text.i18n import tr
from ui.plots.paint import Picture, paint_back


def _appearance_key(picture: Picture, ratio: float) -> Hashable:
    """Everything that the background depends on."""
    boxes = tuple((box.x(), box.y(), box.width(), box.height()) for box in (lane.box for lane in picture.lanes))
    lanes = tuple((lane.scale, tr(lane.lane.title)) for lane in picture.lanes)
    ticks = tuple((round(picture.x(tick.time_s), 1), tick.label) for tick in picture.ticks)
    return picture.theme.name, ratio, boxes, lanes, ticks, picture.limits.background_key


class PlotBackground:
    """Paints the background; call `invalidate` when fonts or sizes change."""

    def __init__(self) -> None:
        self._looks: Hashable = None
        self._pixmap: QPixmap | None = None

    def invalidate(self) -> None:
        self._looks = self._pixmap = None

    def paint(self, painter: QPainter, picture: Picture, size: QSize, ratio: float) -> None:
        """Paints directly at first, then from the pixmap until something changes."""
        looks = _appearance_key(picture, ratio)
        if looks != self._looks:
            self._looks, self._pixmap = looks, None
            painter.fillRect(QRect(QPoint(), size), picture.theme.surface)
            paint_back(painter, picture)
            return
        if self._pixmap is None:
            self._pixmap = _painted(picture, size, ratio)
        painter.drawPixmap(0, 0, self._pixmap)


def _painted(picture: Picture, size: QSize, ratio: float) -> QPixmap:
    pixmap = QPixmap(size * ratio)
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(picture.theme.surface)  # opaque, so that drawing it is a plain copy
    painter = QPainter(pixmap)
    paint_back(painter, picture)
    painter.end()
    return pixmap
