"""Chains of the facts of all stations, verifiable on every computer that has their facts.

An altered record fails its own signature. A chain also shows that a record is missing or duplicated.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from app.archive.archive import Archive
from app.archive.facts import Fact
from app.store.facts import FactKind
from app.store.former import link_hash
from app.text.messages import UserMessage


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainState:
    """`missing`: number of links that are not here (yet). `faults`: what is wrong with it."""

    station: str
    count: int
    missing: int
    faults: tuple[UserMessage, ...] = ()


def chains_in(archive: Archive) -> list[ChainState]:
    """For every station the chain of its facts. This station's store is verified as a whole. Raises `UserError`."""
    stations: dict[str, list[Fact]] = {}
    for fact in archive.of_kind(None):
        stations.setdefault(fact.station, []).append(fact)
    own_faults = tuple(fault.message for fault in archive.own.faults())
    return [
        ChainState(
            station=station,
            count=len(chain),
            missing=_missing(_links(chain)),
            faults=own_faults if station == archive.public else (),
        )
        for station, chain in sorted(stations.items())
    ]


def in_chain_order(facts: Sequence[Fact]) -> Iterator[Fact]:
    """Each behind those that its station recorded before it, whatever the clock said; what follows none by its time."""
    there = {(fact.station, fact.hash) for fact in facts}
    following: dict[tuple[str, object], list[Fact]] = {}
    for fact in facts:
        before = (fact.station, fact.content.get("previous"))
        following.setdefault(before if before in there else ("", None), []).append(fact)
    waiting = sorted(following.get(("", None), ()), key=lambda fact: (fact.made_at, fact.id), reverse=True)
    while waiting:
        fact = waiting.pop()
        yield fact
        waiting += following.get((fact.station, fact.hash), ())


def _links(facts: Iterable[Fact]) -> Iterator[tuple[object, object]]:
    """The former audit log was a chain of its own within its facts."""
    for fact in facts:
        if fact.kind != FactKind.AUDIT.value:
            yield fact.content.get("previous"), fact.hash
            continue
        yield None, fact.hash
        if link_hash(fact.content["previous"], fact.content["entry"]) == fact.content["hash"]:
            yield fact.content["previous"], fact.content["hash"]


def _missing(links: Iterable[tuple[object, object]]) -> int:
    """Number of links that are referred to as predecessors and are missing. The first link has no predecessor."""
    pairs = list(links)
    there = {hash_ for _, hash_ in pairs}
    return len({previous for previous, _ in pairs if previous} - there)
