"""The facts of all stations: those of this one in its store, those of others in a second file beside it, and how both
are exchanged with a server or a file.

The second file has the same table. It is neither copied nor checked for an act, and may be thrown away, as everything
in it comes again. Whatever came from outside is there, also what claims to be of this station: nothing that decides
here reads it. `docs/archive.md` says how two sets of facts become one.
"""

import logging
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from msgspec import Meta, Struct, field

from app.archive.places import FilePlace, PostgresPlace, digests, is_server, lengths_in, rows_in
from app.records.verification import StationNames, is_of_row
from app.store import rows
from app.store.fact_store import Facts, Store, StoreError, connect, connect_to_read, is_whole, set_aside, unusable
from app.store.station import shown_key
from app.text.messages import clean
from protocol.translatable import marked

_log = logging.getLogger(__name__)

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
_DAMAGED = marked("The records of other stations are damaged, and kept as {file}: they come with the next exchange.")
PAGE_ROWS = 1000
PAGE_BYTES = 8_000_000
NAMED = 20


class StationName(Struct, forbid_unknown_fields=True):
    """`name`: what the station calls itself, which is no trust."""

    station: str
    name: str


class ArchiveStatus(Struct, forbid_unknown_fields=True):
    """As `dps-s archive status --json` prints it. `own`: facts of this station; `not_shared`: of these the ones that
    are not known to be on the server. `stations_ahead`: with facts of more than a day from now, which count for
    nothing."""

    station: str
    facts: rows.Count
    own: rows.Count
    stations: list[StationName]
    server: str | None
    not_shared: rows.Count
    last_sync_at: Annotated[str, Meta(extra_json_schema={"format": "date-time"})] | None
    stations_ahead: list[str]


@contextmanager
def all_facts(store: Store) -> Iterator[Facts]:
    """Give the facts of all stations as if they were in one file: the file of the others is `main`, the store is `own`.
    It may block, as all here that takes a store: not for a port's or the window's thread. Raises `StoreError`, also
    where the file of the others turns out to be damaged: the next time an empty one is made."""
    store.wait()
    path = store.folder / OTHERS_FILE
    try:
        with closing(connect(path)) as connection:
            connection.execute("PRAGMA synchronous = NORMAL")  # what a lost power takes comes again
            connection.execute(f"PRAGMA wal_autocheckpoint = {CHECKPOINT_PAGES}")
            connection.execute(_REFUSED)
            # Only read: else a transaction of an exchange would hold the store, too, and an intent wait for a page.
            connection.execute("ATTACH ? AS own", (f"{store.path.as_uri()}?mode=ro",))
            connection.execute("CREATE TEMP VIEW facts AS SELECT * FROM main.facts UNION ALL SELECT * FROM own.facts")
            yield Facts(connection, store.station)
    except sqlite3.OperationalError as error:  # a lock, a full disk or a missing permission: it is not bad
        raise unusable(path, error) from error
    except sqlite3.Error as error:
        if is_whole(path):
            raise unusable(store.path, error) from error
        _log.warning("%s is damaged, and replaced by an empty one: %s", path, error)
        raise StoreError(_DAMAGED, file=set_aside(path)) from error


def status_of(store: Store) -> ArchiveStatus:
    server = store.state("server")
    last_at, not_shared = exchanged(store, server or "")
    with all_facts(store) as facts:
        query = "SELECT (SELECT count(*) FROM main.facts), (SELECT count(*) FROM own.facts)"
        others, own = facts.connection.execute(query).fetchone()
        later = "SELECT DISTINCT station FROM facts WHERE id > ? ORDER BY station"
        # Only the ids of facts that were made later are greater.
        ahead = facts.connection.execute(later, (f"{rows.time_in_id(datetime.now(UTC) + rows.AHEAD)}g",))
        return ArchiveStatus(
            station=shown_key(store.station),
            facts=others + own,
            own=own,
            stations=[StationName(shown_key(key), name) for key, name in sorted(dict(introductions(facts)).items())],
            server=server,
            not_shared=not_shared,
            last_sync_at=last_at,
            stations_ahead=[shown_key(station) for (station,) in ahead],
        )


def exchanged(store: Store, place: str) -> tuple[str | None, int]:
    """When the last complete exchange with a place was, ISO 8601, and how many facts of this station are not known to
    be there. Quick, as only the store is read."""
    noted = store.state(f"exchanged:{place}") or {}
    # One thread writes them, so that rows have ascending numbers in the order in which they were committed.
    query, last = "SELECT count(*) FROM facts WHERE rowid > ?", noted.get("last", 0)
    count = store.read(lambda facts: facts.connection.execute(query, (last,)).fetchone()[0])
    return noted.get("at"), count


def introductions(facts: Facts) -> list[tuple[str, str]]:
    """The keys of stations with what they call themselves, the oldest first. A name is no trust, and only a station
    itself introduces itself."""
    kept = facts.of_kind(rows.StationNamed)
    return [(one.content.public_key, one.content.name) for one in kept if one.row.station == one.content.public_key]


def known_names(store: Store | None) -> StationNames:
    """Return what the stations of this store and its archive call themselves, as far as they can be read."""
    if store is None:
        return StationNames()
    names: list[tuple[str, str]] = []
    try:
        names = store.read(introductions)
        # Only read: nobody here would be told that the file of the others was set aside. There may be none.
        with closing(connect_to_read(store.folder / OTHERS_FILE)) as others:
            names += introductions(Facts(others, store.station))
    except (StoreError, sqlite3.Error) as error:
        _log.info("Names of stations cannot be read: %s", error)
    return StationNames(store.station, tuple(dict.fromkeys(names)))


# The exchange


class LeftOut(Struct, forbid_unknown_fields=True):
    """A row that was left out, as `dps-s archive sync --json` prints it."""

    id: str
    why: str


class Synced(Struct, forbid_unknown_fields=True):
    """The result of an exchange, as `dps-s archive sync --json` prints it. `left_out` are rows that are no facts, named
    when they are first met; `left_out_count` counts all of the place, also those that were named before that day."""

    place: str
    sent: rows.Count = 0
    received: rows.Count = 0
    left_out: list[LeftOut] = field(default_factory=list)
    left_out_count: rows.Count = 0


def sync(store: Store, address: str) -> Synced:
    """`address`: of a server, or a file. Raises `UserError`; what was exchanged before that stays."""
    with (
        closing(PostgresPlace(address) if is_server(address) else FilePlace(Path(address))) as place,
        all_facts(store) as facts,
    ):
        here = facts.connection
        last = here.execute("SELECT coalesce(max(rowid), 0) FROM own.facts").fetchone()[0]
        today = f"{datetime.now(UTC):%Y-%m-%d}"
        # After a day what was left out is looked at again.
        here.execute('DELETE FROM refused WHERE "on" <> ?', (today,))
        here.execute("CREATE TEMP TABLE left_out AS SELECT id FROM refused WHERE place = ?", (place.name,))
        left_out = {id_ for (id_,) in here.execute("SELECT id FROM left_out")}
        # With what was left out, else the two sides would never be equal.
        here.execute("CREATE TEMP VIEW known AS SELECT id FROM facts UNION ALL SELECT id FROM left_out")
        ours = digests(here, "known")
        theirs = place.buckets()
        differing = {one for one in ours.keys() | theirs.keys() if ours.get(one) != theirs.get(one)}
        done = Synced(place.name)
        for bucket in sorted(differing & theirs.keys()):
            there_ids = place.lengths(bucket)
            for ids in _pages(there_ids, there_ids.keys() - lengths_in(here, bucket).keys() - left_out):
                _receive(here, place, {id_: there_ids[id_] for id_ in ids}, today, done)
        # Afterwards, as the place may be full or write-protected.
        for bucket in sorted(differing & ours.keys()):
            here_ids = lengths_in(here, bucket)
            for ids in _pages(here_ids, here_ids.keys() - place.lengths(bucket).keys()):
                done.sent += place.add(sorted(rows_in(here, ids)))
        count = "SELECT count(*) FROM refused WHERE place = ?"
        done.left_out_count = here.execute(count, (place.name,)).fetchone()[0]
        at = datetime.now(UTC).isoformat(timespec="seconds")
        store.write_in_time(lambda facts: facts.set_state(f"exchanged:{place.name}", {"at": at, "last": last}))
        return done


def _receive(
    here: sqlite3.Connection, place: FilePlace | PostgresPlace, lengths: Mapping[str, int], today: str, done: Synced
) -> None:
    """Take one page: each row is checked, the good ones are kept and the others are remembered."""
    found = {row[0]: row for row in place.rows([id_ for id_ in lengths if lengths[id_] <= rows.MAX_CONTENT_BYTES])}
    good, bad = [], []
    for id_ in lengths:
        try:
            if id_ not in found:
                raise rows.BadRow("too large, or cannot be read")
            row, content = rows.check_row(found[id_])
            # The record of a check is verified once, where its row comes in.
            if isinstance(content, rows.PreflightCheck) and not is_of_row(content, row):
                raise rows.BadRow("its record says something else")
            good.append(row)
        except rows.BadRow as error:
            bad.append(LeftOut(id_, clean(str(error), longest=200)))
    before = here.total_changes
    with here:  # which commits, or rolls back where it fails
        here.execute("BEGIN IMMEDIATE")
        keep = f"INSERT INTO main.facts ({rows.COLUMNS}) VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING"  # noqa: S608
        here.executemany(keep, good)
        done.received += here.total_changes - before
        remember = "INSERT INTO refused VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"
        here.executemany(remember, [(place.name, one.id, one.why, today) for one in bad])
    done.left_out += bad[: NAMED - len(done.left_out)]


def _pages(lengths: Mapping[str, int], wanted: set[str]) -> Iterator[list[str]]:
    """These ids in their order. `lengths`: bytes of the content, by id."""
    page: list[str] = []
    size = 0
    for id_ in sorted(wanted):
        if page and (len(page) == PAGE_ROWS or size + lengths[id_] > PAGE_BYTES):
            yield page
            page, size = [], 0
        page.append(id_)
        size += min(lengths[id_], rows.MAX_CONTENT_BYTES)
    if page:
        yield page
