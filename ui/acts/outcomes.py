"""Texts for unmet conditions and outcomes of acts, shared by rows, ritual and baud rate."""

from dataclasses import replace
from typing import Final

from app.engine.address_lock import sets_rate
from app.procedures.act import Performed
from app.procedures.lock import Locked
from app.safety.acts import Act
from app.safety.interlocks import Interlock, Refusal, interlock_inputs, refusals
from app.safety.journal import Outcome
from app.text.i18n import tr
from app.text.messages import UserMessage
from protocol.translatable import marked
from ui.services.context import Services
from ui.services.port import Ports
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice

ASKING: Final = marked("Asking the module…")
_ASKED_ANYWAY: Final = (Interlock.CONFIRMED, Interlock.RITUAL_DONE)
"""What the person is about to do: not shown as an open condition."""


def open_conditions(services: Services, act: Act) -> tuple[Refusal, ...]:
    """Open conditions of `act`, apart from the person's confirmation."""
    port = services.ports.current
    if not port.is_open:
        return (Refusal(Interlock.ONLINE, UserMessage(marked("Not connected"))),)
    inputs = replace(
        interlock_inputs(port.device, port.clock(), must_be_proven=False),
        is_identity_settled=port.identity.is_settled,
        armed=services.armed.act,
        is_audit_ready=port.journal().is_ready,
        sets_rate=sets_rate(port.connection.port),
    )
    return tuple(refusal for refusal in refusals(act, inputs) if refusal.condition not in _ASKED_ANYWAY)


class OutcomeWatch:
    """Whether a notice of an act is still true."""

    def __init__(self, services: Services) -> None:
        self._connector = services.ports
        self._done: Performed | None = None
        """The act that was asked about last, with the last confirmed LOCK and the restarts until then."""
        self._locked: Locked | None = None
        self._restarts = 0

    def has_turned(self, done: Performed | None) -> bool:
        """Whether the module no longer reports that it is active, after an activation that was confirmed; or, after
        one that is unknown, reports that it is locked after a restart or a confirmed LOCK."""
        device = self._connector.current.device
        if done is not self._done:
            self._done, self._locked, self._restarts = done, self._connector.current.lock.confirmed, device.restarts
        if done is None or done.act is not Act.ACTIVATE or done.outcome not in (Outcome.CONFIRMED, Outcome.UNKNOWN):
            return False
        locked = self._connector.current.lock.confirmed
        is_locked_since = locked is not None and locked is not self._locked
        is_active = device.fresh("active", self._connector.clock())
        if done.outcome is Outcome.CONFIRMED:
            return is_active is not True
        return is_active is False and (is_locked_since or device.restarts > self._restarts)


def outcome_meaning(done: Performed) -> Meaning:
    if done.is_rehearsal:
        return Meaning.INFORMATION
    match done.outcome:
        case Outcome.UNKNOWN:
            return Meaning.DANGER
        case Outcome.CONFIRMED:
            is_hot = done.act in (Act.ACTIVATE, Act.DEPLOY) or (done.act is Act.ZERO and not done.is_level)
            return Meaning.DANGER if done.act is Act.DEPLOY else Meaning.ATTENTION if is_hot else Meaning.GOOD
        case _:
            return Meaning.ATTENTION


def motion_text(connector: Ports) -> str:
    """The current input of zeroing; empty if unknown."""
    motion, tilt = connector.current.device.motion, connector.current.device.fresh("tilt_deg", connector.clock())
    if motion is None or tilt is None:
        return ""
    return tr(
        "{tilt:.0f}°, {low:.1f}–{high:.1f} g, moved {change:.0f}° in 2 s",
        tilt=tilt,
        low=motion.acceleration_low_g,
        high=motion.acceleration_high_g,
        change=motion.tilt_change_deg,
    )


def not_begun() -> Notice:
    return Notice(Meaning.ATTENTION, tr("Link lost. Nothing was sent."))


def outcome_notice(done: Performed) -> Notice:
    return Notice(outcome_meaning(done), done.sentence)
