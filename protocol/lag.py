"""Measures how late the module's frames arrive, and the earliest time they can have been sent.

A wireless bridge holds everything back by seconds, streamed reports included: what has just come may be old. The module
answers in the order in which it was asked, and the line keeps that order. So once a question is answered, all that
comes afterwards was said after that question went out. Where the answer may belong to the same question asked before,
the earlier one counts.

A status proves nothing of this kind, for it may have been streamed; nor does a heartbeat, two of which come unasked
after a restart.
"""

from collections import deque
from math import inf
from typing import NamedTuple

from protocol.catalogue import HEARTBEAT, SERIAL_OUTPUT, STATUS, Request

LONGEST_S = 10.0
"""What was asked longer ago is not answered any more."""
STREAM_SHOWS_S = 3.0
"""Where nothing has come unasked for this long nothing streams: the slowest streams send one a second."""
_MOST = 256


class _Asked(NamedTuple):
    request: Request
    at: float


class Lag:
    """See the module's docstring. Times are the link's `now`."""

    def __init__(self, now: float) -> None:
        self.said_after = -inf
        """All that comes now was said after this moment."""
        self._unasked_at = now
        self._asked: deque[_Asked] = deque(maxlen=_MOST)
        """What may still be answered, oldest first."""
        self._answerable: set[Request] = set()
        """Questions that this module has answered before."""
        self._last_s: float | None = None

    def ask(self, request: Request, now: float) -> None:
        """One attempt goes out."""
        while self._asked and now - self._asked[0].at > LONGEST_S:
            self._asked.popleft()
        self._asked.append(_Asked(request, now))
        if request.command is SERIAL_OUTPUT:
            self._unasked_at = now

    def hear_unasked(self, now: float) -> None:
        """A streamed status, or the heartbeat of a restart after which a stream may begin."""
        self._unasked_at = now

    def may_be_streamed(self, request: Request, now: float) -> bool:
        """Whether what is taken for the answer to `request` may be a report that came unasked."""
        return request.command is STATUS and now - self._unasked_at <= STREAM_SHOWS_S

    def answer_said_after(self, request: Request, now: float) -> float:
        """The same of what is taken for the answer to `request`: where nothing streams, it is the answer."""
        if self.may_be_streamed(request, now):
            return self.said_after
        return max(self.said_after, self.asked_at(request))

    def asked_at(self, request: Request) -> float:
        """When the earliest request went out that a reply to `request`, coming now, may answer."""
        codes = request.command.reply_codes
        return next((one.at for one in self._asked if one.request.command.reply_codes & codes), -inf)

    def answer(self, request: Request, now: float) -> None:
        """A reply to `request` came, in time or late."""
        asked_at = self.asked_at(request)
        if asked_at == -inf:
            return
        if request.command is STATUS:
            self._asked.remove(next(one for one in self._asked if one.request.command is STATUS))
            return
        self._last_s = now - asked_at
        self._answerable.add(request)
        if request.command is not HEARTBEAT:
            self.said_after = max(self.said_after, asked_at)
        while self._asked and self._asked[0].at <= asked_at:
            self._asked.popleft()

    def seconds(self, now: float) -> float | None:
        """How long answers take now; None before the first. What is overdue counts with the time it has been waited
        for, where the module is known to answer it."""
        if self._last_s is None:
            return None
        due = (one.at for one in self._asked if one.request in self._answerable and now - one.at <= LONGEST_S)
        return max(self._last_s, now - next(due, now))
