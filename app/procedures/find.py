"""Searches for the baud rate at which a module answers."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle

from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure, Report, UseRate, is_alive
from protocol.catalogue import BAUD_RATES, BY_NAME, Request
from protocol.events import Answered
from protocol.translatable import marked

WAITS_S = (0.25, 1.0)
"""The last wait is the second that the vendor gives the module."""
SETTLE_S = 0.03
"""After a change of rate, for the last character at the old rate."""
PROOF_WAITS_S = (0.25, 0.5, 1.0)
"""Enough for a line that loses every other frame."""
_PROOFS = tuple(BY_NAME[name].query() for name in ("boot_count", "charging", "active", "triggered"))
_PROOFS_TRIED = 2
"""In case the module does not know one of them."""


@dataclass(frozen=True, slots=True)
class Found:
    """`baud_rate`: None if nothing answered; `tried`: all rates in order."""

    baud_rate: int | None
    tried: tuple[int, ...]


def proofs() -> Iterator[Request]:
    """The questions of one search, for `answers_here`."""
    return cycle(_PROOFS)


def answers_here(waits_s: tuple[float, ...], questions: Iterator[Request]) -> Procedure[bool]:
    """Whether a module answers at the port's rate: a heartbeat and then one of `questions`.

    The answer to a heartbeat at another rate may still come (a serial server passes on whole bytes), but not the answer
    to a question that was not asked there.
    """
    if not (yield from is_alive(waits_s)):
        return False
    for _ in range(_PROOFS_TRIED):
        proof = yield Ask(next(questions), PROOF_WAITS_S)
        if isinstance(proof, Answered):
            return True
    return False


def find_rate(first: int | None = None) -> Procedure[Found]:
    """Try `first`, then all rates from the fastest down; the port stays at the first that answers, else at the old one.

    Only questions are sent.
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
