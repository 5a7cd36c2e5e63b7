"""Button for one step of a multi-step act, which accepts only deliberate presses.

It is dead for half a second after it appeared, to the pointer until the pointer moved onto it, and to the keyboard
until all keys were released. The second press of a double click never counts. A press is cancelled when the pointer
leaves the button, or when a second key or mouse button is pressed; only the release of the same key or button completes
it. While hidden it keeps its place in the layout, so that two steps of an act never share a place.
"""

from collections.abc import Callable
from math import ceil
from typing import Final

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent, QMouseEvent, QPaintEvent, QShowEvent
from PySide6.QtWidgets import QApplication, QPushButton, QScrollArea, QStyle, QStyleOptionButton, QStylePainter, QWidget
from shiboken6 import isValid

from ui.widgets.gestures import PRESS_KEYS, application, gestures

DEAD_FOR_S: Final = 0.5


class StepButton(QPushButton):
    """`is_safe` (Cancel, the steps of a guided test): keeps its place, but is never dead; a double click is one."""

    chosen = Signal()  # A press that counted. `clicked` may also come from assistive technology, at any time.

    def __init__(self, text: str = "", *, is_safe: bool = False) -> None:
        super().__init__(text)
        self._is_safe = is_safe
        self._gestures = gestures()
        self.appeared_at = 0.0  # When it became visible or enabled, or moved, by the clock of `gestures`
        self._place = QRect()
        self._is_pointer_blocked = False
        self._is_key_blocked = False
        self._is_pressed = False  # Pressed by a press that counts
        self._key = 0  # The key that pressed it; 0: the mouse
        policy = self.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.setSizePolicy(policy)
        self.setAutoDefault(False)
        self._live_timer = QTimer(self, singleShot=True, timerType=Qt.TimerType.PreciseTimer)
        self._live_timer.timeout.connect(self._show_live)
        self.clicked.connect(self._on_clicked)

    @property
    def is_live(self) -> bool:
        """Whether it has been visible and enabled for long enough."""
        is_there = self.isVisible() and self.isEnabled()
        return is_there and (self._is_safe or self._gestures.clock() - self.appeared_at >= DEAD_FOR_S)

    @property
    def takes_pointer(self) -> bool:
        """Whether a mouse press counts now."""
        return self.is_live and (self._is_safe or not self._is_pointer_blocked)

    @property
    def takes_keys(self) -> bool:
        """Whether a key press counts now."""
        return self.is_live and (self._is_safe or not self._is_key_blocked)

    def appear(self) -> None:
        """It became visible or enabled, or moved: a press in progress does not count."""
        self._place = self._place_now()
        self.appeared_at = self._gestures.clock()
        self._is_pointer_blocked = False
        self._is_key_blocked = self._gestures.has_key_down
        self._gestures.ignore_until_reentered(self)
        self.cancel_press()
        if not self._is_safe:
            self._show_live()

    def _show_live(self) -> None:
        """Repaints when it becomes live; a timer that ends early is started again."""
        left_s = self.appeared_at + DEAD_FOR_S - self._gestures.clock()
        if left_s > 0:
            self._live_timer.start(ceil(left_s * 1000))
        self.update()

    def cancel_press(self) -> None:
        self._is_pressed = False
        self.setDown(False)

    def check_place(self) -> None:
        if self.isVisible() and self._place != self._place_now():
            self.appear()

    def block_pointer(self) -> None:
        """It appeared under the pointer."""
        self._is_pointer_blocked = True
        self.cancel_press()
        self.update()

    def unblock_pointer(self) -> None:
        """The pointer left it."""
        self._is_pointer_blocked = False
        self.update()

    def unblock_keys(self) -> None:
        """No key is down."""
        self._is_key_blocked = False

    def _place_now(self) -> QRect:
        return QRect(self.mapToGlobal(QPoint(0, 0)), self.size())

    def _on_clicked(self) -> None:
        is_pressed, self._is_pressed = self._is_pressed, False
        if is_pressed or self.is_live:
            self.chosen.emit()

    # Clear the focus: Qt would give it to the next button, which may be dangerous too.

    def setEnabled(self, is_enabled: bool) -> None:
        if not is_enabled and self.hasFocus():
            self.clearFocus()
        super().setEnabled(is_enabled)

    def setVisible(self, is_visible: bool) -> None:
        if not is_visible and self.hasFocus():
            self.clearFocus()
        super().setVisible(is_visible)

    # Qt

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._gestures.add(self)
        self.appear()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._gestures.remove(self)
        self._live_timer.stop()
        self.cancel_press()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.EnabledChange and self.isEnabled() and self.isVisible():
            self.appear()

    def counts(self, event: QMouseEvent) -> bool:
        """Whether this mouse press counts."""
        self.check_place()
        self._gestures.on_pointer(event.globalPosition())
        is_single_left = event.button() is Qt.MouseButton.LeftButton and event.type() != QEvent.Type.MouseButtonDblClick
        return self.takes_pointer and is_single_left

    @property
    def _is_held_down(self) -> bool:
        """A press is in progress, which another one would cancel."""
        return self.isDown() and not self._is_safe

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if self._is_held_down:
            self.cancel_press()
        elif self.counts(event):
            self._is_pressed, self._key = True, 0
            super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()
        if self._is_held_down:
            self.cancel_press()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        # Without Qt, which would press it again when the pointer comes back.
        event.accept()
        if self._is_safe:
            super().mouseMoveEvent(event)
        elif not self._key and not self.rect().contains(event.position().toPoint()):
            self.cancel_press()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self.check_place()
        if self._is_held_down and self._key:
            event.accept()
        else:
            super().mouseReleaseEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        self.check_place()
        if event.key() not in PRESS_KEYS:
            super().keyPressEvent(event)
        elif self._is_held_down:
            if not event.isAutoRepeat():
                self.cancel_press()
        elif self.takes_keys:
            self._key = event.key()
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        # Qt completes a click with the release of any of these keys.
        if event.key() not in PRESS_KEYS or not self._is_held_down or event.key() == self._key:
            super().keyReleaseEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QStylePainter(self)
        painter.drawControl(QStyle.ControlElement.CE_PushButton, self._option())
        painter.end()

    def _option(self) -> QStyleOptionButton:
        """Draws a dead button as disabled."""
        option = QStyleOptionButton()
        self.initStyleOption(option)
        if not self.takes_pointer:
            option.state &= ~QStyle.StateFlag.State_Enabled
        return option


def is_in_sight(widget: QWidget) -> bool:
    """Whether all of it is visible: not scrolled away, cut off or covered."""
    return widget.isVisible() and widget.visibleRegion().boundingRect().contains(widget.rect())


def bring_into_sight(widget: QWidget) -> None:
    """Scrolls all scroll areas around it."""
    above = widget.parentWidget()
    while above is not None:
        if isinstance(above, QScrollArea):
            above.ensureWidgetVisible(widget)
        above = above.parentWidget()


def leave_focus(widget: QWidget) -> None:
    """Clears the focus if it is in `widget`."""
    focused = QApplication.focusWidget()
    if focused is not None and (focused is widget or widget.isAncestorOf(focused)):
        focused.clearFocus()


class FocusBack(QObject):
    """Of a part of a window that comes and goes: remembers where the focus was before it came into `part`."""

    def __init__(self, part: QWidget) -> None:
        super().__init__(part)
        self._part = part
        self._before: QWidget | None = None
        application().focusChanged.connect(self._on_focus_changed)

    def _on_focus_changed(self, old: QWidget | None, now: QWidget | None) -> None:
        if now is not None and self._part.isAncestorOf(now) and (old is None or not self._part.isAncestorOf(old)):
            self._before = old

    def leave(self, hide: Callable[[], None]) -> None:
        """Calls `hide`, and gives the focus back if it was in the part."""
        focused = QApplication.focusWidget()
        was_in = focused is not None and self._part.isAncestorOf(focused)
        hide()
        if was_in:
            self.give()

    def give(self) -> None:
        """Back to where it was, but never to a step of an act."""
        before, self._before = self._before, None
        if before is not None and isValid(before) and not isinstance(before, StepButton):
            before.setFocus()
