"""One line where a newer version is there, for those who gave an address in the preferences."""

import logging
from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject

from app import version
from app.system.newer_version import find_newer
from app.text.i18n import tr
from ui.core.background_task import BackgroundTask
from ui.preferences.dialog import Choices
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice

_log = logging.getLogger(__name__)


class UpdateNotice(QObject):
    """Asks once at each start, and when another address is given; without one it asks nobody. That it cannot be asked
    is only logged."""

    def __init__(self, choices: Choices, parent: QObject, tell: Callable[[Callable[[], Notice]], None]) -> None:
        super().__init__(parent)
        self._remembered, self._tell = choices.remembered, tell
        self._asked = ""
        self._asking: BackgroundTask[str | None] = BackgroundTask("dps-s newer version", self)
        choices.changed.connect(self.check)

    def check(self) -> None:
        address = self._remembered.update_address
        is_other, self._asked = address != self._asked, address
        if is_other and address:
            self._asking.run(lambda _running: find_newer(address, version()), self._show, self._log)

    def _show(self, newer: str | None) -> None:
        if newer is not None:
            self._tell(partial(self._notice, newer))

    def _notice(self, newer: str) -> Notice:
        text = tr("A newer version is there: {newer}. This is {own}.", newer=newer, own=version())
        return Notice(Meaning.INFORMATION, text)

    @staticmethod
    def _log(error: Exception) -> None:
        _log.info("Whether a newer version is there is not known: %s", error)
