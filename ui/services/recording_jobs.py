"""Background jobs on recordings: list, export, delete; one at a time."""

from collections.abc import Iterable
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from app.text.i18n import tr
from app.text.messages import UserError, error_text, join_sentences, not_written, saved_text
from ui.core.background_task import BackgroundTask, Running
from ui.services.page_job import PageJob
from ui.style.theme import Meaning

if TYPE_CHECKING:  # they load numpy, which the window's first paint does not wait for
    from app.recordings.library import RecordingEntry, RecordingLibrary
    from app.recordings.recording import Exported


class RecordingJobs(PageJob):
    """`changed`: also when the list changed."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(is_of_module=False)
        self._folder = folder
        self.entries: tuple[RecordingEntry, ...] = ()
        self._is_list_old = False
        self._listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)

    @cached_property
    def library(self) -> "RecordingLibrary":
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self._folder)

    def refresh(self) -> None:
        self._is_list_old = self._listing.is_running  # the running one may miss what changed since it began
        if not self._is_list_old:
            self._listing.run(lambda _running: self.library.entries(), self._show_list)

    def _show_list(self, entries: tuple["RecordingEntry", ...]) -> None:
        if entries != self.entries:
            self.entries = entries
            self.changed.emit()
        if self._is_list_old:
            self.refresh()

    def export(self, entry: "RecordingEntry", path: Path) -> None:
        """Exports the recording into one file, written whole or not at all: a table, or a copy where it ends so."""

        def work(running: Running) -> "Exported":
            from app.recordings.recording import export

            is_table = path.suffix.lower() != ".mcap"
            return export(entry, path, is_table=is_table, on_progress=running.set_progress_or_end)

        def end(done: "Exported") -> None:
            text = saved_text(path, done.rows)
            if done.damage is None:
                self.notify_saved(path, text)
            else:
                self.notify_saved(path, join_sentences([text, done.damage.translated()]), Meaning.ATTENTION)

        if not self.is_busy:
            self.begin(tr("Exporting {name}", name=path.name), work, end, partial(not_written, path))

    def delete(self, entries: Iterable["RecordingEntry"]) -> None:
        """Deletes permanently."""
        chosen = tuple(entries)

        def work(running: Running) -> int:
            for count, entry in enumerate(chosen):
                if running.is_cancelled():
                    return count
                self.library.delete(entry)
                running.set_progress((count + 1) / len(chosen))
            return len(chosen)

        def end(count: int) -> None:
            self.notify(Meaning.INFORMATION, tr("Recordings deleted: {count}.", count=count))
            self.refresh()

        def refused(error: Exception) -> str:
            self.refresh()
            return error.sentence if isinstance(error, UserError) else tr("Failed: {why}.", why=error_text(error))

        if not self.is_busy:
            self.begin(tr("Deleting…"), work, end, refused)

    def stop(self) -> None:
        """The window closes; a file that is being written is finished."""
        for task in (self._writing, self._listing):
            task.close()
