"""Controller of the Pre-flight page: runs, judges, files and watches the check.

A void verdict stays void: only another check gives another one.
"""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import Any, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from app.diagnosis.link_state import Phase
from app.engine.procedure import PortLost, Report
from app.engine.worker import Batch, Job
from app.fleet.verdicts import KeptCheck
from app.limits.past import Past
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import CheckResult, Person
from app.preflight.reread import REREAD_EVERY_S, StateReading, read_state
from app.preflight.run import TRIGGERS, run_preflight
from app.preflight.verdict import VALID_FOR_S, Assessment, Verdict, Void, assess, void_of_reading, void_reason
from app.records.filing import Filed
from app.records.record import Record
from app.safety.interlocks import interlock_inputs
from app.settings.profiles import ActivatedBy, Profile
from app.store.database import StoreTrouble
from app.text.messages import message
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.running_job import RunningJob, file_in_background


class Standing(Enum):
    """The verdict as it stands now."""

    NOT_CHECKED = "not checked"
    CHECKING = "checking"
    GO = "GO"
    READY = "READY"
    NO_GO = "NO-GO"
    VOID = "void"


class Entered(NamedTuple):
    """What stands in the form now; `profile` with the answers for its manual items."""

    who: str
    aircraft: str
    profile: Profile


class PreflightController(QObject):
    """`changed`: the standing, the findings or the entries are different."""

    changed = Signal()

    def __init__(self, services: Services, read_form: Callable[[], Entered], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector, self._read_form = services, services.connector, read_form
        self.filed: Filed | None = None
        self.void: Void | None = None
        """Set during a check, it voids that check when it ends."""
        self.trouble: StoreTrouble | None = None
        """Why the last check was not kept."""
        self._job = RunningJob(services.connector, self)
        self._job.changed.connect(self.changed)
        self._evidence = Evidence()
        self._stated = Person()
        """What was stated with the click that started the check."""
        self._is_port_broken = False
        self._checked_name = ""
        """The module's name when the check started."""
        self._filing: BackgroundTask[Filed] = BackgroundTask("dps-s check", self)
        self._rereading = RunningJob(services.connector, self)
        self._by_verdict: dict[Verdict, Filed] = {}
        """Records of this check: activated, READY becomes GO; locked again, READY."""
        self._reread_timer = QTimer(self, interval=round(1000 * REREAD_EVERY_S))
        self._reread_timer.timeout.connect(self.read_again)
        self._connector.changed.connect(self._watch_port)
        self._connector.batch.connect(self._on_batch)
        self._connector.renamed.connect(self._on_name)

    # What is known

    @property
    def _is_checking(self) -> bool:
        """Until the record is in the store, or cannot be kept."""
        return self._job.is_running or (self._filing.is_running and self.filed is None)

    @property
    def standing(self) -> Standing:
        if self._is_checking:
            return Standing.CHECKING
        if self.filed is None:
            return Standing.NOT_CHECKED
        if self.void is not None:
            return Standing.VOID
        return _STANDINGS[self.filed.assessment.verdict]

    @property
    def assessment(self) -> Assessment | None:
        """The last check's; None while one runs, so that no old finding is shown."""
        return None if self.filed is None or self._is_checking else self.filed.assessment

    @property
    def record(self) -> Record | None:
        """What may be exported: None unless the check still holds."""
        return self.filed.record if self.filed is not None and self.standing in _STANDINGS.values() else None

    @property
    def progress(self) -> Report | None:
        return self._job.progress

    @property
    def can_check(self) -> bool:
        port = self._connector.current
        is_settled = port.state.phase not in (Phase.OPENING, Phase.FINDING)
        return port.is_open and is_settled and not self._job.is_running and not self._filing.is_running

    @property
    def can_enable(self) -> bool:
        """Nothing is written to an active module, nor before a person has said which module it is."""
        port = self._connector.current
        is_locked = port.device.presence is Presence.ONLINE and not self.may_fire
        return self.can_check and port.identity.is_settled and (is_locked or self.needs_lock)

    @property
    def needs_lock(self) -> bool:
        """It is active, and its triggers are not known: it has to be locked to enable them."""
        return self.can_check and self.may_fire and not self.are_triggers_known

    @property
    def are_triggers_known(self) -> bool:
        """Whether the module has acknowledged the state of both automatic triggers in this conversation."""
        device, now = self._connector.current.device, self._connector.clock()
        known = [device.known(command.key, now) for command in TRIGGERS]
        return all(trigger is not None and not trigger.is_stale for trigger in known)

    @property
    def may_fire(self) -> bool:
        """It reports ACTIVE, or did so last."""
        return self._connector.current.is_active

    @property
    def reported_active(self) -> bool | None:
        """What the module reports now; an acknowledgement is no report."""
        return interlock_inputs(self._connector.current.device, self._connector.clock(), must_be_proven=False).active

    @property
    def leads_to_activation(self) -> bool:
        """READY, and it is a person who activates the module."""
        return self.standing is Standing.READY and self._read_form().profile.activated_by is ActivatedBy.PERSON

    @property
    def expires_in_s(self) -> float | None:
        """Until a GO or READY is too old; None for any other standing."""
        ended_at = self._evidence.ended_at
        if ended_at is None or self.standing not in _PASSED:
            return None
        return max(0.0, VALID_FOR_S - (self._connector.clock() - ended_at))

    # What a person does

    def check(self, stated: Person | None = None, *, is_enabling: bool = False) -> None:
        """Start a check; nothing of the previous one is kept on screen."""
        if not self.can_check:
            return
        self._stated = stated or Person()
        self.filed = self.void = self.trouble = None
        self._rereading.drop()
        self._by_verdict.clear()
        self._checked_name = self._connector.current.module.name
        self._evidence = Evidence(port=self._connector.current.connection.port)
        self._is_port_broken = False
        journal = self._connector.current.journal()
        procedure = run_preflight(self._evidence, is_enabling=is_enabling, journal=journal)
        self._job.run(procedure, self._end)

    def cancel(self) -> None:
        self._job.cancel()

    def enter(self) -> None:
        """An entry of the record changed: the check, also a running one, is void."""
        if self.void is None and (self._is_checking or self.filed is not None):
            self._set_void(Void(Disturbance.CHANGED, message(marked("entries"))))
        self.changed.emit()

    def _on_name(self) -> None:
        """The signal also comes when the same module is recognised again."""
        if self._connector.current.module.name != self._checked_name:
            self.enter()

    def reset(self) -> None:
        """Another module may be connected: discard the check, a running one too."""
        self._filing.cancel()
        self._reread_timer.stop()
        self._by_verdict.clear()
        self._evidence = Evidence()
        self.filed = self.void = self.trouble = None
        self.changed.emit()

    def poll(self) -> None:
        """Void the verdict if it no longer holds."""
        if self.filed is None or self.void is not None or self._is_checking:
            return
        opened_at = None if self._is_port_broken else self._evidence.opened_at
        now = self._connector.clock()
        void = void_reason(self.filed.assessment, self._connector.current.device, now, opened_at=opened_at)
        if void is None:
            self._follow_activation()
        else:
            self._set_void(void)
            self.changed.emit()

    def _set_void(self, void: Void) -> None:
        self.void = void
        self._publish()

    def _publish(self) -> None:
        """Let the Fleet page show the same verdict."""
        kept = self._connector.current.kept
        if self.filed is not None and (self.void is None or kept.check is None or kept.check.filed is self.filed):
            kept.check = KeptCheck(self.filed, self.void)

    # While GO or READY stands

    def read_again(self) -> None:
        """Read everything a verdict depends on; any difference voids it."""
        if self.standing not in _PASSED:
            self._reread_timer.stop()
        elif not self._rereading.is_running:
            self._rereading.run(read_state(), self._end_rereading)

    def _follow_activation(self) -> None:
        """Reported locked, GO becomes READY at once; reported active, READY becomes GO after reading everything."""
        if self.standing not in _PASSED or self._filing.is_running:
            return
        reported, was = self.reported_active, self._evidence.is_active
        if reported and not was:
            self.read_again()
        elif was and reported is False and self._evidence.status is not None:
            self._judge_again(replace(self._evidence, status=self._evidence.status._replace(active=False)))

    def _end_rereading(self, job: Job[StateReading]) -> None:
        self.poll()
        evidence = self._evidence
        if self.standing not in _PASSED:
            return
        state = job.outcome() if job.run.error is None else None
        void = void_of_reading(evidence, state)
        if void is not None:
            self._set_void(void)
        elif state is not None and state.status is not None and state.status.active is not evidence.is_active:
            self._judge_again(replace(evidence, status=state.status))
        self.changed.emit()

    def _judge_again(self, evidence: Evidence) -> None:
        """Judge the same check with the activation that is reported now."""
        if self.filed is None or self._filing.is_running:
            return
        case = self.filed.assessment.case
        earlier = self._by_verdict.get(assess(replace(case, evidence=evidence)).verdict)
        if earlier is None:
            self._file(evidence, case.past)
        else:
            self._use(earlier)

    # The end of a check

    def _end(self, job: Job[Any]) -> None:
        self._evidence.listen(self._connector.current.last.events)
        self._evidence.note_error(job.run.error)
        if self._is_port_broken or not self._connector.current.is_open:
            self._evidence.note_error(PortLost())
        self._file(self._evidence)
        self.changed.emit()

    def _file(self, evidence: Evidence, past: Past | None = None) -> None:
        """Judge the check, and keep it unless it is void."""
        entered, module = self._read_form(), self._connector.current.module.name or None
        person = replace(self._stated, who=entered.who, module=module, aircraft=entered.aircraft)
        is_stored = evidence.is_complete and self.void is None
        file_in_background(
            self._filing, evidence, entered.profile, person, past=past, is_stored=is_stored,
            target=self._connector.current.target, store=self._services.storage.store,
            then=partial(self._end_filing, is_stored=is_stored),
        )  # fmt: skip

    def _end_filing(self, filed: Filed, *, is_stored: bool) -> None:
        store = self._services.storage.store
        self.trouble = store if isinstance(store, StoreTrouble) else filed.trouble
        self._by_verdict[filed.assessment.verdict] = filed
        if is_stored and self.trouble is None and filed.assessment.result("boot_count") is not CheckResult.FAIL:
            self._connector.current.module.remember_adapter()
        self._use(filed)

    def _use(self, filed: Filed) -> None:
        self.filed, self._evidence = filed, filed.assessment.case.evidence
        self._publish()
        if self.standing in _PASSED and not self._reread_timer.isActive():
            self._reread_timer.start()
        self.poll()
        self.changed.emit()

    def _on_batch(self, batch: Batch) -> None:
        if self._job.is_running:
            self._evidence.listen(batch.events)
        else:
            self.poll()

    def _watch_port(self) -> None:
        if not self._connector.current.is_open or self._connector.current.state.phase is Phase.OPENING:
            self._is_port_broken = True
        self.poll()


_STANDINGS = {Verdict.GO: Standing.GO, Verdict.READY: Standing.READY, Verdict.NO_GO: Standing.NO_GO}
_PASSED = (Standing.GO, Standing.READY)
