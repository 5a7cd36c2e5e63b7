"""Changes the module's baud rate, and finds the module again whatever it did (E9).

    conditions -> log old and new rate, durably -> who is there -> the set, once
    -> search for the module: new, old, all rates -> the port stays at the rate that answers

A job of the port, as the conversation at the old rate ends with it. The table specifies neither the rate of the
acknowledgement nor the time of the change, so only a conversation proves a rate. If the program ends meanwhile,
`dps-s find` finds the module.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, Procedure
from app.procedures.act import Armed, begin_act
from app.procedures.find import look_for
from app.procedures.write import SetReply, WriteFault, Written, reply_of
from app.safety.acts import Act
from app.safety.interlocks import Refusal
from app.safety.journal import Journal, Outcome
from app.safety.permit import Permit
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked

_log = logging.getLogger(__name__)


class BaudEnd(Enum):
    CHANGED = "changed"
    AT_RESTART = "at restart"  # acknowledged but still at the old rate: it changes at the next start, or not at all
    UNCHANGED = "unchanged"
    ELSEWHERE = "elsewhere"  # it answers at another rate: the set was corrupted on the line
    LOST = "lost"
    NOT_SENT = "not sent"


# What to say of it, what is logged, and what is wrong with the setting then.
_ENDS: Mapping[BaudEnd, tuple[str, Outcome, WriteFault | None]] = {
    BaudEnd.CHANGED: (marked("Module and port are at {new} baud."), Outcome.CONFIRMED, None),
    BaudEnd.AT_RESTART: (
        marked("Still at {old} baud. Switch it off and on, then try {new} baud."),
        Outcome.UNKNOWN,
        WriteFault.AT_RESTART,
    ),
    BaudEnd.UNCHANGED: (marked("Refused: still at {old} baud."), Outcome.REFUSED, WriteFault.UNCHANGED),
    BaudEnd.ELSEWHERE: (
        marked("The module is at {found} baud instead. Change it again."),
        Outcome.UNKNOWN,
        WriteFault.CLAMPED,
    ),
    BaudEnd.LOST: (
        marked("No answer at any rate. Switch the module off and on, then “Find the baud rate”."),
        Outcome.UNKNOWN,
        WriteFault.MODULE_LOST,
    ),
    BaudEnd.NOT_SENT: (marked("Nothing was sent."), Outcome.NOT_SENT, WriteFault.NOT_SENT),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BaudChanged:
    old_rate: int
    new_rate: int
    end: BaudEnd
    heard: SetReply = SetReply.NOT_SENT
    # The rate at which it answers, and of the port; None if it does not answer (the port is at the old rate).
    found_rate: int | None = None
    refusals: tuple[Refusal, ...] = ()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        text = _ENDS[self.end][0]
        rates = {"old": self.old_rate, "new": self.new_rate, "found": self.found_rate}
        words = tr(text, **{name: rate for name, rate in rates.items() if f"{{{name}}}" in text})
        return join_sentences((words, *(refusal.sentence for refusal in self.refusals)))

    @property
    def written(self) -> Written:
        """As one line among the results of a write."""
        return Written(
            BAUD_RATE,
            self.new_rate,
            self.heard,
            self.found_rate,
            WriteFault.NOT_ALLOWED if self.refusals else _ENDS[self.end][2],
        )


def change_baud(
    new_rate: int, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[BaudChanged]:
    """Raises `ValueRefused` for a rate without a code, before anything is sent. If it is cancelled or the port is lost
    after the set, it raises, and the outcome is unknown."""
    request = BAUD_RATE.set(new_rate)
    view: EngineView = yield Inspect()
    old_rate = view.baud_rate
    rates = {"old": old_rate, "new": new_rate}
    entry = yield from begin_act(Act.CHANGE_BAUD, request, journal, permit=permit, armed=armed, detail=rates)
    if isinstance(entry, tuple):
        return BaudChanged(old_rate=old_rate, new_rate=new_rate, end=BaudEnd.NOT_SENT, refusals=entry)
    heard, found = SetReply.NOT_SENT, None
    try:
        heard = reply_of((yield Ask(request, is_deliberate=True)))
        if heard is not SetReply.NOT_SENT:
            found = yield from look_for(new_rate, old_rate)
    except (Interrupted, Cancelled) as error:
        journal.settle(entry, Outcome.UNKNOWN, {"why": type(error).__name__})
        raise
    end = _end(old_rate, new_rate, found, heard)
    _log.debug("from %d to %d baud: %s, %s", old_rate, new_rate, end.value, found)
    journal.settle(entry, _ENDS[end][1], {"end": end.value, "found": found})
    return BaudChanged(old_rate=old_rate, new_rate=new_rate, end=end, heard=heard, found_rate=found)


def _end(old_rate: int, new_rate: int, found: int | None, heard: SetReply) -> BaudEnd:
    if heard is SetReply.NOT_SENT:
        return BaudEnd.NOT_SENT
    if found is None:
        return BaudEnd.LOST
    if found == new_rate:
        return BaudEnd.CHANGED
    if found != old_rate:
        return BaudEnd.ELSEWHERE
    is_acknowledged = heard in (SetReply.ECHO, SetReply.ONE)
    return BaudEnd.AT_RESTART if is_acknowledged else BaudEnd.UNCHANGED
