"""Print label, in the File menu and in each field that names the module: for tape, or a sheet for all modules.

What prints is imported when it is first used.
"""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtGui import QCursor

from app.modules.labels import PAPERS, Label, Paper, write_labels
from app.modules.names import modules
from app.settings.values import fingerprint
from app.text.i18n import tr
from protocol.translatable import marked
from ui.files.file_dialogs import AskPath, ask_path
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.shell.actions import MenuEntry
from ui.shell.main_window import MainWindow

_SHEET: Final = "A4"
_TITLES: Final = {"62": marked("62 mm tape…"), "24": marked("24 mm tape…"), _SHEET: marked("A4 sheets…")}


class LabelActions(QObject):
    """For one window."""

    def __init__(self, window: MainWindow, services: Services) -> None:
        super().__init__(window)
        self._window, self._services = window, services
        self.ask_path: AskPath = ask_path
        self._folder = Path.home()
        self._job = JobNotice(self, is_of_module=False)
        self._job.changed.connect(self._say)
        menu = window.menus.add_menu("label", marked("Print labels"))
        for key, title in _TITLES.items():
            when = None if key == _SHEET else lambda: bool(services.ports.module.name)
            window.menus.add("label", MenuEntry(f"label_{key}", title, partial(self.print_on, key), when=when))
        menu.aboutToShow.connect(self._refresh)
        services.ports.label_wanted.connect(lambda: menu.popup(QCursor.pos()))

    def _refresh(self) -> None:
        """Only for the menu: which modules are known is read from the store."""
        self._window.menus.refresh()
        self._window.menus[f"label_{_SHEET}"].setEnabled(bool(self._services.ports.known_names()))

    def print_on(self, key: str, _is_checked: bool = False) -> None:
        """Asks for a file, then writes the label of the shown module, or those of all."""
        from app.records.report import file_name

        module = self._services.ports.module
        shown = Label(module.name, _now(), fingerprint(module.view.settings(module.now_s)) or "")
        find = self._labels_of_all if key == _SHEET else lambda: [shown]
        name = file_name("DPS-S" if key == _SHEET else shown.name, tr("label"))
        suggested, write = self._folder / f"{name}.pdf", partial(self._write, find, PAPERS[key])
        self.ask_path(self._window, tr("Print labels"), suggested, "*.pdf", write)

    def _labels_of_all(self) -> list[Label]:
        """With the settings that were last read of each."""
        store, at = self._services.storage.ready, _now()
        if store is None:
            return []
        known = sorted(store.read(modules), key=lambda module: module.name)
        return [Label(module.name, at, fingerprint(module.settings) or "") for module in known]

    def _write(self, find: Callable[[], Sequence[Label]], paper: Paper, path: Path) -> None:
        from ui.files.report_printer import print_pages

        self._folder = path.parent
        self._job.write_file(path, lambda: write_labels(path, find(), paper, print_pages))

    def _say(self) -> None:
        notice = self._job.result_notice()
        self._window.show_message("" if notice is None else notice.text)


def _now() -> datetime:
    return datetime.now(UTC).astimezone()
