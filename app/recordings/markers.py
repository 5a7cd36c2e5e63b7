"""Marks on the time line: where a conversation broke, which module it was, and what the module did.

A mark at each end of a conversation says why; what follows may be another module. A name holds from the beginning of
the conversation in which it was said up to the next such mark.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final, NamedTuple

from app.engine.conversation import ConversationView, StatusSample
from app.engine.worker import Batch, PortState
from app.safety.last_known import FALL_TRIGGER, TILT_TRIGGER
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.events import Began, Ended, EndReason
from protocol.fields import Value


class MarkerKind(Enum):
    """The value is the word in files, which is not translated."""

    CONNECTED = "connected"
    PORT_LOST = "port lost"
    RESTARTED = "restarted"
    SILENT = "silent"
    CONTRADICTED = "two modules?"
    SLEPT = "computer slept"
    ANOTHER = "another module"
    RATE_CHANGED = "baud rate changed"
    NAMED = "named"
    ACTIVATED = "activated"
    LOCKED = "locked"
    TRIGGERED = "triggered"
    TRIGGER_ENDED = "trigger ended"
    DAMAGED = "damaged data left out"  # from here on


class Marker(NamedTuple):
    time_s: float  # of the program's clock
    kind: MarkerKind
    text: str = ""  # the port that was opened or lost, or the name of the module


# That the port was lost, the connection tells, also where nobody answered; where it is closed the recording ends.
_END_MARKS: Final = {
    reason: MarkerKind[reason.name] for reason in EndReason if reason not in (EndReason.CLOSED, EndReason.PORT_LOST)
}
# After these marks another module may answer, or this one has lost its state.
STATE_LOST: Final = frozenset({MarkerKind.CONNECTED, MarkerKind.PORT_LOST, *_END_MARKS.values()})


class ModuleLimits(NamedTuple):
    """Limits that the module reported; None: unknown, or the trigger is disabled."""

    fires_deg: float | None = None
    rearms_deg: float | None = None
    free_fall_g: float | None = None
    free_fall_s: float | None = None
    light_v: float | None = None


class MarkerTracker:
    """Derives marks from the batches of one port, in order."""

    def __init__(self) -> None:
        self._is_open = False
        self._before: StatusSample | None = None
        # The next report is the first one of a conversation, perhaps of another module.
        self._is_first = False

    def on_batch(self, batch: Batch) -> list[Marker]:
        """The marks of this batch, in order of detection; times may differ slightly from that order."""
        new: list[Marker] = []
        is_open = batch.connection.state is PortState.OPEN
        if is_open and not self._is_open:
            new.append(Marker(batch.at, MarkerKind.CONNECTED, batch.connection.port))
        # A batch is of one conversation, so what it brings lies between its beginning and its end.
        self._is_first |= any(isinstance(event, Began) for event in batch.events)
        for sample in batch.samples:
            before, is_first = self._before, self._is_first
            self._before, self._is_first = sample, False
            if before is None:
                continue  # the first known state is no change
            # Another module may be locked and not triggered, which is no change. One that is active or has triggered
            # is marked in any case.
            for now, then, on, off in (
                (sample.active, before.active, MarkerKind.ACTIVATED, MarkerKind.LOCKED),
                (sample.triggered, before.triggered, MarkerKind.TRIGGERED, MarkerKind.TRIGGER_ENDED),
            ):
                if now is not then and (now or not is_first):
                    new.append(Marker(sample.at, on if now else off))
        ends = (event for event in batch.events if isinstance(event, Ended))
        new += [Marker(event.at, _END_MARKS[event.reason]) for event in ends if event.reason in _END_MARKS]
        if self._is_open and not is_open and batch.connection.trouble is not None:
            new.append(Marker(batch.at, MarkerKind.PORT_LOST, batch.connection.port))
        self._is_open = is_open
        return new


# Limits


def limits_of(conversation: ConversationView, now: float) -> ModuleLimits:
    """Return what the module has told in the conversation that goes on."""
    return _limits(lambda key: conversation.fresh(key, now))


def acting_limits(conversation: ConversationView, now: float) -> ModuleLimits:
    """Return the limits that the module acts on: those of triggers that are known to be enabled."""
    return _limits(lambda key: conversation.fresh(key, now), is_acting=True)


def last_limits(conversation: ConversationView) -> ModuleLimits:
    """The last reported ones, also of a conversation that is over."""
    last = {key: known.value for key, known in conversation.values.items()}
    return _limits(last.get)


def _limits(find: Callable[[str], Value | None], *, is_acting: bool = False) -> ModuleLimits:
    def limit(key: str, switch: str = "") -> float | None:
        is_on = find(switch) if switch else True
        value = find(key) if is_on or (is_on is None and not is_acting) else None
        return None if value is None else float(value)

    fires = limit("attitude_threshold_deg", TILT_TRIGGER)
    return ModuleLimits(
        fires_deg=fires,
        rearms_deg=None if fires is None else fires - RESET_BELOW_THRESHOLD_DEG,
        free_fall_g=limit("freefall_acceleration_g", FALL_TRIGGER),
        free_fall_s=limit("freefall_time_s", FALL_TRIGGER),
        light_v=limit("light_threshold_v"),
    )
