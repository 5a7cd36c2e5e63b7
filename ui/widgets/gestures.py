"""Tells deliberate presses from accidental ones: pointer path and keys held down.

A control counts a press only when the pointer moved onto it. One that came to lie under an unmoved pointer (shown,
scrolled, moved by a layout, uncovered) is blocked until the pointer leaves it. See `ui.widgets.step_button`.
"""

import time
from collections.abc import Callable
from typing import Final, Protocol
from weakref import WeakSet

from PySide6.QtCore import QEvent, QObject, QPointF, QRect, Qt, QTimer
from PySide6.QtGui import QEnterEvent, QGuiApplication, QKeyEvent, QMouseEvent, QWindow
from PySide6.QtWidgets import QApplication, QWidget

PRESS_KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Select, Qt.Key.Key_Return, Qt.Key.Key_Enter)
"""Keys that press a button."""
REPEATS_WITHIN_MS: Final = 50
"""X11 reports an auto-repeat as a release and a press of the same time. Qt marks the pair only if both have arrived."""
_POINTER: Final = (
    QEvent.Type.MouseMove,
    QEvent.Type.MouseButtonPress,
    QEvent.Type.MouseButtonDblClick,
    QEvent.Type.MouseButtonRelease,
)


class Step(Protocol):
    """A `QWidget` that is pressed deliberately or not at all."""

    def isVisible(self) -> bool: ...
    def rect(self) -> QRect: ...
    def mapFromGlobal(self, position: QPointF, /) -> QPointF: ...
    def window(self) -> QWidget: ...
    def check_place(self) -> None: ...
    def block_pointer(self) -> None: ...
    def unblock_pointer(self) -> None: ...
    def unblock_keys(self) -> None: ...


class Gestures(QObject):
    """One for the application: `gestures()`. Event filter of every window that has a step in sight."""

    def __init__(self, application: QApplication) -> None:
        super().__init__(application)
        self.clock: Callable[[], float] = time.monotonic
        """Monotonic seconds."""
        self.has_paired_repeats = QGuiApplication.platformName() == "xcb"
        self._steps: WeakSet[Step] = WeakSet()
        """In sight."""
        self._pointer: QPointF | None = None
        self._under: Step | None = None
        """The step under the pointer."""
        self._keys: set[int] = set()
        """That are down."""
        self._ignored: set[int] = set()
        """Still down after an act was completed by them."""
        self._release: tuple[QWindow, QKeyEvent] | None = None
        """Held back until it is certain that it is no auto-repeat."""
        self._is_sending = False
        self._release_timer = QTimer(self)
        self._release_timer.setSingleShot(True)
        self._release_timer.setInterval(REPEATS_WITHIN_MS)
        self._release_timer.timeout.connect(self._send_release)
        application.focusWindowChanged.connect(self._on_focus_window)

    # For steps

    def add(self, step: Step) -> None:
        """`step` came into sight."""
        self._steps.add(step)
        window = step.window()
        window.installEventFilter(self)
        handle = window.windowHandle()
        if handle is not None:
            handle.installEventFilter(self)

    def remove(self, step: Step) -> None:
        """`step` is no longer in sight."""
        self._steps.discard(step)
        self.forget(step)

    def forget(self, step: Step) -> None:
        """`step` appeared, or lies elsewhere: where it is under the pointer now, the pointer did not move onto it."""
        if self._under is step:
            self._under = None

    @property
    def has_key_down(self) -> bool:
        return bool(self._keys)

    @property
    def is_release_uncertain(self) -> bool:
        """A key may have been released a moment ago, or it repeats."""
        return self._release is not None

    def ignore_keys_down(self) -> None:
        """A key that is down now counts for nothing, in any window, until it was released."""
        self._ignored |= self._keys.intersection(PRESS_KEYS)

    def on_pointer(self, position: QPointF, *, is_move: bool = True) -> None:
        """The pointer is at `position` (global). Not `is_move`: it did not get there by its own movement."""
        if self._pointer is not None:
            self._arrive(self._find(self._pointer), is_move=False)
        self._pointer = QPointF(position)
        self._arrive(self._find(position), is_move=is_move)

    def _arrive(self, step: Step | None, *, is_move: bool) -> None:
        left, self._under = self._under, step
        if left is step:
            return
        if left is not None:
            left.unblock_pointer()
        if step is not None and not is_move:
            step.block_pointer()

    def _find(self, position: QPointF) -> Step | None:
        for step in self._steps:
            if step.isVisible() and step.rect().contains(step.mapFromGlobal(position).toPoint()):
                window = step.window()
                found: object = window.childAt(window.mapFromGlobal(position).toPoint())
                if found is step:
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
        """Whether it goes no further."""
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
        """Whether it goes no further."""
        if event.isAutoRepeat():
            return event.key() in self._ignored
        if self.has_paired_repeats and event.key() in PRESS_KEYS:
            self._send_release()
            self._release = window, event.clone()
            self._release_timer.start()
            return True
        return self._let_up(event.key())

    def _let_up(self, key: int) -> bool:
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
            if not self._let_up(event.key()):
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
        """As at the start of the program: no key is down, the pointer is nowhere."""
        self.clock = time.monotonic
        self._pointer = self._under = self._release = None
        self._release_timer.stop()
        self._keys.clear()
        self._ignored.clear()

    def _on_focus_window(self, _window: QWindow | None) -> None:
        """What is released from here on, another window is told; a key that is still down repeats."""
        self._send_release()
        self._keys.clear()
        self._ignored.clear()


def _as_repeat(event: QKeyEvent) -> QKeyEvent:
    return QKeyEvent(
        event.type(), event.key(), event.modifiers(), event.nativeScanCode(), event.nativeVirtualKey(),
        event.nativeModifiers(), event.text(), True, event.count(),
    )  # fmt: skip


_one: Gestures | None = None


def gestures() -> Gestures:
    """The application's; made with the first step."""
    global _one  # noqa: PLW0603  as Qt has one application
    if _one is None:
        application = QApplication.instance()
        if not isinstance(application, QApplication):
            raise TypeError("steps belong to a window's application")
        _one = Gestures(application)
    return _one
