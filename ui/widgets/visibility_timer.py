"""Timer that runs only while its page is visible."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QWidget


class VisibilityTimer(QObject):
    """Calls `refresh` when `widget` is shown, and `tick` (as a rule the same) every `every_ms` until it is hidden.

    A change of language calls `retranslate` (as a rule `refresh`), seen or not.
    """

    def __init__(
        self,
        widget: QWidget,
        refresh: Callable[[], object],
        *,
        every_ms: int,
        tick: Callable[[], object] | None = None,
        retranslate: Callable[[], object] | None = None,
    ) -> None:
        super().__init__(widget)
        self._refresh, self._retranslate = refresh, retranslate or refresh
        self._timer = QTimer(self)
        self._timer.setInterval(every_ms)
        self._timer.timeout.connect(tick or refresh)
        widget.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        match event.type():
            case QEvent.Type.Show:
                self._timer.start()
                self._refresh()
            case QEvent.Type.Hide:
                self._timer.stop()
            case QEvent.Type.LanguageChange:
                self._retranslate()
        return False
