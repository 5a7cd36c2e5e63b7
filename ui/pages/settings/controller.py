"""Controller of the Settings page: reads, writes and verifies; one job at a time."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

from app.engine.identity import Trust
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, unconfirmed, write_all
from protocol.link_states import Presence
from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Cancelled, TwoModules
from app.engine.snapshots import Snapshot
from app.engine.worker import Batch, Job
from app.procedures.read import READABLE, Everything, read_everything
from app.procedures.write import Written
from app.safety.acts import Act
from app.safety.interlocks import Interlock, Refusal, interlock_inputs, refusals
from app.settings.form import FORM_COMMANDS, RowState, SettingsForm
from app.text.i18n import tr
from app.text.sentences import join_names, join_sentences
from protocol.catalogue import Command
from protocol.events import Received
from protocol.fields import Value
from protocol.messages import Reading
from protocol.translatable import marked
from ui.services.context import Services
from ui.session.running_job import RunningJob, is_risk_open, risk_choices, risk_notice
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class SettingsController(QObject):
    """Owns the form. `changed` is emitted when the form or the job changes."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        connector = services.ports
        self.form = SettingsForm(lambda: not connector.current.identity.is_settled, connector.current.kept.watch)
        self._services = services
        self._connector = services.ports
        services.pending_edits.find_foreign = lambda: tuple(self.form.watch.changed.values())
        self.job = RunningJob(services.ports, self)
        self.job.changed.connect(self.changed)
        self._connector.changed.connect(self.changed)
        self._connector.disconnected.connect(self._begin_again)
        self._connector.batch.connect(self._on_batch)
        self._connector.invalidated.connect(self._begin_again)
        self.changed.connect(self._observe)
        services.pending_edits.count = self.count_unsent
        services.pending_edits.discard = self.discard

    @property
    def initial(self) -> Snapshot | None:
        """The settings before the first write to this module; None while it may be another one."""
        return self._connector.current.kept.as_found if self._connector.current.identity.is_settled else None

    def can_fill(self, values: Mapping[str, Value] | None) -> bool:
        port = self._connector.current
        is_new = values is not None and self.form.would_change(values, port.device, port.clock())
        return self.can_edit and is_new

    @property
    def can_edit(self) -> bool:
        """There is a module to write to, or one is expected back."""
        return self._connector.current.is_requested and not self.form.is_writing

    @property
    def can_write(self) -> bool:
        """The engine would not refuse a write, and the module's identity is read: where it stays uncertain, writing is
        refused with the reason."""
        port = self._connector.current
        is_identifying = port.is_open and port.identity.trust is Trust.OPEN
        return self.job.can_run and port.device.presence is Presence.ONLINE and not is_identifying

    def count_unsent(self) -> int:
        port = self._connector.current
        return self.form.count_unsent(port.device, port.clock()) if port.is_requested else 0

    def _observe(self) -> None:
        if self._connector.current.is_requested:
            self.form.observe(self._connector.current.device, self._connector.clock())
        self._services.pending_edits.changed.emit()

    def _on_batch(self, batch: Batch) -> None:
        if any(isinstance(event, Received) and isinstance(event.message, Reading) for event in batch.events):
            self._observe()

    def discard(self) -> None:
        self.form.revert()
        self.changed.emit()

    def notice(self) -> Notice | None:
        return self.job.notice(marked("Asking the module…"))

    def _unless_in_doubt(self, make: Callable[..., Notice], of: object) -> Notice | None:
        """What came of a job, which may be of another module than the one that answers."""
        return make(of) if self._connector.current.identity.is_settled else None

    # Actions

    def read_all(self) -> None:
        if self.job.can_run:
            self.job.run(read_everything(), self._end_reading)

    def write(
        self,
        *,
        accepted: frozenset[SettingChange] = frozenset(),
        is_unlocked: bool = False,
        only: Collection[str] | None = None,
    ) -> None:
        """Writes and verifies all edits, or those of the keys `only`. Asks first where one takes protection away; says
        why where it is refused."""
        connector = self._connector
        changes = self.form.changes(connector.current.device, connector.clock())
        if only is not None:
            changes = tuple(change for change in changes if change.command.key in only)
        mistyped = [key for key in self.form.mistyped if only is None or key in only]
        if not changes or not self.can_write or mistyped:
            return
        if is_risk_open(changes, accepted):
            self.job.set_notice(self._risk_notice(changes, only))
        elif open_conditions := self._refusals(is_unlocked=is_unlocked):
            self.job.set_notice(self._refused_notice(open_conditions, accepted, only))
        else:
            heard: list[Written] = []
            begun: list[Command] = []
            context = WriteContext(
                journal=connector.current.journal(),
                armed=self._services.armed,
                is_unlocked=is_unlocked,
                accepted_risks=accepted,
                store_snapshot=connector.current.keep_as_found(),
                on_written=heard.append,
                on_begun=begun.append,
            )
            self.form.begin_write(changes)
            self.job.run(write_all(changes, context), partial(self._end_writing, heard, begun, accepted, only))

    def restore_initial(self) -> None:
        if self.initial is not None:
            self.edit(partial(self.form.fill, self.initial.settings))

    def edit(self, act: Callable[[], object]) -> None:
        """Applies `act` to the form and dismisses the last message, which no longer holds."""
        if self.can_edit:
            act()
            self.job.dismiss()

    # Ends of jobs

    def _end_reading(self, job: Job[Everything]) -> None:
        if job.run.error is not None:
            self.job.set_notice(_interrupted_notice(job.run.error))
            return
        self.form.watch.accept()  # the user asked for the current values
        errors = job.outcome().errors
        missing = tuple(command for command in READABLE if command.key in errors)
        if missing:
            self.job.set_notice_of_now(partial(self._unread_notice, missing, job.outcome().began_at))

    def _end_writing(
        self,
        heard: list[Written],
        begun: list[Command],
        accepted: frozenset[SettingChange],
        only: Collection[str] | None,
        job: Job[WriteReport],
    ) -> None:
        if job.run.error is not None:
            self.form.abort_write(unconfirmed(heard), begun)
            interrupted = _interrupted_notice(job.run.error)
            self.job.set_notice(interrupted)
            if isinstance(job.run.error, Cancelled) and self.job.can_run:
                self.job.run(read_everything(), lambda _job: self.job.set_notice(interrupted))
            return
        report = job.outcome()
        self.form.on_written(report.results, self._connector.current.device, self._connector.clock())
        if report.is_refused:
            self.job.set_notice(self._refused_notice(report.refusals, accepted, only))
        else:
            self.job.set_notice_of_now(partial(self._unless_in_doubt, self._written_notice, report))

    def _begin_again(self) -> None:
        self.form.reset(self._connector.current.kept.watch)
        self.changed.emit()

    # Notices

    def mistyped_notice(self) -> Notice | None:
        """Why nothing can be written while something stands in a field that cannot be sent."""
        names = join_names(tr(command.title) for command in FORM_COMMANDS if command.key in self.form.mistyped)
        if not names:
            return None
        return Notice(Meaning.ATTENTION, tr("Nothing can be written until this is corrected: {names}.", names=names))

    def _risk_notice(self, changes: Sequence[SettingChange], only: Collection[str] | None) -> Notice | None:
        unlock = self._unlock_choice(frozenset(changes), only, is_shown=False)
        return risk_notice(changes, partial(self.write, only=only), self.job.dismiss, unlock)

    def _unlock_choice(
        self, accepted: frozenset[SettingChange], only: Collection[str] | None, *, is_shown: bool = True
    ) -> Choice:
        unlocked = partial(self.write, accepted=accepted, is_unlocked=True, only=only)
        return Choice("unlock_once", tr("Unlock this one write"), unlocked, is_step=True, is_shown=is_shown)

    def _refusals(self, *, is_unlocked: bool) -> tuple[Refusal, ...]:
        port = self._connector.current
        inputs = replace(
            interlock_inputs(port.device, port.clock(), must_be_proven=False),
            is_identity_settled=port.identity.is_settled,
            armed=self._services.armed.act,
            is_unlocked=is_unlocked,
        )
        unmet = refusals(Act.WRITE, inputs)
        # The engine asks for an unknown activation itself; here only a known ACTIVE refuses.
        return tuple(refusal for refusal in unmet if refusal.condition is not Interlock.MAY_WRITE or inputs.active)

    def _refused_notice(
        self,
        open_conditions: tuple[Refusal, ...],
        accepted: frozenset[SettingChange],
        only: Collection[str] | None,
    ) -> Notice:
        text = join_sentences([tr("Nothing was written."), *(condition.sentence for condition in open_conditions)])
        can_unlock = all(condition.condition is Interlock.MAY_WRITE for condition in open_conditions)
        # The two buttons that confirm a write never share a place, so each keeps its own while it is hidden.
        anyway = risk_choices((), self.write, self.job.dismiss, is_shown=False)
        choices = (*anyway, self._unlock_choice(accepted, only)) if can_unlock else ()
        return Notice(Meaning.ATTENTION, text, choices)

    def _written_notice(self, report: WriteReport) -> Notice:
        """Counts by the current states: a setting that changed since is no longer called verified."""
        rows = {row.command: row for row in self.form.rows(self._connector.current.device, self._connector.clock())}
        ended = [(result, rows[result.command].state) for result in report.results if result.command in rows]
        verified = sum(state is RowState.VERIFIED for _, state in ended)
        doubtful = sum(state in (RowState.STALE, RowState.UNKNOWN) for _, state in ended)
        since = sum(state is RowState.READ and result.verified is not None for result, state in ended)
        acknowledged = sum(result.is_fine and result.verified is None for result in report.results)
        bad, moved = (
            join_names(tr(row.command.title) for row in rows.values() if row.state is state)
            for state in (RowState.FAILED, RowState.CHANGED)
        )
        unread = self._unread(report.unread, report.read_at)
        counts = (
            (marked("Read back as written: {count}."), verified),
            (marked("Acknowledged, cannot be read: {count}."), acknowledged),
            (marked("Not as written: {names}."), bad),
            (marked("Changed without being written: {names}."), moved),
            (marked("Not verified, but read as set since: {count}."), since),
            (marked("In doubt since: {count}; see the rows."), doubtful),
            (marked("Not read back: {names}."), unread),
        )
        parts = [tr(text, count=found, names=found) for text, found in counts if found]
        parts += [refusal.sentence for refusal in report.refusals]
        is_bad = bad or moved or doubtful or unread or report.refusals
        meaning = Meaning.DANGER if is_bad else (Meaning.GOOD if verified else Meaning.INFORMATION)
        return Notice(meaning, join_sentences(parts), (), self.job.dismiss)

    def _unread(self, commands: Sequence[Command], began_at: float | None) -> str:
        """The titles of those that were not read since either."""
        values = self._connector.current.device.values
        missing = (one for one in commands if one.key not in values or values[one.key].at < (began_at or 0.0))
        return join_names(tr(command.title) for command in missing)

    def _unread_notice(self, missing: Sequence[Command], began_at: float) -> Notice | None:
        names = self._unread(missing, began_at)
        if not names:
            return None
        text = tr("Could not read: {names}. Read again or check the wiring.", names=names)
        again = Choice("read_again", tr("Read all"), self.read_all)
        return Notice(Meaning.ATTENTION, text, (again,), self.job.dismiss)


def _interrupted_notice(error: BaseException) -> Notice:
    if isinstance(error, TwoModules):
        return Notice(Meaning.DANGER, error.sentence)
    if isinstance(error, Cancelled):
        return Notice(Meaning.INFORMATION, tr("Cancelled."))
    return Notice(Meaning.DANGER, tr("Interrupted."))  # what is known, also since, is in the rows
