"""One procedure at a time on the module, as a page shows it: progress, cancel, result, notice; the question before a
write that takes protection away."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from app.engine.procedure import Job, Procedure, Report, Result
from app.procedures.write import SettingChange, risk_message
from app.text.i18n import tr
from protocol.events import EndReason
from ui.services.job_notice import JobNotice, progress_notice
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

GREYED_AFTER_S: Final = 0.5


class RunningJob(JobNotice):
    """Belongs to one module, and ends with its conversation. A second `run` replaces the first, whose end is then not
    reported."""

    def __init__(self, module: ShownModule) -> None:
        super().__init__(module)
        self.progress: Report | None = None
        self._module = module
        self._job: Job[Any] | None = None
        self._began_at = 0.0

    @property
    def is_running(self) -> bool:
        return self._job is not None

    @property
    def can_run(self) -> bool:
        return self._module.is_going and self._job is None

    @property
    def looks_free(self) -> bool:
        """Whether its buttons are shown as enabled: a job that ends at once does not grey them for an instant. While it
        runs a press does nothing."""
        is_short = self._job is not None and self._module.now_s - self._began_at < GREYED_AFTER_S
        return self.can_run or (self._module.is_going and is_short)

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        expects: frozenset[EndReason] = frozenset(),
    ) -> None:
        """Clears the notice. `then` is called in the window's thread when the procedure has ended, well or not.
        `expects`: see `ShownModule.run`."""
        self.progress = self._find = None
        self._began_at = self._module.now_s
        self._job = self._module.run(
            procedure, partial(self._end, then), on_progress=self._remember_progress, expects=expects
        )
        self.changed.emit()

    def cancel(self) -> None:
        """It cleans up and ends with `Cancelled`."""
        if self._job is not None:
            self._job.cancel()

    def drop(self) -> None:
        """Drop the procedure; its end is not reported."""
        self._job = self.progress = None

    def notice(self, waiting: str, *, can_cancel: bool = True) -> Notice | None:
        """The running procedure (`waiting`, English, until it reports progress), else the last notice."""
        if self._job is None:
            return self.result_notice()
        return progress_notice(_progress_text(self.progress, waiting), self.cancel if can_cancel else None)

    def _remember_progress(self, report: Report) -> None:
        """In the worker's thread."""
        self.progress = report

    def _end(self, then: Callable[[Job[Result]], None], job: Job[Result]) -> None:
        if job is self._job:
            self._job = None
            then(job)
            self.changed.emit()


def _progress_text(report: Report | None, waiting: str) -> str:
    """What a procedure does; `waiting`, English, until it reports progress."""
    if report is None:
        return tr(waiting)
    doing = tr(report.doing, **{name: _spoken(value) for name, value in report.values})
    return tr("{what} ({done} of {total})", what=doing, done=report.done + 1, total=report.total)


def _spoken(value: object) -> object:
    return tr(value) if isinstance(value, str) else value


Write = Callable[..., None]
"""Called with the changes that were shown and `accepted`."""


def is_risk_open(changes: Sequence[SettingChange], accepted: frozenset[SettingChange]) -> bool:
    """Whether the question has to be asked before these changes are written."""
    return any(change.risks and change not in accepted for change in changes)


def risk_notice(changes: Sequence[SettingChange], write: Write, cancel: Callable[[], None]) -> Notice | None:
    """The question in the language in use; None if the changes take nothing away."""
    risk = risk_message(changes)
    if risk is None:
        return None
    anyway = partial(write, accepted=frozenset(changes))
    choices = (
        Choice("not_now", tr("Cancel"), cancel),
        Choice("write_anyway", tr("Write anyway"), anyway, is_step=True),
    )
    return Notice(Meaning.ATTENTION, risk.translated(), choices)
