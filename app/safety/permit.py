"""Permit for one frame: created by an explicit act, expires, used once."""

from dataclasses import dataclass
from enum import Enum

from app.safety.acts import Act


class Origin(Enum):
    """How the person gave the permit; the value is how long it is valid, in seconds.

    If the sending thread is busy for longer than this, the act is refused rather than carried out late.
    """

    RITUAL = 1.0
    """Chosen, armed, held for two seconds."""
    CONFIRMATION = 5.0
    """A second click in the window."""
    COMMAND_LINE = 10.0
    """--yes."""


@dataclass(slots=True, eq=False)
class Permit:
    """For one frame of one act. `granted_at`: monotonic seconds of the session's clock.

    `is_rehearsal`: nothing is ever sent. Only the sending thread calls `spend`.
    """

    act: Act
    origin: Origin
    granted_at: float
    is_rehearsal: bool = False
    is_spent: bool = False

    def age_s(self, now: float) -> float:
        return now - self.granted_at

    def is_good(self, act: Act, now: float) -> bool:
        """Whether it allows `act` now."""
        is_in_time = 0.0 <= self.age_s(now) <= self.origin.value
        return self.act is act and is_in_time and not self.is_spent and not self.is_rehearsal

    def spend(self) -> bool:
        """Use it up; False if it was used before."""
        if self.is_spent:
            return False
        self.is_spent = True
        return True
