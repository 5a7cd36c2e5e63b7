"""Saves traffic as a capture; opens captures by dialog or drop."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget

from app import version
from app.captures.explained import Explainer
from app.captures.reader import CaptureEntry, CaptureRefused, Header, LineFault, OpenCapture, entries_of, lines_of
from app.captures.rows import CaptureRows
from app.recordings.file_export import ExportCancelled, FileExport
from app.system.gil_yield import GilYield
from app.system.wall_clock import WallClock
from app.text.i18n import tr
from protocol.events import Event
from ui.core.background_task import BackgroundTask
from ui.files.file_dialogs import AskOpen, AskPath, ask_open, ask_path, default_name
from ui.services.context import Services
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control
from ui.widgets.notice_bar import Choice, Notice

SUFFIX = ".dpscap"
OPENED_SUFFIXES = (SUFFIX, ".hex", ".txt", ".log")
KEPT_ENTRIES = 60_000
"""Half an hour of a usual stream, 40 s of a full line; some 10 MB. What is older is in the session's recording."""
_ENTRIES_AT_ONCE = 1000
_LOOK_EVERY_MS = 100


def ask_capture(parent: QWidget, folder: Path) -> Path | None:
    kinds = ";;".join((tr("Capture (*.dpscap)"), tr("Hex text (*.txt *.hex *.log)"), tr("All files (*)")))
    return ask_open(parent, folder, tr("Open a capture"), kinds)


class Kept:
    """What went over the line, oldest first, in bounded memory. One thread."""

    def __init__(self) -> None:
        self._entries: deque[CaptureEntry] = deque(maxlen=KEPT_ENTRIES)
        self.wall = WallClock()
        self.has_dropped = False
        """What is older is no longer kept."""

    def __len__(self) -> int:
        return len(self._entries)

    def feed(self, events: Iterable[Event]) -> None:
        self.wall.poll()
        new = list(entries_of(events, 0.0))
        self.has_dropped |= len(self._entries) + len(new) > KEPT_ENTRIES
        self._entries.extend(new)

    def entries(self, most: int = KEPT_ENTRIES) -> tuple[CaptureEntry, ...]:
        """The last `most`, with times that begin at 0."""
        last = list(islice(reversed(self._entries), most))
        last.reverse()
        began_s = last[0].at_s if last else 0.0
        return tuple(entry._replace(at_s=entry.at_s - began_s) for entry in last)

    def header(self, port: str, baud_rate: int, most: int = KEPT_ENTRIES) -> Header:
        """Of a file with `entries(most)`."""
        first = next(islice(self._entries, max(0, len(self._entries) - most), None), None)
        started = "" if first is None else _iso(self.wall.at(first.at_s))
        return Header(
            program=f"DPS-S Configurator {version()}", port=port, baud_rate=baud_rate or None, started=started
        )


def _iso(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


def capture_parts(entries: tuple[CaptureEntry, ...], header: Header) -> Iterator[bytes]:
    """The file in pieces."""
    yield "".join(f"{line}\n" for line in header.lines()).encode()
    for first in range(0, len(entries), _ENTRIES_AT_ONCE):
        some = entries[first : first + _ENTRIES_AT_ONCE]
        yield "".join(f"{line}\n" for entry in some for line in lines_of(entry)).encode()


@dataclass(frozen=True, slots=True)
class Opened:
    """A capture as it is shown."""

    path: Path
    rows: CaptureRows
    faults: tuple[LineFault, ...]
    is_timed: bool


class Loading:
    """Reads and explains a file, beside the window; `share` is looked at meanwhile."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.share = 0.0
        """How much of the file has been read, 0 … 1."""

    def run(self, is_wanted: Callable[[], bool]) -> Opened:
        """Raises OSError, `CaptureRefused` or `ExportCancelled`."""
        rows, explainer, pace = CaptureRows(), Explainer(), GilYield()
        with self.path.open("rb") as file:
            capture = OpenCapture(file)
            for entries in capture.steps():
                if not is_wanted():
                    raise ExportCancelled
                for entry in entries:
                    for row in explainer.feed(entry):
                        rows.append(row)
                self.share = capture.share_read
                pace.checkpoint()
            for row in explainer.end():
                rows.append(row)
            reader = capture.reader
            return Opened(self.path, rows, tuple(reader.faults), is_timed=not reader.is_plain)


class CaptureFiles(QWidget):
    """Two buttons. `opened` gives an `Opened`, `said` a `Notice`, or None when there is nothing more to say."""

    opened = Signal(object)
    said = Signal(object)

    def __init__(self, services: Services, kept: Kept) -> None:
        super().__init__()
        self.setObjectName("capture_files")
        self.ask_open: AskOpen = ask_capture
        self.ask_save: AskPath = ask_path
        self._connector, self._kept = services.connector, kept
        self._folder = Path.home()
        self._saving: FileExport | None = None
        self._beside: BackgroundTask[Opened] = BackgroundTask("dps-s open capture", self)
        self._loading: Loading | None = None
        self._saved_text = ""
        texts = services.texts
        self.open = control(QPushButton(), texts, "capture_open", "Open capture…", says="Open a capture",
                            tip="Look at what was recorded, and play it (Ctrl+O); or drop the file on the window",
                            picture=Icon.FOLDER, slot=self.choose)  # fmt: skip
        self.save = control(QPushButton(), texts, "capture_save", "Save capture…", says="Save a capture",
                            tip="Save the last 60,000 entries of what went over the line, as a text file (Ctrl+S). "
                                "The session's recording, where it is on, holds all of them.", picture=Icon.SAVE,
                            slot=self.choose_and_save)  # fmt: skip
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(Space.S)
        row.addWidget(self.open)
        row.addWidget(self.save)
        self._timer = QTimer(self)
        self._timer.setInterval(_LOOK_EVERY_MS)
        self._timer.timeout.connect(self._look)

    @property
    def is_busy(self) -> bool:
        return self._saving is not None or self._beside.is_running

    def refresh(self) -> None:
        self.save.setEnabled(len(self._kept) > 0 and self._saving is None)

    def choose(self) -> None:
        path = self.ask_open(self, self._folder)
        if path is not None:
            self.open_file(path)

    def open_file(self, path: Path) -> None:
        """Whatever comes of it is told by a signal."""
        self._folder = path.parent
        self._loading = Loading(path)

        def refuse(error: Exception) -> None:
            self._loading = None
            self._say(Meaning.ATTENTION, _refusal(path, error))

        self._beside.run(self._loading.run, self._show, refuse)
        self._say_loading(self._loading)
        self._timer.start()

    def choose_and_save(self) -> None:
        """What is kept at this moment, before anybody chooses a file."""
        if not len(self._kept) or self._saving is not None:
            return
        connection = self._connector.connection
        entries = self._kept.entries()
        header = self._kept.header(connection.port, connection.baud_rate)
        is_whole = not self._kept.has_dropped
        suggested = self._folder / default_name(connection.port, SUFFIX, datetime.now().astimezone())
        path = self.ask_save(self, tr("Save a capture"), suggested, tr("Capture (*.dpscap)"))
        if path is None:
            return
        self._folder = path.parent
        count = f"{len(entries):,}"
        self._saved_text = (
            tr("Saved {count} entries to {path}.", count=count, path=path)
            if is_whole
            else tr("Saved the last {count} entries to {path}; older ones are no longer kept.", count=count, path=path)
        )
        self._saving = FileExport(path, lambda: capture_parts(entries, header), len(entries) // _ENTRIES_AT_ONCE + 2)
        self._timer.start()
        self.refresh()

    def _look(self) -> None:
        saving = self._saving
        if self._loading is not None:
            self._say_loading(self._loading)
        if saving is None:
            if self._loading is None:
                self._timer.stop()
        elif not saving.is_done:
            cancel = (Choice("capture_cancel", tr("Cancel"), saving.cancel),)
            self.said.emit(Notice(Meaning.INFORMATION, tr("Saving {name}…", name=saving.path.name), cancel))
        else:
            self._end_saving(saving)

    def _end_saving(self, saving: FileExport) -> None:
        self._saving = None
        self.refresh()
        if saving.error is None:
            self._say(Meaning.GOOD, self._saved_text)
        elif isinstance(saving.error, ExportCancelled):
            self._say(Meaning.INFORMATION, tr("Cancelled, nothing was saved."))
        else:
            why = getattr(saving.error, "strerror", None) or saving.error
            self._say(
                Meaning.ATTENTION,
                tr("Not saved to {path}: {why}. Choose another folder.", path=saving.path, why=why),
            )

    def _cancel_loading(self) -> None:
        self._beside.cancel()
        self._loading = None
        self.said.emit(None)

    def _say_loading(self, loading: Loading) -> None:
        cancel = (Choice("capture_cancel", tr("Cancel"), self._cancel_loading),)
        text = tr("Reading {name}: {percent} %…", name=loading.path.name, percent=round(loading.share * 100))
        self.said.emit(Notice(Meaning.INFORMATION, text, cancel))

    def _show(self, opened: Opened) -> None:
        self._loading = None
        if not opened.rows:
            self._say(Meaning.ATTENTION, tr("There are no bytes in {name}.", name=opened.path.name))
            return
        self.said.emit(None)
        self.opened.emit(opened)

    def _say(self, meaning: Meaning, text: str) -> None:
        self.said.emit(Notice(meaning, text, dismiss=lambda: self.said.emit(None)))


def _refusal(path: Path, error: Exception) -> str:
    if isinstance(error, CaptureRefused):
        return tr("{name} was not opened: {why}.", name=path.name, why=tr(error.args[0]))
    why = getattr(error, "strerror", None) or error
    return tr("{name} was not opened: {why}.", name=path.name, why=why)
