"""At which baud rate does a module answer?"""

from dataclasses import dataclass

from app.procedure import Ask, Listen, Look, Procedure, Report, Sight, UseRate
from protocol.catalogue import BAUD_RATES, HEARTBEAT
from protocol.events import Answered
from protocol.text import marked

WAITS_S = (0.25, 0.5)
SETTLE_S = 0.03
"""After a change of rate: let the last character of the old rate pass."""


@dataclass(frozen=True, slots=True)
class Found:
    """`baud_rate` is None where nothing answered; `tried` in the order of trying."""

    baud_rate: int | None
    tried: tuple[int, ...]


def find_rate(first: int | None = None) -> Procedure[Found]:
    """Tries `first`, then all rates from the fastest down; ends at the first that answers, on that rate.

    Sends nothing but heartbeats. Where none answers the port goes back to the rate that it had.
    """
    sight: Sight = yield Look()
    candidates = list(BAUD_RATES)
    if first in candidates:
        candidates.remove(first)
        candidates.insert(0, first)
    tried: list[int] = []
    for rate in candidates:
        yield Report(len(tried), len(candidates), marked("Trying {rate} baud"), (("rate", rate),))
        yield UseRate(rate)
        yield Listen(SETTLE_S)
        tried.append(rate)
        outcome = yield Ask(HEARTBEAT.query(), WAITS_S)
        if isinstance(outcome, Answered):
            return Found(rate, tuple(tried))
    yield UseRate(sight.baud_rate)
    return Found(None, tuple(tried))
