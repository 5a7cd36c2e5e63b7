"""Last known activation of a silent module: ACTIVE, or shut down by command."""

from enum import Enum
from typing import Final, NamedTuple

from app.engine.device import DeviceView, Known, StaleReason
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.translatable import marked

LAST_HEARD_ACTIVE: Final = marked("Last heard ACTIVE: treat it as ready to fire.")
_KEEP_AWAY: Final = marked("Keep away, LOCK again, restore the link; only then switch it off.")


def keep_away(restoring: str = "") -> str:
    """What to do about a module that was last heard ACTIVE and is silent, in the language in use.

    It may fire while somebody leans over it, so no advice that brings a hand near it comes before this. `restoring`: a
    sentence about how the link comes back, which needs nothing done at the module.
    """
    return join_sentences((tr(_KEEP_AWAY), restoring))


def was_heard_active(device: DeviceView) -> bool:
    """Whether its last report, however old, is ACTIVE."""
    known = device.values.get("active")
    return known is not None and known.value is True


class Activation(Enum):
    """The state that is shown. A module that is `ACTIVE` or `WAS_ACTIVE` must be treated as ready to fire."""

    UNKNOWN = "unknown"
    LOCKED = "locked"
    WAS_LOCKED = "was locked"
    """It reported LOCKED last; it may have been activated since."""
    ACTIVE = "active"
    WAS_ACTIVE = "was active"
    """It reported ACTIVE last."""


class SeenActivation(NamedTuple):
    """`at`: monotonic seconds of the report; None if unknown."""

    state: Activation
    at: float | None = None

    @property
    def may_fire(self) -> bool:
        return self.state in (Activation.ACTIVE, Activation.WAS_ACTIVE)


class LastKnown:
    """The state of one module; `clear` for another one."""

    def __init__(self) -> None:
        self._active: Known | None = None
        """The last report, or an acknowledged activation."""
        self._shut_down: tuple[float, float] | None = None
        """When, by the session's clock and by `time.time()`."""

    def feed(self, device: DeviceView) -> None:
        """To be called with every view of the device."""
        known = device.values.get("active")
        if known is not None:
            self._active = known
        if self._shut_down is not None and any(value.at > self._shut_down[0] for value in device.values.values()):
            self._shut_down = None  # the module answers again

    def clear(self) -> None:
        """Reset: another module may be connected."""
        self._active = self._shut_down = None

    def note_shutdown(self, at: float, wall_s: float) -> None:
        """The module acknowledged a shutdown by this program. `wall_s`: as `time.time()`."""
        self._shut_down = at, wall_s

    @property
    def switched_off_at(self) -> float | None:
        """As `time.time()`; None if it was not shut down, or once it answers again."""
        return None if self._shut_down is None else self._shut_down[1]

    def activation(self, device: DeviceView, now: float) -> SeenActivation:
        """The state to show at `now`."""
        known = device.known("active", now)
        if known is not None and not known.is_stale:
            return SeenActivation(Activation.ACTIVE if known.value is True else Activation.LOCKED, known.at)
        is_doubtful = known is not None and known.stale_reason is StaleReason.WRITE_UNCONFIRMED
        if known is not None and known.value is False and not is_doubtful:
            return SeenActivation(Activation.WAS_LOCKED, known.at)
        # Unknown, or a LOCK was acknowledged but not reported, or an activation was not answered.
        last = known if known is not None and known.value is True else self._active
        if last is not None and last.value is True:
            return SeenActivation(Activation.WAS_ACTIVE, last.at)
        return SeenActivation(Activation.UNKNOWN)
