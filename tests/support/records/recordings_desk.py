"""The Logs page for tests, with one recording in the list."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile

from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.recordings.library import RecordingLibrary
from tests.support.records.recordings_made import HEADING, batch, recorder_in, report, talk
from tests.support.window.fake_ports import fake_services, show_alone
from tests.support.window.steps import Driver, notice_text
from ui.pages.logs.page import LogsPage
from ui.pages.logs.rows import LogColumn
from ui.services.storage import Storage

SECONDS = 120


def record(folder: Path, *, module: str = "Left wing", seconds: int = SECONDS) -> Path:
    """Record ten reports a second, tipped over for one second in the middle while active; return the folder."""
    with recorder_in(folder) as bench:
        bench.recorder.begin(*HEADING)
        bench.name(module)
        for second in range(seconds):
            start_s = 1000.0 + second
            is_tipped = second == seconds // 2
            samples = [
                report(start_s + n / 10, 75 if is_tipped else 10, triggered=is_tipped, active=second >= 30)
                for n in range(10)
            ]
            view = talk(start_s, cell_voltage_v=3.9, light_v=0.4, attitude_threshold_deg=60, light_threshold_v=1.8)
            bench.recorder.on_batch(batch(start_s + 0.95, *samples, view=view))
        bench.settle()  # it reads the clock, which moves on next
        bench.clock.now_s += seconds
        bench.recorder.end()
        bench.settle()
        return bench.path


@dataclass
class Desk(Driver):
    qtbot: QtBot
    storage: Storage
    page: LogsPage

    @property
    def root(self) -> QWidget:
        return self.page

    @property
    def library(self) -> RecordingLibrary:
        return self.storage.library

    def list_again(self, count: int) -> None:
        """Refresh the list; wait until it has `count` rows and nothing reads it any more."""
        self.page.work.list_again()
        self.until(lambda: self.page.table.filter.rowCount() == count and not self.page.work.listing.is_running)

    def answer(self, key: str) -> None:
        self.click(self.page.strip.button(key))

    def said(self) -> str:
        return notice_text(self.page.strip)

    def texts(self, column: LogColumn) -> list[str]:
        shown = self.page.table.filter
        return [str(shown.index(row, column).data()) for row in range(shown.rowCount())]


@contextmanager
def made(qtbot: QtBot, qapp: QApplication, folder: Path, template: Path) -> Iterator[Desk]:
    """Show the page without a main window or a port."""
    storage = Storage(folder)
    with fake_services(qapp, storage) as (_, services):
        storage.library.folder.mkdir(parents=True)
        copyfile(template, storage.library.folder / template.name)
        page = LogsPage(services)
        page.show_module(services.ports.module)
        show_alone(qtbot, services, page, 876, 500)
        desk = Desk(qtbot, storage, page)
        desk.list_again(1)
        yield desk
        page.hide()
