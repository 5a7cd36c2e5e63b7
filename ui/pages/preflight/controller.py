"""Controller of the Pre-flight page: begins checks, and says what can be done with the module that the pages show."""

from dataclasses import replace

from protocol.link_states import Presence
from PySide6.QtCore import QObject, Signal

from app.diagnosis.link_state import Phase, link_text
from app.preflight.findings import Person
from app.preflight.run import TRIGGERS
from app.preflight.verdict import Assessment
from app.records.record import SignedRecord
from app.settings.profiles import ActivatedBy, Profile
from ui.services.port import Ports
from ui.services.port_check import ENTRIES, PortCheck, Standing, reported_active


class PreflightController(QObject):
    """`changed`: the standing or the findings are different."""

    changed = Signal()

    def __init__(self, connector: Ports, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._connector = connector
        self.last: PortCheck | None = None
        """The last check begun here, of this module."""
        connector.leaving.connect(self.cancel)

    # What is known

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
        port = self._connector.current
        is_settled = port.state.phase not in (Phase.OPENING, Phase.FINDING)
        return port.is_open and is_settled and (port.check is None or not port.check.is_busy)

    @property
    def can_enable(self) -> bool:
        """Nothing is written to an active module, nor before a person has said which module it is."""
        is_locked = self.is_answering and not self.may_fire
        return self.can_check and self._connector.current.identity.is_settled and (is_locked or self.needs_lock)

    @property
    def is_answering(self) -> bool:
        return self._connector.current.device.presence is Presence.ONLINE

    @property
    def link_sentence(self) -> str:
        """In the language in use."""
        return link_text(self._connector.current.state, self._connector.clock()).what

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
        return reported_active(self._connector.current)

    @property
    def leads_to_activation(self) -> bool:
        """READY, and it is a person who activates the module."""
        last = self.last
        return last is not None and last.standing is Standing.READY and last.profile.activated_by is ActivatedBy.PERSON

    # What a person does

    def check(self, profile: Profile, person: Person, *, is_enabling: bool = False) -> None:
        """Start a check; nothing of the previous one is kept on screen."""
        if self.can_check:
            self.last = None  # what becomes of the former one is no news
            self.last = self._connector.current.begin_check(profile, person, is_enabling=is_enabling)
            self.last.changed.connect(self.changed)
            self.changed.emit()

    def cancel(self) -> None:
        if self.last is not None:
            self.last.cancel()

    def enter(self, profile: Profile, *, who: str, aircraft: str) -> None:
        """An entry changed. Where it decides (the profile, a manual item), the check is void, also a running one; what
        is only written on the record is written on it."""
        if self.last is not None:
            if profile != self.last.profile:
                self.last.set_void(ENTRIES)
            self.last.state_again(replace(self.last.person, who=who, aircraft=aircraft))
        self.changed.emit()

    def poll(self) -> None:
        """Void the verdict if it no longer holds."""
        if self.last is not None:
            self.last.poll()

    def reset(self) -> None:
        """Another module may be connected."""
        self.last = None
        self.changed.emit()
