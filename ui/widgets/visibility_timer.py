"""Refreshes a widget while it is visible, and at changes of the theme."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QWidget

# By class first: of every event `type()` would make an enumeration's member.
_HANDLED: Final = {QShowEvent, QHideEvent, QEvent}


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
        restyle: Callable[[], object] = bool,
        hidden: Callable[[], object] = bool,
    ) -> None:
        super().__init__(widget)
        self._widget, self._refresh, self._restyle, self._hidden = widget, refresh, restyle, hidden
        self._has_ticks = every_ms is not None
        self.timer = QTimer(self, interval=every_ms or 0)
        self.timer.timeout.connect(tick or refresh)
        widget.installEventFilter(self)

    def refresh_seen(self) -> None:
        """Refreshes now if the widget is visible; else showing it will."""
        if self._widget.isVisible():
            self._refresh()

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if type(event) in _HANDLED:
            match event.type():
                case QEvent.Type.Show:
                    if self._has_ticks:
                        self.timer.start()
                    self._refresh()
                case QEvent.Type.Hide:
                    self.timer.stop()
                    self._hidden()
                case QEvent.Type.StyleChange:
                    self._restyle()
        return False
