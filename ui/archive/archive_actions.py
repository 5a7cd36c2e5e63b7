"""Archive… in the File menu, and the line in the status bar. Imported late, to keep the start fast."""

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QToolButton

from app.text.i18n import tr
from app.text.sentences import labelled
from ui.archive.archive_exchange import ArchiveExchange, last_time
from ui.services.context import Services
from ui.shell.main_window import MainWindow
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning
from ui.widgets.controls import control
from ui.widgets.visibility_timer import VisibilityTimer

if TYPE_CHECKING:
    from ui.archive.archive_dialog import ArchiveDialog

SMALLEST_PX: Final = 80
"""In a narrow window the text is elided; the tooltip has all of it."""


class ArchiveLine(QToolButton):
    """Hidden without a server. A click opens the archive."""

    def __init__(self, exchange: ArchiveExchange) -> None:
        super().__init__()
        control(self, "archive_line", says=tr("Archive"), tip=tr("Archive"), role="quiet")
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setMinimumWidth(SMALLEST_PX)
        self._exchange = exchange
        exchange.changed.connect(self.refresh)
        VisibilityTimer(self, self.refresh)
        self.refresh()

    def refresh(self) -> None:
        seen = self._exchange.seen
        self.setVisible(self._exchange.server is not None and seen is not None)
        if seen is None:
            return
        count, last = seen.not_shared, seen.last_at
        text = tr("Not shared: {count}. Last: {time}.", count=count, time=last_time(last))
        altered = 0 if seen.done is None else seen.done.left_out_count
        if altered:
            text = tr("Left out, unreadable or altered: {count}", count=altered)
        self.setIcon(icon(Icon.WARNING, Meaning.ATTENTION) if altered else icon(Icon.BUNDLE))
        self.setText(text)
        trouble = seen.trouble
        self.setToolTip("\n".join((text, *(() if trouble is None else (trouble.translated(),)))))
        self.setAccessibleName(labelled(tr("Archive"), text))


class ArchiveActions(QObject):
    """For one window."""

    def __init__(self, window: MainWindow, services: Services) -> None:
        super().__init__(window)
        self._window, self._services = window, services
        self.exchange = ArchiveExchange(services.storage, self)
        self.line = ArchiveLine(self.exchange)
        window.status_bar.add(self.line)
        self.dialog: ArchiveDialog | None = None
        window.archive_wanted.connect(self.show)
        self.line.clicked.connect(self.show)
        window.pages_made.connect(self.exchange.start)

    def show(self) -> None:
        from ui.archive.archive_dialog import ArchiveDialog

        if self.dialog is None:
            self.dialog = ArchiveDialog(self.exchange, self._services, self._window)
        self.dialog.bring_up()
