"""Handles uncaught errors: disarms, logs, and shows a notice with details to copy."""

from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QGuiApplication

from app import version
from app.procedures.act import Armed
from app.system.uncaught import UncaughtError
from app.text.i18n import tr
from ui.shell.attention import Attention
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class UncaughtErrors(QObject):
    """`tell` may be called from any thread. The same error again is counted, not said again."""

    _has_come = Signal(object)

    def __init__(
        self, attention: Attention, armed: Armed, *, say: Callable[[str], None], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._attention, self._armed, self._say = attention, armed, say
        self._counts: dict[str, int] = {}
        """By details; what is in here is in sight, or waits for its turn."""
        # Queued also within the window's thread: the error may have come in the middle of a painting.
        self._has_come.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def tell(self, mishap: UncaughtError) -> None:
        """Disarm at once; say it when the window has its turn."""
        self._armed.act = None
        self._has_come.emit(mishap)

    def _show(self, mishap: UncaughtError) -> None:
        self._say(tr("Unexpected error: {error}. Nothing is armed.", error=mishap.summary))
        count = self._counts.get(mishap.details, 0)
        self._counts[mishap.details] = count + 1
        if not count:
            self._attention.tell(lambda: self._notice(mishap))

    def _notice(self, mishap: UncaughtError) -> Notice:
        count = self._counts.get(mishap.details, 1)
        text = tr("Unexpected error: {error}. Nothing is armed.", error=mishap.summary)
        if count > 1:
            text += f" (×{count})"

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{mishap.thread}\n{mishap.details}")
            self._say(tr("Copied."))

        def dismiss() -> None:
            self._counts.pop(mishap.details, None)
            self._attention.forget_told()

        choices = (Choice("copy_details", tr("Copy details"), copy_details),)
        return Notice(Meaning.ATTENTION, text, choices, dismiss=dismiss)
