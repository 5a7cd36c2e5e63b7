"""Searches for the baud rate at which a module answers."""

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure, Report, UseRate, is_alive
from protocol.catalogue import BAUD_RATES, Request
from protocol.events import Answered
from protocol.stale_replies import FENCES
from protocol.translatable import marked

WAITS_S = (0.25, 1.0)
"""The last wait is the second that the vendor gives the module."""
SETTLE_S = 0.03
"""After a change of rate, for the last character at the old rate."""
LIKELY_WAITS_S = (0.25, 0.5, 1.0)
"""At a likely rate and for a proof; enough for a line that loses every other frame."""
ROUNDS = 2
"""At the likely rates."""
_PROOFS = FENCES[1:]  # no heartbeat
_PROOFS_TRIED = 2
"""In case the module does not know one of them."""


class RateSearch(NamedTuple):
    """`baud_rate`: None if nothing answered; `tried`: all rates in order."""

    baud_rate: int | None
    tried: tuple[int, ...]


def proofs() -> Iterator[Request]:
    """The questions of one search, for `answers_here`."""
    return cycle(_PROOFS)


def answers_here(waits_s: tuple[float, ...], questions: Iterator[Request]) -> Procedure[bool]:
    """Whether a module answers at the port's rate: a heartbeat and then one of `questions`. The answer to a heartbeat
    at another rate may still come (a serial server passes on whole bytes), but not the answer to a question that was
    not asked there."""
    if not (yield from is_alive(waits_s)):
        return False
    for _ in range(_PROOFS_TRIED):
        proof = yield Ask(next(questions), LIKELY_WAITS_S)
        if isinstance(proof, Answered):
            return True
    return False


def find_rate(first: int | None = None) -> Procedure[RateSearch]:
    """Try `first`, then all rates from the fastest down; the port stays at the first that answers, else at the old one.
    A plain socket is only asked whether a module answers. Only questions are sent."""
    view: EngineView = yield Inspect()
    if not view.sets_rate:
        return (yield from _search([(view.baud_rate, WAITS_S)], view.baud_rate))
    rates = sorted(BAUD_RATES, key=lambda rate: rate != first)
    return (yield from _search([(rate, WAITS_S) for rate in rates], view.baud_rate))


def look_for(new_rate: int, old_rate: int) -> Procedure[int | None]:
    """Search for the module at the new, the old and then all rates; return its rate, where the port stays, or None with
    the port at the old rate. Only questions are sent."""
    likely = list(dict.fromkeys((new_rate, old_rate)))
    places: list[tuple[int, tuple[float, ...]]] = [(rate, LIKELY_WAITS_S) for rate in likely * ROUNDS]
    places += [(rate, WAITS_S) for rate in BAUD_RATES if rate not in likely]
    return (yield from _search(places, old_rate)).baud_rate


def _search(places: Sequence[tuple[int, tuple[float, ...]]], old_rate: int) -> Procedure[RateSearch]:
    """Try these rates, each with its waits; the port stays at the first that answers, else at the old one."""
    questions = proofs()
    tried = [rate for rate, _ in places]
    for done, (rate, waits_s) in enumerate(places):
        yield Report(done, len(places), marked("Trying {rate} baud"), (("rate", rate),))
        yield UseRate(rate)
        yield Pause(SETTLE_S)
        is_here = yield from answers_here(waits_s, questions)
        if is_here:
            return RateSearch(rate, tuple(tried[: done + 1]))
    yield UseRate(old_rate)
    return RateSearch(None, tuple(tried))
