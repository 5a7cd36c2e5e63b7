"""Spotlight and text card of the tour.

Neither is in the way: the light lets every click through, the card stays off the top bar, and what has the focus keeps
it until the person goes to the next step.
"""

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QPoint, QRect, QRectF, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QAccessibleEvent,
    QColor,
    QKeyEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
)
from PySide6.QtWidgets import QFrame, QPushButton, QSizePolicy, QWidget

from ui.core.texts import Texts
from ui.style.theme import Space, current
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.naming import named

CARD_PX: Final = 360
_RING_PX: Final = 3
_MARGIN_PX: Final = 4
_ROUND_PX: Final = 8
_SHADE_LIGHT: Final = 64
_SHADE_DARK: Final = 90


class Spotlight(QWidget):
    """Shades its parent but for `spots`, and rings them. For the eye only."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("tour_light")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.spots: tuple[QRect, ...] = ()
        self._bright = QRect()

    def show_spots(self, spots: Sequence[QRect], *, bright: QRect) -> None:
        """Of this widget's own coordinates; `bright` is never shaded."""
        shown = tuple(one.adjusted(-_MARGIN_PX, -_MARGIN_PX, _MARGIN_PX, _MARGIN_PX) for one in spots)
        if (shown, bright) != (self.spots, self._bright):
            self.spots, self._bright = shown, bright
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        shade, rings = QPainterPath(), QPainterPath()
        shade.addRect(QRectF(self.rect()))
        for spot in self.spots:
            rings.addRoundedRect(QRectF(spot), _ROUND_PX, _ROUND_PX)
        bright = QPainterPath()
        bright.addRect(QRectF(self._bright))
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillPath(
            shade.subtracted(rings.simplified()).subtracted(bright),
            QColor(0, 0, 0, _SHADE_DARK if theme.is_dark else _SHADE_LIGHT),
        )
        painter.setPen(QPen(QColor(theme.information.ink), _RING_PX))
        painter.drawPath(rings)
        painter.end()


class _Way(QPushButton):
    """Leaves the arrows to the card; a button would move the focus with them."""

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            event.ignore()
        else:
            super().keyPressEvent(event)


class TourCard(QFrame):
    """The words of a step and its buttons. Enter does what the main button says, arrows go on and back, Esc ends."""

    main_wanted = Signal()
    next_wanted = Signal()
    back_wanted = Signal()
    end_wanted = Signal()

    def __init__(self, texts: Texts, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("tour_card")
        self.setFixedWidth(CARD_PX)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.count = text_label("tour_count", "caption")
        self.title = text_label("tour_title", "title")
        self.text = text_label("tour_text", "")
        self.main = named(_Way(), "tour_main", "primary")
        self.main.clicked.connect(self.main_wanted)
        self.next = control(_Way(), texts, "tour_next", "Next", says="Next step of the tour",
                            tip="On to the next step (arrow right)", slot=self.next_wanted)  # fmt: skip
        self.back = control(_Way(), texts, "tour_back", "Back", says="Back to the step before",
                            tip="Back to the step before (arrow left)", slot=self.back_wanted)  # fmt: skip
        self.end = control(_Way(), texts, "tour_end", "End the tour", role="quiet",
                           tip="End the tour; everything is as it was before (Esc)", slot=self.end_wanted)  # fmt: skip
        self._lay_out()

    def show_words(self, count: str, title: str, text: str, *, main: str) -> None:
        """`main`: what the main button says, empty where there is nothing to do but to go on."""
        if (count, title, text, main) == (self.count.text(), self.title.text(), self.text.text(), self.main.text()):
            return
        had_focus = any(one.hasFocus() for one in (self, self.main, self.next))
        self.count.setText(count)
        self.title.setText(title)
        self.text.setText(text)
        self.main.setText(main)
        self.main.setAccessibleName(main)
        self.main.setToolTip(main)
        self.main.setVisible(bool(main))
        self._give_role(self.next, "" if main else "primary")
        self.setAccessibleName(f"{count}. {title}")
        self.setAccessibleDescription(text)
        self.text.setAccessibleName(text)
        layout = self.layout()
        if layout is not None:
            layout.activate()
            self.resize(CARD_PX, layout.totalHeightForWidth(CARD_PX))
        if had_focus:
            self.take_focus()
        QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.Alert))

    def take_focus(self) -> None:
        """For the keyboard: what goes on is at hand."""
        ways_on = (self.main, self.next)
        next((one for one in ways_on if not one.isHidden() and one.isEnabled()), self).setFocus()

    def place(self, area: QRect, spots: Sequence[QRect]) -> None:
        """Beside the spots where there is room in `area`, else at its lower right corner."""
        self.move(_place(self.size().width(), self.size().height(), area, spots))

    @staticmethod
    def _give_role(button: QPushButton, role: str) -> None:
        if button.property("role") != role:
            button.setProperty("role", role)
            button.style().unpolish(button)
            button.style().polish(button)

    def _lay_out(self) -> None:
        self.text.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.MinimumExpanding)
        for label in (self.count, self.title, self.text):
            label.setTextInteractionFlags(Qt.TextInteractionFlag.NoTextInteraction)
        feet = in_row(self.end, 1, self.back, self.next, spacing=Space.S)
        in_column(
            self.count, self.title, self.text, self.main, feet, of=self, spacing=Space.S, margins=(Space.L, Space.M)
        )
        for one, other in ((self.main, self.next), (self.next, self.back), (self.back, self.end)):
            QWidget.setTabOrder(one, other)

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        match event.key():
            case Qt.Key.Key_Escape:
                self.end_wanted.emit()
            case Qt.Key.Key_Right:
                self.next_wanted.emit()
            case Qt.Key.Key_Left:
                self.back_wanted.emit()
            case Qt.Key.Key_Return | Qt.Key.Key_Enter:
                self._enter()
            case _:
                super().keyPressEvent(event)

    def _enter(self) -> None:
        """The button with the focus, as anywhere else; from the card itself the main one, or on."""
        buttons = (self.main, self.next, self.back, self.end)
        focused = next((one for one in buttons if one.hasFocus()), None)
        default = self.next if self.main.isHidden() else self.main
        (focused or default).click()

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.information.ink), 2))
        painter.setBrush(QColor(theme.surface))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), _ROUND_PX, _ROUND_PX)
        painter.end()


def _place(width: int, height: int, area: QRect, spots: Sequence[QRect]) -> QPoint:
    inner = area.adjusted(Space.S, Space.S, -Space.S, -Space.S)
    corner = QPoint(inner.right() - width, inner.bottom() - height)
    if not spots:
        return corner
    around = QRect(spots[0])
    for spot in spots[1:]:
        around = around.united(spot)
    gap = Space.M
    middle_y, middle_x = around.center().y() - height // 2, around.center().x() - width // 2
    for wanted in (
        QPoint(around.right() + gap, middle_y),
        QPoint(around.left() - gap - width, middle_y),
        QPoint(middle_x, around.bottom() + gap),
        QPoint(middle_x, around.top() - gap - height),
        corner,
        QPoint(inner.left(), inner.bottom() - height),
    ):
        x = min(max(wanted.x(), inner.left()), inner.right() - width)
        y = min(max(wanted.y(), inner.top()), inner.bottom() - height)
        if not any(QRect(x, y, width, height).intersects(spot) for spot in spots):
            return QPoint(x, y)
    return corner
