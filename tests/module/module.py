"""The module itself: bytes and `now` in, bytes out. It has no clock and no thread; `line.py` gives it both."""

import heapq
import itertools
import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from tests.module.log import GOT, NOT_A_FRAME, SENT, Entry, Log
from tests.module.options import Options, Times
from tests.module.wire import FROM_MODULE, HEARTBEAT_BODY, RATES, Ear, Question, answer, with_sum

HEARTBEAT_GAP_S = 0.05
MOST_RECORDS = 9
HEARTBEAT, ACTIVATION, DEPLOY, SHUT_DOWN, OUTPUT, LIGHT, LIGHT_THRESHOLD = 0x01, 0x10, 0x11, 0x12, 0x13, 0x14, 0x15
ATTITUDE_OFF, FREEFALL_OFF, ATTITUDE, ACCELERATION, TIME, BOOTS = 0x16, 0x17, 0x20, 0x21, 0x22, 0x23
BAUD, ZERO, ACTIVE, TRIGGERED, STATUS, CHARGING, CELL, RECORDS = 0x24, 0x25, 0x30, 0x31, 0x32, 0x33, 0x34, 0x35
BY_SERIAL, BY_ATTITUDE, BY_PWM, BY_FALL = 0x01, 0x02, 0x04, 0x08


@dataclass
class Readings:
    """What its sensors say, as D4 of the answers."""

    tilt_deg: int = 2
    acceleration: int = 10
    bay_open: bool = False
    cell: int = 0xC8
    charging: int = 0
    boots: int = 1


class Module:
    """One DPS-S module, as delivered.

    `settings` holds D4 by code, {0x20: 60, 0x16: 0 …}, also of what cannot be read. All that happens to it happens in
    `hear` and `speak`; what a test does from outside is done by the next `speak`.
    """

    def __init__(
        self,
        options: Options | None = None,
        *,
        name: str = "",
        seed: int = 1,
        now: float = 0.0,
    ) -> None:
        self.options = options or Options()
        self.name = name
        self.log = Log()
        self.settings = {ACTIVATION: 0, OUTPUT: 0, ATTITUDE_OFF: 0, FREEFALL_OFF: 0, BAUD: 6}
        self.settings |= {LIGHT_THRESHOLD: 0x12, ATTITUDE: 60, ACCELERATION: 5, TIME: 160}
        self.readings = Readings()
        self.triggered = False
        self.records: list[bytes] = []
        """Oldest first, each from D2 to the last byte before the sum."""
        self.rate = RATES[self.settings[BAUD]]
        self.is_on = True
        self.at_frame: Callable[[Question], None] | None = None
        """Called with each frame before anything is done with it: the place for what happens in the middle."""
        self._random = random.Random(seed)
        self._ear = Ear()
        self._due: list[tuple[float, int, Callable[[float], bytes | None]]] = []
        self._order = itertools.count()
        self._out = b""
        self.began_at = self._switched_on_at = self._free_at = self._streamed_at = now
        self._silent_until = -math.inf
        self._next_record = 0
        self._falling_since = math.inf

    # What the line calls.

    def hear(self, data: bytes, now: float) -> None:
        """Take what the host sent; the answers come out of `speak`."""
        self._advance(now)
        if not self.is_on:
            return
        for question in self._ear.hear(self._worn(data)):
            self._take(question, now)
        if self._ear.dropped:
            self._note(NOT_A_FRAME, bytes(self._ear.dropped), now)
            self._ear.dropped.clear()

    def speak(self, now: float) -> bytes:
        """Return what leaves the module until `now`."""
        self._advance(now)
        out = self._out
        self._out = b""
        return out

    def _advance(self, now: float) -> None:
        self._repeat(now)
        self._fall(now)
        while self._due and self._due[0][0] <= now:
            _, _, act = heapq.heappop(self._due)
            self._out += act(now) or b""

    def next_at(self) -> float:
        """Return when `speak` has something of its own, infinity if only a question brings it."""
        at = min(self._due[0][0] if self._due else math.inf, self._falling_since + self.settings[TIME] / 100)
        if self._streams:
            at = min(at, self._streamed_at + 1 / self.options.stream_hz)
        return at

    # What a person does to it.

    def restart(self, now: float, *, off_s: float = 0.3, heartbeats: int = 2, boots: int = 1) -> None:
        """Switch it off and on again, as by a brown-out; `boots` is what its count grows by."""

        def off(at: float) -> None:
            self._switch_off(at)
            self._later(now + off_s, lambda on_at: self._switch_on(on_at, boots))
            for number in range(heartbeats):
                self._later(now + off_s + number * HEARTBEAT_GAP_S, self._beat)

        self._later(now, off)

    def be_silent(self, now: float, for_s: float) -> None:
        """Neither hear nor say anything for a while, as with the plug pulled."""
        self._silent_until = now + for_s

    def trigger(self, now: float, source: int) -> None:
        """Fire, and keep a record."""
        self.triggered = True
        self.records = [*self.records, self._record(now, source)][-MOST_RECORDS:]

    # Questions.

    def _take(self, question: Question, now: float) -> None:
        if self.at_frame is not None:
            self.at_frame(question)
        if now < self._silent_until:
            self._note(GOT, question.frame, now, "silent")
            return
        if question.is_set:
            self._take_set(question, now)
        else:
            self._take_query(question, now)

    def _take_set(self, question: Question, now: float) -> None:
        code = question.code
        value = question.value
        options = self.options
        if code not in (DEPLOY, SHUT_DOWN) and code not in self.settings:
            self._note(GOT, question.frame, now, "unknown")
            return
        if self._counts(options.lost_sets, code):
            self._note(GOT, question.frame, now, "lost")
            return
        is_ignored = self._counts(options.ignored_sets, code) or code in options.refused_sets
        is_unanswered = self._counts(options.lost_answers, code)
        self._note(GOT, question.frame, now, "ignored" if is_ignored else "unanswered" if is_unanswered else "")
        if code == ATTITUDE and value < options.lowest_attitude_deg:
            value = self.settings[ATTITUDE]
        at = self._answer_at(now)
        if not is_ignored:
            self._do(code, value, now, at)
        if is_unanswered or (code == BAUD and options.baud_answer == "none"):
            return
        said = 0x00 if code in options.refused_sets else 0x01 if code in options.acknowledged_by_one else value
        frame = answer(options.freefall_code if code == FREEFALL_OFF else code, bytes((0x01, said)))
        self._say(at, frame)
        for after_s in options.copies.get(code, ()):
            self._say(at + after_s, frame, "again")

    def _take_query(self, question: Question, now: float) -> None:
        code = question.code
        body = self._body(code)
        is_known = body is not None or code == RECORDS
        is_heard = is_known and not self._counts(self.options.lost_queries, code)
        self._note(GOT, question.frame, now, "" if is_heard else "lost" if is_known else "unknown")
        if not is_heard:
            return
        if code == ZERO:
            self.readings.tilt_deg = 0
        at = self._answer_at(now)
        frames = self._record_frames() if body is None else [self._short_or_status(code, body)]
        for number, frame in enumerate(frames):
            self._say(at + number * self.options.record_gap_s, frame)
            for after_s in self.options.query_copies.get(code, ()):
                self._say(at + after_s + number * self.options.record_gap_s, frame, "again")
        if code in self.options.second:
            after_s, text = self.options.second[code]
            self._say(at + after_s, self._short_or_status(code, bytes.fromhex(text)), "second")

    def _short_or_status(self, code: int, body: bytes) -> bytes:
        if code in self.options.instead:
            body = bytes.fromhex(self.options.instead[code])
        if code == STATUS:
            return with_sum(FROM_MODULE + bytes((STATUS,)) + body)
        frame = answer(self.options.voltage_code if code == CELL else code, body)
        if code == ATTITUDE and self.options.misprinted_sum:
            return frame[:-1] + b"\x50"
        return frame

    def _body(self, code: int) -> bytes | None:
        """Return what stands between code and sum in the answer to a query; None for what it does not know."""
        readings = self.readings
        active = self.settings[ACTIVATION]
        if code == HEARTBEAT:
            return HEARTBEAT_BODY
        if code == STATUS:
            return bytes((readings.tilt_deg, readings.acceleration, int(self.triggered), active))
        # E8: 13, 16, 17 and 24 can be set and not asked.
        values = {one: self.settings[one] for one in (LIGHT_THRESHOLD, ATTITUDE, ACCELERATION, TIME)}
        values |= {LIGHT: self._light, BOOTS: readings.boots, ZERO: 1, ACTIVE: active, TRIGGERED: int(self.triggered)}
        values |= {CHARGING: readings.charging, CELL: readings.cell}
        return bytes((0x01, values[code])) if code in values else None

    @property
    def _light(self) -> int:
        return self.options.light_open if self.readings.bay_open else self.options.light_closed

    def _record(self, now: float, source: int) -> bytes:
        uptime_s = min(0xFFFF, int(now - self._switched_on_at))
        return bytes((
            RECORDS, 0x01, self.readings.boots, uptime_s >> 8, uptime_s & 0xFF, source,
            self.settings[ATTITUDE], self.settings[ACCELERATION], self.settings[TIME],
            0, 1 - self.readings.charging, self._light, self.readings.cell,
        ))  # fmt: skip

    def _record_frames(self) -> list[bytes]:
        kept = self.records[::-1]
        if self.options.empty_slot is not None:
            empty = bytes((RECORDS, 0x01)) + bytes((self.options.empty_slot,)) * 11
            kept += [empty] * (MOST_RECORDS - len(kept))
        if not kept:
            return []
        lost = self.options.lost_records.get(len(self.log.got(RECORDS)), frozenset())
        first = self._next_record % len(kept)
        chosen = kept[first : first + self.options.records_at_once]
        self._next_record = (first + len(chosen)) % len(kept)
        return [with_sum(FROM_MODULE + body) for number, body in enumerate(chosen, 1) if number not in lost]

    # What it does.

    def _do(self, code: int, value: int, now: float, answered_at: float) -> None:
        if code == DEPLOY and value == 1 and self.settings[ACTIVATION] == 1:
            self.trigger(now, BY_SERIAL)
        if code == SHUT_DOWN:
            self._later(answered_at + 0.001, self._switch_off)
        if code not in self.settings:
            return
        before = self.settings[code]
        self.settings[code] = value
        if code == OUTPUT:
            self._streamed_at = now
        if code == BAUD and self.options.baud_at_once:
            # Queued before the answer: at the same time it comes first.
            leaves_s = 0.01 if self.options.baud_answer == "old" else 0.0
            self._later(answered_at + leaves_s, lambda _: setattr(self, "rate", RATES.get(value, self.rate)))
        if code in self.options.reverts:
            after_s, other = self.options.reverts[code]
            returns_to = before if other is None else other
            self._later(now + after_s, lambda _: self.settings.update({code: returns_to}))

    def _fall(self, now: float) -> None:
        """Fire by itself, if it is active, by the flags and thresholds that hold."""
        settings = self.settings
        may_fire = self.is_on and settings[ACTIVATION] == 1 and not self.triggered
        if may_fire and settings[ATTITUDE_OFF] == 0 and self.readings.tilt_deg >= settings[ATTITUDE]:
            self.trigger(now, BY_ATTITUDE)
        elif not may_fire or settings[FREEFALL_OFF] == 1 or self.readings.acceleration >= settings[ACCELERATION]:
            self._falling_since = math.inf
        else:
            self._falling_since = min(self._falling_since, now)
            if now - self._falling_since >= settings[TIME] / 100:
                self.trigger(now, BY_FALL)

    def _switch_off(self, now: float) -> None:
        self.is_on = False
        self._due.clear()
        self._ear.forget()
        self._free_at = now

    def _switch_on(self, now: float, boots: int) -> None:
        options = self.options
        self.is_on = True
        self.triggered = False
        self._switched_on_at = now
        self.readings.boots = (self.readings.boots + boots) % 256
        self.rate = RATES.get(self.settings[BAUD], self.rate)
        if not options.activation_survives:
            self.settings[ACTIVATION] = 0
        self.settings[OUTPUT] = 0
        if not options.flags_survive:
            self.settings |= {ATTITUDE_OFF: 0, FREEFALL_OFF: 0}

    # What it says, and when.

    @property
    def _streams(self) -> bool:
        return self.settings[OUTPUT] == 1 and self.is_on and self.options.stream_hz > 0

    def _repeat(self, now: float) -> None:
        """Queue the stream."""
        self._streamed_at = max(self._streamed_at, now - 1.0)
        while self._streams and self._streamed_at + 1 / self.options.stream_hz <= now:
            self._streamed_at += 1 / self.options.stream_hz
            self._say(self._streamed_at, self._short_or_status(STATUS, self._body(STATUS) or b""), "stream")

    def _beat(self, now: float) -> bytes:
        return self._leave(answer(HEARTBEAT, HEARTBEAT_BODY), now, "unasked")

    def _answer_at(self, now: float) -> float:
        """An answer waits for the one before it."""
        at = now + self.options.delay_s + self._random.uniform(0, self.options.jitter_s)
        self._free_at = max(at, self._free_at)
        return self._free_at

    def _say(self, at: float, frame: bytes, note: str = "") -> None:
        self._later(at, lambda now: self._leave(frame, now, note))

    def _leave(self, frame: bytes, now: float, note: str) -> bytes:
        if now < self._silent_until or not self.is_on:
            return b""
        worn = self._worn(frame)
        self._note(SENT, frame, now, note if worn == frame else f"{note} garbled".strip())
        return worn

    def _later(self, at: float, act: Callable[[float], bytes | None]) -> None:
        heapq.heappush(self._due, (at, next(self._order), act))

    def _worn(self, data: bytes) -> bytes:
        """Return `data` as a bad line leaves it."""
        return bytes(byte for byte in data if self._random.random() >= self.options.lose)

    def _counts(self, times: Times, code: int) -> bool:
        """Use up one of the times that a fault is left for."""
        left = times.get(code, 0)
        if left > 0:
            times[code] = left - 1
        return left != 0

    def _note(self, kind: str, frame: bytes, now: float, note: str = "") -> None:
        self.log.add(Entry(now - self.began_at, kind, frame, note, self.name))
