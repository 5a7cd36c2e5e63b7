"""One procedure at a time on the module, as a page shows it: progress, cancel, result, notice."""

from collections.abc import Callable
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Procedure, Report, Result
from app.engine.worker import Job
from app.text.i18n import tr
from ui.core.announcer import announcer
from ui.core.connector import Connector
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class RunningJob(QObject):
    """`changed`: a procedure began or ended, or the notice changed.

    A second `run` replaces the first, whose end is then not reported.
    """

    changed = Signal()

    def __init__(self, connector: Connector, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.progress: Report | None = None
        self._connector = connector
        self._job: Job[Any] | None = None
        self._notice: Callable[[], Notice | None] | None = None

    @property
    def is_running(self) -> bool:
        return self._job is not None

    @property
    def can_run(self) -> bool:
        return self._connector.is_open and self._job is None

    def run(self, procedure: Procedure[Result], then: Callable[[Job[Result]], None]) -> None:
        """Clears the notice. `then` is called in the window's thread when the procedure has ended, well or not."""
        self.progress = self._notice = None
        self._job = self._connector.run(procedure, partial(self._end, then), on_progress=self._remember_progress)
        self.changed.emit()

    def cancel(self) -> None:
        """It cleans up and ends with `Cancelled`."""
        if self._job is not None:
            self._job.cancel()

    def forget(self) -> None:
        """Drop the procedure; its end is not reported."""
        self._job = self.progress = None

    def set_notice(self, make: Callable[[], Notice | None] | None) -> None:
        """Set the notice; `make` is called whenever it is shown, None removes it. Screen readers hear it once."""
        self._notice = make
        said = None if make is None else make()
        if said is not None:
            announcer().announce(said.text, is_urgent=said.meaning is Meaning.DANGER)
        self.changed.emit()

    def notify(self, meaning: Meaning, make: Callable[[], str]) -> None:
        self.set_notice(lambda: Notice(meaning, make(), dismiss=self.dismiss))

    def dismiss(self) -> None:
        self.set_notice(None)

    def notice(self, waiting: str, *, can_cancel: bool = True) -> Notice | None:
        """The running procedure (`waiting`, English, until it reports progress), else the last notice."""
        if self._job is None:
            return None if self._notice is None else self._notice()
        report, text = self.progress, tr(waiting)
        if report is not None:
            doing = tr(report.doing, **{name: _spoken(value) for name, value in report.values})
            text = tr("{what} ({done} of {total})", what=doing, done=report.done + 1, total=report.total)
        return Notice(Meaning.INFORMATION, text, (Choice("cancel", tr("Cancel"), self.cancel),) if can_cancel else ())

    def _remember_progress(self, report: Report) -> None:
        """In the worker's thread."""
        self.progress = report

    def _end(self, then: Callable[[Job[Result]], None], job: Job[Result]) -> None:
        if job is self._job:
            self._job = None
            then(job)
            self.changed.emit()


def _spoken(value: object) -> object:
    return tr(value) if isinstance(value, str) else value
