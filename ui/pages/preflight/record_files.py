"""Exports reports and verifies files of records."""

import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from app.preflight.verdict import Verdict
from app.records.labels import Printer
from app.records.record import Record, recorded_verdict
from app.records.report_files import suggested_name, write_report
from app.records.verification import RecordState, Verification, verify_file
from app.stations.known import Stations
from app.stations.station import fingerprint_of
from app.store.store import Store
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import error_text, join_sentences, not_written
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import AskPath, AskText, ThenPath, ask_open, ask_path, ask_text
from ui.files.report_printer import print_pages
from ui.services.job_notice import JobNotice
from ui.services.storage import Storage
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

_log = logging.getLogger(__name__)
SUFFIXES: Final = (".json", ".pdf")
AskRecord = Callable[[QWidget, ThenPath], object]


def ask_record(parent: QWidget, then: ThenPath) -> None:
    ask_open(parent, Path.home(), tr("Verify a file…"), "*.json *.html *.htm *.pdf", then)


class RecordFiles(QObject):
    def __init__(self, storage: Storage, result: JobNotice, parent: QWidget) -> None:
        super().__init__(parent)
        self.ask_path: AskPath = ask_path
        self.ask_record: AskRecord = ask_record
        self.ask_name: AskText = ask_text
        self.printer: Printer = print_pages
        self._storage, self._result, self._window = storage, result, parent
        self._folder = Path.home()
        self._verifying: BackgroundTask[Verification] = BackgroundTask("dps-s verify", self)

    # Printing

    def print_record(self, record: Record) -> None:
        """Ask for a file name, then write the report as PDF and JSON."""
        suggested = self._folder / f"{suggested_name(record)}.pdf"
        write = partial(self._write_report, record)
        self.ask_path(self._window, tr("Export report…"), suggested, "*.pdf", write)

    def _write_report(self, record: Record, path: Path) -> None:
        self._folder = path.parent
        self._result.write_file(path, partial(write_report, path, record, self.printer), beside=".json")

    # Verifying

    def choose_and_verify(self) -> None:
        self.ask_record(self._window, self.verify)

    def verify(self, path: Path) -> None:
        """Verify a file in a background thread: it may be large, and on a slow disk. It replaces one being read."""
        self._result.notify(Meaning.INFORMATION, lambda: tr("Reading: {what}", what=path.name))
        store = self._storage.store
        folder = self._storage.folder

        def work(_running: Running) -> Verification:
            from app.archive.archive import kept_records  # no start waits for it

            with kept_records(store if isinstance(store, Store) else None, folder) as kept:
                return verify_file(path, kept, Stations(folder).find)

        self._verifying.run(
            work,
            partial(self._notify_verified, path),
            partial(self._notify_unread, path),
        )

    def _notify_unread(self, path: Path, error: Exception) -> None:
        is_expected = isinstance(error, OSError | ValueError)  # ValueError: a NUL in the name
        if not is_expected:
            _log.error("%s could not be verified", path, exc_info=error)
        file = clean(path.name, longest=60)

        def text() -> str:
            why = error_text(error) if is_expected else type(error).__name__
            return tr("{file} cannot be read: {why}.", file=file, why=why)

        self._result.notify(Meaning.ATTENTION, text)

    def _notify_verified(self, path: Path, done: Verification) -> None:
        file = clean(path.name, longest=60)
        meaning = _MEANINGS[done.state]
        if meaning is Meaning.GOOD and recorded_verdict(done.record or {}) is not Verdict.GO:
            meaning = Meaning.INFORMATION  # an intact NO-GO is not shown in green
        is_to_trust = done.state is RecordState.UNKNOWN_STATION
        trust = partial(self._ask_to_trust, path, done.signer)

        def notice() -> Notice:
            sentences = join_sentences(sentence.translated() for sentence in done.sentences())
            choices = (Choice("trust_station", tr("Trust this station…"), trust),) if is_to_trust else ()
            return Notice(meaning, f"{file} — {sentences}", choices, self._result.dismiss)

        self._result.set_notice(notice)

    def _ask_to_trust(self, path: Path, public: bytes | None) -> None:
        if public is None:
            return
        label = tr(
            "Signed by {fingerprint}. Trust it only if that computer shows the same. Name:",
            fingerprint=fingerprint_of(public),
        )
        self.ask_name(self._window, tr("Trust this station…"), label, partial(self._trust, path, public))

    def _trust(self, path: Path, public: bytes, name: str) -> None:
        try:
            Stations(self._storage.folder).trust(public, name)
        except OSError as error:
            self._result.notify(Meaning.DANGER, partial(not_written, tr("Known stations"), error))
            return
        self.verify(path)


_MEANINGS: Final = {
    RecordState.INTACT: Meaning.GOOD,
    RecordState.NOT_SIGNED: Meaning.ATTENTION,
    RecordState.UNKNOWN_STATION: Meaning.ATTENTION,
    RecordState.REVOKED_STATION: Meaning.DANGER,
    RecordState.ALTERED: Meaning.DANGER,
    RecordState.CONTRADICTORY: Meaning.DANGER,
    RecordState.CHAIN_BROKEN: Meaning.DANGER,
    RecordState.UNREADABLE: Meaning.ATTENTION,
}
