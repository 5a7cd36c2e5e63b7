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
from typing import Any, NamedTuple, TypeVar

from app.records.verification import StationNames
from app.store.fact_store import Facts, Store
from app.store.kinds import StationNamed
from app.store.opening import connect
from app.store.rows import AHEAD, fact_id
from app.store.trouble import StoreTrouble, trouble_of

_log = logging.getLogger(__name__)
Result = TypeVar("Result")

OTHERS_FILE = "archive.sqlite"
# Rows of a place that are left out: remembered there and for that day, so that they are fetched and named once. Not for
# longer and not for other places: the id of a row that was altered is that of a good one, which may still come.
_REFUSED = """
    CREATE TABLE IF NOT EXISTS refused (
        place TEXT NOT NULL, id TEXT NOT NULL, why TEXT NOT NULL, "on" TEXT NOT NULL, PRIMARY KEY (place, id)
    ) STRICT
"""
_EXCHANGED = "exchanged:"


class ArchiveStatus(NamedTuple):
    """`not_shared`: facts of this station that are not known to be at the place. `last_at`: of the last complete
    exchange with it. `ahead`: stations with facts of more than a day from now, which count for nothing."""

    facts: int
    own: int
    stations: dict[str, str]
    """Names by key."""
    not_shared: int
    last_at: str | None
    ahead: list[str]


class Archive:
    """Every method may block, is for no port's and no window's thread, and raises `StoreTrouble`."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.path = store.folder / OTHERS_FILE

    @contextmanager
    def opened(self) -> Iterator[sqlite3.Connection]:
        """The file of the others, with the store beside it as `own`. Only the first may be written."""
        self.store.opened.result()
        try:
            with closing(self._connect()) as connection:
                connection.execute("ATTACH ? AS own", (str(self.store.path),))
                yield connection
        except sqlite3.Error as error:
            raise trouble_of(error, self.path) from error

    def read(self, work: Callable[[Facts], Result]) -> Result:
        """`work` reads the facts of all stations as if they were in one file."""
        with self.opened() as connection:
            connection.execute("CREATE TEMP VIEW facts AS SELECT * FROM main.facts UNION ALL SELECT * FROM own.facts")
            return work(Facts(connection, self.store.station, lambda: datetime.now(UTC)))

    def status(self, place: str | None) -> ArchiveStatus:
        """`place`: as an exchange with it is noted; None: of no place."""
        exchanged = self._exchanged(place)
        with self.opened() as connection:
            others = _number(connection, "SELECT count(*) FROM main.facts")
            own = _number(connection, "SELECT count(*) FROM own.facts")
            not_shared = _number(connection, "SELECT count(*) FROM own.facts WHERE rowid > ?", exchanged.get("last", 0))
        stations, ahead = self.read(lambda facts: (station_names(facts), _stations_ahead(facts)))
        return ArchiveStatus(others + own, own, stations, not_shared, exchanged.get("at"), ahead)

    def not_shared(self, place: str) -> int:
        """Quick; only of this station's store."""
        last = self._exchanged(place).get("last", 0)
        query = "SELECT count(*) FROM facts WHERE rowid > ?"
        return self.store.read(lambda facts: _number(facts.connection, query, last))

    def last_own(self) -> int:
        """What was written by now. Rows of the store have ascending numbers in the order of commits, as one writes."""
        return self.store.read(lambda facts: _number(facts.connection, "SELECT coalesce(max(rowid), 0) FROM facts"))

    def note_exchange(self, place: str, last: int) -> None:
        """A complete one."""
        at = datetime.now(UTC).isoformat(timespec="seconds")
        self.store.set_state(_EXCHANGED + place, {"at": at, "last": last}).result()

    def last_exchange(self, place: str) -> str | None:
        at = self._exchanged(place).get("at")
        return at if isinstance(at, str) else None

    def _exchanged(self, place: str | None) -> dict[str, Any]:
        return {} if place is None else self.store.state(_EXCHANGED + place) or {}

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
        connection.execute(_REFUSED)
        return connection


def station_names(facts: Facts) -> dict[str, str]:
    """What stations call themselves, by key; of one that has several names the last. A name is no trust."""
    return dict(introductions(facts))


def introductions(facts: Facts) -> list[tuple[str, str]]:
    """Keys with names. Only a station itself introduces itself."""
    kept = facts.of_kind(StationNamed)
    return [(one.content.public_key, one.content.name) for one in kept if one.row.station == one.content.public_key]


def known_names(store: Store | None) -> StationNames:
    """What the stations of this store and its archive call themselves; of an archive that cannot be read nothing."""
    if store is None:
        return StationNames(None)
    try:
        archive = Archive(store)
        names = archive.read(introductions) if archive.path.exists() else store.read(introductions)
        return StationNames(store.station, names)
    except StoreTrouble as error:
        _log.warning("The names of stations cannot be read: %s", error)
        return StationNames(None)


def _stations_ahead(facts: Facts) -> list[str]:
    """An id begins with the time."""
    latest = (datetime.now(UTC) + AHEAD).isoformat()
    since = fact_id("", None, "", latest, "")[:12]
    rows = facts.connection.execute("SELECT DISTINCT station FROM facts WHERE id > ?", (since + "g",))
    return sorted(station for (station,) in rows)


def _number(connection: sqlite3.Connection, query: str, *values: object) -> int:
    return int(connection.execute(query, values).fetchone()[0])
