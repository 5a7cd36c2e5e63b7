"""The archive of this station: the facts of all stations, its own in the store, those of others in a file beside it.

A separate file (SQLite), so that opening, copying and writing the store stay fast. It may be lost: what is in it comes
again from the server or from files.
"""

import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from app.archive.facts import (
    BUCKET,
    FACT_COLUMNS,
    Digests,
    Fact,
    FactRow,
    StoredRow,
    digests_of,
    fact_of,
    make_fact,
    row_digest,
)
from app.records.verification import StationNames
from app.stations.station import encoded, find_station, own_station
from app.store.database import Clock, open_database, utc_now
from app.store.facts import FactKind, Facts, fact_hash
from app.store.former import ARCHIVE
from app.store.station_names import introductions
from app.store.store import Store
from app.text.messages import clean
from app.text.user_error import UserError

_log = logging.getLogger(__name__)

FACTS_FILE: Final = "archive.sqlite"
_COLUMNS: Final = ", ".join(FACT_COLUMNS)
PAGE: Final = 200
"""Facts that are signed between two commits."""
_TO_SIGN: Final = (
    "SELECT number, kind, made_at, payload, hash FROM facts WHERE id IS NULL AND number > ? ORDER BY number LIMIT ?"
)
_SIGN: Final = "UPDATE facts SET id = ?, station = ?, signature = ?, digest = ? WHERE number = ? AND id IS NULL"


class Archive:
    """Opens what is beside the store: the key of this station, which is made if it is missing, and the file of the
    others, of which a damaged one is set aside. Every method may block and raises `UserError`; thread-safe."""

    def __init__(self, store: Store, *, clock: Clock = utc_now) -> None:
        self.store, self.own = store, store.facts
        folder = store.database.path.parent
        self.station = own_station(folder)
        self.others = open_database(folder, ARCHIVE, clock=clock, name=FACTS_FILE)
        self.others.attach(store.database.path, "own")
        self._unreadable: set[str] = set()

    def close(self) -> None:
        """The store stays open."""
        self.others.close()

    @property
    def public(self) -> str:
        """This station's public key, as used in facts."""
        return encoded(self.station.public)

    # The set

    def digests(self) -> Digests:
        return digests_of(dict(self._read("SELECT id, digest FROM facts WHERE id IS NOT NULL")))

    def rows(self, buckets: Sequence[str]) -> Mapping[str, StoredRow]:
        places = ", ".join("?" * len(buckets))
        query = f"SELECT id, digest, length(payload) FROM facts WHERE substr(id, 1, {BUCKET}) IN ({places})"  # noqa: S608
        return {id_: StoredRow(digest, length) for id_, digest, length in self._read(query, buckets)}

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        return list({row[0]: row for row in self._by_ids(_COLUMNS, ids)}.values())

    def add(self, facts: Sequence[Fact]) -> int:
        if not facts:
            return 0
        known = {row[0] for row in self._by_ids("id", [fact.id for fact in facts])}
        new = {fact.id: fact for fact in facts if fact.id not in known}
        with self.others.transaction():
            self.others.write_all(
                f"INSERT INTO facts ({_COLUMNS}, digest, module, link, hash) "  # noqa: S608
                "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
                [(*fact.row, row_digest(fact.row), fact.module, None, fact.hash) for fact in new.values()],
            )
        return len(new)

    def collect(self) -> int:
        """Sign what this station recorded since; returns the number of new facts. Those that were altered, or that
        nobody could read, are left out."""
        database, count, last = self.own.database, 0, 0
        while rows := database.read(_TO_SIGN, (last, PAGE)):
            last = rows[-1][0]
            signed = [values for row in rows if (values := self._signed(*row)) is not None]
            with database.transaction():  # short: acts wait for it
                database.write_all(_SIGN, signed)
            count += len(signed)
        return count

    def _signed(self, number: int, kind: str, made_at: str, payload: str, hash_: str) -> tuple[object, ...] | None:
        try:
            if fact_hash(kind, made_at, payload) != hash_:
                raise ValueError("it was altered")
            fact = make_fact(kind, made_at, payload, self.station)
        except ValueError as error:
            self._warn(str(number), error)
            return None
        return fact.id, fact.station, fact.signature, row_digest(fact.row), number

    # Queries

    def of_kind(self, kind: FactKind | None, module: str | None = None) -> list[Fact]:
        """None: of all kinds. `module`: only those of modules with this name. Without those that an older version
        imported and nobody can read; they are named once."""
        query = f"SELECT {_COLUMNS} FROM facts WHERE id IS NOT NULL"  # noqa: S608
        values = []
        if kind is not None:
            query, values = f"{query} AND kind = ?", [kind.value]
        if module is not None:
            query, values = f"{query} AND module = ?", [*values, module]
        facts = {}
        for row in self._read(f"{query} ORDER BY number", values):
            try:
                facts[row[0]] = fact_of(row)
            except ValueError as error:
                self._warn(str(row[0]), error)
        return list(facts.values())

    def counts(self) -> Mapping[str, int]:
        """Number of facts by station."""
        return Counter(dict(self._read("SELECT id, station FROM facts WHERE id IS NOT NULL")).values())

    # Progress of exchanges

    def last_number(self) -> int:
        """Of this station's facts that are signed: later ones cannot have been exchanged."""
        query = "SELECT coalesce(max(number), 0) FROM facts WHERE id IS NOT NULL"
        return int(self.own.database.read(query)[0][0])

    def not_shared(self, place: str | None) -> tuple[int, str | None]:
        """Number of this station's facts that are not known to be on this server; when all of them were last."""
        done = self.own.state(f"exchange:{place}") or {}
        query = "SELECT count(*) FROM facts WHERE number > ? AND id IS NOT NULL"
        return int(self.own.database.read(query, (done.get("last", 0),))[0][0]), done.get("at")

    def note_exchange(self, place: str, last: int) -> None:
        """A complete exchange: this station's facts up to the number `last` are there."""
        self.own.set_state(f"exchange:{place}", {"at": self.own.database.now(), "last": last})

    def _warn(self, id_: str, error: ValueError) -> None:
        if id_ not in self._unreadable:
            _log.warning("The content of fact %s cannot be read: %s", clean(id_, longest=64), error)
        self._unreadable.add(id_)

    def _by_ids(self, columns: str, ids: Sequence[str]) -> list[FactRow]:
        """Of a page of facts."""
        places = ", ".join("?" * len(ids))
        return self._read(f"SELECT {columns} FROM facts WHERE id IN ({places})", ids)  # noqa: S608

    def _read(self, query: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        """Of both files: after a store was restored from a copy, later facts of this station may come from others."""
        queries = (query.replace("FROM facts", f"FROM {file}.facts") for file in ("main", "own"))
        return [row for statement in queries for row in self.others.read(statement, values)]


def station_names(store: Store | None, folder: Path) -> StationNames:
    """What the stations of this store and its archive call themselves. Creates no file; an archive that cannot be read
    has none."""
    try:
        station = find_station(folder)
    except UserError as error:
        _log.warning("%s", error)
        station = None
    names = [] if store is None else introductions(store.facts)
    if (folder / FACTS_FILE).exists():
        try:
            with closing(open_database(folder, ARCHIVE, name=FACTS_FILE)) as others:
                names += introductions(Facts(others))
        except UserError as error:
            _log.warning("The archive cannot be read: %s", error)
    return StationNames(None if station is None else station.public.hex(), names)
