"""Locks the module (standby): always safe, never refused, sent at once and repeated.

    LOCK -> the module's report -> LOCK again until it reports that it is locked

A job of the port: the frame waits for no condition, no conversation, no answer to another request and no disk (the
journal has its own thread), and it goes on when a conversation ends. It is sent at the last rate at which the module
answered. An acknowledgement proves nothing; two reports in a row do, 30 and the status, in one conversation. If the
conversation in which LOCK was pressed has ended by then, they prove that the module which answers now is LOCKED: what
was left ACTIVE before is not cleared by that. `protocol.link` explains why only this request is repeated.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, LockRepeat, Pause, Procedure, UseRate
from app.procedures.find import find_rate
from app.procedures.read import ACTIVE
from app.safety.journal import Act, Entry, Journal, Outcome
from app.text.i18n import tr
from protocol.catalogue import LOCK, STATUS
from protocol.events import Answered, Reply
from protocol.messages import Acknowledgement, Reading, Status
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# How long to wait for the acknowledgement before asking for the state.
ACKNOWLEDGED_S = 0.06
# Also an answer that a bridge holds back for more than a second counts; LOCK is sent again meanwhile.
ANSWER_S = 2.0
# The last answer is waited for so long after the last LOCK could be sent: who stands beside the module has to know.
LAST_ANSWER_S = 0.8
# Reports in a row that must agree.
AGREEING = 2
# The number of no conversation: it is sent in a later one than that in which it was wanted.
OWED = 0
QUESTIONS = (ACTIVE.query(), STATUS.query())
# After this silence, while the module may be at any rate, its rate is searched, and LOCK is sent there.
SILENT_S = 1.5

SENTENCES: Mapping[Outcome, str] = {
    Outcome.CONFIRMED: marked("The module reports LOCKED."),
    Outcome.REFUSED: marked("LOCK sent {count}×; the module still reports ACTIVE."),
    Outcome.UNKNOWN: marked("LOCK sent {count}×, not confirmed: treat the module as ACTIVE."),
    Outcome.NOT_SENT: marked("LOCK was not sent: treat the module as ACTIVE."),
}


@dataclass(slots=True, kw_only=True)
class Locked:
    """The result, filled in as it goes on. `sent`: how often LOCK was sent."""

    outcome: Outcome = Outcome.UNKNOWN
    sent: int = 0
    is_acknowledged: bool = False
    # The module answered anything at all.
    is_heard: bool = False
    is_port_lost: bool = False
    # LOCK was pressed again, or another act was confirmed, which ended the repetition.
    is_replaced: bool = False
    # The conversation in which it was pressed has ended, so another module may have answered.
    may_be_another: bool = False

    @property
    def is_locked(self) -> bool | None:
        """Whether the module reports LOCKED; None while unknown."""
        return {Outcome.CONFIRMED: True, Outcome.REFUSED: False}.get(self.outcome)

    @property
    def sentence(self) -> str:
        """The sentence in the language in use now."""
        if self.may_be_another and self.outcome is Outcome.CONFIRMED:
            return tr("The module that answers now reports LOCKED.")
        text = SENTENCES[self.outcome]
        return tr(text, count=self.sent) if "{count}" in text else tr(text)


def waiting_sentence(sent: int) -> str:
    """The text while LOCK is repeated."""
    return tr("LOCK sent {count}×, not yet reported", count=sent) if sent > 1 else tr("Locking…")


class _Locking:
    """LOCK that is being sent, and the module's answers since the first frame."""

    def __init__(self, journal: Journal, repeat: LockRepeat, pressed_in: int | None) -> None:
        self.journal, self.repeat = journal, repeat
        self.locked = Locked()
        # What the log has of it, from the first frame on.
        self.entry: Entry | None = None
        # The number of the conversation in which it was pressed, or since which it is owed; before the first one, of
        # the one that begins.
        self._pressed_in = pressed_in
        self._reports: list[bool] = []
        self._reported_in = (0, False)

    @property
    def is_locked(self) -> bool | None:
        """Whether the last reports say LOCKED; None while there are too few, or they contradict each other."""
        last = self._reports[-AGREEING:]
        return None if len(last) < AGREEING or len(set(last)) > 1 else not last[0]

    @property
    def says_locked(self) -> bool:
        """Whether the last report does."""
        return bool(self._reports) and not self._reports[-1]

    def until_reported(self) -> Procedure[None]:
        repeat = self.repeat
        view = yield from self._look()
        # While somebody searches the rate the port may be at any.
        if view.proven_rate is not None and view.proven_rate != view.baud_rate:
            yield UseRate(view.proven_rate)
        silent_since = view.now
        may_search = True
        question = asked_after = 0
        while not self.is_locked:
            view = yield from self._look()
            is_going_on = repeat.is_repeating(view.now)
            if repeat.is_due(view.now) and not self.says_locked:
                reply = yield Ask(LOCK, limit_s=ACKNOWLEDGED_S, repeat=repeat)
                self.log_intent()
                self._note(reply)
            limit_s = max(ACKNOWLEDGED_S, min(ANSWER_S, repeat.until + LAST_ANSWER_S - view.now))
            reply = yield Ask(QUESTIONS[question], limit_s=limit_s, repeat=repeat)
            view = yield from self._look()
            is_answered = self._note(reply)
            question = 1 - question  # also unanswered, in case the module lacks it
            if is_answered:
                silent_since = view.now
            if not is_going_on:
                asked_after += 1
                if not is_answered or self.is_locked is False or asked_after > 2 * AGREEING:
                    return
            if self.locked.is_heard and not self.says_locked:
                yield Pause(max(0.0, repeat.next_at - view.now))
            is_long_silent = view.now - silent_since > SILENT_S
            if may_search and view.is_rate_in_doubt and is_long_silent and repeat.is_repeating(view.now):
                may_search = False
                yield from find_rate()
                view = yield from self._look()
                silent_since = view.now

    def log_intent(self) -> None:
        """Log it once the frame has left: LOCK waits for no disk."""
        if self.repeat.sent and self.entry is None:
            self.entry = self.journal.begin(Act.LOCK, LOCK.encode(), {})

    def _look(self) -> Procedure[EngineView]:
        """Look at the conversation: what was reported in one counts in no other."""
        view: EngineView = yield Inspect()
        now = view.conversation
        if self._pressed_in is None:
            self._pressed_in = max(now.number, 1)
        self.locked.may_be_another |= now.ended is not None or now.number > self._pressed_in
        if (now.number, now.is_going) != self._reported_in:
            self._reported_in = now.number, now.is_going
            self._reports.clear()
        return view

    def _note(self, reply: Reply) -> bool:
        """Note the outcome of a request; return whether it was answered."""
        answer = reply.messages[0] if isinstance(reply, Answered) else None
        if isinstance(answer, Acknowledgement):
            self.locked.is_acknowledged |= answer.is_accepted
        elif isinstance(answer, Status):
            self._reports.append(answer.active)
        elif isinstance(answer, Reading):
            self._reports.append(answer.value is True)
        self.locked.is_heard |= answer is not None
        return answer is not None


def lock(
    journal: Journal | None = None, repeat: LockRepeat | None = None, *, pressed_in: int | None = None
) -> Procedure[Locked]:
    """Send LOCK until the module reports that it is locked, or to the limits of `LockRepeat`. A lost port and a
    cancellation are results, not exceptions. `repeat`: a new one, which shows the progress. `pressed_in`: the number of
    the conversation of that journal, where the next one may have begun before this does; `OWED` since one that has
    ended."""
    locking = _Locking(journal or Journal(), repeat or LockRepeat(), pressed_in)
    locked = locking.locked
    try:
        yield from locking.until_reported()
    except Cancelled:
        locked.is_replaced = True
    except Interrupted:
        locked.is_port_lost = True
    locking.log_intent()
    locked.sent = locking.repeat.sent
    if locking.is_locked:
        locked.outcome = Outcome.CONFIRMED
    elif not locked.sent:
        locked.outcome = Outcome.NOT_SENT
    elif locking.is_locked is False and locked.is_acknowledged:
        # Without an acknowledgement the reports may be older than LOCK.
        locked.outcome = Outcome.REFUSED
    _log.debug("%s", locked)
    if locking.entry is not None:
        # Of the module for which it was pressed nothing is confirmed then.
        logged = Outcome.UNKNOWN if locked.may_be_another else locked.outcome
        why = "port lost" if locked.is_port_lost else "replaced" if locked.is_replaced else None
        result = {"sent": locked.sent, "acknowledged": locked.is_acknowledged, "why": why}
        locking.journal.settle(locking.entry, logged, result)
    return locked
