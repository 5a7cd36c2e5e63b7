"""Disarms at an uncaught error, which is shown with details to copy."""

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
    """`report` may be called from any thread. Repeated errors share one notice with a count."""

    _reported = Signal(object)

    def __init__(self, attention: Attention, armed: Armed, *, say: Callable[[str], None], parent: QObject) -> None:
        super().__init__(parent)
        self._attention, self._armed, self._say = attention, armed, say
        self._counts: dict[str, int] = {}
        """By details; those whose notice is shown or queued."""
        # Queued also in the window's thread: the error may have happened while painting.
        self._reported.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def report(self, error: UncaughtError) -> None:
        """Disarms at once, and shows the error from the event loop."""
        self._armed.act = None
        self._reported.emit(error)

    def _show(self, error: UncaughtError) -> None:
        self._say(tr("Unexpected error: {error}. Nothing is armed.", error=error.summary))
        count = self._counts.get(error.details, 0)
        self._counts[error.details] = count + 1
        if count:
            self._attention.refresh()
        else:
            self._attention.queue_notice(lambda: self._notice(error))

    def _notice(self, error: UncaughtError) -> Notice:
        count = self._counts.get(error.details, 1)
        text = tr("Unexpected error: {error}. Nothing is armed.", error=error.summary)
        if count > 1:
            text += f" (×{count})"

        def copy_details() -> None:
            QGuiApplication.clipboard().setText(f"DPS-S Configurator {version()}\n{error.thread}\n{error.details}")
            self._say(tr("Copied."))

        def dismiss() -> None:
            self._counts.pop(error.details, None)
            self._attention.dismiss_queued()

        choices = (Choice("copy_details", tr("Copy details"), copy_details),)
        return Notice(Meaning.ATTENTION, text, choices, dismiss=dismiss)
