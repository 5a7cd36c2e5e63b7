"""Searches for the baud rate at which a module answers."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle

from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure, Report, UseRate
from protocol.catalogue import BAUD_RATES, BY_NAME, HEARTBEAT, Request
from protocol.events import Answered
from protocol.translatable import marked

WAITS_S = (0.25, 1.0)
"""The vendor gives the module one second: "no" is not said before."""
SETTLE_S = 0.03
"""After a change of rate: let the last character of the old rate pass."""
PROOF_WAITS_S = (0.25, 0.5, 1.0)
"""Enough for a line that loses every other frame."""
_PROOFS = tuple(BY_NAME[name].query() for name in ("boot_count", "charging", "active", "triggered"))
_PROOFS_TRIED = 2
"""Should a module not know one of them."""


@dataclass(frozen=True, slots=True)
class Found:
    """`baud_rate` is None where nothing answered; `tried` in the order of trying."""

    baud_rate: int | None
    tried: tuple[int, ...]


def proofs() -> Iterator[Request]:
    """Questions for `answers_here`, of one search for a rate."""
    return cycle(_PROOFS)


def answers_here(waits_s: tuple[float, ...], questions: Iterator[Request]) -> Procedure[bool]:
    """Whether a module answers at the port's rate: a heartbeat, and then one of `questions` too.

    The answer to a heartbeat that went out at another rate may still come, through a network even in whole bytes. To
    what was not asked there no answer comes.
    """
    sign = yield Ask(HEARTBEAT.query(), waits_s)
    if not isinstance(sign, Answered):
        return False
    for _ in range(_PROOFS_TRIED):
        proof = yield Ask(next(questions), PROOF_WAITS_S)
        if isinstance(proof, Answered):
            return True
    return False


def find_rate(first: int | None = None) -> Procedure[Found]:
    """Tries `first`, then all rates from the fastest down; ends at the first that answers, on that rate.

    Sends nothing but questions. Where none answers the port goes back to the rate that it had.
    """
    questions = proofs()
    sight: EngineView = yield Inspect()
    candidates = list(BAUD_RATES)
    if first in candidates:
        candidates.remove(first)
        candidates.insert(0, first)
    tried: list[int] = []
    for rate in candidates:
        yield Report(len(tried), len(candidates), marked("Trying {rate} baud"), (("rate", rate),))
        yield UseRate(rate)
        yield Pause(SETTLE_S)
        tried.append(rate)
        is_here = yield from answers_here(WAITS_S, questions)
        if is_here:
            return Found(rate, tuple(tried))
    yield UseRate(sight.baud_rate)
    return Found(None, tuple(tried))
