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

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, Procedure
from app.procedures.act import Armed, begin_act
from app.procedures.find import look_for
from app.procedures.write import WriteFault, Written, reply_of
from app.safety.journal import Act, Journal, Outcome
from app.safety.permit import Permit, Refusal
from app.text.i18n import tr
from app.text.messages import join_sentences
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked

_log = logging.getLogger(__name__)


# By what is wrong with the rate then: what to say, and what is logged.
_ENDS: Mapping[WriteFault | None, tuple[str, Outcome]] = {
    None: (marked("Module and port are at {new} baud."), Outcome.CONFIRMED),
    WriteFault.AT_RESTART: (
        marked("Still at {old} baud. Switch it off and on, then try {new} baud."),
        Outcome.UNKNOWN,
    ),
    WriteFault.UNCHANGED: (marked("Refused: still at {old} baud."), Outcome.REFUSED),
    WriteFault.CLAMPED: (marked("The module is at {found} baud instead. Change it again."), Outcome.UNKNOWN),
    WriteFault.MODULE_LOST: (
        marked("No answer at any rate. Switch the module off and on, then “Find the baud rate”."),
        Outcome.UNKNOWN,
    ),
    WriteFault.NOT_SENT: (marked("Nothing was sent."), Outcome.NOT_SENT),
    WriteFault.NOT_ALLOWED: (marked("Nothing was sent."), Outcome.NOT_SENT),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BaudChanged:
    """`written.read_back`: the rate at which the module answers, and of the port; None if it does not answer (the port
    is at the old rate)."""

    old_rate: int
    written: Written
    refusals: tuple[Refusal, ...] = ()

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        text = _ENDS[self.written.fault][0]
        rates = {"old": self.old_rate, "new": self.written.target, "found": self.written.read_back}
        words = tr(text, **{name: rate for name, rate in rates.items() if f"{{{name}}}" in text})
        return join_sentences((words, *(refusal.sentence for refusal in self.refusals)))


def change_baud(
    new_rate: int, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[BaudChanged]:
    """Raises `ValueRefused` for a rate without a code, before anything is sent. If it is cancelled or the port is lost
    after the set, it raises, and the outcome is unknown."""
    request = BAUD_RATE.set(new_rate)
    view: EngineView = yield Inspect()
    old_rate = view.baud_rate
    rates = {"old": old_rate, "new": new_rate}
    written = Written(BAUD_RATE, new_rate)
    entry = yield from begin_act(Act.CHANGE_BAUD, request, journal, permit=permit, armed=armed, detail=rates)
    if isinstance(entry, tuple):
        written.fault = WriteFault.NOT_ALLOWED
        return BaudChanged(old_rate=old_rate, written=written, refusals=entry)
    try:
        written.heard = reply_of((yield Ask(request, is_deliberate=True)))
        if written.is_sent:
            written.read_back = yield from look_for(new_rate, old_rate)
            written.fault = _fault(written, old_rate)
    except (Interrupted, Cancelled) as error:
        journal.settle(entry, Outcome.UNKNOWN, {"why": type(error).__name__})
        raise
    fault = None if written.fault is None else written.fault.name
    _log.debug("from %d to %d baud: %s, %s", old_rate, new_rate, fault, written.read_back)
    journal.settle(entry, _ENDS[written.fault][1], {"fault": fault, "found": written.read_back})
    return BaudChanged(old_rate=old_rate, written=written)


def _fault(written: Written, old_rate: int) -> WriteFault | None:
    if written.read_back is None:
        return WriteFault.MODULE_LOST
    if written.read_back == written.target:
        return None
    if written.read_back != old_rate:
        return WriteFault.CLAMPED  # the set was corrupted on the line
    # It changes at the next start, or not at all.
    return WriteFault.AT_RESTART if written.is_acknowledged else WriteFault.UNCHANGED
