"""The facts known to this computer, its own and those of other stations, in a SQLite file beside the store.

A separate file, so that opening, copying and writing the store stay fast. Own facts can be recreated from the store,
those of other stations from the server or their files.
"""

import logging
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Final, NamedTuple

from app.archive.content import FactKind
from app.archive.fact_set import BUCKET, Digests, StoredRow, digests_of_rows
from app.archive.facts import FACT_COLUMNS, Fact, FactRow, fact_of, row_digest
from app.store.audit_chain import AuditRow
from app.store.database import Clock, Database, open_database, utc_now
from app.text.messages import UserMessage, clean
from app.text.user_error import UserError

_log = logging.getLogger(__name__)

FACTS_FILE: Final = "archive.sqlite"
_COLUMNS: Final = ", ".join(FACT_COLUMNS)
_MAX_VALUES: Final = 500
"""Maximum number of values in one SQL statement."""

_DETAIL: Final = f"json_extract(payload, '$.entry[{AuditRow._fields.index('detail')}]')"
FACT_TABLES: Final[tuple[tuple[str, ...], ...]] = (
    (
        """
        CREATE TABLE facts (
            number INTEGER PRIMARY KEY AUTOINCREMENT,
            id TEXT NOT NULL UNIQUE,
            kind TEXT NOT NULL,
            station TEXT NOT NULL,
            made_at TEXT NOT NULL,
            payload TEXT NOT NULL,
            signature TEXT NOT NULL,
            digest TEXT NOT NULL,
            module TEXT,
            link TEXT
        ) STRICT
        """,
        "CREATE INDEX facts_compared ON facts (id, digest)",
        "CREATE INDEX facts_by_module ON facts (module, station, kind)",
        "CREATE INDEX facts_by_link ON facts (link)",
        "CREATE INDEX facts_by_kind ON facts (kind, number)",
        "CREATE TABLE sources (name TEXT PRIMARY KEY, last INTEGER NOT NULL) STRICT",
        """
        CREATE TABLE exchanges (
            place TEXT PRIMARY KEY,
            at TEXT NOT NULL,
            last INTEGER NOT NULL
        ) STRICT
        """,
    ),
    (
        f"""
        UPDATE facts SET module = CASE WHEN json_valid(payload) THEN
            CASE WHEN json_valid({_DETAIL}) THEN json_extract({_DETAIL}, '$.module') END
        END WHERE kind = '{FactKind.AUDIT.value}'
        """,  # noqa: S608  fixed words
    ),
)
"""The second step: acts on a module are found by its name."""


class LastExchange(NamedTuple):
    """The last exchange with a server or a file. `last`: the number of the last local fact that is there, too."""

    place: str
    at: str
    last: int


class LocalFacts:
    """A `FactSet` with local queries. Thread-safe. Raises `UserError`."""

    def __init__(self, database: Database, notice: UserMessage | None = None) -> None:
        self.database = database
        self.notice = notice
        """Set if a damaged file was set aside."""
        self._unreadable: set[str] = set()

    def close(self) -> None:
        self.database.close()

    def transaction(self) -> AbstractContextManager[None]:
        return self.database.transaction()

    # The set

    def digests(self) -> Digests:
        return digests_of_rows(self._read("SELECT id, digest FROM facts"))

    def rows(self, buckets: Sequence[str]) -> Mapping[str, StoredRow]:
        places = ", ".join("?" * len(buckets))
        query = f"SELECT id, digest, length(payload) FROM facts WHERE substr(id, 1, {BUCKET}) IN ({places})"  # noqa: S608
        return {id_: StoredRow(digest, length) for id_, digest, length in self._read(query, buckets)}

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        return self._by_ids(_COLUMNS, ids)

    def add(self, facts: Sequence[Fact]) -> int:
        if not facts:
            return 0
        with self.database.transaction():
            before = self.last_number()
            self.database.write_all(
                f"INSERT INTO facts ({_COLUMNS}, digest, module, link) "  # noqa: S608
                "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
                [(*fact.row, row_digest(fact.row), *_lookup_key(fact)) for fact in facts],
            )
            return self.count_after(before)

    # Queries

    def has(self, ids: Sequence[str]) -> set[str]:
        return {str(row[0]) for row in self._by_ids("id", ids)}

    def of_kind(self, kind: FactKind, module: str | None = None) -> list[Fact]:
        """In the order of import; `module`: only those of modules with this name."""
        query = f"SELECT {_COLUMNS} FROM facts WHERE kind = ?"  # noqa: S608
        values: tuple[str, ...] = (kind.value,)
        if module is not None:
            query, values = f"{query} AND module = ?", (*values, module)
        return self._facts(f"{query} ORDER BY number", values)

    def linked(self, link: str) -> list[Fact]:
        """Facts with this hash of a check's record or of a link of the audit log."""
        query = f"SELECT {_COLUMNS} FROM facts WHERE link = ?"  # noqa: S608
        return self._facts(query, (link,))

    def counts(self) -> Mapping[str, int]:
        """Number of facts by station."""
        return dict(self._read("SELECT station, count(*) FROM facts GROUP BY station"))

    def last_number(self) -> int:
        return int(self._read("SELECT coalesce(max(number), 0) FROM facts")[0][0])

    def count_after(self, number: int, station: str | None = None) -> int:
        """Number of facts imported after `number`; `station`: only those of this station."""
        query = "SELECT count(*) FROM facts WHERE number > ?1 AND (?2 IS NULL OR station = ?2)"
        return int(self._read(query, (number, station))[0][0])

    # Progress of exchanges

    def last_collected(self, source: str) -> int:
        rows = self._read("SELECT last FROM sources WHERE name = ?", (source,))
        return rows[0][0] if rows else 0

    def note_collected(self, source: str, last: int) -> None:
        self._write(
            "INSERT INTO sources (name, last) VALUES (?, ?) ON CONFLICT (name) DO UPDATE SET last = excluded.last",
            (source, last),
        )

    def last_exchange(self, place: str) -> LastExchange | None:
        rows = self._read("SELECT place, at, last FROM exchanges WHERE place = ?", (place,))
        return LastExchange(*rows[0]) if rows else None

    def note_exchange(self, place: str, last: int) -> None:
        """A complete exchange: all facts up to the number `last` are there."""
        self._write(
            "INSERT INTO exchanges (place, at, last) VALUES (?, ?, ?) "
            "ON CONFLICT (place) DO UPDATE SET at = excluded.at, last = excluded.last",
            (place, self.database.now(), last),
        )

    def _facts(self, query: str, values: Sequence[object]) -> list[Fact]:
        """Without those that an older version imported and nobody can read; they are named once."""
        facts = []
        for row in self._read(query, values):
            try:
                facts.append(fact_of(row))
            except ValueError:
                if row[0] not in self._unreadable:
                    _log.warning("The content of fact %s cannot be read", clean(str(row[0]), longest=64))
                self._unreadable.add(row[0])
        return facts

    def _by_ids(self, columns: str, ids: Sequence[str]) -> list[FactRow]:
        found: list[FactRow] = []
        for start in range(0, len(ids), _MAX_VALUES):
            part = ids[start : start + _MAX_VALUES]
            places = ", ".join("?" * len(part))
            found += self._read(f"SELECT {columns} FROM facts WHERE id IN ({places})", part)  # noqa: S608
        return found

    def _read(self, query: str, values: Sequence[object] = ()) -> list[tuple]:  # type: ignore[type-arg]
        return self.database.read(query, values)

    def _write(self, statement: str, values: Sequence[object]) -> None:
        self.database.write(statement, values)


def open_facts(folder: Path, *, clock: Clock = utc_now) -> LocalFacts:
    """Open or create the file; a damaged one is set aside. Raises `UserError`."""
    opened = open_database(folder, clock=clock, migrations=FACT_TABLES, name=FACTS_FILE)
    return LocalFacts(opened.database, opened.set_aside.message if opened.set_aside is not None else None)


def find_facts(folder: Path) -> LocalFacts | None:
    """None if there is no archive or it cannot be read; never creates one."""
    try:
        return open_facts(folder) if (folder / FACTS_FILE).exists() else None
    except UserError as error:
        _log.warning("The archive cannot be read: %s", error)
        return None


def _lookup_key(fact: Fact) -> tuple[str | None, str | None]:
    """The name of the module and the hash of the chain's link."""
    content = fact.content
    record = content.get("record")
    link = record.get("hash") if isinstance(record, dict) else content.get("hash")
    return fact.module, link if isinstance(link, str) else None
