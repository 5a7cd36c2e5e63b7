"""Changes the module's baud rate, and finds the module again whatever it did (E9).

    conditions -> log old and new rate, durably -> the set, once -> search for the module: new, old, all rates
    -> the port stays at the rate that answers

The table specifies neither the rate of the acknowledgement nor the time of the change, so only an answered question
proves a rate. If the program ends meanwhile, `dps-s find` finds the module.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from app.engine.procedure import Ask, EngineView, Inspect, Procedure
from app.procedures.act import Armed, begin_act
from app.procedures.find import look_for
from app.procedures.settings_reading import is_refuted, read_settings
from app.procedures.write import SetReply, acknowledged
from app.safety.acts import Act
from app.safety.interlocks import Refusal
from app.safety.journal import Journal, Outcome
from app.safety.permit import Permit
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked


class BaudEnd(Enum):
    CHANGED = "changed"
    AT_RESTART = "at restart"
    """Acknowledged but still at the old rate: it changes at the next start, or not at all."""
    UNCHANGED = "unchanged"
    ELSEWHERE = "elsewhere"
    """It answers at another rate: the set was corrupted on the line."""
    LOST = "lost"
    NOT_SENT = "not sent"


SENTENCES: Mapping[BaudEnd, str] = {
    BaudEnd.CHANGED: marked("Module and port are at {new} baud."),
    BaudEnd.AT_RESTART: marked("Still at {old} baud. Switch it off and on, then try {new} baud."),
    BaudEnd.UNCHANGED: marked("Refused: still at {old} baud."),
    BaudEnd.ELSEWHERE: marked("The module is at {found} baud instead. Change it again."),
    BaudEnd.LOST: marked("No answer at any rate. Switch the module off and on, then “Find the baud rate”."),
    BaudEnd.NOT_SENT: marked("Nothing was sent."),
}
_OUTCOMES: Mapping[BaudEnd, Outcome] = {
    BaudEnd.CHANGED: Outcome.CONFIRMED,
    BaudEnd.AT_RESTART: Outcome.UNKNOWN,
    BaudEnd.UNCHANGED: Outcome.REFUSED,
    BaudEnd.ELSEWHERE: Outcome.UNKNOWN,
    BaudEnd.LOST: Outcome.UNKNOWN,
    BaudEnd.NOT_SENT: Outcome.NOT_SENT,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BaudChanged:
    old_rate: int
    new_rate: int
    end: BaudEnd
    heard: SetReply = SetReply.NOT_SENT
    found_rate: int | None = None
    """The rate at which it answers, and of the port; None if it does not answer (the port is at the old rate)."""
    refusals: tuple[Refusal, ...] = ()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        text = SENTENCES[self.end]
        rates = {"old": self.old_rate, "new": self.new_rate, "found": self.found_rate}
        words = tr(text, **{name: rate for name, rate in rates.items() if f"{{{name}}}" in text})
        return join_sentences((words, *(refusal.sentence for refusal in self.refusals)))


def change_baud(
    new_rate: int, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None,
    begin: EngineView | None = None,
) -> Procedure[BaudChanged]:  # fmt: skip
    """Raises `ValueRefused` for a rate without a code, before anything is sent. If it is cancelled or the port is lost
    after the set, it raises, and the log has no outcome. For `begin` see `begin_act`."""
    request = BAUD_RATE.set(new_rate)
    view: EngineView = yield Inspect()
    old_rate = view.baud_rate
    rates = {"old": old_rate, "new": new_rate}
    entry = yield from begin_act(
        Act.CHANGE_BAUD, request, journal, permit=permit, armed=armed, detail=rates, begin=begin
    )
    if isinstance(entry, tuple):
        return BaudChanged(old_rate=old_rate, new_rate=new_rate, end=BaudEnd.NOT_SENT, refusals=entry)
    reply = acknowledged((yield Ask(request, is_deliberate=True)))
    if reply.heard is SetReply.NOT_SENT:
        changed = BaudChanged(old_rate=old_rate, new_rate=new_rate, end=BaudEnd.NOT_SENT)
    else:
        rate = yield from look_for(new_rate, old_rate)
        if rate not in (None, new_rate):
            yield from read_settings()
            if is_refuted(view, (yield Inspect())):
                rate = None  # another module answers
        end = _end(old_rate, new_rate, rate, reply.heard)
        changed = BaudChanged(old_rate=old_rate, new_rate=new_rate, end=end, heard=reply.heard, found_rate=rate)
    journal.settle(entry, _OUTCOMES[changed.end], {"end": changed.end.value, "found": changed.found_rate})
    return changed


def _end(old_rate: int, new_rate: int, rate: int | None, heard: SetReply) -> BaudEnd:
    if rate is None:
        return BaudEnd.LOST
    if rate == new_rate:
        return BaudEnd.CHANGED
    if rate != old_rate:
        return BaudEnd.ELSEWHERE
    is_acknowledged = heard in (SetReply.ECHO, SetReply.ONE)
    return BaudEnd.AT_RESTART if is_acknowledged else BaudEnd.UNCHANGED
