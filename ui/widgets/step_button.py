"""Button for one step of a multi-step act, which accepts only deliberate presses, and what tells those from accidents.

It is dead for half a second after it appeared, to the pointer until the pointer moved onto it, and to the keyboard
until all keys were released: one that appeared under an unmoved pointer (shown, scrolled, moved by a layout, uncovered)
is blocked until the pointer leaves it. The second press of a double click never counts. A press is cancelled when the
pointer leaves the button, or when a second key or mouse button is pressed; only the release of the same key or button
completes it. While hidden it keeps its place in the layout, so that two steps of an act never share a place.
"""

import time
from collections.abc import Callable
from functools import cache
from math import ceil
from typing import Final
from weakref import WeakSet

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QEnterEvent, QGuiApplication, QHideEvent, QKeyEvent, QMouseEvent, QShowEvent, QWindow
from PySide6.QtWidgets import QApplication, QPushButton, QScrollArea, QStyleOptionButton, QWidget
from shiboken6 import isValid

# Keys that press a button.
PRESS_KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Select, Qt.Key.Key_Return, Qt.Key.Key_Enter)
# X11 reports an auto-repeat as a release and a press with equal timestamps, which Qt detects only if both arrived.
REPEATS_WITHIN_MS: Final = 50
DEAD_FOR_S: Final = 0.5
_POINTER: Final = (
    QEvent.Type.MouseMove,
    QEvent.Type.MouseButtonPress,
    QEvent.Type.MouseButtonDblClick,
    QEvent.Type.MouseButtonRelease,
)


class Gestures(QObject):
    """The application's, from `gestures()`. Filters the events of every window with a visible step."""

    def __init__(self, application: QApplication) -> None:
        super().__init__(application)
        self.clock: Callable[[], float] = time.monotonic  # Monotonic seconds
        self.has_paired_repeats = QGuiApplication.platformName() == "xcb"
        self._steps: WeakSet[StepButton] = WeakSet()  # The visible steps
        self._pointer: QPointF | None = None
        self._under: StepButton | None = None  # The step under the pointer
        self._keys: set[int] = set()  # Keys that are down
        self._ignored: set[int] = set()  # Keys still down after they completed an act
        # A release held back until it is certain that it is not an auto-repeat.
        self._release: tuple[QWindow, QKeyEvent] | None = None
        self._is_sending = False
        self._release_timer = QTimer(self, singleShot=True, interval=REPEATS_WITHIN_MS)
        self._release_timer.timeout.connect(self._send_release)
        application.focusWindowChanged.connect(self._on_focus_window)

    def add(self, step: "StepButton") -> None:
        self._steps.add(step)
        window = step.window()
        window.installEventFilter(self)
        handle = window.windowHandle()
        if handle is not None:
            handle.installEventFilter(self)

    def remove(self, step: "StepButton") -> None:
        self._steps.discard(step)
        self.ignore_until_reentered(step)

    def ignore_until_reentered(self, step: "StepButton") -> None:
        """`step` appeared or moved: if it is under the pointer now, the pointer did not move onto it."""
        if self._under is step:
            self._under = None

    @property
    def has_key_down(self) -> bool:
        return bool(self._keys)

    @property
    def is_release_uncertain(self) -> bool:
        """A key was released a moment ago, or it repeats."""
        return self._release is not None

    def ignore_keys_down(self) -> None:
        """Ignores the keys that are down now, in all windows, until they are released."""
        self._ignored |= self._keys.intersection(PRESS_KEYS)

    def on_pointer(self, position: QPointF, *, is_move: bool = True) -> None:
        """The pointer is at `position` (global); `is_move`: because it moved."""
        if self._pointer is not None:
            self._on_enter(self._find(self._pointer), is_move=False)
        self._pointer = QPointF(position)
        self._on_enter(self._find(position), is_move=is_move)

    def _on_enter(self, step: "StepButton | None", *, is_move: bool) -> None:
        left, self._under = self._under, step
        if left is step:
            return
        if left is not None:
            left.is_pointer_blocked = False
            left.update()
        if step is not None and not is_move:
            step.block_pointer()

    def _find(self, position: QPointF) -> "StepButton | None":
        """That in which it is, and which nothing covers there."""
        for step in self._steps:
            window = step.window()
            if step.isVisible() and window.childAt(window.mapFromGlobal(position).toPoint()) is step:
                return step
        return None

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind is QEvent.Type.UpdateRequest:  # before each frame that is painted
            for step in tuple(self._steps):
                step.check_place()
        elif isinstance(watched, QWindow) and not self._is_sending:
            if kind in _POINTER and isinstance(event, QMouseEvent):
                self.on_pointer(event.globalPosition())
            elif kind is QEvent.Type.Enter and isinstance(event, QEnterEvent):
                self.on_pointer(event.globalPosition(), is_move=False)
            elif kind is QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
                return self._on_key_press(watched, event)
            elif kind is QEvent.Type.KeyRelease and isinstance(event, QKeyEvent):
                return self._on_key_release(watched, event)
        return False

    def _on_key_press(self, window: QWindow, event: QKeyEvent) -> bool:
        """True stops the event."""
        if self._release is not None:
            released = self._release[1]
            if released.key() == event.key() and released.timestamp() == event.timestamp():
                self._release_timer.stop()
                self._release = None
                codes = event.nativeScanCode(), event.nativeVirtualKey(), event.nativeModifiers()
                text, count = event.text(), event.count()
                self._send(window, QKeyEvent(event.type(), event.key(), event.modifiers(), *codes, text, True, count))
                return True
            self._send_release()
        self._keys.add(event.key())
        return event.key() in self._ignored

    def _on_key_release(self, window: QWindow, event: QKeyEvent) -> bool:
        """True stops the event."""
        if event.isAutoRepeat():
            return event.key() in self._ignored
        if self.has_paired_repeats and event.key() in PRESS_KEYS:
            self._send_release()
            self._release = window, event.clone()
            self._release_timer.start()
            return True
        return self._on_release(event.key())

    def _on_release(self, key: int) -> bool:
        is_ignored = key in self._ignored
        self._keys.discard(key)
        self._ignored.discard(key)
        if not self._keys:
            for step in tuple(self._steps):
                step.is_key_blocked = False
        return is_ignored

    def _send_release(self) -> None:
        if self._release is not None:
            (window, event), self._release = self._release, None
            self._release_timer.stop()
            if not self._on_release(event.key()):
                self._send(window, event)

    def _send(self, window: QWindow, event: QKeyEvent) -> None:
        if event.key() not in self._ignored:
            self._is_sending = True
            try:
                QApplication.sendEvent(window, event)
            finally:
                self._is_sending = False

    def reset(self) -> None:
        """Forgets all keys and the pointer."""
        self.clock = time.monotonic
        self._pointer = self._under = self._release = None
        self._on_focus_window()

    def _on_focus_window(self) -> None:
        """Forgets all keys: releases now go to another window, and a key that is still down repeats."""
        self._send_release()
        self._release_timer.stop()
        self._keys.clear()
        self._ignored.clear()


@cache
def gestures() -> Gestures:
    """The instance of the application, made for the first step."""
    return Gestures(application())


def application() -> QApplication:
    """Exists as long as a window does."""
    found = QApplication.instance()
    if not isinstance(found, QApplication):
        raise TypeError("a window needs a QApplication")
    return found


class StepButton(QPushButton):
    """`is_safe` (Cancel, the steps of a guided test): keeps its place, but is never dead; a double click is one."""

    chosen = Signal()  # A press that counted. `clicked` may also come from assistive technology, at any time.

    def __init__(self, text: str = "", *, is_safe: bool = False) -> None:
        super().__init__(text)
        self._is_safe = is_safe
        self._gestures = gestures()
        self.appeared_at = 0.0  # When it became visible or enabled, or moved, by the clock of `gestures`
        self._place = QRect()
        self.is_pointer_blocked = False
        self.is_key_blocked = False
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
        """It has been visible and enabled for long enough."""
        is_there = self.isVisible() and self.isEnabled()
        return is_there and (self._is_safe or self._gestures.clock() - self.appeared_at >= DEAD_FOR_S)

    @property
    def takes_pointer(self) -> bool:
        """Whether a mouse press counts now."""
        return self.is_live and (self._is_safe or not self.is_pointer_blocked)

    @property
    def takes_keys(self) -> bool:
        """Whether a key press counts now."""
        return self.is_live and (self._is_safe or not self.is_key_blocked)

    def appear(self) -> None:
        """It became visible or enabled, or moved: a press in progress does not count."""
        self._place = self._place_now()
        self.appeared_at = self._gestures.clock()
        self.is_pointer_blocked = False
        self.is_key_blocked = self._gestures.has_key_down
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
        self.is_pointer_blocked = True
        self.cancel_press()
        self.update()

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

    def initStyleOption(self, option: QStyleOptionButton) -> None:
        """A dead button looks disabled."""
        from PySide6.QtWidgets import QStyle  # the first paint does not wait for it

        super().initStyleOption(option)
        if not self.takes_pointer:
            option.state &= ~QStyle.StateFlag.State_Enabled


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


def has_focus(widget: QWidget) -> bool:
    """Whether the focus is in `widget`."""
    focused = QApplication.focusWidget()
    return focused is not None and (focused is widget or widget.isAncestorOf(focused))


def leave_focus(widget: QWidget) -> None:
    """Clears the focus if it is in `widget`."""
    focused = QApplication.focusWidget()
    if focused is not None and has_focus(widget):
        focused.clearFocus()


class FocusBack(QObject):
    """It brings the focus back from a part of a window that comes and goes: it remembers where the focus was before it
    came into `part`."""

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
        was_in = has_focus(self._part)
        hide()
        if was_in:
            self.give()

    def give(self) -> None:
        """Back to where it was, but never to a step of an act."""
        before, self._before = self._before, None
        if before is not None and isValid(before) and not isinstance(before, StepButton):
            before.setFocus()
