"""What a page does on its module or with files, and its notices: what runs, with Cancel, then what came of it, until it
is closed, the page is left, or another module is connected."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from PySide6.QtCore import QObject, QTimer, QUrl
from PySide6.QtGui import QDesktopServices

from app.engine.procedure import Job, Procedure, Report
from app.text.i18n import tr
from app.text.messages import UserError, labelled, not_written
from protocol.events import EndReason
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, ExportCancelled, Running
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice, NoticeList

if TYPE_CHECKING:
    from app.settings.profiles import Profile
    from ui.session.shown_module import ShownModule

Result = TypeVar("Result")
# What a file or a driver does; anything else is a fault of our own, which is raised: it is no word about a file.
EXPECTED: Final = (UserError, OSError, RuntimeError, ValueError)


class PageJob(NoticeList):
    """`changed`: something began, went on or ended, or a notice changed.

    One procedure at a time runs on the module, of which a second one replaces the first; beside it any number of
    functions may read and write files in the background.
    """

    def __init__(
        self, parent: QObject | None = None, *, module: "ShownModule | None" = None, is_of_module: bool = True
    ) -> None:
        """`module`: it ends with its conversation. `is_of_module`: else of files, and another module ends nothing."""
        super().__init__(parent)
        self.is_of_module = is_of_module
        self.open_in_system: Callable[[QUrl], object] = QDesktopServices.openUrl
        self._module = module
        self._job: Job[Any] | None = None
        self._began_at = 0.0
        self._doing, self._can_cancel = "", True
        self.progress: Report | None = None
        # Functions in the background, each with what it does and how it is cancelled.
        self._tasks: dict[BackgroundTask[Any], tuple[str, Callable[[], object] | None]] = {}
        self._ticking = QTimer(self, interval=100)
        self._ticking.timeout.connect(self.changed)

    # What is said

    @property
    def notices(self) -> list[Notice]:
        """The notice of what runs, then what was said."""
        running = []
        if self._job is not None:
            running.append(progress_notice(self._doing_now(), self.cancel if self._can_cancel else None))
        for task, (doing, cancel) in self._tasks.items():
            text = doing if task.share is None else labelled(doing, f"{task.share * 100:.0f} %")
            running.append(progress_notice(text, cancel))
        return running + self.said

    def end(self, *, is_page_left: bool) -> None:
        """Another module is connected, or only the page was left, which does not end what a person has to act on."""
        if not self._said or self._tasks or (not is_page_left and not self.is_of_module):
            return
        if not (is_page_left and any(map(_is_to_act_on, self.said))):
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
        doing: str = marked("Asking the module…"),
        can_cancel: bool = True,
        expects: frozenset[EndReason] = frozenset(),
    ) -> None:
        """Nothing that was said before holds. `then` is called in the window's thread when the procedure has ended,
        well or not. `doing` (English) is shown until it reports progress. `expects`: see `ShownModule.run`."""
        if self._module is None:
            raise RuntimeError("there is no module to run it on")

        def end(job: Job[Result]) -> None:
            if job is self._job:
                self._job = None
                then(job)
                self.changed.emit()

        def remember(report: Report) -> None:  # in the worker's thread
            self.progress = report

        self._said.clear()
        self.progress = None
        self._doing, self._can_cancel = doing, can_cancel
        self._began_at = self._module.now_s
        self._job = self._module.run(procedure, end, on_progress=remember, expects=expects)
        self.changed.emit()

    def cancel(self) -> None:
        """The procedure cleans up and ends with `Cancelled`."""
        if self._job is not None:
            self._job.cancel()

    def drop(self) -> None:
        """Cancel the procedure; its end is not reported."""
        self.cancel()
        self._job = self.progress = None

    def _doing_now(self) -> str:
        report = self.progress
        if report is None:
            return tr(self._doing)
        values = {name: tr(value) if isinstance(value, str) else value for name, value in report.values}
        what = tr(report.doing, **values)
        return tr("{what} ({done} of {total})", what=what, done=report.done + 1, total=report.total)

    # Files in the background

    @property
    def is_busy(self) -> bool:
        return bool(self._tasks)

    def begin(
        self,
        doing: str,
        act: Callable[[Running], Result],
        then: Callable[[Result], object],
        refused: Callable[[Exception], str],
        *,
        cancelled: Callable[[], object] = bool,
        writes: bool = True,
        can_cancel: bool = True,
        cause: str = "",
    ) -> None:
        """Does it in the background; `then` says what came of it, `refused` why nothing did. What `writes` goes on when
        the window closes; cancelled, it learns that and says what it had done by then. Reading ends at once, and then
        `cancelled` is called."""
        task: BackgroundTask[Result] = BackgroundTask("dps-s file", self, finished_at_close=writes, for_once=True)

        def end(result: Result) -> None:
            self._forget(task)
            then(result)

        def fail(error: Exception) -> None:
            self._forget(task)
            if not isinstance(error, EXPECTED):
                raise error
            text = error.sentence if isinstance(error, ExportCancelled) else refused(error)
            self.notify(_meaning_of(error), text, cause)

        def cancel() -> None:
            task.stop()
            if not writes:
                task.cancel()
                fail(ExportCancelled())
                cancelled()

        if not self._tasks:
            self._said.clear()  # else what came of those that ended meanwhile must still be read
        self._tasks[task] = doing, cancel if can_cancel else None
        task.run(act, end, fail)
        self._ticking.start()
        self.changed.emit()

    def _forget(self, task: BackgroundTask[Any]) -> None:
        del self._tasks[task]
        if not self._tasks:
            self._ticking.stop()
        self.changed.emit()

    def cancel_files(self) -> None:
        for _doing, cancel in tuple(self._tasks.values()):
            if cancel is not None:
                cancel()

    def write_file(self, path: Path, write: Callable[[], Result], saved: Callable[[Result], str] | None = None) -> None:
        """Writes a small file. `saved` is given what `write` returned, where more is to be said than the path."""

        def say(result: Result) -> None:
            self.notify_saved(path, "" if saved is None else saved(result))

        refused = partial(not_written, path)
        self.begin(tr("Saving…"), lambda _running: write(), say, refused, can_cancel=False, cause=str(path))

    def notify_saved(self, path: Path, text: str = "", meaning: Meaning = Meaning.GOOD) -> None:
        """Says where a file was saved, and offers it and its folder."""
        choices = tuple(
            Choice(key, title, partial(self.open_file, where))
            for key, title, where in (("open", tr("Open"), path), ("folder", tr("Show in folder"), path.parent))
        )
        notice = Notice(meaning, text or tr("Saved to {path}.", path=path), choices, self.dismiss)
        self.set_notice(notice, str(path))

    def open_file(self, path: Path) -> None:
        self.open_in_system(QUrl.fromLocalFile(path))

    def read_profile(self, path: Path) -> "Profile | None":
        """Read a profile; None where the file is none, which is said."""
        from app.settings.profile_file import ProfileRefused, read_profile  # the first paint does not wait for TOML

        try:
            return read_profile(path)
        except ProfileRefused as refusal:
            self.notify(Meaning.ATTENTION, refusal.sentence)
            return None


def _is_to_act_on(notice: Notice) -> bool:
    is_offer = notice.meaning is Meaning.INFORMATION and bool(notice.choices)
    return is_offer or notice.meaning in (Meaning.ATTENTION, Meaning.DANGER)


def _meaning_of(error: Exception) -> Meaning:
    if isinstance(error, ExportCancelled):
        return Meaning.INFORMATION
    return Meaning.ATTENTION if isinstance(error, UserError) else Meaning.DANGER


def progress_notice(text: str, cancel: Callable[[], object] | None) -> Notice:
    """Return the notice of a running job."""
    choices = () if cancel is None else (Choice("cancel", tr("Cancel"), cancel),)
    return Notice(Meaning.INFORMATION, text, choices)
