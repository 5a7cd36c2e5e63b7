"""The activation as it is shown: what the module reports, or reported last."""

from enum import Enum
from typing import Final, NamedTuple

from app.engine.conversation import ConversationView
from app.text.i18n import tr
from app.text.messages import join_sentences
from protocol.translatable import marked

LAST_HEARD_ACTIVE: Final = marked("Last heard ACTIVE: treat it as ready to fire.")
_KEEP_AWAY: Final = marked("Keep away, LOCK again, restore the link; only then switch it off.")


def keep_away(restoring: str = "") -> str:
    """What to do about a module that was last heard ACTIVE and is silent, in the language in use.

    It may fire while somebody leans over it, so no advice that brings a hand near it comes before this. `restoring`: a
    sentence about how the link comes back, which needs nothing done at the module.
    """
    return join_sentences((tr(_KEEP_AWAY), restoring))


class Activation(Enum):
    """A module that is `ACTIVE` or `WAS_ACTIVE` must be treated as ready to fire."""

    UNKNOWN = "unknown"
    LOCKED = "locked"
    WAS_LOCKED = "was locked"  # it reported LOCKED last; it may have been activated since
    ACTIVE = "active"
    WAS_ACTIVE = "was active"


class SeenActivation(NamedTuple):
    """`at`: when that was reported, in seconds of the session's clock; None if unknown."""

    state: Activation
    at: float | None = None

    @property
    def may_fire(self) -> bool:
        return self.state in (Activation.ACTIVE, Activation.WAS_ACTIVE)


def seen_activation(conversation: ConversationView, now: float) -> SeenActivation:
    """The state to show at `now`; of an ended conversation, too. An acknowledged activation counts as ACTIVE, although
    no report has told it yet: it may fire already."""
    known = conversation.known("active", now)
    if known is None:
        return SeenActivation(Activation.UNKNOWN)
    if known.value is True:
        return SeenActivation(Activation.WAS_ACTIVE if known.is_stale else Activation.ACTIVE, known.at)
    return SeenActivation(Activation.WAS_LOCKED if known.is_stale else Activation.LOCKED, known.at)


def was_heard_active(conversation: ConversationView) -> bool:
    """Whether its last report, however old, is ACTIVE."""
    known = conversation.values.get("active")
    return known is not None and known.value is True
