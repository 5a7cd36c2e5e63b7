"""The pre-flight check of one module: run, judged, kept, and watched while it stands, whoever began it.

It belongs to one conversation. When that ends, the verdict is void.
"""

from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.engine.conversation import How
from app.engine.procedure import Job, Report
from app.engine.worker import Batch
from app.fleet.card import HeldVerdict
from app.limits.past import Past
from app.preflight.evidence import UNREAD, Evidence, StateReading, Void, changed, read_state, void_of_end
from app.preflight.findings import CheckResult, Person
from app.preflight.run import STEPS, run_preflight
from app.preflight.verdict import REREAD_EVERY_S, VALID_FOR_S, Assessment, Verdict, void_of_news, void_reason
from app.records.filing import Filed, file_check
from app.records.record import SignedRecord
from app.settings.profiles import Profile
from app.store.opening import StoreTrouble
from app.text.messages import UserError, message
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.storage import Storage
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning


class Standing(Enum):
    """The verdict as it stands now."""

    NOT_CHECKED = "not checked"
    CHECKING = "checking"
    GO = "GO"
    READY = "READY"
    NO_GO = "NO-GO"
    VOID = "void"


_STANDINGS = {Verdict.GO: Standing.GO, Verdict.READY: Standing.READY, Verdict.NO_GO: Standing.NO_GO}
VERDICT_STYLES = {
    Verdict.GO: StateStyle(Icon.CHECK, Meaning.GOOD),
    Verdict.READY: StateStyle(Icon.LOCK, Meaning.INFORMATION),
    Verdict.NO_GO: StateStyle(Icon.DANGER, Meaning.DANGER),
}
LOUD = {standing: VERDICT_STYLES[verdict].meaning for verdict, standing in _STANDINGS.items()}
PASSED = (Standing.GO, Standing.READY)
ENTRIES = changed(message(marked("entries")))
NEWER = Void("changed", message(marked("It was checked again.")))


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
        self.target = module.target
        device = "" if self.target is None else self.target.device
        self.evidence = Evidence(port=device, may_have_fired=module.may_have_fired)
        self.filed: Filed | None = None
        # Set during the check, it voids it when it ends.
        self.void: Void | None = None
        # Why it was not kept.
        self.trouble: UserError | None = None
        self.progress: Report | None = None
        self._filing: BackgroundTask[Filed] = BackgroundTask("dps-s check", self)
        self._rereading: Job[StateReading] | None = None
        self._timer = QTimer(self, interval=round(1000 * REREAD_EVERY_S))
        self._timer.timeout.connect(self.read_again)
        self._slots = (
            (module.changed, self.poll),
            (module.batch, self._on_batch),
            (module.named, self._on_name),
            (module.ended, self._on_ended),
        )
        for signal, slot in self._slots:
            signal.connect(slot)
        procedure = run_preflight(self.evidence, is_enabling=is_enabling, journal=module.journal)
        self._job: Job[Any] | None = module.run(procedure, self._end, on_progress=self._remember_progress, goes_on=True)

    # What is known

    @property
    def is_running(self) -> bool:
        """Until the record is in the store, or cannot be kept."""
        return self._job is not None or (self._filing.is_running and self.filed is None)

    @property
    def is_busy(self) -> bool:
        """It runs, or its record is still being kept."""
        return self._job is not None or self._filing.is_running

    @property
    def standing(self) -> Standing:
        if self.is_running or (self.filed is None and self.void is None):
            return Standing.CHECKING
        if self.filed is None:
            return Standing.VOID
        return Standing.VOID if self.void is not None else _STANDINGS[self.filed.assessment.verdict]

    @property
    def assessment(self) -> Assessment | None:
        return None if self.filed is None or self.is_running else self.filed.assessment

    @property
    def signed(self) -> SignedRecord | None:
        """What may be exported: None unless the check still holds, and while the next record of it is being kept."""
        has_record = self.filed is not None and not self.is_busy and self.standing in _STANDINGS.values()
        return self.filed.signed if self.filed is not None and has_record else None

    @property
    def held(self) -> HeldVerdict | None:
        """For the module's card; None while it runs."""
        assessment = self.assessment
        if assessment is None:
            return None
        verdict = assessment.verdict if self.void is None else None
        return HeldVerdict(verdict, self.evidence.ended_at, self.void, assessment.titles_against)

    @property
    def expires_in_s(self) -> float | None:
        """Until a GO or READY is too old; None for any other standing."""
        ended_at = self.evidence.ended_at
        if ended_at is None or self.standing not in PASSED:
            return None
        return max(0.0, VALID_FOR_S - (self._module.now_s - ended_at))

    # What is done with it

    def cancel(self) -> None:
        if self._job is not None:
            self._job.cancel()

    def state_again(self, person: Person) -> None:
        """What is only written on the record voids nothing. A module that got its name after the check is judged again
        by what is kept under that name."""
        if person == self.person or self.void is not None:
            return
        is_named_now = person.module != self.person.module
        self.person = person
        if self._job is None:  # else it is filed with this when it ends
            past = None if is_named_now or self.filed is None else self.filed.assessment.case.past
            self._file(self.evidence, past)
            self.changed.emit()

    def set_void(self, void: Void) -> None:
        if self.void is None:
            self.void = void
            self.changed.emit()

    def drop(self) -> None:
        """Nothing more is heard of it: another check or another module has taken its place."""
        for job in filter(None, (self._job, self._rereading)):
            job.cancel()
        self._job = self._rereading = None
        self._filing.cancel()
        self._timer.stop()
        for signal, slot in self._slots:
            signal.disconnect(slot)
        self.deleteLater()

    def poll(self) -> None:
        """Void the verdict if it no longer holds."""
        if self.filed is None or self.void is not None or self.is_running:
            return
        void = void_reason(self.filed.assessment, self._module.view, self._module.now_s)
        if void is None:
            self._follow_activation()
        else:
            self.set_void(void)

    def read_again(self) -> None:
        """Read everything that a GO or READY depends on; any difference voids it."""
        if self.standing not in PASSED:
            self._timer.stop()
        elif self._rereading is None:
            self._rereading = self._module.run(read_state(), self._end_rereading, goes_on=True)

    # What happens

    def _remember_progress(self, report: Report) -> None:
        """In the worker's thread. Only its own steps: what they are made of tells its progress, too."""
        if report.total == STEPS:
            self.progress = report

    def _on_batch(self, batch: Batch) -> None:
        fired = void_of_news(batch.events, batch.samples)
        if fired is not None and not self._is_known_to_be_triggered:
            self.set_void(fired)
        if self._job is not None:
            self.evidence.listen(batch.events)
        self.poll()  # also what no page shows, and what is over by the next look

    def _on_ended(self) -> None:
        """What came of one that runs is shown no more once the next conversation begins."""
        end = self._module.end
        if self._job is not None and end is not None:
            why = void_of_end(end).message
            self._module.keep_report(message(marked("{name}: {value}"), name=message(marked("Pre-flight")), value=why))

    @property
    def _is_known_to_be_triggered(self) -> bool:
        """The check itself found it triggered, so that a report of it is no news."""
        return self.filed is not None and self.filed.assessment.has_triggered

    def _on_name(self) -> None:
        """The signal also comes when the same module is recognised again."""
        name = self._module.name or None
        if self.person.module is None:
            self.state_again(replace(self.person, module=name))
        elif name != self.person.module:
            self.set_void(ENTRIES)

    def _follow_activation(self) -> None:
        """Reported locked, GO becomes READY at once; reported active, READY becomes GO after reading everything. Not
        reported any more, it is asked for at once: a verdict says nothing else than the top bar."""
        if self.standing not in PASSED or self._filing.is_running:
            return
        reported, status = self._reported_active, self.evidence.status
        if reported is None or (reported and not self.evidence.is_active):
            self.read_again()
        elif reported is False and status is not None and status.active:
            self._judge_again(replace(self.evidence, status=status._replace(active=False)))

    @property
    def _reported_active(self) -> bool | None:
        """What the module reports now; an acknowledgement is no report."""
        active = self._module.view.fresh("active", self._module.now_s)
        known = self._module.view.values.get("active")
        if known is None or known.how is How.ACKNOWLEDGED or active is None:
            return None
        return active is True

    def _end_rereading(self, job: Job[StateReading]) -> None:
        if job is not self._rereading:
            return
        self._rereading = None
        self.poll()
        if self.standing not in PASSED:
            return
        state = job.outcome() if job.error is None else None
        if state is None or not state.is_complete:
            self.set_void(UNREAD)
        elif state.status is not None and state.status.active is not self.evidence.is_active:
            self._judge_again(replace(self.evidence, status=state.status))

    def _judge_again(self, evidence: Evidence) -> None:
        """Judge the same check with the activation that is reported now."""
        if self.filed is None or self._filing.is_running:
            return
        self._file(evidence, self.filed.assessment.case.past)

    def _end(self, job: Job[Any]) -> None:
        if job is not self._job:
            return
        self._job, evidence = None, self.evidence
        if job.error is not None:
            evidence.note_error(job.error)  # it may not even have begun
        if self.void is not None and evidence.void is None:
            evidence.void = self.void
        if evidence.history is not None and evidence.history.is_confirmed:
            self._module.note_records_read()
        self._file(evidence)
        self.changed.emit()

    def _file(self, evidence: Evidence, past: Past | None = None) -> None:
        """Judge the check; keep it, in the store's thread, unless it is void. It takes the place of one being kept."""
        self.evidence = evidence
        store = self._storage.begun if evidence.is_complete else None
        adapter = "" if self.target is None else self.target.identity
        work = partial(file_check, evidence, self.profile, self.person, store=store, adapter=adapter, past=past)
        if store is not None:
            self._filing.run(lambda _running: work(), self._end_filing)
            return
        trouble = self._storage.store if self._storage.begun is None else None
        self._end_filing(work(), trouble if isinstance(trouble, StoreTrouble) else None)

    def _end_filing(self, filed: Filed, trouble: StoreTrouble | None = None) -> None:
        self.trouble = trouble or filed.trouble
        is_kept = filed.assessment.case.evidence.is_complete and self.trouble is None
        if is_kept and filed.assessment.result("boot_count") is not CheckResult.FAIL:
            self._module.keep()
        self.filed = filed
        if self.standing in PASSED and not self._timer.isActive():
            self._timer.start()
        if filed.assessment.verdict is Verdict.GO:
            self._module.note_go()
        self.poll()
        self.changed.emit()
