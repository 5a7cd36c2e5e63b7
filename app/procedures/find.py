"""Searches for the baud rate at which a module answers.

A job of the port, where no conversation has begun yet. The link itself asks the boot count behind another question
until a module answers. The answer to a question that was asked at another rate (a serial server passes on whole bytes)
does not pass that fence, so a conversation that begins proves the rate, and nothing is asked here.
"""

import logging
from typing import NamedTuple

from app.engine.procedure import EngineView, Inspect, Pause, Procedure, UseRate
from protocol.catalogue import BAUD_RATES

_log = logging.getLogger(__name__)

# The link's first questions are lost on many lines; the last one has the second that the vendor gives the module.
WAIT_S = 1.5
LOOK_EVERY_S = 0.005


class RateSearch(NamedTuple):
    """`baud_rate`: None if nothing answered."""

    baud_rate: int | None
    tried: tuple[int, ...]


def find_rate(first: int | None = None, old: int | None = None) -> Procedure[RateSearch]:
    """Try `first`, then all rates from the fastest down. The port stays at the first that answers, else at the one it
    has. `old`: the module was told to change from this one to `first`."""
    view: EngineView = yield Inspect()
    before = view.baud_rate
    rates = [*dict.fromkeys(rate for rate in (first, old, *BAUD_RATES) if rate is not None)]
    if old is not None:
        rates += rates[:2]  # the likely ones once more, as the line may lose frames
    if not view.sets_rate:
        rates = [before]  # somebody else sets it, at the other end of the socket
    for tried, rate in enumerate(rates, 1):
        if view.sets_rate:
            yield UseRate(rate)
        view = yield Inspect()
        ends_at = view.now + WAIT_S
        while not view.conversation.is_going and view.now < ends_at:
            yield Pause(min(LOOK_EVERY_S, ends_at - view.now))
            view = yield Inspect()
            if view.baud_rate != rate and not view.conversation.is_going:
                yield UseRate(rate)  # LOCK, which may come between, has tried another one
        if view.conversation.is_going:
            _log.debug("found at %d baud", view.baud_rate)
            return RateSearch(view.baud_rate, tuple(rates[:tried]))
    if view.sets_rate:
        yield UseRate(before)
    return RateSearch(None, tuple(rates))
