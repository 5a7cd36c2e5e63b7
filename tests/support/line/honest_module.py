"""A module whose line delivers whole frames in the order of the requests.

It may be slow or silent, answer twice, stream and restart; noise and echoes may lie between its frames. It reports
every frame and its cause to the referee. Neither uses `protocol/`.
"""

import heapq
import random
from dataclasses import dataclass, field
from typing import NamedTuple

from tests.support.line import reference_link
from tests.support.line.reference_link import Cause, Referee

HEARTBEAT_FRAME = b"\x41\x75\x01\xa5\x5a\x00"
DOUBLED_GAPS_S = (0.0, 0.001, 0.015)
"""Delays of a duplicate reply."""
REPEATED_GAPS_S = (0.001, 0.05, 0.2)
"""Gaps within a frame that arrives in two parts; a longer one would end the frame."""
QUIET_NOISE = bytes(one for one in range(256) if one not in b"AB")


@dataclass(frozen=True, slots=True, kw_only=True)
class Habits:
    """Behaviour of a module and its line; probabilities are 0 … 1."""

    delays_s: tuple[float, ...] = (0.003,)
    dropped: float = 0.0
    doubled: float = 0.0
    cut: float = 0.0
    noise: float = 0.0
    echo: bool = False
    streams_every_s: float | None = None
    voltage_as_35: bool = False
    freefall_as_16: bool = False
    acknowledges_by_one: bool = False
    gap_s: float = 0.0
    """A request that follows a reply or another request sooner than this is ignored."""


class _Coming(NamedTuple):
    at_s: float
    order: int
    raw: bytes
    cause: Cause | None
    """None for noise and echoes."""


@dataclass(slots=True)
class _Cut:
    """A frame whose first part has been read."""

    at_s: float
    rest: bytes
    whole: bytes
    cause: Cause | None
    began_at: int


@dataclass(slots=True)
class HonestModule:
    """Takes what the host writes and returns what it can read, at the times that the caller passes."""

    source: random.Random
    habits: Habits
    _coming: list[_Coming] = field(default_factory=list)
    _cut: _Cut | None = None
    _order: int = 0
    _emitted: int = 0
    _last_s: float = 0.0
    _value: int = 0
    _deaf_until_s: float = 0.0
    _ready_s: float = 0.0

    def write(self, raw: bytes, number: int | None, now_s: float) -> None:
        """Receive requests; `number` identifies the one that the link waits for, None its own heartbeats."""
        for at in range(0, len(raw), 6):
            request = raw[at : at + 6]
            if self.habits.echo:
                self._put(now_s, request, None)
            is_too_soon = now_s < self._ready_s
            self._ready_s = max(self._ready_s, now_s + self.habits.gap_s)
            if is_too_soon or now_s < self._deaf_until_s or self.source.random() < self.habits.dropped:
                continue
            self._last_s = max(self._last_s, now_s + self.source.choice(self.habits.delays_s))
            cause = Cause(request, number)
            for frame in self.answers(request):
                self._put(self._last_s, frame, cause)
                if self.source.random() < self.habits.doubled:
                    self._last_s += self.source.choice(DOUBLED_GAPS_S)
                    self._put(self._last_s, frame, cause)
            self._ready_s = max(self._ready_s, self._last_s + self.habits.gap_s)

    def stream(self, first_s: float, until_s: float) -> None:
        """Send status frames from `first_s` to `until_s` if it streams."""
        every_s = self.habits.streams_every_s
        while every_s is not None and first_s < until_s:
            self._put(first_s, self._status(), Cause())
            first_s += every_s

    def restart(self, now_s: float) -> None:
        """Drop the pending replies, except a frame that has begun, and send two heartbeats."""
        if self._cut is not None:
            self._cut.at_s = now_s
        self._coming = [one for one in self._coming if one.cause is not None and one.cause.request is None]
        heapq.heapify(self._coming)
        self._last_s = self._deaf_until_s = now_s + 0.05
        self._put(now_s, HEARTBEAT_FRAME, Cause())
        self._put(now_s + 0.05, HEARTBEAT_FRAME, Cause())

    def next_due_s(self) -> float:
        """Return the time of the next byte, or infinity."""
        if self._cut is not None:
            return self._cut.at_s
        return self._coming[0].at_s if self._coming else float("inf")

    def read(self, now_s: float, referee: Referee) -> bytes:
        """Return the bytes up to now; report each whole frame to the referee."""
        read = bytearray()
        while self.next_due_s() <= now_s:
            if self._cut is None:
                read += self._begin(heapq.heappop(self._coming), referee, now_s)
            else:
                cut, self._cut = self._cut, None
                read += cut.rest
                self._emitted += len(cut.rest)
                self._tell(cut, referee, now_s)
        referee.heard(bytes(read))
        return bytes(read)

    def _begin(self, coming: _Coming, referee: Referee, now_s: float) -> bytes:
        noise = b""
        if self.source.random() < self.habits.noise:
            noise = bytes(self.source.choices(QUIET_NOISE, k=self.source.randint(1, 20)))
        frame = coming.raw
        length = self.source.randint(1, len(frame) - 1) if self.source.random() < self.habits.cut else len(frame)
        began_at = self._emitted + len(noise)
        self._emitted = began_at + length
        gap_s = self.source.choice(REPEATED_GAPS_S)
        cut = _Cut(coming.at_s + gap_s, frame[length:], frame, coming.cause, began_at)
        if cut.rest:
            self._cut = cut
        else:
            self._tell(cut, referee, now_s)
        return noise + frame[:length]

    @staticmethod
    def _tell(cut: _Cut, referee: Referee, now_s: float) -> None:
        if cut.cause is not None:
            referee.came(cut.whole, cut.cause, began_at=cut.began_at, now_s=now_s)

    def _put(self, at_s: float, raw: bytes, cause: Cause | None) -> None:
        self._order += 1
        heapq.heappush(self._coming, _Coming(at_s, self._order, raw, cause))

    # Replies

    def answers(self, request: bytes) -> list[bytes]:
        """Return the replies to a request."""
        code, control, data = request[2:5]
        if request == reference_link.HEARTBEAT:
            return [HEARTBEAT_FRAME]
        if code == reference_link.STATUS:
            return [self._status()]
        if code == reference_link.RECORDS:
            return [self._record() for _ in range(self.source.choice((0, 1, 2, 9)))]
        if control == reference_link.SET or code == reference_link.ZERO:
            by_one = code == reference_link.ZERO or (code in (0x21, 0x22, 0x24) and self.habits.acknowledges_by_one)
            code = 0x16 if code == 0x17 and self.habits.freefall_as_16 else code
            return [_short(code, 1 if by_one else data)]
        self._value = (self._value + 1) % 256
        value = self._value % 2 if code == 0x33 else self._value
        return [_short(0x35 if code == reference_link.VOLTAGE and self.habits.voltage_as_35 else code, value)]

    def _status(self) -> bytes:
        self._value = (self._value + 1) % 256
        return _summed(bytes((0x41, 0x75, 0x32, self._value, self.source.choice((10, 0x41, 0x75)), 0, 1)))

    def _record(self) -> bytes:
        """Return a trigger record; every second one begins like a reply with a voltage."""
        self._value = boot_count = (self._value + 1) % 256
        high = (0x36 + boot_count) % 256 if boot_count % 2 else 0
        body = (boot_count, high, self.source.randrange(256), 2, 60, 5, 160, 0, 1, 12, 200)
        return _summed(b"\x41\x75\x35\x01" + bytes(body))


def _summed(head: bytes) -> bytes:
    return head + bytes((sum(head[2:]) % 256,))


def _short(code: int, value: int) -> bytes:
    return _summed(bytes((0x41, 0x75, code, 1, value)))
