"""What is shown of a module's state: its activation and its two triggers."""

from enum import Enum
from typing import Final, NamedTuple

from app.engine.conversation import ConversationView
from app.text.i18n import tr
from app.text.messages import join_sentences
from protocol.catalogue import BY_NAME
from protocol.translatable import marked

# The activation: what the module reports, or reported last

LAST_HEARD_ACTIVE: Final = marked("Last heard ACTIVE: treat it as ready to fire.")


def keep_away(restoring: str = "") -> str:
    """Say what to do about a module that was last heard ACTIVE and is silent, in the language in use. It may fire while
    somebody leans over it, so no advice that brings a hand near it comes before this. `restoring` is a sentence about
    how the link comes back, which needs nothing done at the module."""
    return join_sentences((tr("Keep away, LOCK again, restore the link; only then switch it off."), restoring))


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


# The two automatic triggers. A module cannot be asked (E8): they are known only of what was set

TILT_TRIGGER = BY_NAME["attitude_trigger"].key
FALL_TRIGGER = BY_NAME["freefall_trigger"].key
TRIGGER_OFF = marked("trigger off")
TRIGGER_NOT_KNOWN = marked("trigger not known")


class TriggerFlags(NamedTuple):
    """The two triggers: whether each is enabled, None where it is not known."""

    tilt: bool | None = None
    fall: bool | None = None

    @property
    def are_on(self) -> bool:
        return self.tilt is True and self.fall is True

    @property
    def is_one_off(self) -> bool:
        return self.tilt is False or self.fall is False

    @property
    def text(self) -> str:
        """The words in the language in use. One that is off is said even where the other is not known."""
        if self.is_one_off:
            is_tilt_off, is_fall_off = self.tilt is False, self.fall is False
            return tr("both off") if is_tilt_off and is_fall_off else tr("tilt off") if is_tilt_off else tr("fall off")
        return tr("both on") if self.are_on else tr("not known")


def trigger_flags(conversation: ConversationView, now: float) -> TriggerFlags:
    tilt, fall = (conversation.fresh(key, now) for key in (TILT_TRIGGER, FALL_TRIGGER))
    return TriggerFlags(tilt if isinstance(tilt, bool) else None, fall if isinstance(fall, bool) else None)
