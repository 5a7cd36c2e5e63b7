"""Permit for one frame: given by a person, in one conversation; it expires, and is used once."""

from dataclasses import dataclass
from enum import Enum

from app.safety.acts import Act


class Origin(Enum):
    """How the person gave the permit; the value is how long it is valid, in seconds.

    Whatever takes longer, the act is refused rather than carried out late. The slowest line that takes commands needs
    1.5 s to ask who is there, and the intent may take a second.
    """

    RITUAL = 3.0  # chosen, armed, held for two seconds
    CONFIRMATION = 6.0  # a second click in the window; zeroing watches the module for two seconds
    COMMAND_LINE = 10.0  # --yes


@dataclass(slots=True, eq=False)
class Permit:
    """For one frame of one act in the conversation of this number. Only the sending thread calls `spend`."""

    act: Act
    origin: Origin
    # By the session's clock, in seconds.
    granted_at: float
    conversation: int
    # Nothing is ever sent.
    is_rehearsal: bool = False
    is_spent: bool = False

    def age_s(self, now: float) -> float:
        return now - self.granted_at

    def is_in_time(self, now: float) -> bool:
        return 0.0 <= self.age_s(now) <= self.origin.value

    def spend(self) -> bool:
        """Use it up; False if it was used before."""
        if self.is_spent:
            return False
        self.is_spent = True
        return True
