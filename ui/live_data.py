"""What the Live page remembers: series of what was measured, limits over time, and what happened when.

``take`` costs the same for one sample as for a hundred: numbers go into the series as arrays, and only changes
are looked at one by one.  Times are monotonic seconds.
"""

from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.device import DeviceView
from app.device import Sample as Status
from app.recording import is_recording
from app.samples import Seconds, Series, Steps, Values
from app.worker import Batch, Connection, PortState
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.events import Event, Restarted
from protocol.link_states import Presence
from protocol.text import marked
from ui.icons import Icon
from ui.plot_view import Lane, Limit, Mark, Scale
from ui.theme import Meaning

# Polled once a second: ten hours.
_SLOW_SAMPLES: Final = 36_000
_HAPPENINGS_KEPT: Final = 1000
_RATE_OVER_S: Final = 2.0
# Voltage and light count as fresh for 5 s, so their lines go on for as long.
_SLOW_GAP_S: Final = 5.0
_TRIGGERED: Final = 2
_ACTIVE: Final = 1


class Kind(Enum):
    """What can happen; the value is the word in a file, which stays English."""

    CONNECTED = "connected"
    RECORDING = "recording played"
    RECONNECTED = "reconnected"
    PORT_LOST = "port lost"
    OFFLINE = "offline"
    RESTARTED = "restarted"
    ACTIVATED = "activated"
    LOCKED = "locked"
    TRIGGERED = "triggered"
    TRIGGER_ENDED = "trigger ended"
    CHARGER_CONNECTED = "charger connected"
    CHARGER_REMOVED = "charger removed"


@dataclass(frozen=True, slots=True)
class Happening:
    """Something that happened; ``port`` is the one it happened on."""

    time_s: float
    kind: Kind
    port: str = ""


_MARKS: Final[dict[Kind, tuple[str, Icon, Meaning | None]]] = {
    Kind.CONNECTED: (marked("connected"), Icon.LINK, Meaning.INFORMATION),
    Kind.RECORDING: (marked("recording"), Icon.PLAY, Meaning.INFORMATION),
    Kind.RECONNECTED: (marked("reconnected"), Icon.LINK, Meaning.INFORMATION),
    Kind.PORT_LOST: (marked("port lost"), Icon.UNPLUGGED, Meaning.ATTENTION),
    Kind.OFFLINE: (marked("offline"), Icon.LINK_LOST, Meaning.ATTENTION),
    Kind.RESTARTED: (marked("restarted"), Icon.RESTART, Meaning.ATTENTION),
    Kind.ACTIVATED: (marked("activated"), Icon.ACTIVE, Meaning.ATTENTION),
    Kind.LOCKED: (marked("locked"), Icon.LOCK, None),
    Kind.TRIGGERED: (marked("triggered"), Icon.PARACHUTE, Meaning.DANGER),
    Kind.TRIGGER_ENDED: (marked("trigger ended"), Icon.NOT_TRIGGERED, None),
    Kind.CHARGER_CONNECTED: (marked("charger connected"), Icon.BOLT, None),
    Kind.CHARGER_REMOVED: (marked("charger removed"), Icon.PLUG, None),
}


def mark_of(happening: Happening) -> Mark:
    """How the plots show it."""
    word, icon, meaning = _MARKS[happening.kind]
    return Mark(happening.time_s, word, icon, meaning)


@dataclass(frozen=True, slots=True)
class Recording:
    """A copy of what was measured in a span, for a file: nothing that comes later changes it."""

    start_s: float
    end_s: float
    time_s: Seconds
    tilt_deg: Values
    acceleration_g: Values
    is_triggered: NDArray[np.bool_]
    is_active: NDArray[np.bool_]
    cell_time_s: Seconds
    cell_voltage_v: Values
    light_time_s: Seconds
    light_v: Values
    happenings: tuple[Happening, ...]
    is_whole: bool
    """False where the span reaches back to what is no longer kept sample by sample."""

    @property
    def first_s(self) -> float:
        """When its first row was measured; the start of the span where it has none."""
        firsts = [float(times[0]) for times in (self.time_s, self.cell_time_s, self.light_time_s) if len(times)]
        return min((*firsts, *(one.time_s for one in self.happenings)), default=self.start_s)

    @property
    def row_count(self) -> int:
        """Of everything that has a time of its own."""
        return len(self.time_s) + len(self.cell_time_s) + len(self.light_time_s) + len(self.happenings)


class LiveData:
    """Takes batches in the window's thread."""

    def __init__(self) -> None:
        self.tilt = Series()
        self.acceleration = Series()
        self.cell = Series(_SLOW_SAMPLES, summary_buckets=_SLOW_SAMPLES)
        self.light = Series(_SLOW_SAMPLES, summary_buckets=_SLOW_SAMPLES)
        self.fires = Steps()
        self.rearms = Steps()
        self.falls = Steps()
        self.happenings: deque[Happening] = deque(maxlen=_HAPPENINGS_KEPT)
        # In step with tilt and acceleration, sample by sample; its summary is not used.
        self._flags = Series(summary_buckets=2)
        self._flags_now: int | None = None
        self._is_charging: bool | None = None
        self._first_s: float | None = None
        self._state = PortState.CLOSED
        self._port = ""
        self._lost_port: str | None = None
        self._presence = Presence.UNKNOWN
        self._restarts = 0

    @property
    def has_samples(self) -> bool:
        """A module said at least once how it is."""
        return self._first_s is not None

    def reports_per_s(self, now_s: float) -> float:
        """Status reports a second, streamed or polled, over the last two seconds."""
        return len(self.tilt.window(now_s - _RATE_OVER_S, now_s).time_s) / _RATE_OVER_S

    def take(self, batch: Batch) -> list[Mark]:
        """Add a batch; what happened in it, as marks for the plots."""
        count = len(self.happenings)
        new: list[Happening] = []
        self._follow_opening(batch.connection, batch.at, new)
        if batch.samples:
            self._add_samples(batch.samples, new)
        self._follow_device(batch.device, batch.events, batch.at, new)
        self._follow_loss(batch.connection, batch.at, new)
        self._add_slow(batch.device)
        self._put_limits(batch.device, batch.at)
        self.happenings.extend(new)
        # The very first connection is the beginning of the time line, and no news on it.
        shown = new[1:] if not count and new and new[0].kind is Kind.CONNECTED else new
        return [mark_of(one) for one in shown]

    def recording(self, start_s: float, end_s: float) -> Recording:
        """A copy of everything in a span, both ends included."""
        time_s, tilt_deg = self.tilt.window(start_s, end_s)
        flags = self._flags.window(start_s, end_s).value.astype(np.int8)
        cell, light = self.cell.window(start_s, end_s), self.light.window(start_s, end_s)
        oldest_s = self.tilt.exact_since_s
        is_whole = self._first_s is None or start_s >= oldest_s or self._first_s >= oldest_s
        return Recording(
            start_s=start_s,
            end_s=end_s,
            time_s=time_s.copy(),
            tilt_deg=tilt_deg.copy(),
            acceleration_g=self.acceleration.window(start_s, end_s).value.copy(),
            is_triggered=(flags & _TRIGGERED) != 0,
            is_active=(flags & _ACTIVE) != 0,
            cell_time_s=cell.time_s.copy(),
            cell_voltage_v=cell.value.copy(),
            light_time_s=light.time_s.copy(),
            light_v=light.value.copy(),
            happenings=tuple(one for one in self.happenings if start_s <= one.time_s <= end_s),
            is_whole=is_whole,
        )

    def _add_samples(self, samples: tuple[Status, ...], new: list[Happening]) -> None:
        columns = np.array(samples, np.float64).T
        times = columns[0]
        flags = columns[3] * _TRIGGERED + columns[4] * _ACTIVE
        self.tilt.append(times, columns[1])
        self.acceleration.append(times, columns[2])
        self._flags.append(times, flags)
        if self._first_s is None:
            self._first_s = float(times[0])
        # The first state that is known is no change.
        before = flags[0] if self._flags_now is None else self._flags_now
        for n in np.flatnonzero(np.diff(flags, prepend=before)):
            was, now = int(flags[n - 1] if n else before), int(flags[n])
            at = float(times[n])
            if (was ^ now) & _ACTIVE:
                new.append(Happening(at, Kind.ACTIVATED if now & _ACTIVE else Kind.LOCKED, self._port))
            if (was ^ now) & _TRIGGERED:
                new.append(Happening(at, Kind.TRIGGERED if now & _TRIGGERED else Kind.TRIGGER_ENDED, self._port))
        self._flags_now = int(flags[-1])

    def _follow_opening(self, connection: Connection, at: float, new: list[Happening]) -> None:
        is_open, was_open = connection.state is PortState.OPEN, self._state is PortState.OPEN
        if not is_open or (was_open and connection.port == self._port):
            return
        self._state, self._port = connection.state, connection.port
        self._presence, self._restarts = Presence.UNKNOWN, 0
        if self._lost_port != connection.port:
            # A person chose it: another module, of which nothing is known.
            self._lost_port, self._flags_now, self._is_charging = None, None, None
            kind = Kind.RECORDING if is_recording(self._port) else Kind.CONNECTED
            new.append(Happening(at, kind, self._port))

    def _follow_loss(self, connection: Connection, at: float, new: list[Happening]) -> None:
        was_open, self._state = self._state is PortState.OPEN, connection.state
        if was_open and connection.state is PortState.CLOSED and connection.trouble is not None:
            self._lost_port = self._port
            new.append(Happening(at, Kind.PORT_LOST, self._port))

    def _follow_device(
        self, device: DeviceView, events: tuple[Event, ...], at: float, new: list[Happening]
    ) -> None:
        since = at if device.presence_since is None else device.presence_since
        if device.presence is not self._presence:
            was_offline, self._presence = self._presence is Presence.OFFLINE, device.presence
            if device.presence is Presence.OFFLINE:
                new.append(Happening(since, Kind.OFFLINE, self._port))
            elif device.presence is Presence.ONLINE and (was_offline or self._lost_port is not None):
                self._lost_port = None
                new.append(Happening(since, Kind.RECONNECTED, self._port))
        if device.restarts != self._restarts:
            is_news, self._restarts = device.restarts > self._restarts, device.restarts
            if is_news:
                # Known from a heartbeat, or only from a boot count that went on.
                seen = [event.at for event in events if isinstance(event, Restarted)]
                new.extend(Happening(one, Kind.RESTARTED, self._port) for one in seen or [at])
        known = device.values.get("charging")
        if known is not None and not known.is_stale:
            is_charging = known.value is True
            if self._is_charging is not None and is_charging is not self._is_charging:
                kind = Kind.CHARGER_CONNECTED if is_charging else Kind.CHARGER_REMOVED
                new.append(Happening(known.at, kind, self._port))
            self._is_charging = is_charging

    def _add_slow(self, device: DeviceView) -> None:
        for series, key in ((self.cell, "cell_voltage_v"), (self.light, "light_v")):
            known = device.values.get(key)
            if known is None or known.is_stale:
                continue
            last = series.last
            if last is None or known.at > last.time_s:
                series.append(known.at, float(known.value))

    def _put_limits(self, device: DeviceView, at: float) -> None:
        """Limits as the module said them: nothing while that is in doubt, or while the trigger is switched off."""
        fires = _limit(device, "attitude_threshold_deg", "attitude_trigger", at)
        self.fires.put(at, fires)
        self.rearms.put(at, None if fires is None else fires - RESET_BELOW_THRESHOLD_DEG)
        self.falls.put(at, _limit(device, "freefall_acceleration_g", "freefall_trigger", at))


def _limit(device: DeviceView, key: str, switch: str, at: float) -> float | None:
    value, is_on = device.fresh(key, at), device.fresh(switch, at)
    return None if value is None or is_on is False else float(value)


def lanes(data: LiveData) -> tuple[Lane, ...]:
    """The plots of the page, from the top down."""
    return (
        Lane(
            marked("Tilt"),
            "°",
            data.tilt,
            (Scale(0, 90, 30), Scale(0, 180, 45)),
            (
                Limit(data.fires, marked("{value}° fires"), Meaning.DANGER),
                Limit(data.rearms, marked("{value}° rearms"), Meaning.INFORMATION),
            ),
            weight=3,
        ),
        Lane(
            marked("Acceleration"),
            "g",
            data.acceleration,
            (Scale(0, 2, 1), Scale(0, 4, 2), Scale(0, 8, 4), Scale(0, 16, 8), Scale(0, 26, 13)),
            (Limit(data.falls, marked("{value} g free fall"), Meaning.DANGER, 1),),
            decimals=1,
            weight=2,
        ),
        Lane(
            marked("Cell voltage"),
            "V",
            data.cell,
            (Scale(3, 4.5, 0.5), Scale(0, 6, 2)),
            decimals=2,
            weight=1.2,
            gap_s=_SLOW_GAP_S,
        ),
    )
