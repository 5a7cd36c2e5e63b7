"""Two ways to mean an act: asked and confirmed in two steps, or held."""

from math import ceil
from typing import Final

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QHideEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QStyle, QStylePainter, QWidget

from app.text.i18n import tr
from ui.style.theme import Space, current, is_text_large
from ui.widgets.controls import TickingLabel, control, in_column, in_row, named, retain_size
from ui.widgets.gestures import PRESS_KEYS, gestures
from ui.widgets.step_button import StepButton, bring_into_sight, is_in_sight, leave_focus

# An unanswered question is withdrawn after this time.
ASKS_FOR_S: Final = 10.0
CHECK_EVERY_MS: Final = 100


class Confirm(QWidget):
    """`confirmed` is emitted once for a question."""

    asked = Signal()
    confirmed = Signal()
    cancelled = Signal()

    def __init__(self, name: str, *, ask: str, go: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_confirm")
        self.is_asking = False
        self.ask = control(StepButton(tr(ask)), f"{name}_ask", slot=self._ask)
        self.go = control(
            StepButton(tr(go)),
            f"{name}_go",
            role="danger",
            slot=self._go,
        )
        self.cancel = control(
            StepButton(tr("Cancel"), is_safe=True),
            f"{name}_cancel",
            tip=tr("Nothing is sent."),
            key="Esc",
            slot=self.withdraw,
        )
        self.left = named(TickingLabel(), f"{name}_left", "small")
        self.left.setAccessibleName(tr("Withdrawn in"))
        # Its room is that of the longest time: the buttons beside it never move.
        self._show_left(ASKS_FOR_S)
        self.left.setMinimumWidth(self.left.sizeHint().width())
        retain_size(self.left)
        if is_text_large():  # there is no room for all in one row
            answers = in_row(1, self.go, self.cancel, spacing=Space.S)
            in_column(in_row(1, self.left, self.ask), answers, of=self, spacing=Space.S, margins=0)
        else:
            in_row(1, self.left, self.go, self.cancel, self.ask, of=self, spacing=Space.S, margins=0)
        self.setTabOrder(self.ask, self.cancel)
        self.setTabOrder(self.cancel, self.go)
        self._asked_at = 0.0
        self._timer = QTimer(self, interval=CHECK_EVERY_MS)
        self._timer.timeout.connect(self.check)
        self._show()

    def set_possible(self, is_possible: bool) -> None:
        """Enable or disable asking; disabling withdraws a question."""
        self.ask.setEnabled(is_possible)
        if not is_possible:
            self.withdraw()

    def withdraw(self) -> None:
        """Nothing is sent."""
        if self.is_asking:
            self._end()
            self.cancelled.emit()

    def check(self) -> None:
        """Withdraw a question that was not answered in time, or is no longer entirely visible."""
        if not self.is_asking:
            return
        left_s = self._asked_at + ASKS_FOR_S - gestures().clock()
        self._show_left(left_s)
        if left_s <= 0 or not is_in_sight(self):
            self.withdraw()

    def _show_left(self, left_s: float) -> None:
        self.left.setText(tr("{value} s", value=ceil(left_s)))

    def _ask(self) -> None:
        if not is_in_sight(self):
            bring_into_sight(self)
            return
        self.is_asking, self._asked_at = True, gestures().clock()
        self._timer.start()
        self._show_left(ASKS_FOR_S)
        self._show()
        self.cancel.setFocus()
        self.asked.emit()

    def _go(self) -> None:
        self.check()
        if self.is_asking:
            self._end()
            self.confirmed.emit()

    def _end(self) -> None:
        self.is_asking = False
        self._timer.stop()
        leave_focus(self)
        self._show()

    def _show(self) -> None:
        self.left.setVisible(self.is_asking)
        self.go.setVisible(self.is_asking)
        self.cancel.setVisible(self.is_asking)
        self.ask.setVisible(not self.is_asking)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_asking:
            self.withdraw()
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if not self.isVisible():
            self.withdraw()


_SMALLEST = QSize(180, 44)


class HoldButton(StepButton):
    """Never emits `clicked`. `share` (0 … 1) is how much of the hold is done; it fills the button."""

    hold_started = Signal()
    """A valid press has begun."""
    hold_ended = Signal()
    """Released, or the pointer left, or something else was pressed."""

    def __init__(self, *texts: str) -> None:
        """With room for the longest of these texts, so that the size never changes."""
        super().__init__()
        self._share = 0.0
        self._held_by_key = False
        self._texts = texts
        self.setProperty("role", "danger")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def show_share(self, share: float) -> None:
        if share != self._share:
            self._share = share
            self.update()

    def cancel_press(self) -> None:
        was_held = self._is_pressed
        super().cancel_press()
        if was_held:
            self.hold_ended.emit()

    def sizeHint(self) -> QSize:
        """Large enough for a gloved finger."""
        hint, metrics = super().sizeHint(), self.fontMetrics()
        longest = max((metrics.horizontalAdvance(text) for text in self._texts), default=0)
        width = hint.width() - metrics.horizontalAdvance(self.text()) + longest
        return QSize(max(_SMALLEST.width(), width), _SMALLEST.height()).expandedTo(hint)

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()

    # By mouse

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if event.button() is not Qt.MouseButton.LeftButton or self._is_pressed:
            self.cancel_press()  # another button during a hold
        elif self.counts(event):
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            self._hold(by_key=False)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if not self.rect().contains(event.position().toPoint()):
            self.cancel_press()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.cancel_press()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        if not self._held_by_key:
            self.cancel_press()

    # By keyboard

    def keyPressEvent(self, event: QKeyEvent) -> None:
        self.check_place()
        if event.key() not in PRESS_KEYS:
            event.ignore()  # Esc and Tab are the widget's around it
            return
        event.accept()
        if event.isAutoRepeat():
            return
        if self._is_pressed:
            self.cancel_press()
        elif self.takes_keys:
            self._hold(by_key=True)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if event.key() in PRESS_KEYS:
            event.accept()
            if not event.isAutoRepeat():
                self.cancel_press()
        else:
            event.ignore()

    def _hold(self, *, by_key: bool) -> None:
        self._is_pressed, self._held_by_key = True, by_key
        self.setDown(True)
        self.hold_started.emit()

    def paintEvent(self, _event: QPaintEvent) -> None:
        option = self._option()
        option.state &= ~QStyle.StateFlag.State_Sunken
        painter = QStylePainter(self)
        painter.drawControl(QStyle.ControlElement.CE_PushButton, option)
        if self._share > 0:
            self._paint_share(painter)
        painter.end()

    def _paint_share(self, painter: QPainter) -> None:
        tint = current().danger if self.property("role") == "danger" else current().information
        outline = QPainterPath()
        outline.addRoundedRect(QRectF(self.rect()).adjusted(2, 2, -2, -2), 5, 5)
        painter.setClipPath(outline)
        done = QRectF(0, 0, self.width() * self._share, self.height())
        painter.fillRect(done, QColor(tint.fill))
        painter.setClipRect(done, Qt.ClipOperation.IntersectClip)
        painter.setPen(QColor(tint.on_fill))
        painter.setFont(self.font())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.text())
