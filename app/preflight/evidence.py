"""Evidence of a pre-flight check, filled in step by step: an aborted check keeps what it read so far."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from app.engine.device import StatusSample
from app.engine.procedure import Cancelled, Slept, TwoModules
from app.preflight.reread import StateChange, StateReading, changes_between
from app.procedures.history import History
from app.text.messages import UserMessage
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.fields import Value
from protocol.translatable import marked

HEARTBEATS = 20
STILL_S = 2.0
"""For tilt and acceleration."""
MAX_FRAMES = 1500
MAX_STREAMED = 200


class Disturbance(Enum):
    """Why a check is void; the value is English, translatable."""

    INTERRUPTED = marked("interrupted")
    DISCONNECTED = marked("port lost")
    SILENT = marked("no reply")
    RESTARTED = marked("the module restarted")
    BROKEN = marked("no reply for a moment")
    SLEPT = marked("computer slept")
    CHANGED = marked("changed")
    UNREAD = marked("not read again")
    TOO_OLD = marked("too old")
    FIRED = marked("told to fire")
    CONTRADICTED = marked("contradictory answers")


class FlagState(Enum):
    """Result for a trigger flag, which cannot be read: only an acknowledged set tells its state (E8)."""

    NEVER_SET = "never set"
    ENABLED = "enabled"
    DISABLED = "disabled"
    REFUSED = "refused"
    UNANSWERED = "unanswered"
    NOT_SENT = "not sent"


class TriggerFlag(NamedTuple):
    """`why`: why it was not sent."""

    state: FlagState = FlagState.NEVER_SET
    why: UserMessage | None = None


class LoggedFrame(NamedTuple):
    """`way`: "out", "in" or "noise" (invalid bytes)."""

    at: float
    way: str
    raw: bytes


class FrameLog:
    """Raw frames of a check: of a stream only the first ones are kept, the rest is counted."""

    def __init__(self) -> None:
        self.frames: list[LoggedFrame] = []
        self.left_out = 0
        self._streamed = 0

    def feed(self, events: Iterable[Event]) -> None:
        for event in events:
            match event:
                case Sent():
                    self._add_frame(LoggedFrame(event.at, "out", event.raw))
                case Received():
                    self._streamed += event.role is Role.STREAMED
                    is_too_much = event.role is Role.STREAMED and self._streamed > MAX_STREAMED
                    self._add_frame(LoggedFrame(event.at, "in", event.frame.raw), is_left_out=is_too_much)
                case Rejected():
                    self._add_frame(LoggedFrame(event.at, "noise", event.noise.raw))
                case _:
                    pass

    def _add_frame(self, frame: LoggedFrame, *, is_left_out: bool = False) -> None:
        if is_left_out or len(self.frames) >= MAX_FRAMES:
            self.left_out += 1
        else:
            self.frames.append(frame)


@dataclass(slots=True)
class Evidence:
    """Times are monotonic seconds. What is not known is empty or None."""

    port: str = ""
    baud_rate: int = 0
    began_at: float | None = None
    ended_at: float | None = None
    opened_at: float | None = None
    restarts: int = 0
    """Session count at the start of the check."""
    breaks: int = 0
    """Session count when the heartbeats were answered."""
    breaks_noticed: int = 0
    """Session count when what was read before was dropped last."""
    heartbeats_sent: int = 0
    round_trips_s: list[float] = field(default_factory=list)
    """Of the answered heartbeats."""
    rejected_before: int = 0
    """Session count at the start of the check."""
    rejected_bytes: int = 0
    """During the check, also an aborted one."""
    trials: list[StatusSample] = field(default_factory=list)
    """During the two seconds."""
    status: StatusSample | None = None
    """The last one."""
    status_age_s: float | None = None
    """At the end of the check."""
    values: dict[str, Value] = field(default_factory=dict)
    """Settings and boot count by key, as last read: each twice in a row."""
    first: StateReading | None = None
    last: StateReading | None = None
    """Before and after measuring."""
    series: dict[str, list[Value]] = field(default_factory=dict)
    """All answers for cell voltage, charging and light, by key."""
    faults: dict[str, UserMessage] = field(default_factory=dict)
    """Why a value is not known, by key."""
    history: History | None = None
    flags: dict[str, TriggerFlag] = field(default_factory=dict)
    """By key of the trigger."""
    is_enabling: bool = False
    disturbance: Disturbance | None = None
    contradiction: UserMessage | None = None
    """What was answered twice and differently."""
    is_answered_twice: bool = False
    """Something was told that nobody had asked for."""
    streamed: int = 0
    """Status reports that came while none was asked for, for a second or longer."""
    log: FrameLog = field(default_factory=FrameLog)

    @property
    def statuses(self) -> list[StatusSample]:
        """All statuses that were asked for."""
        ends = [
            reading.status for reading in (self.first, self.last) if reading is not None and reading.status is not None
        ]
        return [*ends, *self.trials]

    def said_otherwise(self, key: str) -> UserMessage | None:
        """What 30 or 31 and the status said where they differed, or where one of them was not answered."""
        readings = [reading for reading in (self.first, self.last) if reading is not None]
        found = [reading.present.contradictions.get(key) for reading in readings if not reading.settings.is_silent]
        return next((words for words in found if words is not None), None)

    @property
    def changes(self) -> tuple[StateChange, ...]:
        """What differs between the two readings."""
        return () if self.first is None or self.last is None else tuple(changes_between(self.first, self.last))

    @property
    def heartbeats_lost(self) -> int:
        return self.heartbeats_sent - len(self.round_trips_s)

    @property
    def is_active(self) -> bool | None:
        """As the module last reported itself."""
        return None if self.status is None else self.status.active

    @property
    def is_complete(self) -> bool:
        return self.ended_at is not None and self.disturbance is None

    def note_error(self, error: BaseException | None) -> None:
        """Record why the procedure ended early, unless that is known already."""
        if error is None or self.disturbance is not None:
            return
        if isinstance(error, TwoModules):
            self.disturbance, self.contradiction = Disturbance.CONTRADICTED, error.message
            self.keep_only({})
            self.first = None
            self.history = None
            return
        if isinstance(error, Slept):
            self.disturbance = Disturbance.SLEPT
        else:
            self.disturbance = Disturbance.INTERRUPTED if isinstance(error, Cancelled) else Disturbance.DISCONNECTED

    def keep_only(self, values: Mapping[str, Value]) -> None:
        """Drop what was read, except these values: it may be another module's."""
        self.values = dict(values)
        self.series.clear()
        self.trials.clear()
        self.status = None
        for key, flag in self.flags.items():
            if flag.state is FlagState.ENABLED:
                self.flags[key] = TriggerFlag()

    def listen(self, events: Iterable[Event]) -> None:
        """Keep the frames of the port since the check began."""
        began_at = self.began_at
        if began_at is not None:
            self.log.feed(event for event in events if event.at >= began_at)

    def settings(self, keys: Iterable[str]) -> Mapping[str, Value]:
        return {key: self.values[key] for key in keys if key in self.values}
