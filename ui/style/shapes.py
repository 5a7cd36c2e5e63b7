"""Shapes shared by painted widgets."""

from PySide6.QtCore import QLineF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen

from ui.style.theme import Theme

_HATCH_PX = 7.0


def pen(colour: QColor | str, width: float, *, is_dashed: bool = False) -> QPen:
    """A pen with flat ends, so that dashes keep their length."""
    one = QPen(QColor(colour), width)
    one.setCapStyle(Qt.PenCapStyle.FlatCap)
    if is_dashed:
        one.setDashPattern([4, 3])
    return one


def mixed(one: QColor | str, other: QColor | str, share: float) -> QColor:
    """`share` of `other`, the rest of `one`."""
    ends = zip(QColor(one).getRgb()[:3], QColor(other).getRgb()[:3], strict=True)  # type: ignore[index]
    return QColor(*(round(first + (last - first) * share) for first, last in ends))


def hatch(painter: QPainter, outline: QPainterPath, colour: QColor | str) -> None:
    """Fill an outline with thin diagonals: the shape of "unknown"."""
    painter.save()
    painter.setClipPath(outline, Qt.ClipOperation.IntersectClip)
    box = outline.boundingRect()
    painter.setPen(QPen(QColor(colour), 1))
    count = int((box.width() + box.height()) / _HATCH_PX) + 1
    painter.drawLines(
        [
            QLineF(box.left() + n * _HATCH_PX, box.top(), box.left() + n * _HATCH_PX - box.height(), box.bottom())
            for n in range(1, count)
        ]
    )
    painter.restore()


def unknown_box(painter: QPainter, theme: Theme, box: QRectF, word: str, font: QFont) -> None:
    """A dashed, hatched box with a word in its middle on clear ground."""
    outline = QPainterPath()
    outline.addRoundedRect(box.adjusted(1, 1, -1, -1), 6, 6)
    hatch(painter, outline, theme.muted if theme.line_px > 1 else theme.divider)
    painter.setPen(pen(theme.border, theme.border_px, is_dashed=True))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPath(outline)
    cleared_word(painter, theme, box, word, font)


def cleared_word(painter: QPainter, theme: Theme, box: QRectF, word: str, font: QFont) -> None:
    """A word in the middle of a box, on ground that makes it readable over anything."""
    metrics = QFontMetricsF(font)
    ground = QRectF(0, 0, metrics.horizontalAdvance(word) + 10, metrics.height() + 2)
    ground.moveCenter(box.center())
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(theme.surface))
    painter.drawRoundedRect(ground, 4, 4)
    painter.setPen(QColor(theme.text))
    painter.setFont(font)
    painter.drawText(ground, Qt.AlignmentFlag.AlignCenter, word)
