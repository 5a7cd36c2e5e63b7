"""Records the texts that the window's own widgets paint, with their colours and places.

Painted widgets, delegates and plots call `QPainter.drawText`, which `watching` replaces by a spy. What Qt's style draws
(labels, buttons) is measured on a picture instead.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter
from PySide6.QtWidgets import QWidget

RATIO = 2
"""Scale of pictures, at which even thin strokes have pixels of the pure colour."""
Pixels = NDArray[np.uint32]


class Drawn(NamedTuple):
    """One call of `drawText`; `place` is in the coordinates of the widget, `room_px` the width given, if any."""

    widget: QWidget
    text: str
    colour: QColor
    place: QRectF
    room_px: float | None
    needs_px: float


@contextmanager
def watching() -> Iterator[list[Drawn]]:
    """Record the texts drawn from now on, in order."""
    drawn: list[Drawn] = []
    draw = QPainter.drawText

    def spy(painter: QPainter, *args: Any) -> Any:
        noted = _noted(painter, args)
        if noted is not None:
            drawn.append(noted)
        return draw(painter, *args)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(QPainter, "drawText", spy)
        yield drawn


def _noted(painter: QPainter, args: tuple[Any, ...]) -> Drawn | None:
    """Return the record of a call: at a point, at x and y, or in a rectangle with flags."""
    device, text = painter.device(), args[-1]
    if not isinstance(device, QWidget) or not isinstance(text, str) or not text.strip():
        return None
    metrics = QFontMetricsF(painter.font())
    needs_px = metrics.horizontalAdvance(text)
    room_px: float | None = None
    match args:
        case (QRectF() | QRect() as room, flags, _):
            whole = QRectF(room)
            place = QRectF(metrics.boundingRect(whole, int(flags), text))
            room_px = None if int(flags) & Qt.TextFlag.TextWordWrap.value else whole.width()
        case (int() | float() as x, int() | float() as y, width, height, flags, _):
            whole = QRectF(x, y, width, height)
            place, room_px = QRectF(metrics.boundingRect(whole, int(flags), text)), float(width)
        case (QPointF() | QPoint() as point, _):
            place = metrics.boundingRect(text).translated(QPointF(point))
        case (int() | float() as x, int() | float() as y, _):
            place = metrics.boundingRect(text).translated(x, y)
        case _:
            return None
    return Drawn(device, text, painter.pen().color(), painter.transform().mapRect(place), room_px, needs_px)


def picture_of(root: QWidget) -> Pixels:
    """Render a widget; return rows of 0xAARRGGBB."""
    image = QImage(root.size() * RATIO, QImage.Format.Format_ARGB32)
    image.setDevicePixelRatio(RATIO)
    image.fill(Qt.GlobalColor.white)
    root.render(image)
    return np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), image.width()).copy()


class Colours(NamedTuple):
    """The colours of an area as 0xRRGGBB, and the count of pixels of each."""

    values: Pixels
    counts: NDArray[np.int64]

    @property
    def ground(self) -> str:
        """The most frequent colour."""
        return _name(self.values[self.counts.argmax()])

    def strongest_ink(self, *, least_px: int = 4) -> tuple[str, float]:
        """Return the colour with the most contrast to the ground, and that contrast; rare colours are edges."""
        light = luminance(self.values)
        ground = light[self.counts.argmax()]
        ratios = (np.maximum(light, ground) + 0.05) / (np.minimum(light, ground) + 0.05)
        ratios[self.counts < least_px] = 0
        return _name(self.values[ratios.argmax()]), float(ratios.max())


def colours_in(picture: Pixels, place: QRect) -> Colours:
    part = picture[
        max(0, place.top()) * RATIO : max(0, place.bottom() + 1) * RATIO,
        max(0, place.left()) * RATIO : max(0, place.right() + 1) * RATIO,
    ]
    values, counts = np.unique(part & 0xFFFFFF, return_counts=True)
    return Colours(values, counts)


def _name(value: np.uint32) -> str:
    return f"#{int(value):06x}"


def luminance(values: Pixels) -> NDArray[np.float64]:
    """Return the relative luminance of colours, as WCAG 2.1 defines it."""
    parts = np.stack([(values >> shift) & 0xFF for shift in (16, 8, 0)]) / 255
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.array([0.2126, 0.7152, 0.0722]) @ linear)
