"""Chains of the facts and checks of all stations, verifiable on every computer that has their facts.

An altered record fails its own signature. A chain also shows that a record is missing or duplicated.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from app.archive.facts import Fact
from app.archive.local_facts import LocalFacts
from app.records.check_store import CheckStore
from app.records.record import Record
from app.records.verification import RecordState, chain_name, verify
from app.stations.station import Station, encoded
from app.store.database import Database
from app.store.facts import FactKind
from app.store.former import link_hash
from app.text.messages import UserMessage


class ArchivedRecords:
    """`StoredRecords` for `verify`: the checks of this station in its store, and those of others."""

    def __init__(self, own: Database | None, others: Database | None) -> None:
        both = ((own, True), (others, False))
        self._stores = [CheckStore(database, is_own=is_own) for database, is_own in both if database is not None]

    def record(self, hash_: str) -> Record | None:
        return next((record for store in self._stores if (record := store.record(hash_)) is not None), None)

    def same_number(self, record: Mapping[str, object]) -> str | None:
        return next((other for store in self._stores if (other := store.same_number(record)) is not None), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainState:
    """`is_audit`: of all facts of a station, else of the checks of one module. `missing`: number of links that are not
    here (yet). `faults`: what is wrong with it."""

    station: str
    module: str | None
    is_audit: bool
    count: int
    missing: int
    faults: tuple[UserMessage, ...] = ()


def chains_in(facts: LocalFacts, own: Station) -> list[ChainState]:
    """For every station the chain of its facts, and one of checks per module. `own`: this station, whose
    store is verified as by `dps-s verify --log`. Raises `UserError`."""
    stations: dict[str, list[Fact]] = {}
    checks: dict[tuple[str, object, object], list[Record]] = {}
    for fact in facts.of_kind(None):
        stations.setdefault(fact.station, []).append(fact)
        if record := fact.record:
            checks.setdefault((fact.station, *chain_name(record)), []).append(record)
    kept = ArchivedRecords(facts.own.database, facts.others)
    own_faults = tuple(fault.message for fault in facts.own.faults())
    return [
        *(ChainState(station=station, module=None, is_audit=True, count=len(chain), missing=_missing(_links(chain)),
                     faults=own_faults if station == encoded(own.public) else ())
          for station, chain in sorted(stations.items())),
        *(_checks(station, module, records, kept)
          for (station, module, _adapter), records in sorted(checks.items(), key=lambda chain: [*map(str, chain[0])])),
    ]  # fmt: skip


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


def _checks(station: str, module: object, records: Sequence[Record], kept: ArchivedRecords) -> ChainState:
    verified = [verify(record, kept) for record in records]
    bad = (RecordState.ALTERED, RecordState.CHAIN_BROKEN, RecordState.UNREADABLE)
    return ChainState(
        station=station, module=module if isinstance(module, str) else None, is_audit=False, count=len(records),
        missing=_missing((record.get("previous"), record.get("hash")) for record in records),
        faults=tuple(fault.sentences()[0] for fault in verified if fault.state in bad),
    )  # fmt: skip


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
