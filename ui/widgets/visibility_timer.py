"""Timer that runs only while its page is visible."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QWidget


class VisibilityTimer(QObject):
    """Calls `refresh` when `widget` is shown, and `tick` (as a rule the same) every `every_ms` until it is hidden;
    without `every_ms` only when it is shown.

    `hidden` is called when it is hidden. A change of language calls `retranslate` (as a rule `refresh`), seen or not.
    """

    def __init__(
        self,
        widget: QWidget,
        refresh: Callable[[], object],
        *,
        every_ms: int | None = None,
        tick: Callable[[], object] | None = None,
        retranslate: Callable[[], object] | None = None,
        hidden: Callable[[], object] | None = None,
    ) -> None:
        super().__init__(widget)
        self._widget = widget
        self._refresh, self._retranslate = refresh, retranslate or refresh
        self._hidden = hidden
        self._timer: QTimer | None = None
        if every_ms is not None:
            self._timer = QTimer(self, interval=every_ms)
            self._timer.timeout.connect(tick or refresh)
        widget.installEventFilter(self)

    def refresh_seen(self) -> None:
        """Something changed: refresh now where the widget is visible, else when it is shown."""
        if self._widget.isVisible():
            self._refresh()

    def restart(self) -> None:
        """The next tick is a whole period from now."""
        if self._timer is not None:
            self._timer.start()

    def stop(self) -> None:
        """No tick until it is shown again."""
        if self._timer is not None:
            self._timer.stop()

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
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
            case QEvent.Type.LanguageChange:
                self._retranslate()
        return False
