"""Controller of the Pre-flight page: runs, judges, files and watches the check.

A verdict that was voided stays void, whatever comes afterwards: only another check gives another one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app import version
from app.diagnosis.link_state import Phase
from app.engine.procedure import Cancelled, Report
from app.engine.worker import Batch, Job
from app.limits.expectations import Expectations, Past, expectations_of
from app.preflight.evidence import Disturbance, Evidence, FrameLog
from app.preflight.findings import CheckResult
from app.preflight.reread import REREAD_EVERY_S, StateReading, changes_between, read_state
from app.preflight.run import TRIGGERS, run_preflight
from app.preflight.verdict import VALID_FOR_S, Assessment, Verdict, Void, assess, void_reason
from app.records.filing import Filed, Person, file_check
from app.records.record import Record
from app.safety.interlocks import interlock_inputs
from app.settings.profiles import ActivatedBy, Profile
from app.store.database import StoreTrouble
from app.store.store import Store
from app.text.messages import said
from protocol.link_states import Presence
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.running_job import RunningJob


class Standing(Enum):
    """How the verdict stands at this moment."""

    NOT_CHECKED = "not checked"
    CHECKING = "checking"
    GO = "GO"
    READY = "READY"
    NO_GO = "NO-GO"
    VOID = "void"


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """What a person said with the click that began a check."""

    is_enabling: bool = False
    are_records_looked_at: bool = False
    is_same_module: bool = False


@dataclass(slots=True)
class Entered:
    """What was filled in. `ticked`: manual items by their number, from 1; what is not in it was skipped."""

    who: str = ""
    aircraft: str = ""
    profile: Profile | None = None
    ticked: Mapping[int, bool] | None = None

    @property
    def activated_by(self) -> ActivatedBy:
        return ActivatedBy.PERSON if self.profile is None else self.profile.activated_by

    def expectations(self) -> Expectations:
        return Expectations() if self.profile is None else expectations_of(self.profile, self.ticked)


class PreflightController(QObject):
    """`changed`: the standing, or what was found or entered, is different."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector, self._naming = services, services.connector, services.naming
        self.entered = Entered()
        self.filed: Filed | None = None
        self.void: Void | None = None
        self.trouble: StoreTrouble | None = None
        """Why the last check was not kept."""
        self._job = RunningJob(services.connector, self)
        self._job.changed.connect(self.changed)
        self._evidence = Evidence()
        self._log = FrameLog()
        self._statement = Statement()
        self._is_port_broken = False
        self._is_entered_again = False
        """While a check ran."""
        self._filing: BackgroundTask[Filed] = BackgroundTask("dps-s check", self)
        self._rereading = RunningJob(services.connector, self)
        self._by_verdict: dict[Verdict, Filed] = {}
        """Of this check: activated, READY becomes GO; locked again, READY."""
        self._reread_timer = QTimer(self)
        self._reread_timer.setInterval(round(1000 * REREAD_EVERY_S))
        self._reread_timer.timeout.connect(self.read_again)
        self._connector.changed.connect(self._watch_port)
        self._connector.batch.connect(self._take)
        self._checked_name = ""
        """Of the module, when the check began."""
        self._naming.changed.connect(self._take_name)

    # What is known

    @property
    def _is_checking(self) -> bool:
        """Until its record is in the store, or cannot be."""
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
        """Of the last check; None while one runs, so that no finding of an older one is shown."""
        return None if self.filed is None or self._is_checking else self.filed.assessment

    @property
    def record(self) -> Record | None:
        """What may be printed: only of a check that still holds."""
        return self.filed.record if self.filed is not None and self.standing in _HOLDS else None

    @property
    def progress(self) -> Report | None:
        return self._job.progress

    @property
    def can_check(self) -> bool:
        is_settled = self._connector.state.phase not in (Phase.OPENING, Phase.FINDING)
        is_there = self._connector.is_open and not self._connector.is_recording
        return is_there and is_settled and not self._job.is_running and not self._filing.is_running

    @property
    def can_enable(self) -> bool:
        """Never on an active module: nothing is written then."""
        is_online = self._connector.device.presence is Presence.ONLINE
        return self.can_check and is_online and not self.may_fire

    @property
    def are_triggers_known(self) -> bool:
        """Whether the module has acknowledged how both automatic triggers stand, since its last start."""
        device, now = self._connector.device, self._connector.clock()
        known = [device.known(command.key, now) for command in TRIGGERS]
        return all(one is not None and not one.is_stale for one in known)

    @property
    def may_fire(self) -> bool:
        """It reports to be ACTIVE, or did when it was last heard."""
        return self._connector.is_active

    @property
    def reported_active(self) -> bool | None:
        """As the module reports itself now; an acknowledgement is no report."""
        return interlock_inputs(self._connector.device, self._connector.clock(), must_be_proven=False).active

    @property
    def leads_to_activation(self) -> bool:
        """READY, and a person activates the module."""
        return self.standing is Standing.READY and self.entered.activated_by is ActivatedBy.PERSON

    @property
    def expires_in_s(self) -> float | None:
        """Until the verdict is too old."""
        ended_at = self._evidence.ended_at
        if ended_at is None or self.standing not in _HOLDS:
            return None
        return max(0.0, VALID_FOR_S - (self._connector.clock() - ended_at))

    def result(self, id_: str) -> CheckResult | None:
        assessment = self.assessment
        return None if assessment is None else assessment.result(id_)

    # What a person does

    def check(self, statement: Statement | None = None) -> None:
        """Begin a check; what was found before is gone from here on."""
        if not self.can_check:
            return
        target = self._connector.target
        self._statement = statement or Statement()
        self.filed = self.void = self.trouble = None
        self._rereading.forget()
        self._by_verdict.clear()
        self._checked_name = self._naming.name
        self._evidence = Evidence(port=self._connector.connection.port)
        self._log = FrameLog()
        self._is_port_broken = False
        journal = self._services.storage.journal(target, self._naming.name)
        procedure = run_preflight(self._evidence, is_enabling=self._statement.is_enabling, journal=journal)
        self._job.run(procedure, self._end)

    def cancel(self) -> None:
        self._job.cancel()

    def enter(self) -> None:
        """Something that belongs to the record was filled in otherwise: the record no longer says what is entered."""
        if self._is_checking:
            self._is_entered_again = True
        elif self.filed is not None and self.void is None:
            self.void = _ENTERED_AGAIN
        self.changed.emit()

    def _take_name(self) -> None:
        """The naming also tells that the same module was met again."""
        if self._naming.name != self._checked_name:
            self.enter()

    def forget(self) -> None:
        """Nothing was checked: what was found is of no module that anybody has."""
        if not self._job.is_running:
            self._filing.cancel()
            self._job.forget()
            self.filed = self.void = self.trouble = None
            self.changed.emit()

    def poll(self) -> None:
        """Does the verdict still hold?"""
        if self.filed is None or self.void is not None or self._is_checking:
            return
        opened_at = None if self._is_port_broken else self._evidence.opened_at
        self.void = void_reason(
            self.filed.assessment, self._connector.device, self._connector.clock(), opened_at=opened_at
        )
        if self.void is not None:
            self.changed.emit()
        else:
            self._follow_activation()

    # While it stands

    def read_again(self) -> None:
        """Everything that decides, in the background: whatever differs ends the verdict."""
        if self.standing not in _STANDS:
            self._reread_timer.stop()
        elif not self._rereading.is_running:
            self._rereading.run(read_state(), self._end_rereading)

    def _follow_activation(self) -> None:
        """Seen locked, GO is READY at once; seen active, READY is GO once everything was read again."""
        if self.standing not in _STANDS or self._filing.is_running:
            return
        reported, was = self.reported_active, self._evidence.is_active
        if reported and not was:
            self.read_again()
        elif was and reported is False and self._evidence.status is not None:
            status = replace(self._evidence.status, active=False)
            self._stand(replace(self._evidence, status=status))

    def _end_rereading(self, job: Job[StateReading]) -> None:
        self.poll()
        evidence = self._evidence
        if self.standing not in _STANDS:
            return
        state = job.outcome() if job.run.error is None else None
        changes = changes_between(evidence.last, state) if state is not None and evidence.last is not None else ()
        if changes:
            self.void = Void(Disturbance.CHANGED, changes[0].shown)
        elif state is None or state.status is None or not state.is_complete:
            self.void = Void(Disturbance.UNREAD)
        elif state.status.active is not evidence.is_active:
            self._stand(replace(evidence, status=state.status, status_at=state.status_at))
        self.changed.emit()

    def _stand(self, evidence: Evidence) -> None:
        """The verdict of the same check, with the module as it reports itself now."""
        if self.filed is None or self._filing.is_running:
            return
        case = self.filed.assessment.case
        earlier = self._by_verdict.get(assess(replace(case, evidence=evidence)).verdict)
        if earlier is None:
            self._file(evidence, self._end_standing, case.past)
        else:
            self.filed = earlier
            self._end_standing()

    def _end_standing(self) -> None:
        if self.filed is not None:
            self._services.filed[self._connector.whose] = self.filed
        if self.filed is not None:
            self._evidence = self.filed.assessment.case.evidence
        self.changed.emit()

    # How it ends

    def _end(self, job: Job[Any]) -> None:
        evidence = self._evidence
        if self._connector.last is not None:
            self._keep_frames(self._connector.last)
        if job.run.error is not None and evidence.disturbance is None:
            is_cancelled = isinstance(job.run.error, Cancelled)
            evidence.disturbance = Disturbance.INTERRUPTED if is_cancelled else Disturbance.DISCONNECTED
        if self._is_port_broken or not self._connector.is_open:
            evidence.disturbance = evidence.disturbance or Disturbance.DISCONNECTED
        self._file(evidence, self._end_filing)
        self.changed.emit()

    def _end_filing(self) -> None:
        if self.filed is not None:
            self._services.filed[self._connector.whose] = self.filed
        if self.filed is not None:
            self._evidence = self.filed.assessment.case.evidence
        if self.standing in _STANDS:
            self._reread_timer.start()
        self.poll()
        self.changed.emit()

    def _file(self, evidence: Evidence, then: Callable[[], None], past: Past | None = None) -> None:
        """Keep it, unless it is void: of a void check no record is made. The store's thread does it; then `then`."""
        store = self._services.storage.store
        statement, entered = self._statement, self.entered
        person = Person(
            who=entered.who,
            module=self._naming.name or None,
            aircraft=entered.aircraft,
            are_records_looked_at=statement.are_records_looked_at,
            is_same_module=statement.is_same_module,
        )
        is_kept = evidence.is_complete and not self._is_entered_again and isinstance(store, Store)
        work = partial(
            file_check,
            evidence,
            entered.expectations(),
            person,
            self._log,
            store=store if is_kept and isinstance(store, Store) else None,
            program_version=version(),
            past=past,
            adapter="" if self._connector.target is None else self._connector.target.identity,
        )

        def end(filed: Filed) -> None:
            self.filed = filed
            self._by_verdict[filed.assessment.verdict] = filed
            self.trouble = store if isinstance(store, StoreTrouble) else filed.trouble
            if self._is_entered_again:
                self.void = _ENTERED_AGAIN
            self._is_entered_again = False
            if is_kept and self.trouble is None and self.result("boot_count") is not CheckResult.FAIL:
                self._naming.remember_adapter()
            then()

        if isinstance(store, Store) and is_kept:
            self._filing.run_in(store.queue, work, end)
        else:
            self._filing.cancel()
            end(work())

    def _take(self, batch: Batch) -> None:
        if self._job.is_running:
            self._keep_frames(batch)
        else:
            self.poll()

    def _keep_frames(self, batch: Batch) -> None:
        began_at = self._evidence.began_at
        if began_at is not None:
            self._log.feed(event for event in batch.events if event.at >= began_at)

    def _watch_port(self) -> None:
        if not self._connector.is_open or self._connector.state.phase is Phase.OPENING:
            self._is_port_broken = True
        self.poll()


_STANDINGS = {Verdict.GO: Standing.GO, Verdict.READY: Standing.READY, Verdict.NO_GO: Standing.NO_GO}
_STANDS = (Standing.GO, Standing.READY)
_HOLDS = tuple(_STANDINGS.values())
_ENTERED_AGAIN = Void(Disturbance.CHANGED, said(marked("entries")))
