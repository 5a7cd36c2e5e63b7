"""The button that has to be held: tells presses and releases apart, by mouse or keyboard, and repeats from presses."""

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QPushButton, QStyle, QStyleOptionButton, QStylePainter

from ui.theme import current

_SMALLEST = QSize(180, 44)
_KEYS = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter)


class HoldButton(QPushButton):
    """Never emits `clicked`. `share` (0 … 1) is how much of the hold is done; it fills the button."""

    pressed_down = Signal(bool, bool)
    """Is it an auto-repeat; is it the second press of a double click."""
    let_go = Signal()
    """Released, or the pointer or the focus left it."""

    def __init__(self) -> None:
        super().__init__()
        self._share = 0.0
        self.setProperty("role", "danger")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAutoDefault(False)

    def show_share(self, share: float) -> None:
        if share != self._share:
            self._share = share
            self.setDown(share > 0)
            self.update()

    def sizeHint(self) -> QSize:
        """Large enough for a gloved finger on a touch pad; the style sheet's own height is that of any button."""
        return QSize(max(_SMALLEST.width(), super().sizeHint().width()), _SMALLEST.height())

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()

    # By mouse

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if event.button() is Qt.MouseButton.LeftButton:
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            self.pressed_down.emit(False, False)
        else:
            self.let_go.emit()  # another button in the middle of a hold is no steady hand

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.pressed_down.emit(False, True)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if not self.rect().contains(event.position().toPoint()):
            self.let_go.emit()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.let_go.emit()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.let_go.emit()

    # By keyboard

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in _KEYS:
            event.accept()
            self.pressed_down.emit(event.isAutoRepeat(), False)
        else:
            event.ignore()  # Esc and Tab are the widget's around it

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if event.key() in _KEYS:
            event.accept()
            if not event.isAutoRepeat():  # X11 tells a repeat as a release and a press
                self.let_go.emit()
        else:
            event.ignore()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.let_go.emit()

    def paintEvent(self, _event: QPaintEvent) -> None:
        option = QStyleOptionButton()
        self.initStyleOption(option)
        option.state &= ~QStyle.StateFlag.State_Sunken
        painter = QStylePainter(self)
        painter.drawControl(QStyle.ControlElement.CE_PushButton, option)
        if self._share > 0:
            self._paint_share(painter)
        painter.end()

    def _paint_share(self, painter: QPainter) -> None:
        danger = current().danger
        outline = QPainterPath()
        outline.addRoundedRect(QRectF(self.rect()).adjusted(2, 2, -2, -2), 5, 5)
        painter.setClipPath(outline)
        done = QRectF(0, 0, self.width() * self._share, self.height())
        painter.fillRect(done, QColor(danger.fill))
        painter.setClipRect(done, Qt.ClipOperation.IntersectClip)
        painter.setPen(QColor(danger.on_fill))
        painter.setFont(self.font())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.text())
