"""What can be done with the check of the module that the pages show."""

from app.diagnosis.link_state import Phase
from app.preflight.run import TRIGGERS
from app.preflight.verdict import Assessment
from app.records.record import SignedRecord
from app.settings.profiles import ActivatedBy
from ui.session.check import ModuleCheck, Standing
from ui.session.ports import Ports


class PreflightController:
    """Keeps nothing: the check belongs to the module."""

    def __init__(self, ports: Ports) -> None:
        self._ports = ports

    @property
    def last(self) -> ModuleCheck | None:
        """The last check of this module, whoever began it."""
        return self._ports.module.check

    @property
    def standing(self) -> Standing:
        return Standing.NOT_CHECKED if self.last is None else self.last.standing

    @property
    def assessment(self) -> Assessment | None:
        """The last check's; None while one runs, so that no old finding is shown."""
        return None if self.last is None else self.last.assessment

    @property
    def signed(self) -> SignedRecord | None:
        """What may be exported."""
        return None if self.last is None else self.last.signed

    @property
    def can_check(self) -> bool:
        port, check = self._ports.current, self.last
        is_settled = port.state.phase not in (Phase.OPENING, Phase.FINDING)
        return port.is_open and is_settled and port.module.is_going and (check is None or not check.is_busy)

    @property
    def can_enable(self) -> bool:
        """Nothing is written to an active module, which is locked first."""
        return self.can_check and (not self.may_fire or self.needs_lock)

    @property
    def needs_lock(self) -> bool:
        """It is active, and its triggers are not known: it has to be locked to enable them."""
        return self.can_check and self.may_fire and not self.are_triggers_known

    @property
    def are_triggers_known(self) -> bool:
        """Whether the module has acknowledged the state of both automatic triggers in this conversation."""
        view, now = self._ports.module.view, self._ports.clock()
        known = [view.known(command.key, now) for command in TRIGGERS]
        return all(trigger is not None and not trigger.is_stale for trigger in known)

    @property
    def may_fire(self) -> bool:
        """It reports ACTIVE, or did so last."""
        return self._ports.current.is_active

    @property
    def reported_active(self) -> bool | None:
        """What the module reports now; None while unknown."""
        active = self._ports.module.view.fresh("active", self._ports.clock())
        return None if active is None else active is True

    @property
    def leads_to_activation(self) -> bool:
        """READY, and it is a person who activates the module."""
        last = self.last
        return last is not None and last.standing is Standing.READY and last.profile.activated_by is ActivatedBy.PERSON
