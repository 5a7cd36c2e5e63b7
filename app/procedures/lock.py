"""Put the module into standby: the one act that is always safe, never refused, and done at once."""

from dataclasses import dataclass

from app.acts import Act
from app.journal import Journal, NoJournal, Outcome
from app.procedure import Procedure
from app.procedures.act import perform


@dataclass(frozen=True, slots=True)
class Locked:
    """`is_locked` is what the module says afterwards; None where it does not say."""

    is_acknowledged: bool
    is_locked: bool | None


def lock(journal: Journal | None = None) -> Procedure[Locked]:
    """Sent once; what counts is what the module reports afterwards. Written down where that is possible."""
    performed = yield from perform(Act.LOCK, journal or NoJournal())
    says = {Outcome.CONFIRMED: True, Outcome.REFUSED: False}
    return Locked(performed.is_acknowledged, says.get(performed.outcome))
