"""Plays a capture through the whole program as a port, `capture://FILE?speed=1`.

Bytes that the module sent without a request (stream, restarts, noise) come at their time. A request is answered with
the last answer to the same request at that point of the capture, after the same delay; before the first one, with the
first answer within the next `AHEAD_S`. Requests that were never answered, or never sent, get no answer. The only
exception is the heartbeat, which is answered while the capture has frames of the module. After its end the line is
silent.

The capture is read a little ahead of playback; if reading is too slow, the capture's time waits for it.
"""

import threading
import time
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from typing import Final, NamedTuple
from urllib.parse import parse_qsl, quote, unquote, urlsplit

from app.captures.script import MAX_RECORDS_S, Answer, Script
from app.engine.playback import SCHEME
from protocol.catalogue import HEARTBEAT, HEARTBEAT_REPLY, Request
from protocol.frame import requests_in

SLOWEST, QUICKEST = 0.05, 100.0
ALIVE_FOR_S = 12.0
"""How long a frame proves that the module was present: a heartbeat period and some."""
AHEAD_S: Final = 20.0
"""How far ahead an answer may be taken from. The window queries values every second, the boot count every ten."""
KNOWN_AHEAD_S: Final = AHEAD_S + MAX_RECORDS_S
"""How far ahead the capture is read. Playback begins before that; requests wait for the answers that they need."""
MIN_AHEAD_S: Final = 1.0
"""The capture's time waits if less than this has been read ahead."""
READ_EARLIER_S: Final = 2.0
"""How much earlier than necessary it is read, in time of the clock."""


class Player:
    """Plays a script, beginning at once. One thread reads and writes; any may ask for its position."""

    def __init__(self, script: Script, now_s: float, *, speed: float = 1.0) -> None:
        """`speed`: 0.05 … 100 times the original."""
        self._script = script
        self._began_s = now_s
        self._speed = min(QUICKEST, max(SLOWEST, speed))
        self._due: deque[tuple[float, bytes]] = deque()
        self._heard = b""
        self._waiting: dict[Request, None] = {}
        """Requests that wait until enough has been read to answer them."""

    @property
    def duration_s(self) -> float:
        """Duration in seconds of the capture; approximate until all of it has been read."""
        return self._script.duration_s

    def position_s(self, now_s: float) -> float:
        """Position in seconds of the capture, at most its duration."""
        return min(self._script.duration_s, self._passed_s(now_s))

    def is_over(self, now_s: float) -> bool:
        return self._script.is_read and self._passed_s(now_s) > self._script.duration_s

    def read_ahead(self, now_s: float) -> bool:
        """Read one step of the capture if not enough has been read; whether there was something to do.

        Raises what reading the file raises.
        """
        self._limit_position(now_s)
        script, position_s = self._script, self._passed_s(now_s)
        if script.is_read or script.read_s >= position_s + KNOWN_AHEAD_S + READ_EARLIER_S * self._speed:
            return False
        script.read_on()
        script.discard_before(position_s, ALIVE_FOR_S)
        self._limit_position(now_s)
        return True

    def write(self, data: bytes, now_s: float) -> None:
        """Take requests of the host."""
        self._limit_position(now_s)
        requests, self._heard = requests_in(self._heard + data)
        self._waiting |= dict.fromkeys(requests)
        self._answer_all(now_s)

    def read(self, now_s: float) -> bytes:
        """Bytes that came since the last call."""
        self._limit_position(now_s)
        self._answer_all(now_s)
        arrived = bytearray()
        while (due_s := self._next_unasked_s()) is not None and due_s <= now_s:
            arrived += self._script.unasked.popleft()[1]
        while self._due and self._due[0][0] <= now_s:
            arrived += self._due.popleft()[1]
        return bytes(arrived)

    def next_due(self) -> float | None:
        """When the next bytes come, on the clock of `now_s`; None if there are none."""
        dues = [self._due[0][0] if self._due else None, self._next_unasked_s()]
        return min((due_s for due_s in dues if due_s is not None), default=None)

    def _passed_s(self, now_s: float) -> float:
        """Passed time of the capture."""
        return (now_s - self._began_s) * self._speed

    def _limit_position(self, now_s: float) -> None:
        """Delay playback while not enough has been read."""
        if not self._script.is_read:
            furthest_s = max(0.0, self._script.read_s - MIN_AHEAD_S)
            self._began_s = max(self._began_s, now_s - furthest_s / self._speed)

    def _next_unasked_s(self) -> float | None:
        unasked = self._script.unasked
        return self._began_s + unasked[0][0] / self._speed if unasked else None

    def _answer_all(self, now_s: float) -> None:
        for request in tuple(self._waiting):
            if self.is_over(now_s) or self._answer(request, now_s):
                del self._waiting[request]

    def _answer(self, request: Request, now_s: float) -> bool:
        """Answer a request if the answer is known; whether it is known, also that there is none."""
        position_s = self._passed_s(now_s)
        answer = self._given(request, position_s)
        is_known = self._knows(position_s + AHEAD_S) if answer is None else self._knows_whole(answer)
        if answer is not None and answer.data and is_known:
            self._put(now_s + answer.after_s / self._speed, answer.data)
            return True
        if request == HEARTBEAT.query() and self._is_alive(position_s):
            self._put(now_s, HEARTBEAT_REPLY)
            return True
        return is_known

    def _knows(self, at_s: float) -> bool:
        return self._script.is_read or self._script.read_s >= at_s

    def _knows_whole(self, answer: Answer) -> bool:
        has_all = bool(answer.data) and not answer.is_multi_frame
        return has_all or self._knows(answer.asked_at_s + MAX_RECORDS_S)

    def _given(self, request: Request, position_s: float) -> Answer | None:
        """The last answer before this position, else the first one within `AHEAD_S`."""
        given = self._script.answers.get(request, ())
        last = bisect_right(given, position_s, key=lambda answer: answer.asked_at_s) - 1
        answer = given[max(0, last)] if given else None
        return answer if answer is not None and answer.asked_at_s <= position_s + AHEAD_S else None

    def _put(self, at_s: float, data: bytes) -> None:
        last_s = self._due[-1][0] if self._due else at_s
        self._due.append((max(at_s, last_s), data))

    def _is_alive(self, position_s: float) -> bool:
        """Whether a frame of the module is near this position."""
        return any(abs(at_s - position_s) <= ALIVE_FOR_S for at_s in self._near(position_s))

    def _near(self, position_s: float) -> tuple[float, ...]:
        seen = self._script.alive_at_s
        index = bisect_right(seen, position_s)
        return tuple(seen[one] for one in (index - 1, index) if 0 <= one < len(seen))


# Which capture plays where: the window shows how far it is

Clock = Callable[[], float]
_players: dict[str, Player] = {}
_players_lock = threading.Lock()


class UrlRefused(ValueError):
    """The URL is not of the form `capture://FILE?speed=N`."""


class Order(NamedTuple):
    """Content of a URL."""

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
    """The URL of the port that plays this file."""
    return f"{SCHEME}{quote(path, safe='/:')}?speed={speed:g}"


def play(url: str, script: Script, *, speed: float, clock: Clock = time.monotonic) -> Player:
    """Start a player, which `playing` finds by its URL."""
    player = Player(script, clock(), speed=speed)
    with _players_lock:
        _players[url] = player
    return player


def playing(url: str) -> Player | None:
    """The player of an open `capture://` port, else None."""
    with _players_lock:
        return _players.get(url)


def stop_playing(url: str, player: Player) -> None:
    """Forget this player, but not another one of the same URL. Idempotent."""
    with _players_lock:
        if _players.get(url) is player:
            del _players[url]
