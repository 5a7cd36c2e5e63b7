"""Distinguishes deliberate presses from accidental ones, by the path of the pointer and the keys held down.

A control accepts a press only if the pointer moved onto it. One that appeared under an unmoved pointer (shown,
scrolled, moved by a layout, uncovered) is blocked until the pointer leaves it. See `ui.widgets.step_button`.
"""

import time
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Final
from weakref import WeakSet

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, QTimer
from PySide6.QtGui import QEnterEvent, QGuiApplication, QKeyEvent, QMouseEvent, QWindow
from PySide6.QtWidgets import QApplication

if TYPE_CHECKING:
    from ui.widgets.step_button import StepButton

# Keys that press a button.
PRESS_KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Select, Qt.Key.Key_Return, Qt.Key.Key_Enter)
# X11 reports an auto-repeat as a release and a press with equal timestamps, which Qt detects only if both arrived.
REPEATS_WITHIN_MS: Final = 50
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

    # For steps

    def add(self, step: "StepButton") -> None:
        """`step` became visible."""
        self._steps.add(step)
        window = step.window()
        window.installEventFilter(self)
        handle = window.windowHandle()
        if handle is not None:
            handle.installEventFilter(self)

    def remove(self, step: "StepButton") -> None:
        """`step` is no longer visible."""
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
            left.unblock_pointer()
        if step is not None and not is_move:
            step.block_pointer()

    def _find(self, position: QPointF) -> "StepButton | None":
        for step in self._steps:
            if step.isVisible() and step.rect().contains(step.mapFromGlobal(position).toPoint()):
                window = step.window()
                child: object = window.childAt(window.mapFromGlobal(position).toPoint())
                if child is step:
                    return step
        return None

    # Qt

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
        """Returns True to stop the event."""
        if self._release is not None:
            released = self._release[1]
            if released.key() == event.key() and released.timestamp() == event.timestamp():
                self._release_timer.stop()
                self._release = None
                self._send(window, _as_repeat(event))
                return True
            self._send_release()
        self._keys.add(event.key())
        return event.key() in self._ignored

    def _on_key_release(self, window: QWindow, event: QKeyEvent) -> bool:
        """Returns True to stop the event."""
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
                step.unblock_keys()
        return is_ignored

    def _send_release(self) -> None:
        if self._release is not None:
            (window, event), self._release = self._release, None
            self._release_timer.stop()
            if not self._on_release(event.key()):
                self._send(window, event)

    def _send(self, window: QWindow, event: QKeyEvent) -> None:
        if event.key() in self._ignored:
            return
        self._is_sending = True
        try:
            QApplication.sendEvent(window, event)
        finally:
            self._is_sending = False

    def reset(self) -> None:
        """Forgets all keys and the pointer."""
        self.clock = time.monotonic
        self._pointer = self._under = self._release = None
        self._release_timer.stop()
        self._keys.clear()
        self._ignored.clear()

    def _on_focus_window(self, _window: QWindow | None) -> None:
        """Forgets all keys: releases now go to another window, and a key that is still down repeats."""
        self._send_release()
        self._keys.clear()
        self._ignored.clear()


def _as_repeat(event: QKeyEvent) -> QKeyEvent:
    return QKeyEvent(
        event.type(),
        event.key(),
        event.modifiers(),
        event.nativeScanCode(),
        event.nativeVirtualKey(),
        event.nativeModifiers(),
        event.text(),
        True,
        event.count(),
    )


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
