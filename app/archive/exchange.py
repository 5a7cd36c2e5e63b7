"""Exchanges facts between two sets, page by page, until both have all.

Each page is complete in itself, and missing facts are found by comparison. An exchange may therefore be interrupted at
any point, repeated, or run in parallel with another one: the next exchange adds what is missing.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from app.archive.fact_set import FactSet
from app.archive.facts import Fact, FactRefused, FactRow, RefusedFact, checked, stored_fact

PAGE: Final = 200
BUCKETS_AT_ONCE: Final = 16
"""Compared at a time: at most a sixteenth of the set."""
MAX_REFUSALS: Final = 1000
"""Listed individually; further ones are only counted."""


@dataclass(slots=True)
class Exchanged:
    """`refused`: facts of the other side that were not imported. `damaged`: facts of this side that were not sent."""

    sent: int = 0
    received: int = 0
    refused: list[RefusedFact] = field(default_factory=list)
    damaged: list[RefusedFact] = field(default_factory=list)
    refused_count: int = 0

    @property
    def is_whole(self) -> bool:
        return not self.refused_count and not self.damaged


OnProgress = Callable[[Exchanged], None]
"""Called after each page; may raise to interrupt."""


def exchange(
    here: FactSet,
    there: FactSet,
    *,
    sends: bool = True,
    receives: bool = True,
    on_page: OnProgress = lambda _done: None,
    page: int = PAGE,
) -> Exchanged:
    """`here` is this computer. Raises `ArchiveTrouble`; facts exchanged before that remain."""
    done = Exchanged()
    mine, theirs = here.digests(), there.digests()
    differing = [one for one in sorted(mine.keys() | theirs.keys()) if mine.get(one) != theirs.get(one)]
    for buckets in _parts(differing, BUCKETS_AT_ONCE):
        known, offered = here.rows(buckets), there.rows(buckets)
        if receives:
            # Includes facts that differ on both sides: one of them was altered and is reported.
            for ids in _parts([one for one, digest in offered.items() if known.get(one) != digest], page):
                facts, refused = _sorted(there.read(ids), checked)
                done.received += here.add([one for one in facts if one.id not in known])
                done.refused += refused[: MAX_REFUSALS - len(done.refused)]
                done.refused_count += len(refused)
                on_page(done)
        if sends:
            for ids in _parts([one for one in known if one not in offered], page):
                facts, damaged = _sorted(here.read(ids), partial(_own_fact, known))
                done.sent += there.add(facts)
                done.damaged += damaged
                on_page(done)
    return done


def _own_fact(known: Mapping[str, str], row: FactRow) -> Fact:
    return stored_fact(row, known[str(row[0])])


def _sorted(rows: Sequence[FactRow], check: Callable[[FactRow], Fact]) -> tuple[list[Fact], list[RefusedFact]]:
    facts, refused = [], []
    for row in rows:
        try:
            facts.append(check(row))
        except FactRefused as error:
            refused.append(error.refusal)
    return facts, refused


def _parts(ids: Sequence[str], length: int) -> Iterator[Sequence[str]]:
    for start in range(0, len(ids), length):
        yield ids[start : start + length]
