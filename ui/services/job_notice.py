"""What a page says of a job: its progress with "Cancel" while it runs, then its result until it is dismissed, the page
is left, or another module is connected."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

from PySide6.QtCore import QObject, QTimer, QUrl, Signal
from PySide6.QtGui import QDesktopServices

from app.settings.profiles import Profile
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences, labelled, not_written
from ui.core.background_task import BackgroundTask, ExportCancelled, Running
from ui.style.appearance import announce
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

Result = TypeVar("Result")
PROGRESS_EVERY_MS: Final = 100


class JobNotice(QObject):
    """`changed`: a job began, went on or ended, or the notice changed.

    One that reads and one that writes may run in the background, and any number of small files be written."""

    changed = Signal()

    def __init__(self, parent: QObject | None = None, *, is_of_module: bool = True) -> None:
        """`is_of_module`: else of files, and another module ends nothing of it."""
        super().__init__(parent)
        self.is_of_module = is_of_module
        self.open_in_system: Callable[[QUrl], object] = QDesktopServices.openUrl
        # Finds what is to be said now; None where that is nothing.
        self._find: Callable[[], Notice | None] | None = None
        self._reading: BackgroundTask[Any] = BackgroundTask("dps-s read", self)
        self._writing: BackgroundTask[Any] = BackgroundTask("dps-s save", self, finished_at_close=True)
        # How many files are being written by `write_file`, and what came of those that were meanwhile.
        self._files = 0
        self._outcomes: list[tuple[Meaning, str]] = []
        self._ticking = QTimer(self, interval=PROGRESS_EVERY_MS)
        self._ticking.timeout.connect(self._tick)

    def set_notice(self, notice: Notice | None) -> None:
        """Sets the notice; None removes it. Screen readers hear it once."""
        self._find = None if notice is None else lambda: notice
        self._say()

    def set_notice_of_now(self, find: Callable[[], Notice | None]) -> None:
        """Sets a notice of what is so now: `find` is called whenever it is shown, and gives None once it is over."""
        self._find = find
        self._say()

    def _say(self) -> None:
        notice = self.result_notice()
        if notice is not None:
            announce(notice.text, is_urgent=notice.meaning is Meaning.DANGER)
        self.changed.emit()

    def notify(self, meaning: Meaning, text: str) -> None:
        self.set_notice(Notice(meaning, text))

    def notify_saved(self, path: Path, text: str = "", meaning: Meaning = Meaning.GOOD) -> None:
        """Says where a file was saved, and offers it and its folder."""
        choices = (
            Choice("open", tr("Open"), partial(self.open_file, path)),
            Choice("folder", tr("Show in folder"), partial(self.open_file, path.parent)),
        )
        self.set_notice(Notice(meaning, text or tr("Saved to {path}.", path=path), choices, self.dismiss))

    def open_file(self, path: Path) -> None:
        """Opens a file or a folder in the system's own program."""
        self.open_in_system(QUrl.fromLocalFile(path))

    def read_profile(self, path: Path) -> Profile | None:
        """None where the file is no profile, which is said."""
        from app.settings.profiles import ProfileRefused, read_profile  # the first paint does not wait for TOML

        try:
            return read_profile(path)
        except ProfileRefused as refusal:
            what = tr("{file} is not a profile", file=path.name)
            self.notify(Meaning.ATTENTION, labelled(what, refusal.sentence))
            return None

    def begin(
        self,
        doing: str,
        act: Callable[[Running], Result],
        then: Callable[[Result], object],
        refused: Callable[[Exception], str],
        *,
        writes: bool = True,
    ) -> None:
        """Does it in the background; `then` says what came of it, `refused` why nothing did. What `writes` goes on when
        the window closes; cancelled, it learns that and says what it had done by then. Reading ends at once."""
        task = self._writing if writes else self._reading

        def progress() -> Notice:
            text = doing if task.share is None else labelled(doing, f"{task.share * 100:.0f} %")
            return progress_notice(text, self.cancel_files)

        def end(result: Result) -> None:
            self.dismiss()
            then(result)

        self._find = progress
        task.run(act, end, partial(self._refuse, refused))
        self._ticking.start()
        self.changed.emit()

    def write_file(self, path: Path, write: Callable[[], Result], saved: Callable[[Result], str] | None = None) -> None:
        """Writes a small file, and says what came of it, and of each other one that is written meanwhile; `saved` is
        given what `write` returned, where more is to be said than the path."""
        if not self._files:
            self._outcomes = []
        self._files += 1
        self.set_notice(progress_notice(tr("Saving…"), None))

        def end(meaning: Meaning, text: str) -> None:
            self._files -= 1
            outcomes = self._outcomes
            outcomes.append((meaning, text))
            if not self._files:
                worst = max((meaning for meaning, _ in outcomes), key=_WRITTEN.index)
                told = join_sentences(text for _, text in outcomes)
                self.notify_saved(path, told) if worst is Meaning.GOOD else self.notify(worst, told)

        def fail(error: Exception) -> None:
            end(_meaning_of(error), not_written(path, error))
            if not isinstance(error, UserError | OSError | RuntimeError | ValueError):
                raise error

        writing: BackgroundTask[Result] = BackgroundTask("dps-s save", self, finished_at_close=True, for_once=True)
        text = saved or (lambda _result: tr("Saved to {path}.", path=path))
        writing.run(lambda _running: write(), lambda result: end(Meaning.GOOD, text(result)), fail)

    @property
    def is_writing(self) -> bool:
        return bool(self._files) or self._writing.is_running

    @property
    def is_busy(self) -> bool:
        """In the background."""
        return self._reading.is_running or self.is_writing

    def cancel_files(self) -> None:
        self._writing.stop()
        if self._reading.is_running:
            self._reading.cancel()
            self.notify(Meaning.INFORMATION, tr("Cancelled."))

    def _refuse(self, text: Callable[[Exception], str], error: Exception) -> None:
        if not isinstance(error, UserError | OSError | RuntimeError | ValueError):
            self.dismiss()
            raise error
        self.notify(_meaning_of(error), text(error))

    def _tick(self) -> None:
        if self.is_busy:
            self.changed.emit()
        else:
            self._ticking.stop()

    def dismiss(self) -> None:
        self.set_notice(None)

    def end(self, *, is_page_left: bool) -> None:
        """Another module is connected, or only the page was left, which does not end what a person has to act on."""
        notice = self.result_notice()
        if self._find is None or self.is_busy or (not is_page_left and not self.is_of_module):
            return
        is_trouble = notice is not None and notice.meaning in (Meaning.ATTENTION, Meaning.DANGER)
        is_question = notice is not None and notice.meaning is Meaning.INFORMATION and bool(notice.choices)
        if not (is_page_left and (is_trouble or is_question)):
            self.dismiss()

    def result_notice(self) -> Notice | None:
        """Progress, else the last result; None if there is none, or it was dismissed. What offers no choice can be
        closed."""
        notice = None if self._find is None else self._find()
        return notice if notice is None or notice.choices else notice._replace(dismiss=self.dismiss)


_WRITTEN: Final = (Meaning.GOOD, Meaning.ATTENTION, Meaning.DANGER)
"""The worst last."""


def _meaning_of(error: Exception) -> Meaning:
    if isinstance(error, ExportCancelled):
        return Meaning.INFORMATION
    return Meaning.ATTENTION if isinstance(error, UserError) else Meaning.DANGER


def progress_notice(text: str, cancel: Callable[[], None] | None) -> Notice:
    """Of a running job."""
    choices = () if cancel is None else (Choice("cancel", tr("Cancel"), cancel),)
    return Notice(Meaning.INFORMATION, text, choices)
