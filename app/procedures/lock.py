"""Locks the module (standby): always safe, never refused, sent at once and repeated.

    LOCK -> the module's report -> LOCK again until it reports that it is locked

The frame waits for no condition, no answer to another request and no disk (the journal has its own thread). It is sent
at the last rate at which the module answered. An acknowledgement proves nothing; two reports in a row do. Where nobody
can be asked which module it is, reports from before a silence or a restart do not count: it is asked again, and what is
confirmed then is that the module which answers now is LOCKED. What was left ACTIVE before is not cleared by that.
`protocol.link` explains why only this request is repeated.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.procedure import (
    HEARTBEAT_WAITS_S,
    MAX_LOCKS,
    Ask,
    Cancelled,
    EngineView,
    Inspect,
    LockRepeat,
    Pause,
    PortLost,
    Procedure,
    Report,
    UseRate,
)
from app.engine.transport import PortError
from app.procedures.find import find_rate
from app.safety.acts import Act
from app.safety.journal import Entry, Journal, NoJournal, Outcome
from app.text.i18n import tr
from protocol.catalogue import BY_NAME, HEARTBEAT, LOCK, STATUS
from protocol.events import Answered
from protocol.events import Outcome as Reply
from protocol.lag import QUICK_S
from protocol.messages import Acknowledgement, Reading, Status
from protocol.translatable import marked

ACKNOWLEDGED_S = 0.06
"""How long to wait for the acknowledgement before asking for the state."""
AGREEING = 2
"""Reports in a row that must agree."""
QUESTIONS = (BY_NAME["active"].query(), STATUS.query())
BREATH_S = 0.03
"""Before a question after an unanswered one, as some modules need a gap between frames."""
SILENT_S = 1.5
"""After this silence during a search for the baud rate the search continues, and LOCK is sent at the rate found."""

ROUNDS_AFTER_SILENCE = 5
"""How often it is asked again, as a module may restart or fall silent several times."""

SENTENCES: Mapping[Outcome, str] = {
    Outcome.CONFIRMED: marked("The module reports LOCKED."),
    Outcome.REFUSED: marked("LOCK sent {count}×; the module still reports ACTIVE."),
    Outcome.UNKNOWN: marked("LOCK sent {count}×, not confirmed: treat the module as ACTIVE."),
    Outcome.NOT_SENT: marked("LOCK was not sent: treat the module as ACTIVE."),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Locked:
    """The result. `sent`: how often LOCK was sent."""

    outcome: Outcome
    sent: int
    is_acknowledged: bool = False
    is_heard: bool = True
    """The module answered anything at all."""
    is_port_lost: bool = False
    is_replaced: bool = False
    """LOCK was pressed again, or another act was confirmed, which ended the repetition."""
    may_be_another: bool = False
    """It restarted or was silent meanwhile, so another one may answer now."""

    @property
    def is_locked(self) -> bool | None:
        """What the module reports; None while unknown."""
        return {Outcome.CONFIRMED: True, Outcome.REFUSED: False}.get(self.outcome)

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        text = SENTENCES[self.outcome]
        if self.may_be_another and self.outcome is Outcome.CONFIRMED:
            return tr("The module that answers now reports LOCKED.")
        return tr(text, count=self.sent) if "{count}" in text else tr(text)


def waiting_sentence(sent: int) -> str:
    """The text while LOCK is repeated."""
    return tr("LOCK sent {count}×, not yet reported", count=sent) if sent > 1 else tr("Locking…")


class _Reports:
    """The module's answers since the first LOCK."""

    def __init__(self) -> None:
        self.is_acknowledged = False
        self.heard_at: float | None = None
        self.is_in_doubt = False
        """Since the first LOCK another module may have taken its place."""
        self._reports: list[bool] = []

    def note(self, reply: Reply, now: float) -> bool:
        """Note the outcome of a request; return whether it was answered."""
        message = reply.messages[0] if isinstance(reply, Answered) else None
        if message is None:
            return False
        self.heard_at = now
        if isinstance(message, Acknowledgement):
            self.is_acknowledged |= message.is_accepted
        elif isinstance(message, Status):
            self._reports.append(message.active)
        elif isinstance(message, Reading):
            self._reports.append(message.value is True)
        return True

    def forget(self) -> None:
        """What was reported may be of another module."""
        self._reports.clear()

    @property
    def is_locked(self) -> bool | None:
        """None while there are too few reports or they contradict each other."""
        last = self._reports[-AGREEING:]
        return not last[0] if len(last) == AGREEING and len(set(last)) == 1 else None

    @property
    def says_locked(self) -> bool:
        """Whether the last report does."""
        return bool(self._reports) and not self._reports[-1]

    @property
    def outcome(self) -> Outcome:
        if self.is_locked:
            return Outcome.CONFIRMED
        # Without an acknowledgement the reports may be older than LOCK.
        return Outcome.REFUSED if self.is_locked is False and self.is_acknowledged else Outcome.UNKNOWN


def lock(
    journal: Journal | None = None, repeat: LockRepeat | None = None, *, is_attended: bool = True
) -> Procedure[Locked]:
    """Send LOCK until the module reports that it is locked, or to the limits of `LockRepeat`. A lost port and a
    cancellation are results, not exceptions. `repeat`: to continue after a lost port, or to show the progress.
    `is_attended`: a person is asked which module it is; else it is asked again after a silence."""
    journal, repeat, proof = journal or NoJournal(), repeat or LockRepeat(), _Reports()
    entries: list[Entry] = []
    before = repeat.sent
    is_port_lost = is_replaced = False
    try:
        for _ in range(1 + ROUNDS_AFTER_SILENCE):
            begin: EngineView = yield Inspect()
            yield from _lock_until_reported(journal, repeat, proof, entries)
            if is_attended or not (yield from _was_silent(begin)):
                break
            proof.is_in_doubt = True
            proof.forget()
    except Cancelled:
        is_replaced = True
    except (PortLost, PortError):
        is_port_lost = True
    sent = repeat.sent
    outcome = proof.outcome if sent > before or proof.is_locked else Outcome.UNKNOWN if sent else Outcome.NOT_SENT
    if sent > before and not entries:
        entries.append(_begin(journal))
    logged = Outcome.UNKNOWN if proof.is_in_doubt and sent else outcome
    for entry in entries:
        why = "port lost" if is_port_lost else "replaced" if is_replaced else None
        journal.settle(entry, logged, {"sent": sent, "acknowledged": proof.is_acknowledged, "why": why})
    return Locked(
        outcome=outcome,
        sent=sent,
        is_acknowledged=proof.is_acknowledged,
        is_heard=proof.heard_at is not None,
        is_port_lost=is_port_lost,
        is_replaced=is_replaced,
        may_be_another=proof.is_in_doubt,
    )


def _was_silent(begin: EngineView) -> Procedure[bool]:
    """Whether another module may have taken its place since. A silence on a line that is slow itself is none: an answer
    takes as long now."""
    view: EngineView = yield Inspect()
    if view.device.breaks == begin.device.breaks and not view.device.is_restart_suspected:
        return False
    answer = yield Ask(HEARTBEAT.query(), HEARTBEAT_WAITS_S)
    return not isinstance(answer, Answered) or (answer.round_trip_s or 0.0) < QUICK_S


def _begin(journal: Journal) -> Entry:
    return journal.begin(Act.LOCK, LOCK.encode(), {})


def _lock_until_reported(
    journal: Journal, repeat: LockRepeat, proof: _Reports, entries: list[Entry]
) -> Procedure[None]:
    view: EngineView = yield Inspect()
    if view.proven_rate not in (None, view.baud_rate):
        yield UseRate(view.proven_rate)
    may_search, was_settled = True, view.is_settled
    silent_since = view.now
    question = unanswered = asked_after = 0
    is_last_answered = True
    while not proof.is_locked:
        view = yield Inspect()
        is_going_on = repeat.is_repeating(view.now)
        if repeat.is_due(view.now) and not proof.says_locked:
            sent = repeat.sent
            answer = yield Ask(LOCK, (ACKNOWLEDGED_S,), repeat=repeat)
            if repeat.sent == sent:  # not sent, because the computer slept
                yield Pause(BREATH_S)
                continue
            if not entries:
                entries.append(_begin(journal))
            proof.note(answer, view.now)
            yield Report(min(repeat.sent, MAX_LOCKS) - 1, MAX_LOCKS, marked("Locking…"))
        if not is_last_answered:
            yield Pause(BREATH_S)
        answer = yield Ask(QUESTIONS[question], attempts=1, repeat=repeat)
        view = yield Inspect()
        is_last_answered = proof.note(answer, view.now)
        proof.is_in_doubt |= was_settled and not view.is_settled
        # Unanswered, the same question is repeated (a late answer counts), three times in case the module lacks it.
        unanswered = 0 if is_last_answered else unanswered + 1
        if is_last_answered or unanswered % 3 == 0:
            question = 1 - question
        if is_last_answered:
            silent_since = view.now
        if not is_going_on:
            asked_after += 1
            if not is_last_answered or proof.is_locked is False or asked_after > 2 * AGREEING:
                return
        if proof.heard_at is not None and not proof.says_locked:
            yield Pause(max(0.0, repeat.next_at - view.now))
        is_in_doubt = view.is_rate_searched or view.proven_rate is None
        if may_search and is_in_doubt and view.now - silent_since > SILENT_S:
            may_search = False
            result = yield from find_rate()
            if result.baud_rate is None and view.proven_rate is not None:
                yield UseRate(view.proven_rate)
            view = yield Inspect()
            silent_since = view.now
