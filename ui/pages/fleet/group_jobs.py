"""One profile for the ticked modules, none of which waits for another.

What came of it is of a conversation of the module, and ends with that here, too.
"""

from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Job
from app.fleet.card import Applied, AppliedProfile, changes_of, differences, outcome_of
from app.procedures.write import SettingChange, WriteContext, WriteReport, write_all
from app.safety.journal import Act
from app.safety.permit import Interlock, inputs_at, refusals
from app.settings.form import ProfileRow
from app.settings.profiles import Profile
from app.text.messages import UserError, UserMessage, joined, message
from protocol.translatable import marked
from ui.pages.fleet.members import FleetMembers, port_text
from ui.services.context import Services
from ui.session.port import Port
from ui.session.shown_module import ShownModule


class GroupProfile(QObject):
    """Writes one profile and verifies it on each module; the procedure refuses an active one."""

    changed = Signal()

    def __init__(self, services: Services, members: FleetMembers, parent: QObject) -> None:
        super().__init__(parent)
        self._services = services
        self._members = members
        self.profile: Profile | None = None
        # What came of the last writing, and in which conversation.
        self._applied: dict[Port, tuple[ShownModule, AppliedProfile]] = {}
        self._jobs: dict[ShownModule, Job[WriteReport]] = {}

    @property
    def is_running(self) -> bool:
        return bool(self._jobs)

    def open(self, profile: Profile | None) -> None:
        if not self.is_running:
            self.profile = profile
            self._applied = {}
            self.changed.emit()

    def differences(self, port: Port) -> list[ProfileRow]:
        module = port.module
        return [] if self.profile is None else differences(self.profile, module.view, module.now_s)

    def result(self, port: Port) -> AppliedProfile | None:
        """What came of writing to this module, or will come of it without sending anything; None where something would
        be written now."""
        module, applied = self._applied.get(port, (None, None))
        return applied if applied is not None and module is port.module else self._foreseen(port)

    def _foreseen(self, port: Port) -> AppliedProfile | None:
        module = port.module
        if port not in self._members.reachable:
            return AppliedProfile(Applied.UNREACHABLE)
        if not self.differences(port):
            return AppliedProfile(Applied.NOTHING_TO_DO)
        if not module.activation.may_fire:
            return None
        unmet = refusals(Act.WRITE, inputs_at(module.view, module.now_s))
        locked = [refusal.message for refusal in unmet if refusal.condition is Interlock.MAY_WRITE]
        return AppliedProfile(Applied.REFUSED, joined(locked, " "))

    @property
    def writable(self) -> list[Port]:
        """The modules to which something would be written now."""
        return [port for port in self._members.ticked if self._foreseen(port) is None]

    def changes(self) -> tuple[SettingChange, ...]:
        return tuple(dict.fromkeys(one for port in self.writable for one in changes_of(self.differences(port))))

    def named_results(self) -> list[tuple[str, AppliedProfile]]:
        """Of the last writing, with the name of each module, or its port where it has none. What was verified ends
        with its conversation; what failed is said until the next writing."""
        results = []
        for port in self._members.connections:
            module, applied = self._applied.get(port, (None, None))
            if module is not None and applied is not None and (module is port.module or not applied.state.is_fine):
                results.append((module.name or port_text(port.target), applied))
        return results

    def apply(self, accepted: frozenset[SettingChange] = frozenset()) -> None:
        """Write what differs; a failure of one module does not stop the others."""
        if self.profile is None or self.is_running:
            return
        self._applied = {}
        for port in self._members.ticked:
            module, foreseen = port.module, self._foreseen(port)
            self._applied[port] = module, foreseen or AppliedProfile(Applied.WRITING)
            if foreseen is None:
                context = WriteContext(
                    journal=module.journal,
                    armed=self._services.armed,
                    accepted_risks=accepted,
                    keep_as_found=module.keep_as_found(),
                )
                writing = write_all(changes_of(self.differences(port)), context)
                self._jobs[module] = module.run(writing, partial(self._end, port, module), goes_on=True)
        self.changed.emit()

    def cancel(self) -> None:
        for job in self._jobs.values():
            job.cancel()

    def _end(self, port: Port, module: ShownModule, job: Job[WriteReport]) -> None:
        del self._jobs[module]
        if job.error is None:
            applied = outcome_of(job.outcome())
        else:
            why = job.error.message if isinstance(job.error, UserError) else UserMessage("")
            applied = AppliedProfile(Applied.FAILED, why)
        self._applied[port] = module, applied
        if module.is_going:
            module.keep()
        else:  # the row is of the next conversation by now
            told = applied.why if applied.why.text else message(applied.state.value)
            module.keep_report(message(marked("{name}: {value}"), name=message(marked("Profile")), value=told))
        self.changed.emit()
