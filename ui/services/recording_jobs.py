"""Background jobs on recordings: list, export, pin, delete; one at a time."""

from collections.abc import Callable, Iterable
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from app.text.i18n import tr
from app.text.messages import UserError, error_text, join_sentences, not_written, saved_text
from ui.core.background_task import BackgroundTask, Running
from ui.services.job_notice import JobNotice
from ui.style.theme import Meaning

if TYPE_CHECKING:  # they load numpy, which the window's first paint does not wait for
    from app.recordings.library import RecordingEntry, RecordingLibrary
    from app.recordings.recording import Exported

Result = TypeVar("Result")


class RecordingJobs(JobNotice):
    """`changed`: also when the list changed."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(is_of_module=False)
        self._folder = folder
        self.entries: tuple[RecordingEntry, ...] = ()
        # The list was read at least once.
        self.is_known = False
        self._is_list_old = False
        self._listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)

    @cached_property
    def library(self) -> "RecordingLibrary":
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self._folder)

    def refresh(self) -> None:
        self._is_list_old = self._listing.is_running  # the running one may miss what changed since it began
        if not self._is_list_old:
            self._listing.run(lambda _running: self.library.entries(), self._show_list, self._fail_list)

    def export(self, entry: "RecordingEntry", path: Path) -> None:
        """Export the recording into one file, written whole or not at all: a table, or a copy where it ends so."""

        def work(running: Running) -> "Exported":
            from app.recordings.recording import export

            is_table = path.suffix.lower() != ".mcap"
            return export(entry, path, is_table=is_table, on_progress=running.set_progress_or_end)

        def notify(done: "Exported") -> None:
            text = saved_text(path, done.rows)
            if done.damage is None:
                self.notify_saved(path, text)
            else:
                self.notify_saved(path, join_sentences([text, done.damage.translated()]), Meaning.ATTENTION)

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
        for task in (self._writing, self._listing):
            task.close()

    def _change(
        self,
        doing: str,
        work: Callable[[Running], Result],
        tell: Callable[[Result], object],
        path: Path | None = None,
    ) -> None:
        def end(result: Result) -> None:
            tell(result)
            self.refresh()

        if not self.is_busy:
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
