"""The pre-flight check of one module: run, judged, kept, and watched while it stands, whoever began it.

It belongs to one conversation. When that ends, the verdict is void.
"""

from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.engine.conversation import How
from app.engine.procedure import Job, Report
from app.engine.worker import Batch
from app.limits.past import Past
from app.preflight.checks import CheckResult, Person
from app.preflight.evidence import (
    CHECK_AGAIN,
    OVER,
    UNREAD,
    Evidence,
    StateReading,
    Void,
    changed,
    read_state,
    void_of_end,
)
from app.preflight.run import STEPS, run_preflight
from app.preflight.verdict import REREAD_EVERY_S, CheckState, Verdict, check_state, void_of_news, void_reason
from app.records.filing import Filed, file_check
from app.records.record import SignedRecord
from app.settings.profiles import Profile
from app.text.messages import message
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.storage import Storage
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning

VERDICT_STYLES = {
    Verdict.GO: StateStyle(Icon.CHECK, Meaning.GOOD),
    Verdict.READY: StateStyle(Icon.LOCK, Meaning.INFORMATION),
    Verdict.NO_GO: StateStyle(Icon.DANGER, Meaning.DANGER),
}
ENTRIES = changed(message(marked("entries")))
NEWER = Void("changed", message(marked("It was checked again.")), CHECK_AGAIN)


class ModuleCheck(QObject):
    """A void verdict stays void: only another check gives another one."""

    changed = Signal()
    """It ended, or stands otherwise."""

    def __init__(
        self, module: ShownModule, storage: Storage, profile: Profile, person: Person, *, is_enabling: bool
    ) -> None:
        """`profile` with a person's answers for its manual checks; `person`: what is entered and said."""
        super().__init__(module)
        self._module, self._storage = module, storage
        self.profile = profile
        self.person = replace(person, module=module.name or None)
        target = module.target
        self._adapter = "" if target is None else target.identity
        self.evidence = Evidence(port="" if target is None else target.device, may_have_fired=module.may_have_fired)
        self.filed: Filed | None = None
        # Set during the check, it voids it when it ends.
        self.void: Void | None = None
        self.progress: Report | None = None
        self._filing: BackgroundTask[Filed] = BackgroundTask("dps-s check", self)
        self._rereading: Job[StateReading] | None = None
        self._timer = QTimer(self, interval=round(1000 * REREAD_EVERY_S))
        self._timer.timeout.connect(self._read_again)
        module.changed.connect(self.poll)
        module.batch.connect(self._on_batch)
        module.named.connect(self._on_name)
        module.ended.connect(self._on_ended)
        procedure = run_preflight(self.evidence, is_enabling=is_enabling, journal=module.journal)
        self._job: Job[Any] | None = module.run(procedure, self._end, on_progress=self._remember_progress, goes_on=True)

    # What is known

    @property
    def is_running(self) -> bool:
        """Whether it runs, until the record is in the store, or cannot be kept."""
        return self._job is not None or (self._filing.is_running and self.filed is None)

    @property
    def is_busy(self) -> bool:
        """It runs, or its record is still being kept."""
        return self._job is not None or self._filing.is_running

    @property
    def state(self) -> CheckState:
        found = None if self.filed is None else self.filed.assessment
        return check_state(found, self.void, is_running=self.is_running)

    @property
    def signed(self) -> SignedRecord | None:
        """The record that may be exported: None unless the check still holds, and while the next record of it is being
        kept."""
        is_final = self.state.verdict is not None and not self.is_busy
        return self.filed.signed if self.filed is not None and is_final else None

    # What is done with it

    def cancel(self) -> None:
        if self._job is not None:
            self._job.cancel()

    def state_again(self, person: Person) -> None:
        """Take what is only written on the record, which voids nothing. A module that got its name after the check is
        judged again by what is kept under that name."""
        if person == self.person or self.void is not None:
            return
        is_named_now = person.module != self.person.module
        self.person = person
        if self._job is None:  # else it is filed with this when it ends
            self._file(self.evidence, None if is_named_now or self.filed is None else self.filed.assessment.case.past)
            self.changed.emit()

    def set_void(self, void: Void) -> None:
        if self.void is None:
            self.void = void
            self.changed.emit()

    def drop(self, void: Void = OVER) -> None:
        """Another check or another module has taken its place. Nothing that comes later changes one that is void."""
        self.void = self.void or void
        for job in filter(None, (self._job, self._rereading)):
            job.cancel()
        self._job = self._rereading = None
        self._filing.cancel()
        self._timer.stop()
        self.deleteLater()

    # What happens

    def poll(self) -> None:
        """Void the verdict if it no longer holds. Reported locked, GO becomes READY at once; reported active, READY
        becomes GO after reading everything. Not reported any more, it is asked for at once: a verdict says nothing else
        than the top bar."""
        if self.filed is None or self.void is not None or self.is_running:
            return
        view, now, evidence = self._module.view, self._module.now_s, self.evidence
        void = void_reason(self.filed.assessment, view, now)
        if void is not None:
            self.set_void(void)
        elif self.state.has_passed and not self._filing.is_running:
            known, active = view.values.get("active"), view.fresh("active", now)
            # An acknowledgement is no report.
            is_reported = known is not None and known.how is not How.ACKNOWLEDGED and active is not None
            if not is_reported or (active and not evidence.is_active):
                self._read_again()
            elif not active and evidence.status is not None and evidence.is_active:
                self._judge_again(replace(evidence, status=evidence.status._replace(active=False)))

    def _read_again(self) -> None:
        """Read everything that a GO or READY depends on; any difference voids it."""
        if not self.state.has_passed:
            self._timer.stop()
        elif self._rereading is None:
            self._rereading = self._module.run(read_state(), self._end_rereading, goes_on=True)

    def _end_rereading(self, job: Job[StateReading]) -> None:
        if job is not self._rereading:
            return
        self._rereading = None
        self.poll()
        if not self.state.has_passed:
            return
        state = job.outcome() if job.error is None else None
        if state is None or not state.is_complete:
            self.set_void(UNREAD)
        elif state.status is not None and state.status.active is not self.evidence.is_active:
            self._judge_again(replace(self.evidence, status=state.status))

    def _judge_again(self, evidence: Evidence) -> None:
        """Judge the same check with the activation that is reported now."""
        if self.filed is not None and not self._filing.is_running:
            self._file(evidence, self.filed.assessment.case.past)

    def _remember_progress(self, report: Report) -> None:
        """Remember its own steps only: what they are made of tells its progress, too. Runs in the worker's thread."""
        if report.total == STEPS:
            self.progress = report

    def _on_batch(self, batch: Batch) -> None:
        fired = void_of_news(batch.events, batch.samples)
        # What the check itself found triggered is no news.
        if fired is not None and (self.filed is None or not self.filed.assessment.case.evidence.has_triggered):
            self.set_void(fired)
        self.poll()  # also what no page shows, and what is over by the next look

    def _on_ended(self) -> None:
        """End it: what came of one that runs is shown no more once the next conversation begins."""
        end = self._module.end
        if self._job is not None and end is not None:
            why = void_of_end(end).message
            self._module.keep_report(message(marked("{name}: {value}"), name=message(marked("Pre-flight")), value=why))

    def _on_name(self) -> None:
        """The signal also comes when the same module is recognised again."""
        name = self._module.name or None
        if self.person.module is None:
            self.state_again(replace(self.person, module=name))
        elif name != self.person.module:
            self.set_void(ENTRIES)

    def _end(self, job: Job[Any]) -> None:
        if job is not self._job:
            return
        self._job, evidence = None, self.evidence
        if job.error is not None:
            evidence.note_error(job.error)
        evidence.void = evidence.void or self.void
        if evidence.history is not None and evidence.history.is_confirmed:
            self._module.note_records_read()
        self._file(evidence)
        self.changed.emit()

    def _file(self, evidence: Evidence, past: Past | None = None) -> None:
        """Judge the check; keep it, in the store's thread, unless it is void. It takes the place of one being kept."""
        self.evidence = evidence
        store = self._storage.begun if evidence.is_complete else None
        work = partial(file_check, evidence, self.profile, self.person, store=store, adapter=self._adapter, past=past)
        if store is None:
            self._end_filing(work())
        else:
            self._filing.run(lambda _running: work(), self._end_filing)

    def _end_filing(self, filed: Filed) -> None:
        self.filed = filed
        is_kept = self.evidence.is_complete and filed.trouble is None
        if is_kept and filed.assessment.result("boot_count") is not CheckResult.FAIL:
            self._module.keep()
        if self.state.has_passed and not self._timer.isActive():
            self._timer.start()
        if filed.assessment.verdict is Verdict.GO:
            self._module.note_go()
        self.poll()
        self.changed.emit()
