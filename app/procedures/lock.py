"""Put the module into standby: the one act that is always safe."""

from dataclasses import dataclass

from app.procedure import Ask, Procedure
from protocol.catalogue import ACTIVATION, BY_NAME
from protocol.events import Answered
from protocol.messages import Acknowledgement, Reading


@dataclass(frozen=True, slots=True)
class Locked:
    """`is_locked` is what the module says afterwards; None where it does not say."""

    is_acknowledged: bool
    is_locked: bool | None


def lock() -> Procedure[Locked]:
    """Sent once; what counts is what the module reports afterwards."""
    outcome = yield Ask(ACTIVATION.set(False))
    acknowledged = isinstance(outcome, Answered) and any(
        isinstance(message, Acknowledgement) and message.is_accepted for message in outcome.messages
    )
    state = yield Ask(BY_NAME["active"].query())
    if not isinstance(state, Answered):
        return Locked(acknowledged, None)
    return Locked(acknowledged, not _is_active(state))


def _is_active(state: Answered) -> bool:
    return any(isinstance(message, Reading) and message.value is True for message in state.messages)
