"""Measures how late the module's frames arrive, and the earliest time they can have been sent.

A wireless bridge can delay everything by seconds, streamed reports included. The module answers in the order in which
it was asked, and the line keeps that order: everything that arrives after an answer was sent after its question went
out. Where the answer may belong to an earlier copy of the question, the earlier one counts.

A status proves nothing here, because it may have been streamed; neither does a heartbeat, as a restart sends two.
"""

from collections import deque
from math import inf
from typing import NamedTuple

from protocol.catalogue import HEARTBEAT, SERIAL_OUTPUT, STATUS, Request

MAX_S = 10.0
"""Older questions are no longer answered."""
STREAM_SHOWS_S = 3.0
"""Without an unasked frame for this long nothing streams: the slowest streams send one a second."""
QUICK_S = 0.3
_MAX_ASKED = 256


class _Asked(NamedTuple):
    request: Request
    at: float
    is_due: bool = True
    """No reply has come that may be the answer."""


class Lag:
    """See the module's docstring. Times are the link's `now`."""

    def __init__(self, now: float) -> None:
        self.sent_after = -inf
        """Everything received now was sent after this time."""
        self.heard_at = -inf
        """When the module last sent a frame."""
        self._unasked_at = now
        self._asked: deque[_Asked] = deque(maxlen=_MAX_ASKED)
        """Questions that may still be answered, oldest first."""
        self._answerable: set[Request] = set()
        """Questions that this module has answered."""
        self._last_s: float | None = None

    def ask(self, request: Request, now: float) -> None:
        """Note that an attempt is sent."""
        while self._asked and now - self._asked[0].at > MAX_S:
            self._asked.popleft()
        self._asked.append(_Asked(request, now))
        if request.command is SERIAL_OUTPUT:
            self._unasked_at = now

    def on_unsolicited(self, now: float) -> None:
        """Note a streamed status, or the heartbeat of a restart, after which a stream may begin."""
        self._unasked_at = now

    def may_be_streamed(self, request: Request, now: float) -> bool:
        """Whether the answer to `request` may be a streamed report."""
        return request.command is STATUS and now - self._unasked_at <= STREAM_SHOWS_S

    def answer_sent_after(self, request: Request, now: float) -> float:
        """The earliest time at which the answer to `request`, received now, can have been sent."""
        if self.may_be_streamed(request, now):
            return self.sent_after
        return max(self.sent_after, self.asked_at(request))

    def asked_at(self, request: Request) -> float:
        """When the earliest request was sent that a reply to `request`, received now, may answer."""
        codes = request.command.reply_codes
        return next((question.at for question in self._asked if question.request.command.reply_codes & codes), -inf)

    def answer(self, request: Request, now: float) -> None:
        """Note a reply to `request`, in time or late."""
        asked_at = self.asked_at(request)
        if asked_at == -inf:
            return
        if request.command is STATUS:
            self._asked.remove(next(question for question in self._asked if question.request.command is STATUS))
            return
        if not next(question for question in self._asked if question.at == asked_at).is_due:
            self.answer_or_copy(request)  # that one had its reply: this is the reply to a later one
        self._last_s = now - asked_at
        self._answerable.add(request)
        if request.command is not HEARTBEAT:
            self.sent_after = max(self.sent_after, asked_at)
        while self._asked and self._asked[0].at <= asked_at:
            self._asked.popleft()

    def answer_or_copy(self, request: Request) -> None:
        """Note a reply to `request` that may be a copy of the one before: it proves nothing, and nothing is overdue."""
        for place in reversed(range(len(self._asked))):
            if self._asked[place].request == request and self._asked[place].is_due:
                self._asked[place] = self._asked[place]._replace(is_due=False)
                return

    @property
    def is_quick(self) -> bool:
        """The last answer took less time than an exchange of the module would."""
        return self._last_s is None or self._last_s < QUICK_S

    def seconds(self, now: float) -> float | None:
        """How long answers take now; None before the first. An overdue answer counts with the time waited so far, if
        the module is known to answer that question and has sent something since: else it is silent, not late."""
        if self._last_s is None:
            return None
        due = (question for question in self._asked if question.is_due and question.request in self._answerable
               and question.at < self.heard_at)  # fmt: skip
        return max(self._last_s, now - next((question.at for question in due if now - question.at <= MAX_S), now))
