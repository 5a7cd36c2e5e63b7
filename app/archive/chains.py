"""Chains of checks and audit logs of all stations, verifiable on every computer that has their facts.

An altered record fails its own signature. A chain also shows that a record is missing or duplicated.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from app.archive.content import FactKind
from app.archive.facts import Fact
from app.archive.local_facts import LocalFacts
from app.records.check_store import CheckStore
from app.records.record import Record
from app.records.verification import RecordState, chain_name, verify
from app.store.audit_chain import chain_hash
from app.text.messages import UserMessage


class ArchivedRecords:
    """`StoredRecords` for `verify`: the checks of this computer, and those of other stations."""

    def __init__(self, facts: LocalFacts | None, own: CheckStore | None = None) -> None:
        self._facts, self._own = facts, own

    def record(self, hash_: str) -> Record | None:
        found = self._own.record(hash_) if self._own is not None else None
        linked = self._facts.linked(hash_) if self._facts is not None and found is None else ()
        return found or next((record for fact in linked if (record := record_of(fact)) is not None), None)

    def same_number(self, record: Mapping[str, object]) -> str | None:
        found = self._own.same_number(record) if self._own is not None else None
        module = record.get("module")
        if found is not None or self._facts is None or not isinstance(module, str):
            return found
        others = (record_of(fact) or {} for fact in self._facts.of_kind(FactKind.CHECK, module))
        return next((str(one.get("hash")) for one in others if _is_double(one, record)), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainState:
    """`missing`: number of links that are not here (yet). `faults`: what is wrong with it."""

    station: str
    module: str | None
    is_audit: bool
    count: int
    missing: int
    faults: tuple[UserMessage, ...] = ()


def record_of(fact: Fact) -> Record | None:
    record = fact.content.get("record")
    return record if isinstance(record, dict) else None


def chains_in(facts: LocalFacts) -> list[ChainState]:
    """For every station one chain of its audit log, and one of checks per module. Raises `UserError`."""
    return [*_audit_chains(facts), *_check_chains(facts)]


def _check_chains(facts: LocalFacts) -> list[ChainState]:
    chains: dict[tuple[str, object, object], list[Record]] = {}
    for fact in facts.of_kind(FactKind.CHECK):
        record = record_of(fact)
        if record is not None:
            chains.setdefault((fact.station, *chain_name(record)), []).append(record)
    states = []
    kept = ArchivedRecords(facts)
    for (station, module, _adapter), records in sorted(chains.items(), key=lambda one: tuple(map(str, one[0]))):
        verified = [verify(one, kept) for one in records]
        bad = (RecordState.ALTERED, RecordState.CHAIN_BROKEN, RecordState.UNREADABLE)
        faults = [one.sentences()[0] for one in verified if one.state in bad]
        links = _missing((one.get("previous"), one.get("hash")) for one in records)
        name = module if isinstance(module, str) else None
        states.append(ChainState(station=station, module=name, is_audit=False, count=len(records), missing=links,
                                 faults=tuple(faults)))  # fmt: skip
    return states


def _audit_chains(facts: LocalFacts) -> list[ChainState]:
    chains: dict[str, list[Mapping[str, Any]]] = {}
    for fact in facts.of_kind(FactKind.AUDIT):
        chains.setdefault(fact.station, []).append(fact.content)
    return [
        ChainState(station=station, module=None, is_audit=True, count=len(links),
                   missing=_missing((one.get("previous"), one.get("hash")) for one in links if _is_link(one)))
        for station, links in sorted(chains.items())
    ]  # fmt: skip


def _missing(links: Iterable[tuple[object, object]]) -> int:
    """Number of links that are referred to as predecessors and are missing. The first link has no predecessor."""
    pairs = list(links)
    there = {hash_ for _, hash_ in pairs}
    return sum(1 for previous in Counter(previous for previous, _ in pairs) if previous and previous not in there)


def _is_link(content: Mapping[str, Any]) -> bool:
    return bool(chain_hash(content["previous"], *content["entry"]) == content["hash"])


def _is_double(one: Record, record: Mapping[str, object]) -> bool:
    if one.get("hash") == record.get("hash"):
        return False
    return all(one.get(key) == record.get(key) for key in ("number", "module", "station"))
