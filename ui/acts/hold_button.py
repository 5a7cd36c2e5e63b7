"""Button that must be held, by mouse or keyboard; ignores auto-repeat."""

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QStyle, QStylePainter

from ui.style.theme import current
from ui.widgets.gestures import PRESS_KEYS
from ui.widgets.step_button import StepButton

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
