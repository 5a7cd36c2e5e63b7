"""Base of widgets that paint themselves, and the shapes they share."""

from enum import Enum
from typing import ClassVar

from PySide6.QtCore import QEvent, QLineF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QWidget

from ui.style.accessible_roles import Spoken
from ui.style.theme import Theme, current


class Freshness(Enum):
    """How a value is known."""

    FRESH = "fresh"
    STALE = "stale"
    UNKNOWN = "unknown"


class PaintedWidget(Spoken, QWidget):
    """A widget that paints itself: it measures and repaints after a change of theme."""

    accessible_role: ClassVar = QAccessible.Role.StaticText
    """See `ui.style.accessible_roles`."""
    usual: ClassVar = QSize()
    """Its size hint, where that does not depend on what it shows."""
    least: ClassVar = QSize()
    """Its minimum size hint; without one it is the size hint."""

    def sizeHint(self) -> QSize:
        return QSize(self.usual)

    def minimumSizeHint(self) -> QSize:
        return QSize(self.least) if self.least.isValid() else self.sizeHint()

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self.updateGeometry()
            self.update()
        super().changeEvent(event)

    def use_card_background(self) -> None:
        """Paint the surface of a card too: else all that lies below would be painted with each change."""
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)

    def begin_paint(self) -> QPainter:
        """A smooth painter for `paintEvent`, on the surface where the widget lies on one."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.testAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent):
            painter.fillRect(self.rect(), QColor(current().surface))
        return painter

    def announce(self, text: str, *, name: str = "") -> None:
        """Lets screen readers say `text`, see `Spoken.say`, and paints again."""
        self.say(text, name=name)
        self.update()


_HATCH_PX = 7.0


def pen(colour: QColor | str, width: float, *, is_dashed: bool = False) -> QPen:
    """A pen with flat ends, so that dashes keep their length."""
    flat_pen = QPen(QColor(colour), width)
    flat_pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    if is_dashed:
        flat_pen.setDashPattern([4, 3])
    return flat_pen


def mixed(colour: QColor | str, other: QColor | str, share: float) -> QColor:
    """`share` of `other`, the rest of `colour`."""
    ends = zip(QColor(colour).getRgb()[:3], QColor(other).getRgb()[:3], strict=True)  # type: ignore[index]
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
