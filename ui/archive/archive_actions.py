"""Archive… in the File menu, and the line in the status bar. Imported late, to keep the start fast."""

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QToolButton

from app.text.i18n import tr
from app.text.sentences import labelled
from ui.archive.archive_exchange import ArchiveExchange, exchanged_text
from ui.services.context import Services
from ui.shell.main_window import MainWindow
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning
from ui.widgets.controls import control

if TYPE_CHECKING:
    from ui.archive.archive_dialog import ArchiveDialog

SMALLEST_PX: Final = 80
"""In a narrow window the text is elided; the tooltip has all of it."""


class ArchiveActions(QObject):
    """For one window. `line`: in the status bar, hidden without a server; a click opens the archive."""

    def __init__(self, window: MainWindow, services: Services) -> None:
        super().__init__(window)
        self._window = window
        self._services = services
        self.exchange = ArchiveExchange(services.storage, self)
        self.line = control(QToolButton(), "archive_line", says=tr("Archive"), tip=tr("Archive"), role="quiet")
        self.line.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.line.setMinimumWidth(SMALLEST_PX)
        self.line.hide()
        self.line.clicked.connect(self.show)
        window.status_bar.add(self.line)
        self.dialog: ArchiveDialog | None = None
        window.archive_wanted.connect(self.show)
        window.pages_made.connect(self.exchange.start)
        self.exchange.changed.connect(self._refresh_line)

    def show(self) -> None:
        from ui.archive.archive_dialog import ArchiveDialog

        if self.dialog is None:
            self.dialog = ArchiveDialog(self.exchange, self._services, self._window)
        self.dialog.bring_up()

    def _refresh_line(self) -> None:
        seen = self.exchange.seen
        text = exchanged_text(seen)
        self.line.setIcon(icon(Icon.BUNDLE))
        if seen.done is not None and seen.done.left_out_count:
            text = tr("Left out, unreadable or altered: {count}", count=seen.done.left_out_count)
            self.line.setIcon(icon(Icon.WARNING, Meaning.ATTENTION))
        self.line.setVisible(seen.exchanged is not None)
        self.line.setText(text)
        self.line.setAccessibleName(labelled(tr("Archive"), text))
        self.line.setToolTip(text if seen.trouble is None else f"{text}\n{seen.trouble.translated()}")
