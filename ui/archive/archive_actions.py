"""Archive… in the File menu, and the line in the status bar. Imported late, to keep the start fast."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from ui.archive.archive_exchange import ArchiveExchange
from ui.archive.archive_line import ArchiveLine
from ui.services.context import Services
from ui.shell.main_window import MainWindow

if TYPE_CHECKING:
    from ui.archive.archive_dialog import ArchiveDialog


class ArchiveActions(QObject):
    """For one window."""

    def __init__(self, window: MainWindow, services: Services) -> None:
        super().__init__(window)
        self._window, self._services = window, services
        self.exchange = ArchiveExchange(services.storage, self)
        self.line = ArchiveLine(self.exchange, services.texts)
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
