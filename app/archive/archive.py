"""The facts of all stations: those of this one in its store, those of others in a second file beside it.

The second file has the same table. It is neither copied nor checked for an act, and may be thrown away, as everything
in it comes again. Whatever came from outside is there, also what claims to be of this station: nothing that decides
here reads it.
"""

import logging
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from typing import NamedTuple, TypeVar

from app.records.verification import StationNames
from app.store.fact_store import Facts, Store
from app.store.opening import StoreTrouble, connect, trouble_of
from app.store.rows import AHEAD, StationNamed, last_id_of

_log = logging.getLogger(__name__)
Result = TypeVar("Result")

OTHERS_FILE = "archive.sqlite"
# Of 4 kB. An act's intent waits at the disk for as much as is being written there, so that it is little at a time.
CHECKPOINT_PAGES = 100
# Rows of a place that are left out: remembered there and for that day, so that they are fetched and named once. Not for
# longer and not for other places: the id of a row that was altered is that of a good one, which may still come.
_REFUSED = """
    CREATE TABLE IF NOT EXISTS refused (
        place TEXT NOT NULL, id TEXT NOT NULL, why TEXT NOT NULL, "on" TEXT NOT NULL, PRIMARY KEY (place, id)
    ) STRICT
"""

_OF_BOTH = "CREATE TEMP VIEW facts AS SELECT * FROM main.facts UNION ALL SELECT * FROM own.facts"


class ArchiveStatus(NamedTuple):
    """`stations`: what they call themselves, by key. `ahead`: stations with facts of more than a day from now, which
    count for nothing."""

    facts: int
    own: int
    stations: dict[str, str]
    ahead: list[str]


class Exchanged(NamedTuple):
    """What is known of the exchanges with a place. `last_at`: of the last complete one, ISO 8601. `not_shared`: facts
    of this station that are not known to be there."""

    last_at: str | None
    not_shared: int


class Archive:
    """Every method may block, is for no port's and no window's thread, and raises `StoreTrouble`."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.path = store.folder / OTHERS_FILE

    @contextmanager
    def opened(self) -> Iterator[sqlite3.Connection]:
        """The file of the others as `main`, the store as `own`, and `facts` of both. The store is read only: else a
        transaction of an exchange would hold it, too, and an act's intent would wait for each page."""
        self.store.opened.result()
        try:
            with closing(self._connect()) as connection:
                connection.execute("ATTACH ? AS own", (f"{self.store.path.as_uri()}?mode=ro",))
                connection.execute(_OF_BOTH)
                yield connection
        except sqlite3.Error as error:
            raise trouble_of(error, self.path) from error

    def read(self, work: Callable[[Facts], Result]) -> Result:
        """`work` reads the facts of all stations as if they were in one file."""
        with self.opened() as connection:
            return work(Facts(connection, self.store.station, lambda: datetime.now(UTC)))

    def status(self) -> ArchiveStatus:
        def read(facts: Facts) -> ArchiveStatus:
            query = "SELECT (SELECT count(*) FROM main.facts), (SELECT count(*) FROM own.facts)"
            others, own = facts.connection.execute(query).fetchone()
            later = "SELECT DISTINCT station FROM facts WHERE id > ? ORDER BY station"
            ahead = facts.connection.execute(later, (last_id_of(datetime.now(UTC) + AHEAD),))
            return ArchiveStatus(others + own, own, dict(introductions(facts)), [station for (station,) in ahead])

        return self.read(read)

    @property
    def server(self) -> str | None:
        """The address of the one that is set, without its password."""
        server: str | None = self.store.state("server")
        return server

    def exchanged(self, place: str) -> Exchanged:
        """Quick; only of this station's store."""
        noted = self.store.state(f"exchanged:{place}") or {}
        query = "SELECT count(*) FROM facts WHERE rowid > ?"
        last = noted.get("last", 0)
        count = self.store.read(lambda facts: facts.connection.execute(query, (last,)).fetchone()[0])
        return Exchanged(noted.get("at"), count)

    def note_exchange(self, place: str, last: int) -> None:
        """A complete one, with the own facts up to the row `last`: one thread writes them, so that rows have ascending
        numbers in the order in which they were committed."""
        at = datetime.now(UTC).isoformat(timespec="seconds")
        self.store.set_state(f"exchanged:{place}", {"at": at, "last": last}).result()

    def _connect(self) -> sqlite3.Connection:
        """A file that cannot be used is thrown away."""
        try:
            connection = connect(self.path, is_checked=False)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError as error:
            _log.warning("%s is begun again: %s", self.path, error)
            for end in ("", "-wal", "-shm"):
                self.path.with_name(self.path.name + end).unlink(missing_ok=True)
            connection = connect(self.path, is_checked=False)
        connection.execute("PRAGMA synchronous = NORMAL")  # what a lost power takes comes again
        connection.execute(f"PRAGMA wal_autocheckpoint = {CHECKPOINT_PAGES}")
        connection.execute(_REFUSED)
        return connection


def introductions(facts: Facts) -> list[tuple[str, str]]:
    """The keys of stations with what they call themselves, the oldest first. A name is no trust, and only a station
    itself introduces itself."""
    kept = facts.of_kind(StationNamed)
    return [(one.content.public_key, one.content.name) for one in kept if one.row.station == one.content.public_key]


def known_names(store: Store | None) -> StationNames:
    """What the stations of this store and its archive call themselves; nothing where they cannot be read."""
    if store is None:
        return StationNames()
    try:
        archive = Archive(store)
        names = archive.read(introductions) if archive.path.exists() else store.read(introductions)
        return StationNames(store.station, tuple(dict.fromkeys(names)))
    except StoreTrouble as error:
        _log.warning("The names of stations cannot be read: %s", error)
        return StationNames()
