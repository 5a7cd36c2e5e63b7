"""Saves traffic as a session; opens sessions and hex text by dialog or drop."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QPushButton, QWidget

from app import version
from app.captures.entries import CaptureEntry
from app.captures.explained import Explained, Explainer
from app.captures.rows import CaptureRows
from app.captures.text import NOT_HEX, LineFault, NotHex, TextReader, lines_in
from app.captures.traffic_buffer import TrafficBuffer
from app.diagnosis.link_statistics import LinkStatistics
from app.engine.worker import Connection
from app.system.gil_yield import GilYield
from app.text.i18n import tr
from app.text.sentences import error_text, not_written, saved_text
from ui.core.background_task import ExportCancelled, Running
from ui.files.file_dialogs import AskOpen, AskPath, ThenPath, ask_open, ask_path, default_name
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control
from ui.widgets.layouts import in_row

SUFFIX = ".mcap"
OPENED_SUFFIXES = (".hex", ".txt", ".log", ".dpscap", SUFFIX)


def ask_capture(parent: QWidget, folder: Path, then: ThenPath) -> None:
    kinds = tr("Session or hex text (*.mcap *.txt *.hex *.log *.dpscap)")
    ask_open(parent, folder, tr("Open traffic…"), kinds, then)


class Opened(NamedTuple):
    path: Path
    rows: CaptureRows
    statistics: LinkStatistics
    faults: tuple[LineFault, ...]
    is_timed: bool


def load_capture(path: Path, running: Running) -> Opened:
    """Reads and explains a file. Raises OSError, `NotHex`, `UserError` or `ExportCancelled`."""
    rows, statistics, pace, text = CaptureRows(), LinkStatistics(), GilYield(), TextReader()
    is_session = path.suffix.lower() == SUFFIX
    with ExitStack() as stack:
        if is_session:
            from app.recordings.library import entry_of
            from app.recordings.recording import traffic_of

            explainer: Explainer | TextReader = (session := Explainer())
            steps = map(session.feed, traffic_of(entry_of(path)))
        else:
            explainer = text
            file = stack.enter_context(path.open(encoding="utf-8", errors="replace"))
            steps = map(text.feed, lines_in(file))

        def explained() -> Iterator[Explained]:
            for some in steps:
                if running.is_cancelled():
                    raise ExportCancelled
                yield from some
                pace.checkpoint()
            yield from explainer.end()

        statistics.count(map(rows.append, explained()))
    return Opened(path, rows, statistics, tuple(text.faults), is_timed=is_session or text.is_timed)


class CaptureFiles(QWidget):
    """Buttons to open and save captures. `opened`: an `Opened`."""

    opened = Signal(object)

    def __init__(self, services: Services, buffer: TrafficBuffer, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("capture_files")
        self.ask_open: AskOpen = ask_capture
        self.ask_save: AskPath = ask_path
        self._connector, self._buffer, self._result = services.connector, buffer, result
        self._folder = Path.home()
        texts = services.texts
        self.open = control(QPushButton(), texts, "capture_open", "Open traffic…", key="Ctrl+O", picture=Icon.FOLDER,
                            slot=self.choose)  # fmt: skip
        self.save = control(QPushButton(), texts, "capture_save", "Save traffic…", key="Ctrl+S", picture=Icon.SAVE,
                            slot=self.choose_and_save)  # fmt: skip
        in_row(self.open, self.save, of=self, spacing=Space.S, margins=0)
        result.changed.connect(self.refresh)

    def refresh(self) -> None:
        self.save.setEnabled(len(self._buffer) > 0 and not self._result.is_writing)

    def choose(self) -> None:
        self.ask_open(self, self._folder, self.open_file)

    def open_file(self, path: Path) -> None:
        self._folder = path.parent
        load = partial(load_capture, path)
        self._result.begin(lambda: path.name, load, self._show, partial(_refusal, path), writes=False)

    def choose_and_save(self) -> None:
        """Saves the traffic up to now, not up to when the file is chosen."""
        if not len(self._buffer) or self._result.is_writing:
            return
        connection = self._connector.current.connection
        entries = self._buffer.entries()
        started_at = self._buffer.started_at()
        suggested = self._folder / default_name(connection.port, SUFFIX, datetime.now().astimezone())
        save = partial(self._save, entries, connection, started_at, self._buffer.has_dropped)
        self.ask_save(self, tr("Save traffic…"), suggested, tr("Session (*.mcap)"), save)

    def _save(
        self,
        entries: Sequence[CaptureEntry],
        connection: Connection,
        started_at: datetime,
        has_dropped: bool,
        path: Path,
    ) -> None:
        self._folder = path.parent

        def write(running: Running) -> None:
            from app.recordings.session_format import Opening
            from app.recordings.writer import write_session

            def counted() -> Iterator[CaptureEntry]:
                for number, entry in enumerate(entries):
                    if number % 1000 == 0:
                        running.set_progress_or_end(number / len(entries))
                    yield entry

            opening = Opening(
                started_at=started_at, start_s=0.0, port=connection.port,
                baud_rate=connection.baud_rate, program=f"DPS-S Configurator {version()}",
            )  # fmt: skip
            write_session(path, opening, counted())

        def tell(_none: None) -> None:
            self._result.notify(Meaning.GOOD, partial(saved_text, path, len(entries), is_whole=not has_dropped))

        self._result.begin(lambda: tr("Saving…"), write, tell, partial(not_written, path))

    def _show(self, opened: Opened) -> None:
        if not opened.rows:
            self._result.notify(Meaning.ATTENTION, lambda: _why_nothing(opened))
            return
        self.opened.emit(opened)


def _why_nothing(opened: Opened) -> str:
    if opened.faults:
        return tr("{file} cannot be read: {why}.", file=opened.path.name, why=tr(opened.faults[0].text))
    return tr("{name} is empty.", name=opened.path.name)


def _refusal(path: Path, error: Exception) -> str:
    why = tr(NOT_HEX) if isinstance(error, NotHex) else error_text(error)
    return tr("{file} cannot be read: {why}.", file=path.name, why=why)
