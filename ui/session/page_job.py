"""What a page does in the background or on its module, and says of it: progress with Cancel while it runs, then its
result until that is closed, the page is left, or another module is connected."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from PySide6.QtCore import QObject, QTimer, QUrl, Signal
from PySide6.QtGui import QDesktopServices

from app.engine.procedure import Job, Procedure, Report
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences, labelled, not_written
from protocol.events import EndReason
from ui.core.background_task import BackgroundTask, ExportCancelled, Running
from ui.style.appearance import announce
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

if TYPE_CHECKING:
    from app.settings.profiles import Profile
    from ui.session.shown_module import ShownModule

Result = TypeVar("Result")
# What a file or a driver does; anything else is a fault of our own, which is raised: it is no word about a file.
EXPECTED: Final = (UserError, OSError, RuntimeError, ValueError)


class PageJob(QObject):
    """`changed`: something began, went on or ended, or the notice changed.

    One procedure at a time runs on the module, of which a second one replaces the first; beside it one function that
    reads and one that writes may run in the background, and any number of small files be written.
    """

    changed = Signal()

    def __init__(
        self, parent: QObject | None = None, *, module: "ShownModule | None" = None, is_of_module: bool = True
    ) -> None:
        """`module`: it ends with its conversation. `is_of_module`: else of files, and another module ends nothing."""
        super().__init__(parent)
        self.is_of_module = is_of_module
        self.open_in_system: Callable[[QUrl], object] = QDesktopServices.openUrl
        self._find: Callable[[], Notice | None] | None = None
        self._module = module
        self._job: Job[Any] | None = None
        self._began_at = 0.0
        self.progress: Report | None = None
        self._reading: BackgroundTask[Any] = BackgroundTask("dps-s read", self)
        self._writing: BackgroundTask[Any] = BackgroundTask("dps-s save", self, finished_at_close=True)
        # How many files are being written by `write_file`, and what came of those that were meanwhile.
        self._files = 0
        self._outcomes: list[tuple[Meaning, str]] = []
        self._ticking = QTimer(self, interval=100)
        self._ticking.timeout.connect(self._tick)

    # What is said

    def set_notice(self, notice: Notice | Callable[[], Notice | None] | None) -> None:
        """Screen readers hear it once; None removes it. What finds it is called whenever it is shown, and gives None
        once it is over."""
        self._find = notice if callable(notice) else lambda: notice
        if (shown := self._find()) is not None:
            announce(shown.text, is_urgent=shown.meaning is Meaning.DANGER)
        self.changed.emit()

    def dismiss(self) -> None:
        self.set_notice(None)

    def notify(self, meaning: Meaning, text: str) -> None:
        self.set_notice(Notice(meaning, text))

    def notify_saved(self, path: Path, text: str = "", meaning: Meaning = Meaning.GOOD) -> None:
        """Says where a file was saved, and offers it and its folder."""
        choices = tuple(
            Choice(key, title, partial(self.open_file, where))
            for key, title, where in (("open", tr("Open"), path), ("folder", tr("Show in folder"), path.parent))
        )
        self.set_notice(Notice(meaning, text or tr("Saved to {path}.", path=path), choices, self.dismiss))

    def open_file(self, path: Path) -> None:
        self.open_in_system(QUrl.fromLocalFile(path))

    def result_notice(self) -> Notice | None:
        """Progress in the background, else the last result; None if there is none, or it was closed. What offers no
        choice can be closed."""
        notice = None if self._find is None else self._find()
        return notice if notice is None or notice.choices else notice._replace(dismiss=self.dismiss)

    def notice(self, waiting: str, *, can_cancel: bool = True) -> Notice | None:
        """The running procedure (`waiting`, English, until it reports progress), else the last notice."""
        if self._job is None:
            return self.result_notice()
        text = tr(waiting)
        if (report := self.progress) is not None:
            values = {name: tr(value) if isinstance(value, str) else value for name, value in report.values}
            doing = tr(report.doing, **values)
            text = tr("{what} ({done} of {total})", what=doing, done=report.done + 1, total=report.total)
        return progress_notice(text, self.cancel if can_cancel else None)

    def end(self, *, is_page_left: bool) -> None:
        """Another module is connected, or only the page was left, which does not end what a person has to act on."""
        if self._find is None or self.is_busy or (not is_page_left and not self.is_of_module):
            return
        notice = self.result_notice()
        is_to_act_on = notice is not None and (
            notice.meaning in (Meaning.ATTENTION, Meaning.DANGER)
            or (notice.meaning is Meaning.INFORMATION and bool(notice.choices))
        )
        if not (is_page_left and is_to_act_on):
            self.dismiss()

    # A procedure on the module

    @property
    def is_running(self) -> bool:
        return self._job is not None

    @property
    def can_run(self) -> bool:
        return self._module is not None and self._module.is_going and self._job is None

    @property
    def looks_free(self) -> bool:
        """Whether its buttons are shown as enabled: a job that ends within half a second does not grey them for an
        instant. While it runs a press does nothing."""
        module = self._module
        if module is None or not module.is_going:
            return False
        return self._job is None or module.now_s - self._began_at < 0.5

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        expects: frozenset[EndReason] = frozenset(),
    ) -> None:
        """Clears the notice. `then` is called in the window's thread when the procedure has ended, well or not.
        `expects`: see `ShownModule.run`."""
        if self._module is None:
            raise RuntimeError("there is no module to run it on")

        def end(job: Job[Result]) -> None:
            if job is self._job:
                self._job = None
                then(job)
                self.changed.emit()

        def remember(report: Report) -> None:  # in the worker's thread
            self.progress = report

        self.progress = self._find = None
        self._began_at = self._module.now_s
        self._job = self._module.run(procedure, end, on_progress=remember, expects=expects)
        self.changed.emit()

    def cancel(self) -> None:
        """The procedure cleans up and ends with `Cancelled`."""
        if self._job is not None:
            self._job.cancel()

    def drop(self) -> None:
        """Drop the procedure; its end is not reported."""
        self._job = self.progress = None

    # Functions in the background

    @property
    def is_writing(self) -> bool:
        return bool(self._files) or self._writing.is_running

    @property
    def is_busy(self) -> bool:
        return self._reading.is_running or self.is_writing

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

        def fail(error: Exception) -> None:
            self.dismiss()
            if not isinstance(error, EXPECTED):
                raise error
            self.notify(_meaning_of(error), refused(error))

        self._find = progress
        task.run(act, end, fail)
        self._ticking.start()
        self.changed.emit()

    def cancel_files(self) -> None:
        self._writing.stop()
        if self._reading.is_running:
            self._reading.cancel()
            self.notify(Meaning.INFORMATION, tr("Cancelled."))

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
                grave = (Meaning.GOOD, Meaning.INFORMATION, Meaning.ATTENTION, Meaning.DANGER)
                worst = max((meaning for meaning, _ in outcomes), key=grave.index)
                told = join_sentences(text for _, text in outcomes)
                self.notify_saved(path, told) if worst is Meaning.GOOD else self.notify(worst, told)

        def fail(error: Exception) -> None:
            end(_meaning_of(error), not_written(path, error))
            if not isinstance(error, EXPECTED):
                raise error

        text = saved or (lambda _result: tr("Saved to {path}.", path=path))
        writing: BackgroundTask[Result] = BackgroundTask("dps-s save", self, finished_at_close=True, for_once=True)
        writing.run(lambda _running: write(), lambda result: end(Meaning.GOOD, text(result)), fail)

    def read_profile(self, path: Path) -> "Profile | None":
        """None where the file is no profile, which is said."""
        from app.settings.profiles import ProfileRefused, read_profile  # the first paint does not wait for TOML

        try:
            return read_profile(path)
        except ProfileRefused as refusal:
            what = tr("{file} is not a profile", file=path.name)
            self.notify(Meaning.ATTENTION, labelled(what, refusal.sentence))
            return None

    def _tick(self) -> None:
        if self.is_busy:
            self.changed.emit()
        else:
            self._ticking.stop()


def _meaning_of(error: Exception) -> Meaning:
    if isinstance(error, ExportCancelled):
        return Meaning.INFORMATION
    return Meaning.ATTENTION if isinstance(error, UserError) else Meaning.DANGER


def progress_notice(text: str, cancel: Callable[[], object] | None) -> Notice:
    """Of a running job."""
    choices = () if cancel is None else (Choice("cancel", tr("Cancel"), cancel),)
    return Notice(Meaning.INFORMATION, text, choices)
