"""Markers on the time line, derived from batches."""

from collections.abc import Callable, Iterable
from enum import Enum
from functools import partial
from math import inf
from typing import NamedTuple

from app.engine.device import DeviceView
from app.engine.identity import READ_WITHIN_S
from app.engine.worker import Batch, Connection, PortState
from app.safety.trigger_flags import FALL_TRIGGER, TILT_TRIGGER, TriggerFlags
from protocol.catalogue import BOOT_COUNT, RESET_BELOW_THRESHOLD_DEG
from protocol.events import BREAKS, Event, FellSilent, Received, Restarted
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Heartbeat

ONE_BREAK_S = 0.5
"""A restart that is seen sooner after a break is part of it: it is seen twice."""


class MarkerKind(Enum):
    """The value is the word in files, which is not translated."""

    CONNECTED = "connected"
    RECONNECTED = "reconnected"
    PORT_LOST = "port lost"
    OFFLINE = "offline"
    RESTARTED = "restarted"
    DOUBTED = "another module?"
    """From here on, until a person has said which module it is; perhaps another one again where it comes twice."""
    ACTIVATED = "activated"
    LOCKED = "locked"
    TRIGGERED = "triggered"
    TRIGGER_ENDED = "trigger ended"
    CHARGER_CONNECTED = "charger connected"
    CHARGER_REMOVED = "charger removed"
    DAMAGED = "damaged data left out"
    """Data between here and the next report is missing from the recording."""
    MISSING = "missing"
    """Reports that came before were not recorded, because the disk was too slow."""


class Marker(NamedTuple):
    """`time_s`: monotonic seconds."""

    time_s: float
    kind: MarkerKind
    port: str = ""


class ModuleLimits(NamedTuple):
    """Limits that the module reported; None: unknown, stale, or the trigger is disabled."""

    fires_deg: float | None = None
    rearms_deg: float | None = None
    free_fall_g: float | None = None
    free_fall_s: float | None = None
    light_v: float | None = None


NO_LIMITS = ModuleLimits()
STATE_LOST = frozenset({MarkerKind.RESTARTED, MarkerKind.CONNECTED, MarkerKind.DOUBTED})
"""Markers after which the module has lost its state, or is another one."""


def charging_at(markers: Iterable[Marker], time_s: float) -> bool | None:
    """Whether there was external power at `time_s`; None: unknown. `markers` must be in order of time."""
    is_charging: bool | None = None
    for marker in markers:
        is_past = marker.time_s <= time_s
        match marker.kind:
            case MarkerKind.CHARGER_CONNECTED | MarkerKind.CHARGER_REMOVED:
                is_connected = marker.kind is MarkerKind.CHARGER_CONNECTED
                if not is_past:  # a marker means that the state before was the opposite
                    return not is_connected if is_charging is None else is_charging
                is_charging = is_connected
            case MarkerKind.CONNECTED:
                if not is_past:
                    break
                is_charging = None
            case _:
                pass
    return is_charging


class MarkerTracker:
    """Derives markers by comparing each batch with the previous one."""

    def __init__(self) -> None:
        self.limits = NO_LIMITS
        """As of the last batch."""
        self.flags = TriggerFlags()
        """Whether the triggers are known to be on, as of the last batch."""
        self._triggered: bool | None = None
        self._active: bool | None = None
        self._is_charging: bool | None = None
        self._state = PortState.CLOSED
        self._port = ""
        self._was_lost = False
        """The next port that opens is the same adapter; another one starts a new session with a new tracker."""
        self._presence = Presence.UNKNOWN
        self._restarts = 0
        self.is_settled = False
        self._broke_at = self._read_at = -inf
        """When the conversation broke last, and when the boot count was last read that no doubt followed."""
        self._heard_since: float | None = None
        """When a module first told something of itself after that."""
        self.breaks = self._seen_breaks = 0
        """How often another module may have taken the place of one that was heard; and while the port was last open."""
        self._new: list[Marker] = []

    def on_batch(self, batch: Batch) -> list[Marker]:
        """Markers of this batch, in the order of detection; times may differ slightly from that order."""
        self._new = []
        self._on_opening(batch.connection, batch.at)
        self._on_identity(batch)
        self._on_flags(batch)
        # While a port opens, the view is still that of the previous module.
        is_opening = batch.connection.state is PortState.OPENING
        if not is_opening:
            self._on_device(batch.device, batch.events, batch.at)
        self._on_loss(batch.connection, batch.at)
        find = partial(self._find_limit, batch)
        self.limits = NO_LIMITS if is_opening else _limits(find)
        self.flags = (
            TriggerFlags() if is_opening else TriggerFlags(_flag(find(TILT_TRIGGER)), _flag(find(FALL_TRIGGER)))
        )
        return self._new

    def _find_limit(self, batch: Batch, key: str) -> Value | None:
        """In doubt none from before the break: where the line is slow, it is not stale by that alone."""
        known = batch.device.known(key, batch.at)
        is_of_it = known is not None and (batch.identity.is_settled or known.at >= self._broke_at)
        return known.value if known is not None and is_of_it and not known.is_stale else None

    def _add(self, at: float, kind: MarkerKind) -> None:
        self._new.append(Marker(at, kind, self._port))

    def _on_flags(self, batch: Batch) -> None:
        """The first known state is not a change."""
        for sample in batch.samples:
            if sample.active is not self._active:
                if self._active is not None:
                    self._add(sample.at, MarkerKind.ACTIVATED if sample.active else MarkerKind.LOCKED)
                self._active = sample.active
            if sample.triggered is not self._triggered:
                if self._triggered is not None:
                    self._add(sample.at, MarkerKind.TRIGGERED if sample.triggered else MarkerKind.TRIGGER_ENDED)
                self._triggered = sample.triggered

    def _on_opening(self, connection: Connection, at: float) -> None:
        is_open, was_open = connection.state is PortState.OPEN, self._state is PortState.OPEN
        if not is_open or (was_open and connection.port == self._port):
            return
        self._state, self._port = connection.state, connection.port
        self._presence, self._restarts = Presence.UNKNOWN, 0
        if not self._was_lost:
            # Chosen by a person: another module with unknown state.
            self._triggered = self._active = self._is_charging = None
            self._add(at, MarkerKind.CONNECTED)

    def _on_identity(self, batch: Batch) -> None:
        """In doubt is what came since the break, also where only a reading after it has shown that; without a break
        what came since the last reading that did not."""
        for event in batch.events:
            if isinstance(event, Restarted):
                self._break(event.at, least_s=ONE_BREAK_S)
            elif isinstance(event, BREAKS):
                self._break(event.at - (event.lasted_s if isinstance(event, FellSilent) else 0.0))
            elif self._heard_since is None and isinstance(event, Received):
                self._heard_since = None if isinstance(event.message, Heartbeat) else event.at
        if batch.connection.state is not PortState.OPEN:
            return
        was_settled, self.is_settled = self.is_settled, batch.identity.is_settled
        has_broken, self._seen_breaks = self.breaks > self._seen_breaks, self.breaks
        boots = batch.device.values.get(BOOT_COUNT.key)
        if was_settled and not self.is_settled:
            is_break_recent = batch.at - self._broke_at <= READ_WITHIN_S
            since = self._broke_at if is_break_recent else max(self._broke_at, self._read_at)
            self._add(since if since > -inf else batch.at, MarkerKind.DOUBTED)
        elif not self.is_settled and has_broken:
            self._add(self._broke_at, MarkerKind.DOUBTED)
        elif self.is_settled and boots is not None:
            self._read_at = boots.at

    def _break(self, at: float, *, least_s: float = 0.0) -> None:
        """`least_s`: what was heard of a module for longer since the last break makes it another break."""
        self.breaks += self._heard_since is not None and at - self._heard_since > least_s
        self._broke_at, self._heard_since = at, None

    def _on_loss(self, connection: Connection, at: float) -> None:
        was_open, self._state = self._state is PortState.OPEN, connection.state
        if was_open and connection.state is PortState.CLOSED and connection.trouble is not None:
            self._was_lost = True
            self._break(at)
            self._add(at, MarkerKind.PORT_LOST)

    def _on_device(self, device: DeviceView, events: tuple[Event, ...], at: float) -> None:
        since = at if device.presence_since is None else device.presence_since
        if device.presence is not self._presence:
            was_offline, self._presence = self._presence is Presence.OFFLINE, device.presence
            if device.presence is Presence.OFFLINE:
                self._add(since, MarkerKind.OFFLINE)
            elif device.presence is Presence.ONLINE and (was_offline or self._was_lost):
                self._was_lost = False
                self._add(since, MarkerKind.RECONNECTED)
        if device.restarts != self._restarts:
            is_news, self._restarts = device.restarts > self._restarts, device.restarts
            if is_news:
                # Detected by a heartbeat, or only by the boot count.
                seen = [event.at for event in events if isinstance(event, Restarted)]
                if not seen:
                    self._break(at, least_s=ONE_BREAK_S)
                    self._seen_breaks += any(marker.kind is MarkerKind.DOUBTED for marker in self._new)
                for restarted_at in seen or [at]:
                    self._add(restarted_at, MarkerKind.RESTARTED)
        known = device.values.get("charging")
        if known is not None and not known.is_stale:
            is_charging = known.value is True
            if self._is_charging is not None and is_charging is not self._is_charging:
                self._add(known.at, MarkerKind.CHARGER_CONNECTED if is_charging else MarkerKind.CHARGER_REMOVED)
            self._is_charging = is_charging


def _flag(value: Value | None) -> bool | None:
    return value if isinstance(value, bool) else None


def acting_limits(limits: ModuleLimits, flags: TriggerFlags) -> ModuleLimits:
    """Those of `limits` that the module acts on: of triggers that are known to be on."""
    if flags.tilt is not True:
        limits = limits._replace(fires_deg=None, rearms_deg=None)
    if flags.fall is not True:
        limits = limits._replace(free_fall_g=None, free_fall_s=None)
    return limits


def last_limits(device: DeviceView) -> ModuleLimits:
    """The last reported limits, including stale ones."""
    last = {key: known.value for key, known in device.values.items()}
    return _limits(last.get)


def _limits(find: Callable[[str], Value | None]) -> ModuleLimits:
    def limit(key: str, switch: str) -> float | None:
        value = find(key)
        return None if value is None or find(switch) is False else float(value)

    fires, light = limit("attitude_threshold_deg", TILT_TRIGGER), find("light_threshold_v")
    return ModuleLimits(
        fires_deg=fires,
        rearms_deg=None if fires is None else fires - RESET_BELOW_THRESHOLD_DEG,
        free_fall_g=limit("freefall_acceleration_g", FALL_TRIGGER),
        free_fall_s=limit("freefall_time_s", FALL_TRIGGER),
        light_v=None if light is None else float(light),
    )
