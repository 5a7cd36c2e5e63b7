"""Number and name of one step of a multi-step act, as a heading above its buttons."""

from enum import Enum

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPaintEvent
from PySide6.QtWidgets import QSizePolicy

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style import icons
from ui.style.icons import Icon
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, Space, current, font, scaled
from ui.widgets.controls import named

_CIRCLE_PX = 20


class StepPlace(Enum):
    LATER = "later"
    NOW = "now"
    DONE = "done"


class StepMark(PaintedWidget):
    """A circle with the number, or a check mark, and the name of the step. `english` is translated."""

    def __init__(self, name: str, texts: Texts, number: int, english: str) -> None:
        super().__init__()
        named(self, name)
        self._number, self._text = number, ""
        self._place, self._meaning = StepPlace.LATER, Meaning.DANGER
        self.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Fixed)
        texts.bind(self._name, english)

    def show_place(self, place: StepPlace, meaning: Meaning) -> None:
        """`meaning`: colour of the current step."""
        if (place, meaning) != (self._place, self._meaning):
            self._place, self._meaning = place, meaning
            self._announce()

    def _name(self, text: str) -> None:
        self._text = text
        self._announce()
        self.updateGeometry()

    def _announce(self) -> None:
        states = {StepPlace.LATER: "", StepPlace.NOW: tr("now"), StepPlace.DONE: tr("done")}
        parts = (tr("Step {number}: {name}", number=self._number, name=self._text), states[self._place])
        self.announce(", ".join(part for part in parts if part))

    def sizeHint(self) -> QSize:
        metrics = QFontMetricsF(font(Size.SMALL, is_bold=True))
        circle_px = scaled(_CIRCLE_PX)
        return QSize(round(circle_px + Space.S + metrics.horizontalAdvance(self._text)) + 4, circle_px + 2)

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, is_now = current(), self._place is StepPlace.NOW
        tint = theme.tint(self._meaning)
        painter = self.begin_paint()
        circle_px = scaled(_CIRCLE_PX)
        circle = QRectF(1, (self.height() - circle_px) / 2, circle_px, circle_px).adjusted(1, 1, -1, -1)
        painter.setPen(pen(tint.fill if is_now else theme.muted, theme.border_px))
        painter.setBrush(QColor(tint.fill) if is_now else Qt.BrushStyle.NoBrush)
        painter.drawEllipse(circle)
        painter.setFont(font(Size.SMALL, is_bold=True))
        if self._place is StepPlace.DONE:
            icons.draw(painter, Icon.CHECK, circle.adjusted(3, 3, -3, -3), QColor(theme.text))
        else:
            painter.setPen(QColor(tint.on_fill if is_now else theme.muted))
            painter.drawText(circle, Qt.AlignmentFlag.AlignCenter, str(self._number))
        metrics = QFontMetricsF(painter.font())
        base = (self.height() - metrics.height()) / 2 + metrics.ascent()
        painter.setPen(QColor(theme.muted if self._place is StepPlace.LATER else theme.text))
        painter.drawText(QPointF(circle.right() + Space.S - 2, base), self._text)
        painter.end()
