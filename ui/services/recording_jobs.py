"""Background jobs on recordings: list, open, export, pin, delete; one at a time."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.recordings.entry_texts import when_text
from app.text.i18n import tr
from app.text.sentences import error_text, join_sentences
from ui.core.background_task import BackgroundTask, Running
from ui.services.session_recording import SessionRecording
from ui.style.theme import Meaning

if TYPE_CHECKING:  # they load numpy, which the window's first paint does not wait for
    from app.recordings.library import RecordingEntry, RecordingLibrary


class ExportKind(Enum):
    """What a recording is exported as; the value is the suffix."""

    CSV = ".csv"
    MCAP = ".mcap"


@dataclass(frozen=True, slots=True)
class JobEnded:
    """The result of the last job."""

    meaning: Meaning
    text: str


@dataclass(frozen=True, slots=True)
class Progress:
    """The running job; `share` (0 … 1) is None if its progress is unknown."""

    text: str
    share: float | None = None


class _Exported(NamedTuple):
    """`damage`: what is missing in the file, because it was damaged in the recording."""

    rows: int
    damage: str | None


class RecordingJobs(QObject):
    """`changed`: the list, the running job or its result changed. `opened` passes a `Recording` to look at."""

    changed = Signal()
    opened = Signal(object)
    closing = Signal(object)
    """These folders (`frozenset` of paths) are about to be deleted: close what is shown of them."""

    def __init__(self, sessions: SessionRecording, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._sessions = sessions
        self.entries: tuple[RecordingEntry, ...] = ()
        self.is_known = False
        """The list was read at least once."""
        self.is_shown = False
        """A recording is shown on the Live page."""
        self.said: JobEnded | None = None
        self._is_list_old = False
        self._doing = ""
        self._listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)
        self._job: BackgroundTask[object] = BackgroundTask("dps-s recording", self)

    @property
    def library(self) -> "RecordingLibrary":
        return self._sessions.library

    @property
    def progress(self) -> Progress | None:
        return Progress(self._doing, self._job.share) if self._doing else None

    def refresh(self) -> None:
        """Read the list again."""
        self._is_list_old = self._listing.is_running  # the running one may miss what changed since it began
        if not self._is_list_old:
            self._listing.run(lambda _running: self._listed(), self._show_list, self._fail_list)

    def _listed(self) -> "tuple[RecordingEntry, ...]":
        return (*self.library.entries(), *self.library.trashed())

    def open(self, entry: "RecordingEntry") -> None:
        """Emits `opened`, or sets `said` to the reason why not."""

        def work(_running: Running) -> object:
            from app.recordings.recording import open_recording

            return open_recording(entry.folder)

        def show(recording: object) -> None:
            self._end(None)
            self.opened.emit(recording)

        self._begin(tr("Opening {when}…", when=when_text(entry)), work, show)

    def export(self, entry: "RecordingEntry", path: Path, kind: ExportKind) -> None:
        """Export the recording into one file, written whole or not at all."""

        def work(running: Running) -> _Exported:
            from app.recordings.export import export_csv, export_mcap
            from app.recordings.recording import open_recording

            export = export_csv if kind is ExportKind.CSV else export_mcap
            with open_recording(entry.folder) as recording:
                count = export(recording, path, on_progress=running.set_progress, is_cancelled=running.is_cancelled)
                return _Exported(count, recording.damage)

        def tell(done: object) -> None:
            count, damage = done if isinstance(done, _Exported) else (0, None)
            text = tr("Saved to {path}. Rows: {rows}.", rows=f"{count:,}", path=path)
            self._end(
                JobEnded(Meaning.GOOD, text)
                if damage is None
                else JobEnded(Meaning.ATTENTION, join_sentences([text, damage]))
            )

        self._begin(tr("Exporting {name}", name=path.name), work, tell, path=path)

    def set_pinned(self, entries: Iterable["RecordingEntry"], *, is_pinned: bool) -> None:
        """Whether they are kept when old recordings are deleted automatically."""
        chosen = tuple(entries)

        def work(_running: Running) -> None:
            for one in chosen:
                self.library.set_pinned(one, is_pinned=is_pinned)

        self._begin(tr("Saving…"), work, lambda _nothing: self._end(None))

    def delete(self, entries: Iterable["RecordingEntry"]) -> None:
        """Delete permanently."""
        chosen = tuple(entries)
        self.closing.emit(frozenset(one.folder for one in chosen))

        def work(running: Running) -> int:
            for count, one in enumerate(chosen):
                if running.is_cancelled():
                    return count
                self.library.delete(one)
                running.set_progress((count + 1) / len(chosen))
            return len(chosen)

        def tell(count: object) -> None:
            self._end(JobEnded(Meaning.INFORMATION, tr("Recordings deleted: {count}.", count=count)))

        self._begin(tr("Deleting…"), work, tell)

    def cancel(self) -> None:
        """Stop the running job; an export leaves no file."""
        if self._job.is_running:
            self._job.cancel()
            self._end(JobEnded(Meaning.INFORMATION, tr("Cancelled.")))

    def dismiss(self) -> None:
        self.said = None
        self.changed.emit()

    def stop(self) -> None:
        """Cancel everything: the window closes."""
        self._job.cancel()
        self._listing.cancel()

    def _begin(
        self,
        text: str,
        work: Callable[[Running], object],
        then: Callable[[object], None],
        *,
        path: Path | None = None,
    ) -> None:
        if self._job.is_running:
            return
        self._doing, self.said = text, None
        self._job.run(work, then, lambda error: self._end(JobEnded(Meaning.ATTENTION, _refusal(error, path))))
        self.changed.emit()

    def _end(self, said: JobEnded | None) -> None:
        self._doing, self.said = "", said
        self.changed.emit()
        self.refresh()

    def _show_list(self, entries: tuple["RecordingEntry", ...]) -> None:
        if entries != self.entries or not self.is_known:
            self.entries, self.is_known = entries, True
            self.changed.emit()
        if self._is_list_old:
            self.refresh()

    def _fail_list(self, error: Exception) -> None:
        self.is_known = True
        self.said = JobEnded(Meaning.ATTENTION, _refusal(error, None))
        self.changed.emit()


def _refusal(error: Exception, path: Path | None) -> str:
    from app.recordings.export import not_saved_text
    from app.recordings.library import RecordingInUse
    from app.recordings.recording import RecordingUnreadable

    if isinstance(error, RecordingUnreadable):
        return error.sentence
    if isinstance(error, RecordingInUse):
        return tr("It is being written: not deleted.")
    if path is not None:
        return not_saved_text(path, error)
    why = error_text(error)
    return tr("That did not work: {why}.", why=why)
