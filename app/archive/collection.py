"""Creates facts from what this station has recorded in its store, which is not changed.

Append-only tables are read from where the last collection ended. Small tables whose rows may change are read
completely, and each state of a row is a fact. Nothing is collected twice: equal facts have equal ids.
"""

import json
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from app.archive.content import FactKind, utc_time
from app.archive.facts import Fact, fact_id, make_fact, payload_of
from app.archive.local_facts import LocalFacts
from app.stations.station import Station, encoded
from app.store.audit_chain import BEGUN, chain_hash
from app.store.store import Store

_log = logging.getLogger(__name__)
PAGE: Final = 200
"""Rows between two commits."""


class _New(NamedTuple):
    kind: FactKind
    made_at: str
    content: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class _Source:
    """`query` returns the row's number first. `is_whole`: read from the start each time."""

    name: str
    query: str
    facts_of: Callable[[tuple[Any, ...]], Iterator[_New]]
    is_whole: bool = False


def collect(store: Store, facts: LocalFacts, station: Station) -> int:
    """Return the number of new facts. Raises `UserError`; facts added before that remain."""
    return sum(_collect(source, store, facts, station) for source in _SOURCES)


def _collect(source: _Source, store: Store, facts: LocalFacts, station: Station) -> int:
    query = f"SELECT * FROM ({source.query}) WHERE number"  # noqa: S608
    last, added = _last(source, store, facts, station), 0
    while rows := store.database.read(f"{query} > ? ORDER BY number LIMIT {PAGE}", (last,)):
        new = [fact for row in rows for fact in _facts_of(source, row)]
        last = rows[-1][0]
        with facts.transaction():
            added += facts.add(_unknown(new, facts, station))
            facts.note_collected(source.name, last)
    return added


def _last(source: _Source, store: Store, facts: LocalFacts, station: Station) -> int:
    """The row after which to continue; from the start if that row differs from the collected one, because the store was
    restored from a copy."""
    last = 0 if source.is_whole else facts.last_collected(source.name)
    if not last:
        return 0
    rows = store.database.read(f"SELECT * FROM ({source.query}) WHERE number = ?", (last,))  # noqa: S608
    ids = [_id(one, encoded(station.public)) for row in rows for one in _facts_of(source, row)]
    return last if ids and facts.has(ids) == set(ids) else 0


def _facts_of(source: _Source, row: tuple[Any, ...]) -> list[_New]:
    """Skips rows that were damaged or altered: they prove nothing."""
    try:
        return list(source.facts_of(row))
    except (ValueError, TypeError, KeyError):
        _log.warning("Row %s of %s is damaged and is not shared", row[0], source.name)
        return []


def _unknown(new: Sequence[_New], facts: LocalFacts, station: Station) -> list[Fact]:
    """Checked before signing, which takes longer."""
    public = encoded(station.public)
    by_id = {_id(one, public): one for one in new}
    known = facts.has(list(by_id))
    made = []
    for id_, row in by_id.items():
        if id_ not in known:
            try:
                made.append(make_fact(*row, station))
            except ValueError as error:
                _log.warning("A %s of %s is not shared, nobody could read it: %s", row.kind.value, row.made_at, error)
    return made


def _id(new: _New, public: str) -> str:
    return fact_id(new.kind.value, public, new.made_at, payload_of(new.content))


def _module(row: tuple[Any, ...]) -> Iterator[_New]:
    _number, name, adapter, first_seen_at = row
    yield _New(FactKind.MODULE, utc_time(first_seen_at), {"module": name, "adapter": adapter})


def _trigger_record(row: tuple[Any, ...]) -> Iterator[_New]:
    _number, module, place, raw, first_seen_at, judgement, judged_at, note = row
    content = {"module": module, "place": place, "raw": bytes.fromhex(raw).hex()}
    yield _New(FactKind.TRIGGER_RECORD, utc_time(first_seen_at), content)
    if judged_at is not None:
        said = {**content, "judgement": judgement, "note": note}
        yield _New(FactKind.JUDGEMENT, utc_time(judged_at), said)


def _snapshot(row: tuple[Any, ...]) -> Iterator[_New]:
    number, module, port, taken_at, reason, boot_count, settings = row
    yield _New(FactKind.SNAPSHOT, utc_time(taken_at), {
        "number": number, "module": module, "port": port, "reason": reason, "boot_count": boot_count,
        "settings": json.loads(settings),
    })  # fmt: skip


def _check(row: tuple[Any, ...]) -> Iterator[_New]:
    number, module, at, record = row
    yield _New(FactKind.CHECK, utc_time(at), {"number": number, "module": module, "record": json.loads(record)})


def _guided_test(row: tuple[Any, ...]) -> Iterator[_New]:
    number, module, adapter, at, who, kind, verdict, is_simulated, program, measured = row
    yield _New(FactKind.GUIDED_TEST, utc_time(at), {
        "number": number, "module": module, "adapter": adapter, "who": who, "test": kind, "verdict": verdict,
        "is_simulated": bool(is_simulated), "program": program, "measured": json.loads(measured),
    })  # fmt: skip


def _audit_link(row: tuple[Any, ...]) -> Iterator[_New]:
    """The row as it was when the link was added: without its outcome, or with it. A row that fits neither was altered;
    `dps-s verify --log` reports it."""
    number, previous, hash_, module, *settled = row
    begun = [*settled[:BEGUN], None, None, None]
    entry = next((one for one in (settled, begun) if chain_hash(previous, *one) == hash_), None)
    if entry is None:
        raise ValueError(hash_)
    yield _New(FactKind.AUDIT, utc_time(entry[BEGUN] or entry[4]), {
        "number": number, "module": module, "previous": previous, "hash": hash_, "entry": entry,
    })  # fmt: skip


def _settlement(row: tuple[Any, ...]) -> Iterator[_New]:
    _number, at, content = row
    yield _New(FactKind.SETTLEMENT, utc_time(at), json.loads(content))


_SOURCES: Final = (
    _Source("modules", "SELECT id AS number, name, adapter, first_seen_at FROM modules", _module, is_whole=True),
    _Source(
        "trigger_records",
        "SELECT t.id AS number, m.name, t.place, t.raw, t.first_seen_at, t.judgement, t.judged_at, t.note "
        "FROM trigger_records t JOIN modules m ON m.id = t.module_id",
        _trigger_record,
        is_whole=True,
    ),
    _Source(
        "settings_snapshots",
        "SELECT s.id AS number, m.name, s.port, s.taken_at, s.reason, s.boot_count, s.settings "
        "FROM settings_snapshots s LEFT JOIN modules m ON m.id = s.module_id",
        _snapshot,
    ),
    _Source(
        "preflight_checks",
        "SELECT c.id AS number, m.name, c.at, c.record FROM preflight_checks c LEFT JOIN modules m "
        "ON m.id = c.module_id",
        _check,
    ),
    _Source(
        "guided_tests",
        "SELECT g.id AS number, m.name, g.adapter, g.at, g.who, g.kind, g.verdict, g.is_simulated, g.program, "
        "g.measured FROM guided_tests g LEFT JOIN modules m ON m.id = g.module_id",
        _guided_test,
    ),
    _Source(
        "audit_chain",
        "SELECT l.id AS number, l.previous, l.hash, m.name, a.id, a.module_id, a.port, a.origin, a.at, a.act, "
        "a.frame, a.detail, a.settled_at, a.outcome, a.result "
        "FROM audit_chain l JOIN audit a ON a.id = l.entry LEFT JOIN modules m ON m.id = a.module_id",
        _audit_link,
    ),
    _Source("module_settlements", "SELECT id AS number, at, content FROM module_settlements", _settlement),
)
