"""An independent specification of the link, written without `protocol/`.

The `Referee` is told every event in order: requests, bytes written and read, frames of an honest line with their cause,
ticks of the clock, and what the link reported. It collects violations of these rules:

- Sent: only the request itself, heartbeats, and harmless queries before it. A set or an act at most once; a query again
  only after its timeout; nothing else while a request is pending. LOCK is sent at once, and so is a query while nothing
  has been lost. A set or an act is never sent directly after a reply or another request.
- Accepted as a reply: only a frame that a module can send as the reply, that began after the request was sent and
  arrived before the timeout; with the value of that frame; never an echo.
- On an honest line (whole frames, in the order of the requests): a request is answered if and only if such a frame
  arrived, by the first such frame, which was caused by this request or by an earlier one of the same query. Otherwise
  it ends unanswered, in time.
- Each request has one end: answered, unanswered, or unknown for a set or an act that may have been carried out.
"""

import math
from dataclasses import dataclass, field
from enum import Enum

from tests.support.line import reference_decoder

HEARTBEAT = b"\x42\x61\x01\xa5\x5a\x00"
FENCES = (HEARTBEAT, *(b"\x42\x61" + bytes((code, 1, 0, code + 1)) for code in (0x23, 0x33, 0x30, 0x31)))
"""Queries that may be sent before a request, so that its reply cannot be confused with an earlier one."""
LOCK = b"\x42\x61\x10\x02\x00\x12"
STATUS, VOLTAGE, RECORDS, ZERO, FREEFALL_FLAG = 0x32, 0x34, 0x35, 0x25, 0x17
ACTIVATION = 0x10
SET = 2
SHORT_VALUES = {
    0x14: reference_decoder.ANY, 0x15: reference_decoder.ANY,
    0x20: reference_decoder.ANY, 0x21: reference_decoder.ANY, 0x22: reference_decoder.ANY, 0x23: reference_decoder.ANY,
    0x25: {1}, 0x30: reference_decoder.ANY, 0x31: reference_decoder.ANY, 0x33: reference_decoder.YES_OR_NO,
    0x34: reference_decoder.ANY,
}  # fmt: skip
HELD_S = 0.2
"""The longest time for which a request is held back until the line is quiet."""
QUIET_S = 0.01
"""The shortest quiet time before a set or an act."""
LONGEST_FENCE_S = 3.0 + 4 * HELD_S
"""Three queries of 1 s, each held back; then the request behind them is given up unsent."""
DRAIN_S = 0.03
LONGEST_RECORDS_S = 11.5
"""The longest query for records: the vendor's 1 s, and 10 s of collecting."""


class End(Enum):
    ANSWERED = "answered"
    UNANSWERED = "unanswered"
    UNKNOWN = "outcome unknown"


def is_question(request: bytes) -> bool:
    """Return whether a request may be repeated."""
    return request[3] != SET and request[2] != ZERO


def answers(frame: bytes, request: bytes) -> bool:
    """Return whether a module can send `frame` in reply to `request`."""
    code, asked = frame[2], request[2]
    if request == HEARTBEAT:
        return reference_decoder.is_heartbeat(frame)
    if asked == STATUS:
        return reference_decoder.is_status(frame)
    if asked == RECORDS:
        return reference_decoder.is_record(frame)
    if asked == VOLTAGE:
        return reference_decoder.is_voltage_as_35(frame) or (code == VOLTAGE and reference_decoder.is_reply(frame))
    if not reference_decoder.is_reply(frame):
        return False
    if request[3] == SET:
        return code == asked or (asked == FREEFALL_FLAG and code == 0x16)
    return code == asked and frame[4] in SHORT_VALUES[asked]


def says(frame: bytes) -> tuple[int, ...]:
    """Return the bytes of a frame that carry values."""
    if reference_decoder.is_heartbeat(frame):
        return ()
    return tuple(frame[3:7]) if len(frame) == 8 else tuple(frame[4:-1])


@dataclass(frozen=True, slots=True)
class Told:
    """The link's report on a request; `values` holds the value bytes of each message."""

    request: bytes
    end: End
    values: tuple[tuple[int, ...], ...] = ()
    attempts: int = 0
    round_trip_s: float | None = None


@dataclass(slots=True)
class Asked:
    """The pending request; `number` distinguishes it from earlier ones that are equal."""

    number: int
    request: bytes
    at_s: float
    waits_s: tuple[float, ...]
    written_at_s: list[float] = field(default_factory=list)
    heard_before: int = 0
    """Count of bytes that had arrived when it was first sent."""
    is_fenced: bool = False
    """Another query was sent before it."""
    due: list[bytes] = field(default_factory=list)
    """Replies from an honest line, which must be accepted."""

    @property
    def is_written(self) -> bool:
        return bool(self.written_at_s)

    @property
    def ends_s(self) -> float:
        return self.written_at_s[-1] + self.waits_s[len(self.written_at_s) - 1]


@dataclass(frozen=True, slots=True)
class Cause:
    """The request that caused a frame, and its number; None for a streamed frame or a restart."""

    request: bytes | None = None
    number: int | None = None


class Referee:
    """See the module's docstring. With `is_certain` every frame is reported by `came`, so the outcome is certain."""

    def __init__(self, *, is_certain: bool) -> None:
        self.faults: list[str] = []
        self.asked: Asked | None = None
        self.ends: dict[End, int] = dict.fromkeys(End, 0)
        self._is_certain = is_certain
        self._heard = bytearray()
        self._number = 0
        self._codes_asked: set[int] = set()
        self._spoken_s = -math.inf
        """Time of the last request or of the last frame that was not streamed."""
        self._has_lost = False

    # Events

    def ask(self, request: bytes, now_s: float, waits_s: tuple[float, ...]) -> None:
        """A request is made; `waits_s` holds the timeout of each attempt."""
        self._number += 1
        count = len(waits_s) if is_question(request) and request[2] != RECORDS else 1
        self.asked = Asked(self._number, request, now_s, waits_s[:count])

    def wrote(self, raw: bytes, now_s: float) -> None:
        """These bytes were sent together."""
        for at in range(0, len(raw), 6):
            request = raw[at : at + 6]
            if not reference_decoder.is_request(request):
                self._fault(f"no request on the wire: {request.hex(' ')}")
            elif self.asked is not None and request == self.asked.request:
                self._wrote_asked(self.asked, now_s)
            elif self.asked is None and request != HEARTBEAT:
                self._fault(f"on the wire, not asked: {request.hex(' ')}")
            elif request not in FENCES:
                self._fault(f"on the wire, asked is another: {request.hex(' ')}")
            elif self.asked is not None:
                self._wrote_fence(self.asked)
        self._spoken_s = now_s

    def _wrote_asked(self, asked: Asked, now_s: float) -> None:
        if not asked.is_written:
            asked.heard_before = len(self._heard)
        elif len(asked.written_at_s) >= len(asked.waits_s):
            self._fault("once too often on the wire")
        elif now_s < asked.ends_s + DRAIN_S - 1e-9:
            self._fault("asked again before its time had run out")
        elif asked.due:
            self._fault("asked again though it was answered")
        is_held_long_enough = now_s >= asked.at_s + HELD_S - 1e-9
        is_once = not is_question(asked.request) and asked.request != LOCK
        if is_once and now_s < self._spoken_s + QUIET_S and not is_held_long_enough:
            self._fault("sent directly after a reply or another request")
        self._has_lost = self._has_lost or asked.is_written
        asked.written_at_s.append(now_s)
        self._codes_asked.add(_family(asked.request))

    def _wrote_fence(self, asked: Asked) -> None:
        self._has_lost = self._has_lost or asked.is_fenced
        asked.is_fenced = True
        if asked.is_written:
            self._fault("another question while one waits")
        if asked.request == LOCK:
            self._fault("LOCK waits behind a question")
        if _family(asked.request) not in self._codes_asked:
            self._fault("waits behind a question, though no earlier reply could be mistaken for its own")

    def heard(self, raw: bytes) -> None:
        self._heard += raw

    def came(self, frame: bytes, cause: Cause, *, began_at: int, now_s: float) -> None:
        """On an honest line, a frame is complete that began with byte number `began_at`."""
        asked = self.asked
        if not reference_decoder.is_status(frame):
            self._spoken_s = now_s
        if asked is None or not asked.is_written or began_at < asked.heard_before or not answers(frame, asked.request):
            return
        if asked.due and asked.request[2] != RECORDS:
            return
        asked.due.append(frame)
        if not _may_be_believed(asked, frame, cause):
            self._fault(f"{frame.hex(' ')} was caused by something else and could not be told from an answer")

    def abandon(self) -> None:
        """The caller cancelled the request; the link's report follows."""
        asked = self.asked
        if asked is not None and (is_question(asked.request) or not asked.is_written):
            self.asked = None

    def settled(self, told: list[Told], now_s: float) -> None:
        """Check the link's reports on everything up to now."""
        for one in told:
            self._judge(one, now_s)
        asked = self.asked
        if asked is None:
            return
        if asked.request == LOCK and not asked.is_written:
            self._fault("LOCK did not go out at once")
        elif is_question(asked.request) and not (asked.is_written or asked.is_fenced or self._has_lost):
            self._fault("a question is held back though nothing was lost")
        if self._is_certain and asked.due and asked.request[2] != RECORDS:
            self._fault(f"the answer {asked.due[0].hex(' ')} was not believed")

    def looked(self, now_s: float, *, late_s: float) -> None:
        """The link was ticked, at most `late_s` after its deadline, and its reports were passed to `settled`."""
        asked = self.asked
        if asked is None:
            return
        if not asked.is_written:
            longest_s = LONGEST_FENCE_S + 4 * late_s if asked.is_fenced else HELD_S + late_s
            if now_s > asked.at_s + longest_s + 1e-6:
                self._fault("still held back")
        elif asked.request[2] == RECORDS and (asked.due or not self._is_certain):
            if now_s > asked.written_at_s[0] + LONGEST_RECORDS_S + 2 * late_s:
                self._fault("still collects records")
        else:
            is_last = len(asked.written_at_s) == len(asked.waits_s)
            if now_s >= asked.ends_s + (0.0 if is_last else DRAIN_S + HELD_S + 2 * late_s + 1e-6):
                self._fault("its time has run out and nothing was said")

    # Reports of the link

    def _judge(self, told: Told, now_s: float) -> None:
        asked, self.asked = self.asked, None
        self.ends[told.end] += 1
        self._has_lost = self._has_lost or told.end is not End.ANSWERED
        if asked is None or told.request != asked.request:
            self._fault(f"told of {told.request.hex(' ')}, which nobody waits for")
            return
        if told.attempts != len(asked.written_at_s) and told.end is not End.UNKNOWN:
            self._fault(f"{told.attempts} attempts are told of {len(asked.written_at_s)}")
        if told.end is End.ANSWERED:
            self._judge_answer(asked, told, now_s)
        elif asked.due and self._is_certain:
            self._fault(f"{told.end.value}, though {asked.due[0].hex(' ')} came in time")
        elif (told.end is End.UNKNOWN) != (asked.is_written and not is_question(asked.request)):
            self._fault(f"{told.end.value} is the wrong end")

    def _judge_answer(self, asked: Asked, told: Told, now_s: float) -> None:
        if not asked.is_written:
            self._fault("answered before it went out")
            return
        if asked.request[2] != RECORDS and len(told.values) != 1:
            self._fault("one answer has one value")
        if self._is_certain:
            if told.values != tuple(says(frame) for frame in asked.due):
                self._fault(f"believed {told.values}, not the answers that came")
        else:
            since = bytes(self._heard[asked.heard_before :])
            if not all(_is_carried(values, asked.request, since) for values in told.values):
                self._fault(f"believed {told.values}, which no frame since the request carries")
        is_single = len(asked.written_at_s) == 1 and asked.request[2] != RECORDS
        trip_s = now_s - asked.written_at_s[0] if is_single else None
        is_untimed = told.round_trip_s is None and asked.request[2] == STATUS  # it may have been streamed
        if told.round_trip_s != trip_s and not is_untimed:
            self._fault(f"round trip {told.round_trip_s}, it was {trip_s}")

    def _fault(self, text: str) -> None:
        self.faults.append(text if self.asked is None else f"{self.asked.request.hex(' ')}: {text}")


def _family(request: bytes) -> int:
    """Return the code that stands for all requests whose replies can have the same code."""
    return {FREEFALL_FLAG: 0x16, VOLTAGE: RECORDS}.get(request[2], request[2])


def _may_be_believed(asked: Asked, frame: bytes, cause: Cause) -> bool:
    """Return whether the frame was caused by this request or the same query, or its cause does not matter."""
    if cause.number == asked.number or (asked.request[2] == STATUS and cause.request is None):
        return True
    if asked.request == HEARTBEAT:
        return True  # all heartbeats are equal
    if asked.request == LOCK and frame[2] == ACTIVATION:
        return True  # LOCK does not wait; the state is read afterwards
    return is_question(asked.request) and asked.request[2] != RECORDS and cause.request == asked.request


def _is_carried(values: tuple[int, ...], request: bytes, since: bytes) -> bool:
    for at in range(len(since)):
        for length in (6, 8, 16):
            frame = since[at : at + length]
            if len(frame) == length and frame[:2] == b"\x41\x75" and answers(frame, request) and says(frame) == values:
                return True
    return False
