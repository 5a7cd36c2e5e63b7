"""Exports and prints the report of a check, and verifies files of records."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from app.modules.labels import Printer
from app.records.record import SignedRecord
from app.records.report_files import suggested_name, write_report
from app.records.verification import RecordState, Verification, is_green, verify_file
from app.system.files import CANNOT_READ
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import error_text, join_sentences, not_written
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import Running
from ui.files.file_dialogs import AskPath, ThenPath, ask_open, ask_path
from ui.files.report_printer import print_pages
from ui.services.job_notice import JobNotice
from ui.services.storage import Storage
from ui.style.theme import Meaning

SUFFIXES: Final = (".json", ".pdf")
_NO_RECORD: Final = marked("No pre-flight record: {why}.")
AskRecord = Callable[[QWidget, ThenPath], object]


def ask_record(parent: QWidget, then: ThenPath) -> None:
    ask_open(parent, Path.home(), tr("Verify a file…"), "*.json *.pdf", then)


class RecordFiles(QObject):
    def __init__(self, storage: Storage, result: JobNotice, parent: QWidget) -> None:
        super().__init__(parent)
        self.ask_path: AskPath = ask_path
        self.ask_record: AskRecord = ask_record
        self.printer: Printer = print_pages
        self._storage, self._result, self._window = storage, result, parent
        self._folder = Path.home()

    # Reports

    def export(self, signed: SignedRecord) -> None:
        """Ask for a file name, then write the report as PDF and JSON."""
        suggested = self._folder / f"{suggested_name(signed.record)}.pdf"
        write = partial(self._write_report, signed)
        self.ask_path(self._window, tr("Export report…"), suggested, "*.pdf", write)

    def print(self, signed: SignedRecord) -> None:
        """Open the report in the system's own viewer, which knows the printers."""
        path = Path(mkdtemp(prefix="dps-s-")) / f"{suggested_name(signed.record)}.pdf"
        self._write(signed, path, lambda: self._result.open_file(path))

    def _write_report(self, signed: SignedRecord, path: Path) -> None:
        self._folder = path.parent
        saved = tr("Saved to {path}.", path=f"{path}, {path.with_suffix('.json')}")
        self._write(signed, path, lambda: self._result.notify_saved(path, saved))

    def _write(self, signed: SignedRecord, path: Path, then: Callable[[], object]) -> None:
        write = partial(write_report, path, signed, self.printer)
        self._result.begin(tr("Saving…"), lambda _running: write(), lambda _done: then(), partial(not_written, path))

    # Verifying

    def choose_and_verify(self) -> None:
        self.ask_record(self._window, self.verify)

    def verify(self, path: Path) -> None:
        """Verify a file in the background: it may be large, and on a slow disk. It replaces one being read."""
        storage = self._storage

        def work(_running: Running) -> Verification:
            from app.archive.archive import known_names  # no start waits for it

            return verify_file(path, known_names(storage.begun))

        doing = tr("Reading: {what}", what=path.name)
        self._result.begin(doing, work, partial(self._notify_verified, path), partial(_why_unread, path), writes=False)

    def _notify_verified(self, path: Path, done: Verification) -> None:
        meaning = Meaning.INFORMATION  # an intact NO-GO is not shown in green
        if done.state is not RecordState.INTACT:
            meaning = Meaning.DANGER
        elif is_green(done):
            meaning = Meaning.GOOD
        sentences = join_sentences(sentence.translated() for sentence in done.sentences())
        self._result.notify(meaning, f"{clean(path.name, longest=60)} — {sentences}")


def _why_unread(path: Path, error: Exception) -> str:
    file = clean(path.name, longest=60)
    if isinstance(error, UserError):
        return f"{file} — {tr(_NO_RECORD, why=error.sentence)}"
    return tr(CANNOT_READ, file=file, why=error_text(error))
