"""Refreshes a widget while it is visible, and at changes of the theme."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QWidget

_HANDLED: Final = {QShowEvent, QHideEvent, QEvent}
"""By class first: of every event `type()` would make an enumeration's member."""


class VisibilityTimer(QObject):
    """Calls `refresh` when `widget` is shown, then `tick` (by default `refresh`) every `every_ms` until it is hidden.

    Without `every_ms` there are no ticks. `hidden` is called when the widget is hidden. A change of theme calls
    `restyle`, whether the widget is visible or not. Make it at the end of the constructor: nothing is called before.
    """

    def __init__(
        self,
        widget: QWidget,
        refresh: Callable[[], object] = bool,
        *,
        every_ms: int | None = None,
        tick: Callable[[], object] | None = None,
        restyle: Callable[[], object] | None = None,
        hidden: Callable[[], object] | None = None,
    ) -> None:
        super().__init__(widget)
        self._widget = widget
        self._refresh = refresh
        self._restyle, self._hidden = restyle, hidden
        self._timer: QTimer | None = None
        if every_ms is not None:
            self._timer = QTimer(self, interval=every_ms)
            self._timer.timeout.connect(tick or refresh)
        widget.installEventFilter(self)

    def refresh_seen(self) -> None:
        """Refreshes now if the widget is visible; else showing it will."""
        if self._widget.isVisible():
            self._refresh()

    def restart(self) -> None:
        """Starts the period of the next tick now."""
        if self._timer is not None:
            self._timer.start()

    def stop(self) -> None:
        """Stops the ticks until the widget is shown again."""
        if self._timer is not None:
            self._timer.stop()

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if type(event) not in _HANDLED:
            return False
        match event.type():
            case QEvent.Type.Show:
                if self._timer is not None:
                    self._timer.start()
                self._refresh()
            case QEvent.Type.Hide:
                if self._timer is not None:
                    self._timer.stop()
                if self._hidden is not None:
                    self._hidden()
            case QEvent.Type.StyleChange:
                if self._restyle is not None:
                    self._restyle()
        return False
