"""Hash chain over the audit log: every row added or settled links to the one before.

The links are added by triggers, inside the transaction that writes the row, whichever program writes it. The chain
finds rows that were altered, removed or added afterwards. It has no key: whoever can write the file can recompute it,
and a log cut off at its end looks like an older one.
"""

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, NamedTuple

from protocol.translatable import marked

CHAIN_HASH: Final = "chain_hash"
"""The name of `chain_hash` in SQL."""


class AuditRow(NamedTuple):
    """A row of the audit log, unchecked. `settled_at` and what follows are None in the link of its start."""

    id: object
    module_id: object
    port: object
    origin: object
    at: object
    act: object
    frame: object
    detail: object
    """JSON as text."""
    settled_at: object
    outcome: object
    result: object


_COLUMNS: Final = AuditRow._fields
BEGUN: Final = _COLUMNS.index("settled_at")
"""Number of values that a row has from the start; the rest are its outcome."""
_ADD_LINK: Final = f"""
    INSERT INTO audit_chain (entry, previous, hash)
    SELECT NEW.id, last.hash, {CHAIN_HASH}(last.hash, {", ".join(f"NEW.{name}" for name in _COLUMNS)})
    FROM (SELECT coalesce((SELECT hash FROM audit_chain ORDER BY id DESC LIMIT 1), '') AS hash) AS last;
"""  # noqa: S608  fixed words

AUDIT_CHAIN_TABLES: Final[tuple[str, ...]] = (
    """
    CREATE TABLE audit_chain (
        id INTEGER PRIMARY KEY AUTOINCREMENT,
        entry INTEGER NOT NULL,
        previous TEXT NOT NULL UNIQUE,
        hash TEXT NOT NULL UNIQUE
    ) STRICT
    """,
    f"CREATE TRIGGER audit_began AFTER INSERT ON audit BEGIN {_ADD_LINK} END",
    f"CREATE TRIGGER audit_changed AFTER UPDATE ON audit BEGIN {_ADD_LINK} END",
    "UPDATE audit SET id = id",  # chains the rows that are there already
)
"""One step of the store's migrations."""


def chain_hash(previous: str, *row: str | int | None) -> str:
    text = json.dumps([previous, *row], ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


class ChainFault(Enum):
    """The value is English, translatable, with the place for the entry."""

    ALTERED = marked("Entry {entry} was altered.")
    MISSING = marked("Entry {entry} was removed.")
    FOREIGN = marked("Entry {entry} was added from outside.")
    BROKEN = marked("The chain is broken at entry {entry}.")


@dataclass(frozen=True, slots=True)
class AuditFault:
    """`entry`: its number in the log."""

    entry: int
    fault: ChainFault


def check_audit_chain(read: Callable[[str], list[Any]]) -> tuple[AuditFault, ...]:
    """What is wrong with the log that `read` queries, by entry; empty where it is whole. Raises what `read` does."""
    rows = {row[0]: row for row in read(f"SELECT {', '.join(_COLUMNS)} FROM audit")}  # noqa: S608
    links = [_Link(*row) for row in read("SELECT entry, previous, hash FROM audit_chain ORDER BY id")]
    return tuple(sorted(set(_faults(rows, links)), key=lambda one: (one.entry, one.fault.name)))


@dataclass(frozen=True, slots=True)
class _Link:
    entry: int
    previous: str
    hash: str


def _faults(rows: dict[int, tuple[Any, ...]], links: list[_Link]) -> Iterator[AuditFault]:
    last = ""
    by_entry: dict[int, list[_Link]] = {}
    for link in links:
        if link.previous != last:
            yield AuditFault(link.entry, ChainFault.BROKEN)
        last = link.hash
        by_entry.setdefault(link.entry, []).append(link)
    for entry, own in by_entry.items():
        row = rows.get(entry)
        if row is None:
            yield AuditFault(entry, ChainFault.MISSING)
        elif not _is_true(row, own):
            yield AuditFault(entry, ChainFault.ALTERED)
    for entry in rows.keys() - by_entry.keys():
        yield AuditFault(entry, ChainFault.FOREIGN)


def _is_true(row: tuple[Any, ...], links: list[_Link]) -> bool:
    """A row has a link from when it was written, and one from when it was settled, which happens once."""
    begun = (*row[:BEGUN], *(None for _ in _COLUMNS[BEGUN:]))
    states = [row] if len(links) == 1 else [begun, row]
    return [one.hash for one in links] == [
        chain_hash(one.previous, *state) for one, state in zip(links, states, strict=False)
    ]
