"""Checks and profiles for several modules at once; no module waits for another."""

from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Cancelled
from app.engine.snapshots import Snapshot
from app.engine.worker import Batch, Job
from app.fleet.check_set import SetMember
from app.fleet.profile_table import Applied, AppliedProfile, Column, broken_off, column, outcome_of
from app.fleet.verdicts import KeptCheck
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import Person
from app.preflight.run import run_preflight
from app.procedures.write import Written
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from app.records.filing import Filed
from app.settings.profiles import NO_PROFILE, Profile
from app.text.messages import UserMessage, message
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.pages.fleet.members import FleetMembers, port_text
from ui.services.context import Services
from ui.services.port import Port
from ui.services.running_job import file_in_background

SILENT = message(marked("The module does not answer."))
CANCELLED = message(marked("Cancelled."))


@dataclass(slots=True)
class _Check:
    evidence: Evidence
    port: str
    """Of the module that is checked, as its name."""
    name: str
    job: Job[Any] | None = None
    filing: BackgroundTask[Filed] | None = None


class GroupChecks(QObject):
    """Pre-flight checks of several modules; sends queries only, or enables the triggers of each locked module first."""

    changed = Signal()
    finished = Signal()

    def __init__(self, services: Services, members: FleetMembers, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._members = services, members
        self._running: dict[Port, _Check] = {}
        self.profile: Profile | None = None
        self.results: dict[Port, SetMember] = {}
        """Of the last set."""
        self.total = 0
        services.connector.removed.connect(self._on_removed)
        members.replaced.connect(self._on_removed)
        services.connector.added.connect(self._hear)
        for connection in services.connector.connections:
            self._hear(connection)

    @property
    def is_running(self) -> bool:
        return bool(self._running)

    def check(self, connections: Sequence[Port], *, is_enabling: bool = False) -> None:
        """Start; the results of the previous set are discarded. `is_enabling`: the triggers, of what is locked."""
        if self.is_running:
            return
        self.results = {}
        self.total = len(connections)
        reachable = self._members.reachable
        for connection in connections:
            if connection in reachable:
                self._begin(connection, is_enabling=is_enabling)
        for connection in connections:
            if connection not in reachable:
                self._finish(connection, connection.module.name, None, SILENT)
        self.changed.emit()

    def cancel(self) -> None:
        for running in self._running.values():
            if running.job is not None:
                running.job.cancel()

    def _begin(self, connection: Port, *, is_enabling: bool) -> None:
        name = connection.module.name
        evidence = Evidence(port=connection.connection.port)
        check = self._running[connection] = _Check(evidence, port_text(connection.target), name)
        self._members.is_checking.add(connection)
        journal = connection.journal()
        procedure = run_preflight(check.evidence, is_enabling=is_enabling, journal=journal)
        check.job = connection.run(procedure, partial(self._end, connection, name))

    def _hear(self, connection: Port) -> None:
        connection.batch.connect(partial(self._listen, connection))

    def _listen(self, connection: Port, batch: Batch) -> None:
        check = self._running.get(connection)
        if check is not None and check.filing is None:
            check.evidence.listen(batch.events)

    def _end(self, connection: Port, name: str, job: Job[Any]) -> None:
        check = self._running.get(connection)
        if check is None or job is not check.job:
            return
        self._listen(connection, connection.last)
        evidence = check.evidence
        if connection.module.name != name:
            evidence.disturbance = Disturbance.CHANGED  # it would be kept under the former name
        evidence.note_error(job.run.error)
        if evidence.began_at is None:
            self._finish(connection, name, None, CANCELLED if isinstance(job.run.error, Cancelled) else SILENT)
            return
        check.filing = BackgroundTask("dps-s check", self)
        file_in_background(
            check.filing, evidence, self.profile or NO_PROFILE, Person(module=name or None),
            is_stored=evidence.is_complete, store=self._services.storage.store, target=connection.target,
            then=partial(self._on_filed, connection, name, check),
        )  # fmt: skip

    def _on_filed(self, connection: Port, name: str, check: _Check, filed: Filed) -> None:
        if self._running.get(connection) is not check:
            return  # of the module before
        connection.kept.check = KeptCheck(filed)
        trouble = None if filed.trouble is None else filed.trouble.message
        self._finish(connection, name, filed, trouble)

    def _finish(self, connection: Port, name: str, filed: Filed | None, trouble: UserMessage | None) -> None:
        check = self._running.pop(connection, None)
        self._members.is_checking.discard(connection)
        port = port_text(connection.target) if check is None else check.port
        self.results[connection] = SetMember(port, name, filed, trouble)
        self.changed.emit()
        if not self._running:
            self.finished.emit()

    def _on_removed(self, connection: Port) -> None:
        """The port was disconnected, or has another module; the other checks go on."""
        check = self._running.get(connection)
        if check is not None:
            if check.job is not None:
                check.job.cancel()
            self._finish(connection, check.name, None, message(marked("Disconnected.")))


class GroupProfile(QObject):
    """Writes one profile to several modules and verifies it on each; the engine refuses an active module."""

    changed = Signal()

    def __init__(self, services: Services, members: FleetMembers, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._members = services, members
        self.profile: Profile | None = None
        self.applied: dict[Port, AppliedProfile] = {}
        self._jobs: dict[Port, Job[WriteReport]] = {}
        services.connector.removed.connect(self._on_removed)
        members.replaced.connect(self._on_removed)

    @property
    def is_running(self) -> bool:
        return bool(self._jobs)

    def open(self, profile: Profile | None) -> None:
        if not self.is_running:
            self.profile, self.applied = profile, {}
            self.changed.emit()

    def column(self, connection: Port) -> Column:
        """The profile compared with what is known of the module."""
        profile = self.profile or Profile(name="", settings={})
        return column(
            profile, connection.device, self._services.connector.clock(), port=port_text(connection.target),
            title=connection.module.name, is_reachable=connection in self._members.reachable,
        )  # fmt: skip

    def changes(self) -> tuple[SettingChange, ...]:
        """What would be written to any of the modules."""
        changes = (self.column(connection).changes for connection in self._members.connections)
        return tuple(dict.fromkeys(chain.from_iterable(changes)))

    def apply(self, connections: Sequence[Port], accepted: frozenset[SettingChange] = frozenset()) -> None:
        """Write what differs; a failure of one module does not stop the others."""
        if self.profile is None or self.is_running:
            return
        self.applied = {}
        for connection in connections:
            self._begin(connection, accepted)
        self.changed.emit()

    def cancel(self) -> None:
        for job in self._jobs.values():
            job.cancel()

    def _begin(self, connection: Port, accepted: frozenset[SettingChange]) -> None:
        changes = self.column(connection).changes
        if connection not in self._members.reachable:
            self.applied[connection] = AppliedProfile(Applied.UNREACHABLE)
            return
        if not changes:
            self.applied[connection] = AppliedProfile(Applied.NOTHING_TO_DO)
            return
        heard: list[Written] = []
        storage, port = self._services.storage, connection.connection.port
        name = connection.module.name
        kept = connection.kept

        def keep(snapshot: Snapshot) -> Future[int] | None:
            """Called in the worker's thread."""
            kept.as_found = kept.as_found or snapshot
            return storage.store_snapshot(snapshot, port, name)

        context = WriteContext(
            journal=connection.journal(),
            armed=self._services.armed,
            accepted_risks=accepted,
            store_snapshot=keep,
            on_written=heard.append,
        )
        self.applied[connection] = AppliedProfile(Applied.WRITING)
        self._jobs[connection] = connection.run(write_all(changes, context), partial(self._end, connection, heard))

    def _end(self, connection: Port, heard: list[Written], job: Job[WriteReport]) -> None:
        if self._jobs.get(connection) is not job:
            return
        del self._jobs[connection]
        error = job.run.error
        self.applied[connection] = outcome_of(job.outcome()) if error is None else broken_off(heard, error)
        self.changed.emit()

    def _on_removed(self, connection: Port) -> None:
        job = self._jobs.pop(connection, None)
        if job is not None:
            job.cancel()
        if self.applied.pop(connection, None) is not None:
            self.changed.emit()
