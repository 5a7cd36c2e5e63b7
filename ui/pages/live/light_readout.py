"""Light voltage with a bar that shows its distance from the threshold for an open bay."""

from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent

from ui.style.painted_widget import Freshness
from ui.style.shapes import pen
from ui.style.theme import Space, current
from ui.widgets.readout import Readout

BAR_PX: Final = 64
_BAR_HEIGHT_PX: Final = 10


class LightReadout(Readout):
    """A readout with a bar beside its note, whose middle is the threshold."""

    def __init__(self) -> None:
        super().__init__("", unit="V", template="0.0")
        self._light_v: float | None = None
        self._threshold_v: float | None = None
        self._is_limit_stale = False

    def show_bar(self, light_v: float | None, threshold_v: float | None, *, is_limit_stale: bool) -> None:
        """Sets the bar; None: not known. Without a threshold there is no bar."""
        shown = light_v, threshold_v, is_limit_stale
        if shown != (self._light_v, self._threshold_v, self._is_limit_stale):
            self._light_v, self._threshold_v, self._is_limit_stale = shown
            self.update()

    def sizeHint(self) -> QSize:
        hint = super().sizeHint()
        return QSize(max(hint.width(), round(self._note_px()) + Space.S + BAR_PX), hint.height())

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self._threshold_v or self._light_v is None:
            return
        theme = current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        is_dim = self._is_limit_stale or self.freshness is Freshness.STALE
        bar = QRectF(0, 0, BAR_PX, _BAR_HEIGHT_PX)
        bar.moveCenter(QPointF(self._note_px() + Space.S + BAR_PX / 2, self._note_room().center().y()))
        painter.setPen(pen(theme.muted if is_dim else theme.border, theme.border_px))
        painter.setBrush(QColor(theme.sunken))
        painter.drawRoundedRect(bar, 3, 3)
        part = min(1.0, self._light_v / (2 * self._threshold_v))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.muted) if is_dim else theme.ink(self.meaning))
        painter.drawRoundedRect(QRectF(bar.left(), bar.top(), bar.width() * part, bar.height()), 3, 3)
        painter.setPen(pen(theme.muted if is_dim else theme.attention.ink, 1 + theme.line_px))
        middle = bar.center().x()
        painter.drawLine(QPointF(middle, bar.top() - 4), QPointF(middle, bar.bottom() + 4))
        painter.end()
