"""Everything known about one module: each value with its source, its time and the reason why it is stale.

Only the module's own frames provide values. A value that was never received is absent and shown as "unknown"; the
defaults of the vendor's table are never used instead.

    read          the answer to a question
    acknowledged  the module acknowledged a set (E2: "received", not yet verified)
    streamed      part of a streamed report
    stale         any of these, in doubt after a restart, a lost link, an unconfirmed write or because of its age
    unknown       never received, or (E8) unreadable and lost at a restart
"""

from collections import deque
from collections.abc import Iterable, Mapping
from enum import Enum
from math import inf
from types import MappingProxyType
from typing import NamedTuple

from app.engine.motion import MotionExtremes, MotionWatch
from app.engine.setting_changes import ACKNOWLEDGED_KEYS, BOOTS, READABLE_SETTINGS, UNREADABLE, key_changed_by
from protocol.catalogue import ACTIVATION, BOOT_COUNT, MAX_RECORDS, SERIAL_OUTPUT, Request
from protocol.events import (
    Answered,
    Contradicted,
    Event,
    FellSilent,
    OutcomeUnknown,
    Received,
    Restarted,
    Role,
    WentOffline,
    WentOnline,
)
from protocol.fields import Value
from protocol.flag_answers import TRIGGER_FLAGS, FlagAnswers
from protocol.lag import Lag
from protocol.link_states import Presence
from protocol.messages import Acknowledgement, Heartbeat, Reading, Status, TriggerRecord


class How(Enum):
    READ = "read"
    ACKNOWLEDGED = "acknowledged"
    STREAMED = "streamed"


class StaleReason(Enum):
    """Why a value that was known may no longer be true."""

    RESTARTED = "restarted"
    LINK_LOST = "link lost"
    WRITE_UNCONFIRMED = "write unconfirmed"
    AGED = "aged"
    LATE = "late"
    CONTRADICTED = "contradicted"


STATUS_KEYS = ("tilt_deg", "acceleration_g", "triggered", "active")
SLOW_KEYS = ("cell_voltage_v", "charging", "light_v")
FRESH_FOR_S: Mapping[str, float] = MappingProxyType(dict.fromkeys(STATUS_KEYS, 1.0) | dict.fromkeys(SLOW_KEYS, 5.0))
"""Seconds after which a live value is stale. Settings and the boot count change only with an act or a restart."""
READ_BACK = (BOOT_COUNT.key, *(command.key for command in READABLE_SETTINGS))
"""They do not age. In a silence the module may be exchanged."""

MAX_LAG_S = 1.0
"""Where frames are delayed for longer no status is current."""
STREAM_PROVES_S = 1.5
"""How long a streamed status proves that the serial output is on."""
STREAM_LATE_PERIODS = 1.5
"""A streamed status is stale when the next one is late by half a period."""
STREAM_GAP_S, STREAM_GAP_PERIODS = 0.3, 2.5
"""Longer than both, and the module may have been exchanged (see `Timing.silent_gap_s`), or reports were lost."""
STREAM_DOUBT_S = 3.0
"""So long at most streamed reports count as nobody's after a gap: until the boot count is read."""
STREAM_WINDOW_S = 3.0
"""The window in which the rate of the stream is measured; the slowest streams send one report a second."""
MAX_STRAY_RECORDS = 100 * MAX_RECORDS


class Known(NamedTuple):
    """One value, in its field's unit; `at` is monotonic seconds."""

    value: Value
    how: How
    at: float
    stale_reason: StaleReason | None = None
    sent_after: float = -inf
    """The earliest time at which the module can have sent it."""

    @property
    def is_stale(self) -> bool:
        return self.stale_reason is not None


class StatusSample(NamedTuple):
    """One status report. `at`: monotonic seconds at which its bytes were read from the port."""

    at: float
    tilt_deg: int
    acceleration_g: float
    triggered: bool
    active: bool


class Sleep(NamedTuple):
    """The computer slept. `ended_at`: monotonic seconds."""

    ended_at: float
    lasted_s: float


class DeviceView(NamedTuple):
    """What was known at one moment; immutable, so any thread may keep it."""

    values: Mapping[str, Known] = MappingProxyType({})
    presence: Presence = Presence.UNKNOWN
    presence_since: float | None = None
    is_streaming: bool = False
    """Status reports came unasked, the last one within 1.5 s."""
    stream_hz: float = 0.0
    stream_gaps: int = 0
    """How often reports were missing in the stream."""
    restarts: int = 0
    breaks: int = 0
    """How often the conversation broke (silence, restart): what cannot be read is unknown since."""
    last_sleep: Sleep | None = None
    contradicted: Contradicted | None = None
    """The last contradiction: perhaps two modules on this line."""
    is_restart_suspected: bool = False
    """A heartbeat may have been a restart's; the next boot count decides."""
    undecided: frozenset[str] = frozenset()
    """Keys of the values that are unknown until that is decided, or until no copy of an answer can come any more."""
    motion: MotionExtremes | None = None
    """Of the last seconds."""
    stray_records: tuple[TriggerRecord, ...] = ()
    """Trigger records received outside an answer, mostly after their query was given up; oldest first."""
    lag_s: float | None = None
    """How long frames from the module take to arrive; None while unknown."""

    @property
    def is_late(self) -> bool:
        return self.lag_s is not None and self.lag_s > MAX_LAG_S

    @property
    def reported(self) -> tuple[Value | None, ...]:
        """Triggered and active, as last reported; None while unknown."""
        return tuple(None if known is None else known.value for known in map(self.values.get, ("triggered", "active")))

    def known(self, key: str, now: float) -> Known | None:
        """The value, stale if it is too old at `now`; None while unknown."""
        known = self.values.get(key)
        if known is None or known.stale_reason is not None:
            return known
        if self.lag_s is not None and self.is_late and key in STATUS_KEYS:
            return known._replace(stale_reason=StaleReason.LATE, at=known.at - self.lag_s)  # about when it was sent
        limit_s = self.fresh_for_s(key, known.how)
        if limit_s is not None and now - known.at > limit_s:
            return known._replace(stale_reason=StaleReason.AGED)
        return known

    def fresh_for_s(self, key: str, how: How) -> float | None:
        """Seconds after which the value is stale; None where it does not age. A streamed value may be as old as the
        rate of the stream requires."""
        limit_s = FRESH_FOR_S.get(key)
        if how is not How.STREAMED:
            return limit_s
        if key == SERIAL_OUTPUT.key:
            return STREAM_PROVES_S
        if limit_s is not None and self.stream_hz > 0:
            return max(limit_s, min(STREAM_LATE_PERIODS / self.stream_hz, STREAM_PROVES_S))
        return limit_s

    def proven(self, key: str, now: float) -> Known | None:
        """The status value if it is proven that the module sent it within the last second, else None."""
        known = self.values.get(key)
        return known if known and not known.is_stale and now - known.sent_after <= FRESH_FOR_S[key] else None

    def fresh(self, key: str, now: float) -> Value | None:
        """The value if it is known and not stale, else None."""
        known = self.known(key, now)
        return None if known is None or known.is_stale else known.value


class Device:
    """Collects values from the link's events; one object for each module and port."""

    def __init__(self, baud_rate: int | None = None, lag: Lag | None = None, flags: FlagAnswers | None = None) -> None:
        self._baud_rate, self._lag, self._flags = baud_rate, lag, flags
        self._values: dict[str, Known] = {}
        self._view = DeviceView()
        """Complete after `view`; in between it has what changes with an event."""
        self._streamed_at: deque[float] = deque(maxlen=8192)
        self._latest: Received | None = None
        """The last status frame, not yet among the values: at line rate the next one follows soon."""
        self._gap_at = -inf
        """When the stream had a gap, after which the boot count was not read yet."""
        self._restarts_not_read = 0
        """Restarts since the boot count was last read: it grows by these without a further restart."""
        self._suspected: dict[str, Known] = {}
        """Values that are unknown until that is decided."""
        self._samples: list[StatusSample] = []
        self._stray_records: deque[TriggerRecord] = deque(maxlen=MAX_STRAY_RECORDS)
        self._motion = MotionWatch()

    def use_rate(self, baud_rate: int) -> None:
        """Set the port's rate; the next frame proves that it is the module's."""
        self._baud_rate = baud_rate

    def apply(self, event: Event) -> None:
        if isinstance(event, Received):
            self._on_frame(event)
            return
        self._settle()
        match event:
            case Answered():
                self._on_answer(event)
            case OutcomeUnknown():
                self._invalidate_write(event.request)
            case Restarted():
                self._on_restart()
            case FellSilent():
                self._break_off()
                if self._lag is None or self._lag.is_quick:  # else it is the line that is slow
                    self._doubt(READ_BACK, StaleReason.LINK_LOST)
            case Contradicted():
                self._view = self._view._replace(contradicted=event)
                self._break_off()
                self.mark_all_stale(StaleReason.CONTRADICTED)
            case WentOnline():
                self._view = self._view._replace(presence=Presence.ONLINE, presence_since=event.at)
                if self._baud_rate is not None:
                    self._values["baud_rate"] = Known(self._baud_rate, How.READ, event.at)
            case WentOffline():
                self._view = self._view._replace(presence=Presence.OFFLINE, presence_since=event.at)
                self._break_off()
                self.mark_all_stale(StaleReason.LINK_LOST)

    def mark_all_stale(self, stale_reason: StaleReason) -> None:
        """Mark all values as stale (port lost, module offline)."""
        self._settle()
        # The heartbeats of a restart, or the boot count that tells of it, came at the port's rate.
        came_at_rate = stale_reason in (StaleReason.RESTARTED, StaleReason.CONTRADICTED)
        proven = {"baud_rate"} if came_at_rate else set()
        self._doubt(self._values.keys() - proven, stale_reason)
        self._streamed_at.clear()
        self._motion.clear()
        self._clear_suspicion()

    def _doubt(self, keys: Iterable[str], stale_reason: StaleReason) -> None:
        for key in keys:
            known = self._values.get(key)
            if known is not None and not known.is_stale:
                self._values[key] = known._replace(stale_reason=stale_reason)

    def forget(self, before: float) -> None:
        """Forget what was known of another module, which nothing is of since `before`, in monotonic seconds."""
        self._settle()
        self._values = {key: known for key, known in self._values.items() if known.at >= before and not known.is_stale}
        if self._values and self._baud_rate is not None:  # what answered since answered at this rate
            self._values.setdefault("baud_rate", Known(self._baud_rate, How.READ, before))
        for former in (self._stray_records, self._samples, self._motion):
            former.clear()
        self._clear_suspicion()

    def note_sleep(self, sleep: Sleep) -> None:
        """For the view; its consequences come as events."""
        self._view = self._view._replace(last_sleep=sleep)

    def take_samples(self) -> list[StatusSample]:
        """Return all status reports since the last call, oldest first."""
        samples, self._samples = self._samples, []
        return samples

    def view(self, now: float) -> DeviceView:
        self._settle()
        while self._streamed_at and now - self._streamed_at[0] > STREAM_WINDOW_S:
            self._streamed_at.popleft()
        span_s = self._streamed_at[-1] - self._streamed_at[0] if self._streamed_at else 0.0
        hz = (len(self._streamed_at) - 1) / span_s if span_s > 0 else 0.0
        values, undecided = dict(self._values), set(self._suspected)
        if self._flags is not None and not self._flags.are_known(now):
            for command in TRIGGER_FLAGS:
                is_acknowledged = values.pop(command.key, None) is not None
                if is_acknowledged and not self._flags.has_repeated:
                    undecided.add(command.key)
        self._view = self._view._replace(
            values=MappingProxyType(values),
            is_streaming=len(self._streamed_at) > 1 and now - self._streamed_at[-1] < STREAM_PROVES_S,
            stream_hz=hz,
            undecided=frozenset(undecided),
            motion=self._motion.view(now),
            stray_records=tuple(self._stray_records),
            lag_s=None if self._lag is None else self._lag.seconds(now),
        )
        return self._view

    def _on_frame(self, event: Received) -> None:
        message = event.message
        if isinstance(message, Heartbeat) and event.role in (Role.UNSOLICITED, Role.LATE, Role.DUPLICATE):
            self._suspect_restart()
            if event.role is not Role.UNSOLICITED:  # the link decides about that one
                self._view = self._view._replace(is_restart_suspected=True)
        if isinstance(message, Reading) and event.role is Role.ANSWER and message.command is BOOT_COUNT:
            self._on_reading(message, event.at)  # also the answer to a fence, of which there is no `Answered`
        if isinstance(message, TriggerRecord) and event.role in (Role.LATE, Role.UNSOLICITED):
            self._stray_records.append(message)
        if not isinstance(message, Status) or event.role in (Role.LATE, Role.ECHO):
            return
        if event.role is Role.STREAMED:
            gap_s = event.at - self._streamed_at[-1] if self._streamed_at else 0.0
            is_gap = gap_s > STREAM_GAP_S and gap_s * self._view.stream_hz > STREAM_GAP_PERIODS
            if is_gap and (self._lag is None or self._lag.is_quick):  # else it is the line that is slow
                self._view, self._gap_at = self._view._replace(stream_gaps=self._view.stream_gaps + 1), event.at
                self._doubt(STATUS_KEYS, StaleReason.LINK_LOST)
            self._streamed_at.append(event.at)
        self._samples.append(StatusSample(event.at, *message))
        self._motion.feed(message, event.at)
        self._latest = event

    def _settle(self) -> None:
        """Take over the last status frame into the values."""
        event, self._latest = self._latest, None
        if event is None or not isinstance(event.message, Status):
            return
        how = How.READ if event.role is Role.ANSWER else How.STREAMED
        is_calm = not (event.message.triggered or event.message.active)
        if how is How.STREAMED and is_calm and event.at - self._gap_at < STREAM_DOUBT_S:
            return
        for key, value in zip(STATUS_KEYS, event.message, strict=True):
            self._values[key] = Known(value, how, event.at, sent_after=event.sent_after)
        if len(self._streamed_at) > 1:
            self._values[SERIAL_OUTPUT.key] = Known(True, How.STREAMED, self._streamed_at[-1])

    def _on_answer(self, event: Answered) -> None:
        for message in event.messages:
            if isinstance(message, Reading):
                self._on_reading(message, event.at)
            elif isinstance(message, Acknowledgement):
                self._on_acknowledgement(message, event.at)

    def _on_reading(self, reading: Reading, at: float) -> None:
        key = reading.command.key
        before = self._values.get(key)
        if key == BOOT_COUNT.key:
            boots = 0 if before is None else (reading.raw - int(before.value)) % BOOTS
            if boots > self._restarts_not_read:
                self._on_restart()  # it was switched off and on while nobody listened
            elif before is not None and not boots:
                self._values = self._suspected | self._values
            self._clear_suspicion()
            self._restarts_not_read, self._gap_at = 0, -inf
        self._values[key] = Known(reading.value, How.READ, at)

    def _on_acknowledgement(self, acknowledgement: Acknowledgement, at: float) -> None:
        command = acknowledgement.request.command
        key = key_changed_by(acknowledgement.request)
        # After an act only a report has the new value; but an acknowledged activation already may fire.
        is_over = key in STATUS_KEYS and acknowledgement.request != ACTIVATION.set(True)
        if is_over or not acknowledgement.is_accepted:
            self._invalidate_write(acknowledgement.request)
            return
        if key is None or command.write is None:
            return
        value = command.write.decode(acknowledgement.request.data)
        if key == "baud_rate":
            if value != self._baud_rate:
                self._invalidate_write(acknowledgement.request)  # only a frame at the new rate proves it (E9)
        elif key in ACKNOWLEDGED_KEYS:
            self._values[key] = Known(value, How.ACKNOWLEDGED, at)
            if command is SERIAL_OUTPUT and value is False:
                self._streamed_at.clear()

    def _invalidate_write(self, request: Request) -> None:
        key = key_changed_by(request)
        if key is None:
            return
        known = self._values.get(key)
        if key in UNREADABLE:
            self._values.pop(key, None)
            self._suspected.pop(key, None)
        elif known is not None:
            self._values[key] = known._replace(stale_reason=StaleReason.WRITE_UNCONFIRMED)

    def _suspect_restart(self) -> None:
        """An unexpected heartbeat may be one of a restart's two, or a late or doubled answer; only the boot count can
        tell. Until it is read it is stale, and the values that a restart would lose are unknown."""
        self._settle()
        self._doubt((BOOT_COUNT.key,), StaleReason.RESTARTED)
        for key in UNREADABLE & self._values.keys():
            self._suspected[key] = self._values.pop(key)

    def _clear_suspicion(self) -> None:
        self._view = self._view._replace(is_restart_suspected=False)
        self._suspected.clear()

    def _on_restart(self) -> None:
        self._view = self._view._replace(restarts=self._view.restarts + 1)
        self._restarts_not_read += 1
        self.mark_all_stale(StaleReason.RESTARTED)
        self._break_off()

    def _break_off(self) -> None:
        self._view = self._view._replace(breaks=self._view.breaks + 1)
        for key in UNREADABLE:
            self._values.pop(key, None)
            self._suspected.pop(key, None)
