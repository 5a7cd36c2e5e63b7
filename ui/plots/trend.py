"""Small trend chart of one measured value over all checks."""

from collections.abc import Sequence
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF, QPaintEvent, QPolygonF
from PySide6.QtWidgets import QSizePolicy

from app.records.check_store import Point
from app.text.i18n import tr
from ui.style.painted_widget import PaintedWidget
from ui.style.shapes import pen
from ui.style.theme import Size, Space, current, font

_DOT_PX: Final = 3.5
_MAX_POINTS: Final = 200
"""Only the last ones: more could not be distinguished."""


class Trend(PaintedWidget):
    """Equal distances between the checks, since days or minutes may lie between them."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    usual: ClassVar = QSize(240, 96)
    least: ClassVar = QSize(160, 88)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self._title, self._unit, self._decimals = "", "", 0
        self.points: tuple[Point, ...] = ()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_points(self, title: str, unit: str, points: Sequence[Point], *, decimals: int) -> None:
        """`points` from the oldest to the newest."""
        self._title, self._unit, self._decimals = title, unit, decimals
        self.points = tuple(points[-_MAX_POINTS:])
        if self.points:
            values = [one.value for one in self.points]
            text = tr(
                "{title}: {low} to {high}, last {last}; checks: {count}",
                title=title,
                count=len(values),
                low=self._shown(min(values)),
                high=self._shown(max(values)),
                last=self._shown(values[-1]),
            )
        else:
            text = tr("{setting}: {what}", setting=title, what=tr("not measured yet"))
        self.setToolTip(text)
        self.announce(text)

    def _shown(self, value: float) -> str:
        gap = "" if self._unit in ("°", "") else " "
        return f"{value:.{self._decimals}f}{gap}{self._unit}"

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        small = font(Size.SMALL)
        metrics = QFontMetricsF(small)
        painter.setFont(small)
        painter.setPen(QColor(theme.muted))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        head = QRectF(0, 0, self.width(), metrics.height() + 2)
        painter.drawText(head, left, self._title)
        if not self.points:
            painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignCenter, tr("not measured yet"))
            painter.end()
            return
        values = [one.value for one in self.points]
        low, high = min(values), max(values)
        painter.setPen(QColor(theme.text))
        painter.setFont(font(Size.SMALL, is_bold=True))
        painter.drawText(head, right, self._shown(values[-1]))
        painter.setFont(small)
        gutter = max(metrics.horizontalAdvance(self._shown(value)) for value in (low, high)) + Space.L
        plot = QRectF(gutter, head.bottom() + 8, self.width() - gutter - 8, self.height() - head.bottom() - 18)
        painter.setPen(QColor(theme.muted))
        if high > low:
            painter.drawText(QRectF(0, plot.top() - 8, gutter - Space.S - 2, 16), right, self._shown(high))
            painter.drawText(QRectF(0, plot.bottom() - 8, gutter - Space.S - 2, 16), right, self._shown(low))
        else:
            painter.drawText(QRectF(0, plot.center().y() - 8, gutter - Space.S - 2, 16), right, self._shown(low))
        painter.setPen(pen(theme.divider if theme.border_px == 1 else theme.muted, 1.0))
        painter.drawLine(plot.bottomLeft(), plot.bottomRight())
        step = plot.width() / max(1, len(values) - 1)
        span = high - low
        places = [
            QPointF(
                plot.right() if len(values) == 1 else plot.left() + step * number,
                plot.center().y() if not span else plot.bottom() - (value - low) / span * plot.height(),
            )
            for number, value in enumerate(values)
        ]
        colour = QColor(theme.curves[0])
        painter.setPen(pen(colour, theme.line_px + 0.5))
        painter.drawPolyline(QPolygonF(places))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colour)
        for place in places:
            painter.drawEllipse(place, _DOT_PX, _DOT_PX)
        painter.end()
