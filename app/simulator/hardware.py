"""The simulated module without its command interpreter: power, sensor, triggers and output."""

import heapq
import itertools
import math
from dataclasses import replace
from typing import Any, NamedTuple

from app.flights.judge import NOTHING, Judge, SensorSample
from app.simulator.memory import Memory, ModuleState, limits, record_data
from app.simulator.physics import SENSOR_PERIOD_S, Physics
from app.simulator.setup import Setup
from protocol.catalogue import CELL_VOLT, HEARTBEAT_REPLY, STATUS_CODE, TENTH_G, TENTH_VOLT, Layout
from protocol.frame import encode_long
from protocol.messages import Source

BOOT_GAP_S = 0.05  # "间隔50ms"
MAX_WATCH_S = 10.0
STREAM_BACKLOG_S = 5.0
"""Older frames of a stream that was not collected are lost, as in a full driver buffer."""
HOST_SILENT_S = 30.0
"""The host sends a heartbeat every 10 to 30 s; after this time records say that serial is not connected."""
BITS_PER_BYTE = 10


class SentBytes(NamedTuple):
    """Bytes that leave the module as one burst."""

    at_s: float
    """Time of its first bit, at the earliest while it is queued; in the future while the line is busy."""
    order: int
    """Of those at the same time."""
    data: bytes
    baud_rate: int
    is_streamed: bool = False


def to_byte(value: float) -> int:
    """The nearest byte."""
    return min(255, max(0, round(value)))


class Hardware:
    """Initially switched off. `world` may be changed between two calls."""

    def __init__(self, world: Physics, setup: Setup | None = None, *, memory: Memory | None = None) -> None:
        self.world: Physics = world
        self.setup: Setup = setup or Setup()
        self.memory: Memory = memory or Memory()
        self.state: ModuleState = ModuleState()
        self.baud_rate = self.memory.baud_rate
        """Present rate of its line; the one in `memory` is used after a restart (E9)."""
        self.is_on = False
        self.stream_frames_sent = 0
        self._judge = Judge()
        self._fired = NOTHING
        self._due: list[SentBytes] = []
        self._order = itertools.count()
        self.pwm_at_s = math.inf
        self._line_free_s = -math.inf
        self._stream_due_s = self._stream_base_s = math.inf
        self._stream_step = 0
        self._booted_s = 0.0
        self.heard_s = -math.inf
        self._sampled_s = -math.inf

    # State

    @property
    def is_triggered(self) -> bool:
        return bool(self._fired)

    def change(self, **values: Any) -> None:
        """Set options; a stream goes on at their rate."""
        self.setup = replace(self.setup, **values)
        self._base_stream(self._stream_due_s)

    @property
    def is_streaming(self) -> bool:
        return self._stream_due_s != math.inf

    def tilt_deg(self, now_s: float) -> float:
        """Angle to the position of the last zeroing."""
        return abs(self.world.motion(now_s).tilt_deg - self.memory.zero_tilt_deg)

    def light(self, now_s: float) -> int:
        return to_byte(self.world.light_v(now_s) * TENTH_VOLT.per_unit)

    def voltage(self, now_s: float) -> int:
        return to_byte(self.world.voltage_v(now_s) * CELL_VOLT.per_unit)

    def status(self, now_s: float) -> bytes:
        """The eight bytes of frame 32."""
        motion = self.world.motion(now_s)
        tilt = to_byte(abs(motion.tilt_deg - self.memory.zero_tilt_deg))
        acceleration = to_byte(motion.acceleration_g * TENTH_G.per_unit)
        is_active = self.reports_active(now_s)
        return encode_long(STATUS_CODE, bytes((tilt, acceleration, bool(self._fired), is_active)))

    def reports_active(self, _now_s: float) -> bool:
        return self.state.is_active

    # Power

    def power_on(self, now_s: float) -> None:
        """Boot: count it (0 follows 255), send two heartbeats, enable triggers, lock."""
        self.memory.boot_count = (self.memory.boot_count + 1) & 0xFF
        self.state = ModuleState()
        self.is_on = True
        self.baud_rate = self.memory.baud_rate
        self._clear()
        self._booted_s = now_s
        self._sampled_s = now_s
        self.send(HEARTBEAT_REPLY, now_s)
        self.send(HEARTBEAT_REPLY, now_s + BOOT_GAP_S)

    def power_off(self) -> None:
        """Switch off at once; bytes that were queued are lost."""
        self.is_on = False
        self._clear()

    def shut_down(self, now_s: float) -> None:
        """Switch off after sending what is due by now."""
        due = [burst for burst in self._due if burst.at_s <= now_s]
        self.power_off()
        self._due = sorted(due)

    def restart(self, now_s: float) -> None:
        """Switch off and on."""
        self.power_off()
        self.power_on(now_s)

    def press_switch(self, now_s: float) -> None:
        """Hold its switch for 2 s, which switches it on."""
        if not self.is_on:
            self.power_on(now_s)

    def set_charger(self, now_s: float, *, is_plugged_in: bool) -> None:
        """External power also wakes it after a shutdown ("通过外接供电通电自醒开机")."""
        self.advance(now_s)
        was_powered, self.world.has_external_power = self.world.has_external_power, is_plugged_in
        if is_plugged_in and not was_powered:
            self.press_switch(now_s)

    def _clear(self) -> None:
        self._fired = NOTHING
        self._judge.reset()
        self._due.clear()
        self._line_free_s = -math.inf
        self.heard_s = -math.inf
        self._stream_due_s = math.inf

    # Triggers

    def activate(self, *, is_active: bool) -> None:
        """Activate or lock; both end the block of triggers, and locking ends "triggered"."""
        self.state.is_active = is_active
        self.state.is_forbidden = False
        if not is_active:
            self.end_trigger()

    def end_trigger(self) -> None:
        self._fired = NOTHING
        self._judge.reset()

    def fire(self, sources: Source, now_s: float) -> bool:
        """Fire and write a record; False if it is locked or blocked."""
        if not (self.is_on and self.state.is_active) or self.state.is_forbidden:
            return False
        self._fired |= sources
        data = record_data(
            self.memory,
            uptime_s=now_s - self._booted_s,
            sources=sources,
            is_connected=now_s - self.heard_s <= HOST_SILENT_S,
            is_charging=self.world.has_external_power,
            light=self.light(now_s),
            voltage=self.voltage(now_s),
        )
        self.memory.records.append(data)
        self.world.open_parachute(now_s)
        return True

    def event_s(self) -> float:
        """Time of its next spontaneous event; infinity for none."""
        return max(self._sampled_s, self.pwm_at_s) if self.is_on else math.inf

    def do_event(self, at_s: float) -> None:
        """The event of `event_s`."""
        self.pwm_at_s = math.inf
        self.fire(Source.PWM, at_s)

    def advance(self, now_s: float) -> None:
        """Advance the time of its sensor and its triggers; sends nothing."""
        while (event_s := self.event_s()) <= now_s:
            self.do_event(event_s)
        self._watch(now_s)

    def _watch(self, now_s: float) -> None:
        """Advance to a time before which there is no event."""
        if not (self.is_on and self.state.is_active):
            self._sampled_s = now_s
        else:
            watch_until_s = min(now_s, self._sampled_s + MAX_WATCH_S)
            while self._sampled_s + SENSOR_PERIOD_S <= watch_until_s:
                self._sampled_s += SENSOR_PERIOD_S
                self._sense(self._sampled_s)
                if self.world.is_at_rest and not self._judge.is_falling:  # all that follow are judged like this one
                    self._sampled_s += (watch_until_s - self._sampled_s) // SENSOR_PERIOD_S * SENSOR_PERIOD_S
            if watch_until_s < now_s:
                self._sampled_s = now_s
                self._sense(now_s)
        self.world.advance(now_s)

    def _sense(self, at_s: float) -> None:
        motion = self.world.motion(at_s)
        sample = SensorSample(at_s, abs(motion.tilt_deg - self.memory.zero_tilt_deg), motion.acceleration_g)
        is_armed = self.state.is_active and not self.state.is_forbidden
        verdict = self._judge.judge(sample, limits(self.memory, self.state), is_active=is_armed)
        if self._fired is not NOTHING and Source.ATTITUDE in self._fired and Source.ATTITUDE not in verdict.standing:
            self._fired &= ~Source.ATTITUDE
        if verdict.fired is not NOTHING:
            self.fire(verdict.fired, at_s)

    # Output

    def collect(self, now_s: float) -> list[SentBytes]:
        """What it has sent by now."""
        sent: list[SentBytes] = []
        if self._stream_due_s < now_s - STREAM_BACKLOG_S:
            self._base_stream(now_s - STREAM_BACKLOG_S)
        while True:
            queued_s = self._due[0].at_s if self._due else math.inf
            at_s = min(queued_s, self._stream_due_s)
            if (event_s := self.event_s()) <= now_s and event_s <= at_s:
                self.advance(event_s)
                continue
            if at_s > now_s:
                break
            if queued_s <= self._stream_due_s:
                sent.append(self._transmit(heapq.heappop(self._due)))
            else:
                self._stream_one(at_s)
        self._watch(now_s)
        return sent

    def next_due(self, now_s: float) -> float | None:
        """When it has something to send next, or None."""
        due_s = min(self._due[0].at_s if self._due else math.inf, self._stream_due_s, self.event_s())
        return None if due_s == math.inf else max(now_s, due_s)

    def send(self, data: bytes, at_s: float) -> None:
        """Queue a burst at the present baud rate."""
        self.queue(SentBytes(at_s, 0, data, self.baud_rate))

    def queue(self, due: SentBytes) -> None:
        heapq.heappush(self._due, SentBytes(due.at_s, next(self._order), due.data, due.baud_rate, due.is_streamed))

    def start_stream(self, now_s: float) -> None:
        if not self.is_streaming:
            self._base_stream(now_s + 1 / self.setup.rate)

    def stop_stream(self) -> None:
        self._stream_due_s = math.inf

    def _base_stream(self, first_s: float) -> None:
        """Start the stream at this time. Later times are multiples of the period, so that they do not drift."""
        self._stream_due_s = self._stream_base_s = first_s
        self._stream_step = 0

    def _stream_one(self, at_s: float) -> None:
        self._stream_step += 1
        self._stream_due_s = self._stream_base_s + self._stream_step / self.setup.rate
        self._watch(at_s)
        frame_s = Layout.STATUS.value * BITS_PER_BYTE / self.baud_rate
        # A frame is skipped if the line is a whole frame behind, so that the queue stays bounded.
        if self._line_free_s - at_s <= frame_s:
            self.queue(SentBytes(at_s, 0, self.status(at_s), self.baud_rate, is_streamed=True))
            self.stream_frames_sent += 1

    def _transmit(self, due: SentBytes) -> SentBytes:
        begins_s = max(due.at_s, self._line_free_s)
        self._line_free_s = begins_s + len(due.data) * BITS_PER_BYTE / due.baud_rate
        return SentBytes(begins_s, due.order, due.data, due.baud_rate, due.is_streamed)
