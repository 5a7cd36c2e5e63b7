"""Exchanges facts with a server, page by page, until both have all.

Each page is complete in itself, and missing facts are found by comparison. An exchange may therefore be interrupted at
any point, repeated, or run in parallel with another one: the next exchange adds what is missing.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from app.archive.content import MAX_LENGTH
from app.archive.facts import (
    MAX_REFUSALS,
    Fact,
    RefusedFact,
    StoredRow,
    checked,
    stored_fact,
    too_long,
)
from app.archive.local_facts import LocalFacts

if TYPE_CHECKING:
    from app.archive.postgres import PostgresFacts

PAGE: Final = 200
PAGE_LENGTH: Final = 8 * MAX_LENGTH
"""Characters read at a time, however long the facts are."""
BUCKETS_AT_ONCE: Final = 16
"""Compared at a time: at most a sixteenth of the set."""


@dataclass(slots=True)
class Exchanged:
    """`refused`: rows of the other side that were not imported, of which `MAX_REFUSALS` are listed. `damaged`: facts
    of this side that were not sent."""

    sent: int = 0
    received: int = 0
    refused: list[RefusedFact] = field(default_factory=list)
    damaged: list[RefusedFact] = field(default_factory=list)
    refused_count: int = 0

    @property
    def is_whole(self) -> bool:
        return not self.refused_count and not self.damaged

    def refuse(self, rows: Sequence[RefusedFact]) -> None:
        self.refused += rows[: MAX_REFUSALS - len(self.refused)]
        self.refused_count += len(rows)


OnProgress = Callable[[Exchanged], None]
"""Called after each page; may raise to interrupt."""


def exchange(
    here: LocalFacts, there: "PostgresFacts", *, on_page: OnProgress = lambda _done: None, page: int = PAGE
) -> Exchanged:
    """Raises `UserError`; facts exchanged before that remain."""
    done = Exchanged()
    mine, theirs = here.digests(), there.digests()
    differing = [one for one in sorted(mine.keys() | theirs.keys()) if mine.get(one) != theirs.get(one)]
    for buckets in _parts(differing, BUCKETS_AT_ONCE):
        known, offered = here.rows(buckets), there.rows(buckets)
        # Includes facts that differ on both sides: one of them was altered and is reported.
        other = {id_: row for id_, row in offered.items() if id_ not in known or known[id_].digest != row.digest}
        done.refuse([too_long(id_) for id_, row in other.items() if row.length > MAX_LENGTH])
        for ids in _pages({id_: row for id_, row in other.items() if row.length <= MAX_LENGTH}, page):
            facts, refused = _sorted(map(checked, there.read(ids)))
            done.received += here.add(facts)
            done.refuse(refused)
            on_page(done)
        for facts, damaged in sendable(here, {id_: row for id_, row in known.items() if id_ not in offered}, page):
            done.sent += there.add(facts)
            done.damaged += damaged
            on_page(done)
    return done


def sendable(
    here: LocalFacts, rows: Mapping[str, StoredRow], page: int = PAGE
) -> Iterator[tuple[list[Fact], list[RefusedFact]]]:
    """Pages of these facts, and of those that were damaged since they were stored."""
    for ids in _pages(rows, page):
        yield _sorted(stored_fact(row, rows[str(row[0])].digest) for row in here.read(ids))


def _sorted(facts: Iterable[Fact | RefusedFact]) -> tuple[list[Fact], list[RefusedFact]]:
    good, refused = list[Fact](), list[RefusedFact]()
    for fact in facts:
        if isinstance(fact, Fact):
            good.append(fact)
        else:
            refused.append(fact)
    return good, refused


def _pages(rows: Mapping[str, StoredRow], page: int) -> Iterator[Sequence[str]]:
    """Ids of at most `page` rows and `PAGE_LENGTH` characters."""
    ids: list[str] = []
    length = 0
    for id_, row in rows.items():
        if ids and (len(ids) >= page or length + row.length > PAGE_LENGTH):
            yield ids
            ids, length = [], 0
        ids.append(id_)
        length += row.length
    if ids:
        yield ids


def _parts(buckets: Sequence[str], length: int) -> Iterator[Sequence[str]]:
    for start in range(0, len(buckets), length):
        yield buckets[start : start + length]
