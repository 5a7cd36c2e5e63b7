"""Checks and profiles for several modules at once; no module waits for another."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Job
from app.fleet.check_set import SetMember
from app.fleet.profile_table import Applied, AppliedProfile, Column, column, outcome_of
from app.preflight.evidence import OVER
from app.preflight.findings import Person
from app.procedures.write import SettingChange, WriteContext, WriteReport, write_all
from app.safety.acts import Act
from app.safety.interlocks import Interlock, inputs_at, refusals
from app.settings.profiles import NO_PROFILE, Profile
from app.text.messages import joined, message
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.pages.fleet.members import FleetMembers, port_text
from ui.services.context import Services
from ui.session.check import ModuleCheck
from ui.session.port import Port
from ui.session.shown_module import ShownModule

SILENT = message(marked("The module does not answer."))


class GroupChecks(QObject):
    """Pre-flight checks of several modules; sends queries only, or enables the triggers of each locked module first."""

    changed = Signal()
    finished = Signal()

    def __init__(self, services: Services, members: FleetMembers, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._members = members
        self._running: dict[Port, ModuleCheck] = {}
        self.profile: Profile | None = None
        self._ended: dict[Port, Callable[[], SetMember]] = {}
        """Of the last set."""
        self.total = 0
        services.ports.removed.connect(self._on_removed)
        members.replaced.connect(self._on_removed)

    @property
    def is_running(self) -> bool:
        return bool(self._running)

    @property
    def results(self) -> dict[Port, SetMember]:
        """Of the last set, as they stand now."""
        return {connection: make() for connection, make in self._ended.items()}

    def check(self, connections: Sequence[Port], *, is_enabling: bool = False) -> None:
        """Start; the results of the previous set are discarded. `is_enabling`: the triggers, of what is locked."""
        if self.is_running or any(connection.module.is_checking for connection in connections):
            return
        self._ended = {}
        self.total = len(connections)
        reachable = self._members.reachable
        for connection in connections:
            if connection in reachable:
                profile = self.profile or NO_PROFILE
                check = self._running[connection] = connection.module.begin_check(
                    profile, Person(), is_enabling=is_enabling
                )
                check.changed.connect(partial(self._on_check, connection, check))
        for connection in connections:
            if connection not in reachable:
                name = connection.module.name
                silent = partial(SetMember, port_text(connection.target), name, None, SILENT)
                self._finish(connection, silent)
        self.changed.emit()

    def cancel(self) -> None:
        for check in self._running.values():
            check.cancel()

    def _on_check(self, connection: Port, check: ModuleCheck) -> None:
        if self._running.get(connection) is not check or check.is_running:
            return
        self._finish(connection, partial(_member, connection, check))

    def _finish(self, connection: Port, make: Callable[[], SetMember]) -> None:
        self._running.pop(connection, None)
        self._ended[connection] = make
        self.changed.emit()
        if not self._running:
            self.finished.emit()

    def _on_removed(self, connection: Port) -> None:
        """The port was disconnected, or has another module; the other checks go on."""
        check = self._running.get(connection)
        if check is not None:
            member = SetMember(port_text(check.target), check.person.module or "", None, OVER.message)
            self._finish(connection, lambda: member)
        elif connection in self._ended:
            last = self._ended[connection]()
            self._ended[connection] = lambda: last._replace(filed=None, trouble=OVER.message)


def _member(connection: Port, check: ModuleCheck) -> SetMember:
    """As it stands now: what is void by now is not checked."""
    void = check.void or (None if connection.module.check is check else OVER)
    trouble = check.trouble.message if check.trouble is not None else None if void is None else void.message
    filed = check.filed if void is None else None
    return SetMember(port_text(check.target), check.person.module or "", filed, trouble)


class GroupProfile(QObject):
    """Writes one profile to several modules and verifies it on each; the engine refuses an active module."""

    changed = Signal()

    def __init__(self, services: Services, members: FleetMembers, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._members = services, members
        self.profile: Profile | None = None
        self.applied: dict[Port, AppliedProfile] = {}
        self._jobs: dict[Port, Job[WriteReport]] = {}
        services.ports.removed.connect(self._on_removed)
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
        module = connection.module
        return column(profile, module.view, module.now_s, port=port_text(connection.target), title=module.name)

    def result(self, connection: Port) -> AppliedProfile | None:
        """Of the last writing to this module."""
        return self.applied.get(connection)

    def foreseen(self, connection: Port) -> AppliedProfile | None:
        """Why nothing may be written to this module now; None where it may be, or where nothing differs."""
        module = connection.module
        if not module.is_going:
            return AppliedProfile(Applied.UNREACHABLE)
        if not self.column(connection).changes:
            return None
        if not module.activation.may_fire:
            return None
        unmet = refusals(Act.WRITE, inputs_at(module.view, module.now_s))
        locked = tuple(refusal.message for refusal in unmet if refusal.condition is Interlock.MAY_WRITE)
        return AppliedProfile(Applied.REFUSED, locked)

    @property
    def writable(self) -> tuple[Port, ...]:
        """The modules to which something would be written now."""
        return tuple(
            connection for connection in self._members.connections
            if self.column(connection).changes and self.foreseen(connection) is None
        )  # fmt: skip

    def changes(self) -> tuple[SettingChange, ...]:
        """What would be written to any of the modules."""
        changes = (self.column(connection).changes for connection in self.writable)
        return tuple(dict.fromkeys(chain.from_iterable(changes)))

    def named_results(self) -> list[tuple[str, AppliedProfile]]:
        """Of the last writing, with the name of each module, or its port where it has none."""
        results = ((self.column(connection), self.result(connection)) for connection in self.applied)
        return [(column.title or column.port, result) for column, result in results if result is not None]

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
        foreseen = self.foreseen(connection)
        if foreseen is not None:
            self.applied[connection] = foreseen
            return
        module = connection.module
        context = WriteContext(
            journal=module.journal,
            armed=self._services.armed,
            accepted_risks=accepted,
            keep_as_found=module.keep_as_found(),
        )
        self.applied[connection] = AppliedProfile(Applied.WRITING)
        job = module.run(write_all(changes, context), partial(self._end, connection, module), goes_on=True)
        self._jobs[connection] = job

    def _end(self, connection: Port, module: ShownModule, job: Job[WriteReport]) -> None:
        if self._jobs.get(connection) is not job:
            return
        del self._jobs[connection]
        if isinstance(job.error, UserError):
            applied = AppliedProfile(Applied.FAILED, (job.error.message,))
        elif job.error is not None:
            applied = AppliedProfile(Applied.FAILED)
        else:
            applied = outcome_of(job.outcome())
        self.applied[connection] = applied
        if connection.module is not module:
            del self.applied[connection]  # the row is of the next conversation by now
        if not module.is_going:
            why = joined(applied.why) if applied.why else message(applied.state.value)
            module.keep_report(message(marked("{name}: {value}"), name=message(marked("Profile")), value=why))
        self.changed.emit()

    def _on_removed(self, connection: Port) -> None:
        """The port was disconnected, or has another module; what was being written is reported when it has ended."""
        if connection not in self._jobs and self.applied.pop(connection, None) is not None:
            self.changed.emit()
