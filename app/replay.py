"""A capture played as if the module were there: a port, `capture://FILE?speed=1`, through the whole program.

What the module sent without being asked (the stream, restarts, noise) comes at its time. What it answered comes when
the same is asked: the answer that it had given last at that point of the capture, after the time that it took. What was
never answered, or never asked, is not answered now: nothing is invented. The one exception is the heartbeat, which is
answered while the capture shows any sign of the module. After the end of the capture the line is silent.
"""

import threading
import time
from array import array
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import parse_qsl, quote, unquote, urlsplit

from app.capture import Capture, Entries, Entry, Way
from app.pace import Pace
from app.recording import SCHEME
from protocol.catalogue import HEARTBEAT, HOST_HEADER, MODULE_HEADER, Layout, Request
from protocol.frame import HOST_FRAME_LENGTH, Direction, Frame, check_host, decode_request
from protocol.messages import answers

if TYPE_CHECKING:
    from app.capture_rows import Explained

SLOWEST, QUICKEST = 0.05, 100.0
ALIVE_FOR_S = 12.0
"""How long a frame of the module proves that it was there: one heartbeat period and some."""
LONGEST_ANSWER_S = 3.0
"""A frame later than this after the question no longer counts as its answer; records get ten seconds more."""
LONGEST_RECORDS_S = 13.0
_HEARTBEAT_REPLY = MODULE_HEADER + HEARTBEAT.query().encode()[2:]
_KEPT_REQUEST_BYTES = 64


class Answer(NamedTuple):
    """How the module answered once. `data` is empty where it did not."""

    asked_at_s: float
    after_s: float
    data: bytes


@dataclass(slots=True)
class Script:
    """A capture, sorted into what comes by itself and what answers what."""

    unasked: Entries = field(default_factory=Entries)
    answers: dict[Request, list[Answer]] = field(default_factory=dict)
    alive_at_s: "array[float]" = field(default_factory=lambda: array("d"))
    duration_s: float = 0.0


@dataclass(slots=True)
class _Question:
    request: Request
    at_s: float
    data: bytes = b""
    answered_at_s: float = 0.0

    @property
    def takes_several(self) -> bool:
        return self.request.command.layout is Layout.RECORD


def script_of(capture: Capture) -> Script:
    """See the class."""
    from app.capture_rows import explained  # numpy comes with it, and the window starts without

    script = Script(duration_s=capture.duration_s)
    question: _Question | None = None
    pace = Pace()
    for one in explained(capture.entries):
        pace.keep()
        if one.way is Way.OUT:
            if isinstance(one.piece, Frame):
                _end(script, question)
                question = _Question(decode_request(one.piece.raw), one.at_s)
            continue
        is_frame = isinstance(one.piece, Frame) and one.piece.direction is Direction.MODULE_TO_HOST
        if is_frame:
            script.alive_at_s.append(one.at_s)
        if question is not None and is_frame and _answers(question, one):
            question.answered_at_s = question.answered_at_s or one.at_s
            question.data += one.piece.raw
        else:
            script.unasked.append(Entry(one.at_s, Way.IN, one.piece.raw))
    _end(script, question)
    return script


def _answers(question: _Question, one: "Explained") -> bool:
    is_free = not question.data or question.takes_several
    limit_s = LONGEST_RECORDS_S if question.takes_several else LONGEST_ANSWER_S
    return is_free and one.at_s - question.at_s <= limit_s and answers(one.piece.raw, question.request)


def _end(script: Script, question: _Question | None) -> None:
    if question is not None:
        after_s = max(0.0, question.answered_at_s - question.at_s) if question.data else 0.0
        script.answers.setdefault(question.request, []).append(Answer(question.at_s, after_s, question.data))


class Player:
    """Plays one script from the moment it is made. Any thread may look at it; one reads and writes."""

    def __init__(self, script: Script, now_s: float, *, speed: float = 1.0) -> None:
        """`speed` 0.05 … 100: how much quicker than it was."""
        self._script = script
        self._began_s = now_s
        self._speed = min(QUICKEST, max(SLOWEST, speed))
        self._next = 0
        self._due: deque[tuple[float, bytes]] = deque()
        self._heard = b""

    @property
    def duration_s(self) -> float:
        """Of the capture, in its own seconds."""
        return self._script.duration_s

    def position_s(self, now_s: float) -> float:
        """How far it is, in the capture's own seconds; never beyond its end."""
        return min(self._script.duration_s, (now_s - self._began_s) * self._speed)

    def is_over(self, now_s: float) -> bool:
        return (now_s - self._began_s) * self._speed > self._script.duration_s

    def write(self, data: bytes, now_s: float) -> None:
        """The host asks."""
        heard = (self._heard + data)[-_KEPT_REQUEST_BYTES:]
        while len(heard) >= HOST_FRAME_LENGTH:
            raw = heard[:HOST_FRAME_LENGTH]
            if raw.startswith(HOST_HEADER) and check_host(raw) is None:
                self._answer(decode_request(raw), now_s)
                heard = heard[HOST_FRAME_LENGTH:]
            else:
                heard = heard[1:]
        self._heard = heard

    def read(self, now_s: float) -> bytes:
        """What has come since the last call."""
        arrived = bytearray()
        while (due_s := self._next_unasked_s()) is not None and due_s <= now_s:
            arrived += self._script.unasked[self._next].raw
            self._next += 1
        while self._due and self._due[0][0] <= now_s:
            arrived += self._due.popleft()[1]
        return bytes(arrived)

    def next_due(self) -> float | None:
        """When something comes next, on the clock of `now_s`; None when nothing does."""
        dues = [self._due[0][0] if self._due else None, self._next_unasked_s()]
        return min((due_s for due_s in dues if due_s is not None), default=None)

    def _next_unasked_s(self) -> float | None:
        unasked = self._script.unasked
        return self._began_s + unasked[self._next].at_s / self._speed if self._next < len(unasked) else None

    def _answer(self, request: Request, now_s: float) -> None:
        position_s = (now_s - self._began_s) * self._speed
        if position_s > self._script.duration_s:
            return
        given = self._script.answers.get(request, [])
        index = max(0, bisect_right(given, position_s, key=lambda answer: answer.asked_at_s) - 1)
        if given and given[index].data:
            answer = given[index]
            self._put(now_s + answer.after_s / self._speed, answer.data)
        elif request == HEARTBEAT.query() and self._is_alive(position_s):
            self._put(now_s, _HEARTBEAT_REPLY)

    def _put(self, at_s: float, data: bytes) -> None:
        last_s = self._due[-1][0] if self._due else at_s
        self._due.append((max(at_s, last_s), data))

    def _is_alive(self, position_s: float) -> bool:
        """A frame of the module shortly before, or soon after."""
        seen = self._script.alive_at_s
        index = bisect_right(seen, position_s)
        near = seen[max(0, index - 1) : index + 1]
        return any(abs(at_s - position_s) <= ALIVE_FOR_S for at_s in near)


# Which capture plays where: the window shows how far it is

Clock = Callable[[], float]
_players: dict[str, Player] = {}
_players_lock = threading.Lock()


class UrlRefused(ValueError):
    """The URL is no `capture://FILE?speed=N`."""


class Order(NamedTuple):
    """What a URL asks for."""

    path: str
    speed: float


def parse_url(url: str) -> Order:
    """Raises `UrlRefused`."""
    parts = urlsplit(url)
    options = dict(parse_qsl(parts.query, keep_blank_values=True))
    speed_text = options.pop("speed", "1")
    path = unquote(parts.netloc + parts.path)
    try:
        speed = float(speed_text)
    except ValueError:
        raise UrlRefused(f"speed={speed_text} is no number") from None
    if parts.scheme != "capture" or not path or options or not SLOWEST <= speed <= QUICKEST:
        raise UrlRefused(f"{url}: needed is capture://FILE?speed=N, N from {SLOWEST:g} to {QUICKEST:g}")
    return Order(path, speed)


def url_of(path: str, *, speed: float = 1.0) -> str:
    """The port that plays this file."""
    return f"{SCHEME}{quote(path, safe='/:')}?speed={speed:g}"


def play(url: str, capture: Capture, *, speed: float, clock: Clock = time.monotonic) -> Player:
    """A player that `playing` finds by its URL."""
    player = Player(script_of(capture), clock(), speed=speed)
    with _players_lock:
        _players[url] = player
    return player


def playing(url: str) -> Player | None:
    """The player of an open `capture://` port, else None."""
    with _players_lock:
        return _players.get(url)


def stop_playing(url: str, player: Player) -> None:
    """Idempotent; leaves alone another player of the same URL."""
    with _players_lock:
        if _players.get(url) is player:
            del _players[url]
