"""Background jobs on recordings: list, open, export, pin, delete; one at a time."""

import logging
from collections.abc import Callable, Iterable
from enum import Enum
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from PySide6.QtCore import Signal

from app.recordings.entry_texts import when_text
from app.text.i18n import tr
from app.text.sentences import error_text, join_sentences, not_written, saved_text
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask, Running
from ui.services.job_notice import JobNotice
from ui.style.accessible_roles import announce
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice

if TYPE_CHECKING:  # they load numpy, which the window's first paint does not wait for
    from app.recordings.export import Exported
    from app.recordings.library import RecordingEntry, RecordingLibrary

Result = TypeVar("Result")
_log = logging.getLogger(__name__)


class ExportKind(Enum):
    """What a recording is exported as; the value is the suffix."""

    CSV = ".csv"
    MCAP = ".mcap"


class RecordingJobs(JobNotice):
    """`changed`: also when the list changed. `opened` passes a `Recording` to look at."""

    opened = Signal(object)
    closing = Signal(object)
    """These files (`frozenset` of paths) are about to be deleted: close what is shown of them."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(is_of_module=False)
        self._folder = folder
        self.entries: tuple[RecordingEntry, ...] = ()
        self.is_known = False
        """The list was read at least once."""
        self.is_shown = False
        """A recording is shown on the Live page."""
        self._is_list_old = False
        self._refused = ""
        """When that was recorded which was not opened because of the running job."""
        self._listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)

    def note_shown(self, *, is_shown: bool) -> None:
        self.is_shown = is_shown
        self.changed.emit()

    @cached_property
    def library(self) -> "RecordingLibrary":
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self._folder)

    def notice(self) -> Notice | None:
        notice = self.result_notice()
        if notice is None or not (self.is_busy and self._refused):
            return notice
        text = tr("{what}. Not opened meanwhile: {when}.", what=notice.text, when=self._refused)
        return notice._replace(text=text)

    def refresh(self) -> None:
        self._is_list_old = self._listing.is_running  # the running one may miss what changed since it began
        if not self._is_list_old:
            self._listing.run(lambda _running: self.library.entries(), self._show_list, self._fail_list)

    def open_file(self, path: Path) -> None:
        """Opens a session file from anywhere; see `open`."""
        from app.recordings.library import entry_of

        self.open(entry_of(path))

    def open(self, entry: "RecordingEntry") -> None:
        """Emits `opened`, or ends with the reason why not. While a job runs it is said that nothing is opened."""
        if self.is_busy:
            self._refused = when_text(entry)
            self.changed.emit()
            notice = self.notice()
            announce("" if notice is None else notice.text)
            return

        def work(_running: Running) -> object:
            from app.recordings.recording import open_recording

            return open_recording(entry)

        self._refused = ""
        self.begin(
            tr("Opening {when}…", when=when_text(entry)), work, self.opened.emit, partial(_refusal, None), writes=False
        )

    def export(self, entry: "RecordingEntry", path: Path, kind: ExportKind) -> None:
        """Export the recording into one file, written whole or not at all."""

        def work(running: Running) -> "Exported":
            from app.recordings.export import export

            return export(entry, path, is_table=kind is ExportKind.CSV, on_progress=running.set_progress_or_end)

        def notify(done: "Exported") -> None:
            text = saved_text(path, done.rows)
            if done.damage is None:
                self.notify(Meaning.GOOD, text)
            else:
                self.notify(Meaning.ATTENTION, join_sentences([text, done.damage.translated()]))

        self._change(tr("Exporting {name}", name=path.name), work, notify, path)

    def set_pinned(self, entries: Iterable["RecordingEntry"], *, is_pinned: bool) -> None:
        """Whether they are kept when old recordings are deleted automatically."""
        chosen = tuple(entries)

        def work(_running: Running) -> None:
            for entry in chosen:
                self.library.set_pinned(entry, is_pinned=is_pinned)

        self._change(tr("Saving…"), work, bool)

    def delete(self, entries: Iterable["RecordingEntry"]) -> None:
        """Delete permanently."""
        chosen = tuple(entries)
        self.closing.emit(frozenset(entry.path for entry in chosen))

        def work(running: Running) -> int:
            for count, entry in enumerate(chosen):
                if running.is_cancelled():
                    return count
                self.library.delete(entry)
                running.set_progress((count + 1) / len(chosen))
            return len(chosen)

        def notify(count: int) -> None:
            self.notify(Meaning.INFORMATION, tr("Recordings deleted: {count}.", count=count))

        self._change(tr("Deleting…"), work, notify)

    def stop(self) -> None:
        """The window closes; a file that is being written is finished."""
        for task in (self._reading, self._writing, self._listing):
            task.close()

    def _change(
        self, doing: str, work: Callable[[Running], Result], tell: Callable[[Result], object],
        path: Path | None = None,
    ) -> None:  # fmt: skip
        def end(result: Result) -> None:
            tell(result)
            self.refresh()

        if not self.is_busy:
            self._refused = ""
            self.begin(doing, work, end, partial(_refusal, path))

    def _show_list(self, entries: tuple["RecordingEntry", ...]) -> None:
        if entries != self.entries or not self.is_known:
            self.entries, self.is_known = entries, True
            self.changed.emit()
        if self._is_list_old:
            self.refresh()

    def _fail_list(self, error: Exception) -> None:
        self.is_known = True
        self.notify(Meaning.ATTENTION, _refusal(None, error))


def _refusal(path: Path | None, error: Exception) -> str:
    if path is not None or isinstance(error, UserError):
        return not_written(path, error)
    return tr("Failed: {why}.", why=error_text(error))
