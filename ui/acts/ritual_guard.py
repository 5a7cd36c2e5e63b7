"""Disarms the ritual on focus loss, window deactivation or an uncaught error."""

import sys
from collections.abc import Callable
from types import TracebackType

from PySide6.QtCore import QEvent, QObject, Signal
from PySide6.QtWidgets import QWidget

from app.safety.ritual import Input
from ui.widgets.gestures import application

_Hook = Callable[[type[BaseException], BaseException, TracebackType | None], object]


class RitualGuard(QObject):
    """Watches from `begin` to `end`. `broken` carries the reason; its receivers disarm."""

    broken = Signal(object)

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        self._widget = widget
        self._window: QWidget | None = None
        self._hook_before: _Hook | None = None
        application().focusChanged.connect(self._on_focus_changed)

    @property
    def is_watching(self) -> bool:
        return self._window is not None

    def begin(self) -> None:
        if not self.is_watching:
            self._hook_before = sys.excepthook
            sys.excepthook = self._on_fault
            self._window = self._widget.window()
            self._window.installEventFilter(self)

    def end(self) -> None:
        if self._window is not None:
            self._window.removeEventFilter(self)
            self._window = None
            # A hook that was installed over this one stays; this one then only forwards.
            if self._hook_before is not None and sys.excepthook == self._on_fault:
                sys.excepthook = self._hook_before

    def _on_fault(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        self._break(Input.FAILED)
        if self._hook_before is not None:
            self._hook_before(kind, error, trace)

    def _on_focus_changed(self, _old: QWidget | None, now: QWidget | None) -> None:
        if now is None:
            self._break(Input.WINDOW_LEFT)
        elif now is not self._widget and not self._widget.isAncestorOf(now):
            self._break(Input.FOCUS_LOST)

    def _break(self, why: Input) -> None:
        if self.is_watching:
            self.broken.emit(why)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.WindowDeactivate, QEvent.Type.Hide, QEvent.Type.Close):
            self._break(Input.WINDOW_LEFT)
        return False
