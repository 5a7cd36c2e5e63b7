"""Controller of the Settings page: read, write and verify, power-cycle test; one job at a time."""

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.identity import Trust
from app.engine.procedure import Cancelled
from app.engine.setting_changes import ChangedSetting
from app.engine.snapshots import Snapshot
from app.engine.worker import Job
from app.procedures.power_cycle import Ending, PowerCycleResult, survives_power_cycle
from app.procedures.read import Everything, read_everything
from app.procedures.write_all import Leave, WriteReport, write_all
from app.safety.acts import Act
from app.safety.interlocks import Interlock, Refusal, interlock_inputs, refusals
from app.settings.form import RowState, SettingsForm
from app.text.i18n import tr
from app.text.sentences import together
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.services.context import Services
from ui.services.running_job import RunningJob
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class SettingsController(QObject):
    """Owns the form. `changed`: something about it or about the work is different."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.form = SettingsForm()
        self.found: Snapshot | None = None
        """The settings as they were before the first write to this module."""
        self._services = services
        self._connector = services.connector
        services.pending_edits.changed = self._changed_settings
        self.job = RunningJob(services.connector, self)
        self.job.changed.connect(self.changed)
        self._whose: str | None = None
        self._connector.changed.connect(self._watch_module)
        services.pending_edits.count = self.count_unsent
        services.pending_edits.discard = self.discard

    @property
    def can_edit(self) -> bool:
        """There is, or was and is expected back, a module to write to."""
        return self._connector.is_wanted and not self.form.is_writing

    @property
    def can_write(self) -> bool:
        """Else the engine would refuse it."""
        return self.job.can_run and self._connector.device.presence is Presence.ONLINE and not self.is_identifying

    @property
    def is_identifying(self) -> bool:
        """It is being read which module answers; where that ends in doubt, writing is refused with the reason."""
        return self._connector.is_open and self._connector.identity.trust is Trust.OPEN

    def count_unsent(self) -> int:
        return self.form.count_unsent(self._connector.device, self._connector.clock()) if self._whose else 0

    def _changed_settings(self) -> tuple[ChangedSetting, ...]:
        """What reads differently than before and was not written here."""
        if self._whose:
            self.form.rows(self._connector.device, self._connector.clock())
        return tuple(self.form.watch.changed.values())

    def discard(self) -> None:
        self.form.revert()
        self.changed.emit()

    def notice(self) -> Notice | None:
        """What is being done, or was said last, in the language in use."""
        return self.job.notice(marked("Asking the module…"))

    # What a person does

    def read_all(self) -> None:
        if self.job.can_run:
            self.job.run(read_everything(), self._end_reading)

    def write(self, *, is_warned: bool = False, is_unlocked: bool = False) -> None:
        """Write what is wanted and prove it. Warns first where that is needed, and says why where it is refused."""
        connector = self._connector
        changes = self.form.changes(connector.device, connector.clock())
        if not changes or not self.can_write:
            return
        if not is_warned and self._warnings():
            self.job.say(self._warning_notice)
        elif open_conditions := self._refusals(is_unlocked=is_unlocked):
            self.job.say(partial(self._refused_notice, open_conditions))
        else:
            leave = Leave(
                journal=self._services.storage.journal(connector.target),
                armed=self._services.armed,
                is_unlocked=is_unlocked,
                keep_snapshot=self._keep_snapshot if self.found is None else None,
            )
            self.form.begin_write(changes)
            self.job.run(write_all(changes, leave), self._end_writing)

    def want_as_found(self) -> None:
        if self.found is not None:
            self.edit(partial(self.form.fill, self.found.settings))

    def edit(self, act: Callable[[], object]) -> None:
        """Do one thing to the form; what was said about its state before no longer holds."""
        if self.can_edit:
            act()
            self.job.dismiss()

    def check_survival(self) -> None:
        if self.job.can_run and self.form.written:
            self.job.run(survives_power_cycle(dict(self.form.written)), self._end_survival)

    # How it ends

    def _end_reading(self, job: Job[Everything]) -> None:
        if job.run.error is not None:
            self.job.say(partial(_broken_off_notice, job.run.error))
            return
        self.form.watch.accept()  # a person asked for what stands now
        missing = len(job.outcome().errors)
        if missing:
            self.job.say(partial(self._unread_notice, missing))

    def _end_writing(self, job: Job[WriteReport]) -> None:
        if job.run.error is not None:
            self.form.lose_write()
            broken_off = partial(_broken_off_notice, job.run.error)
            self.job.say(broken_off)
            if isinstance(job.run.error, Cancelled) and self.job.can_run:  # what stands now is soon known
                self.job.run(read_everything(), lambda _job: self.job.say(broken_off))
            return
        report = job.outcome()
        self.form.take_results(report.results)
        if report.refusals:
            self.job.say(partial(self._refused_notice, report.refusals))
        else:
            self.job.say(partial(self._written_notice, report))

    def _end_survival(self, job: Job[PowerCycleResult]) -> None:
        if job.run.error is not None:
            self.job.say(partial(_broken_off_notice, job.run.error))
            return
        survival = job.outcome()
        self.form.stamp(survival.stamps)
        self.job.say(partial(_survival_notice, survival))

    def _keep_snapshot(self, snapshot: Snapshot) -> Future[int] | None:
        """In the worker's thread."""
        self.found = snapshot
        return self._services.storage.keep_snapshot(snapshot, self._connector.connection.port)

    def _watch_module(self) -> None:
        whose = self._connector.whose if self._connector.is_wanted else None
        if whose != self._whose:
            self._whose, self.found = whose, None
            self.form.forget()
            self.job.dismiss()
        self.changed.emit()

    # What is said

    def _warnings(self) -> list[tuple[str, str]]:
        connector = self._connector
        rows = self.form.rows(connector.device, connector.clock())
        return [(tr(row.command.title), together(one.sentence for one in row.warnings)) for row in rows if row.warnings]

    def _warning_notice(self) -> Notice | None:
        warnings = self._warnings()
        if not warnings:
            return None
        text = together(tr("{setting}: {why}", setting=setting, why=why) for setting, why in warnings)
        return Notice(Meaning.ATTENTION, text, self._choices(is_locked=True))

    def _choices(self, *, is_locked: bool) -> tuple[Choice, ...]:
        """Both steps of a write that is asked about have places of their own, whichever is shown."""
        anyway, unlocked = partial(self.write, is_warned=True), partial(self.write, is_warned=True, is_unlocked=True)
        once = tr("Unlock this one write")
        return (
            Choice("not_now", tr("Cancel"), self.job.dismiss),
            Choice("write_anyway", tr("Write anyway"), anyway, is_step=True, is_shown=is_locked),
            Choice("unlock_once", once, unlocked, is_step=True, is_shown=not is_locked),
        )

    def _refusals(self, *, is_unlocked: bool) -> tuple[Refusal, ...]:
        connector = self._connector
        armed = self._services.armed.act
        now_is = interlock_inputs(
            connector.device,
            connector.clock(),
            must_be_proven=False,
            is_the_one_meant=connector.identity.is_proven,
            armed=armed,
            is_unlocked=is_unlocked,
        )
        found = refusals(Act.WRITE, now_is)
        # Where it is merely not known whether the module is locked, the engine asks it: here only "ACTIVE" refuses.
        return tuple(one for one in found if one.condition is not Interlock.MAY_WRITE or now_is.active)

    def _refused_notice(self, open_conditions: tuple[Refusal, ...]) -> Notice:
        text = together([tr("Nothing was written."), *(one.sentence for one in open_conditions)])
        can_unlock = all(one.condition is Interlock.MAY_WRITE for one in open_conditions)
        choices = self._choices(is_locked=False) if can_unlock else ()
        return Notice(Meaning.ATTENTION, text, choices, None if can_unlock else self.job.dismiss)

    def _written_notice(self, report: WriteReport) -> Notice:
        """What stands of it now: what was verified and changed since is no longer said to be verified."""
        rows = {row.command: row for row in self.form.rows(self._connector.device, self._connector.clock())}
        states = [rows[one.command].state for one in report.results if one.command in rows]
        verified = states.count(RowState.VERIFIED)
        received = sum(one.is_fine and one.verified is None for one in report.results)
        bad = sum(row.state is RowState.FAILED for row in rows.values())
        moved = sum(row.state is RowState.CHANGED for row in rows.values())
        since = len(report.results) - verified - received - bad - states.count(RowState.CHANGED)
        parts = []
        if verified:
            parts.append(tr("Verified: {count}.", count=verified))
        if received:
            parts.append(tr("Acknowledged, cannot be read: {count}.", count=received))
        if bad:
            parts.append(tr("NOT as set: {count}; see the rows.", count=bad))
        if moved:
            parts.append(tr("Changed without being written: {count}; see the rows.", count=moved))
        if report.unread:
            titles = ", ".join(tr(command.title) for command in report.unread)
            parts.append(tr("Not read back: {names}.", names=titles))
        if since > 0:
            parts.append(tr("Not verified, but read as set since: {count}.", count=since))
        survive: tuple[Choice, ...] = ()
        if verified:
            survive = (Choice("survives", tr("Survives a power cycle?"), self.check_survival),)
        is_bad = bad or moved or report.unread
        meaning = Meaning.DANGER if is_bad else (Meaning.GOOD if verified else Meaning.INFORMATION)
        return Notice(meaning, together(parts), survive, self.job.dismiss)

    def _unread_notice(self, missing: int) -> Notice:
        text = tr("Could not be read: {count}; see the rows.", count=missing)
        again = Choice("read_again", tr("Read all"), self.read_all)
        return Notice(Meaning.ATTENTION, text, (again,), self.job.dismiss)


def _broken_off_notice(error: BaseException) -> Notice:
    if isinstance(error, Cancelled):
        return Notice(Meaning.INFORMATION, tr("Cancelled: the rest is unknown."))
    return Notice(Meaning.DANGER, tr("Link lost: the rest is unknown."))


def _survival_notice(survival: PowerCycleResult) -> Notice:
    kept = sum(stamp.fate.name == "KEPT" for stamp in survival.stamps.values())
    match survival.ending:
        case Ending.NOT_SEEN:
            return Notice(Meaning.ATTENTION, tr("No restart was seen."))
        case Ending.UNPROVEN:
            text = tr("Restarted; the boot count does not prove a power cycle.")
            return Notice(Meaning.ATTENTION, text)
        case _:
            pass
    boots = tr("Boot count {before} → {after}.", before=survival.boots_before, after=survival.boots_after)
    if survival.is_fine:
        return Notice(Meaning.GOOD, tr("Kept over the power cycle: {count}. {boots}", count=kept, boots=boots))
    text = tr("NOT all kept over the power cycle: see the rows. {boots}", boots=boots)
    return Notice(Meaning.DANGER, text)
