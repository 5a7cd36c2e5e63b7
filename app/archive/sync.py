"""The facts of all stations: this one and a place get the same rows, in both directions.

Both sides tell, for each three days, how many facts they have and a digest of their ids. Where these differ the ids are
compared, and the missing rows are copied in pages, each its own commit. Nothing is remembered from one exchange to the
next that could be wrong after a crash, a restored copy or a moved server: whatever is committed late, by whomever, is
in the next comparison. So an exchange may be broken off anywhere, repeated, and run beside others.
"""

import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from msgspec import Struct, field

from app import version
from app.archive.archive import Archive
from app.archive.places import BUCKET, Buckets, FilePlace, Place, digest_of, lengths_in, rows_in
from app.archive.server_url import SCHEMES
from app.records.verification import is_of_row
from app.store.fact_store import INSERT
from app.store.kinds import MAX_CONTENT_BYTES, PreflightCheck
from app.store.rows import BadRow, Row, check_row, content_of
from app.text.messages import clean

PAGE_ROWS = 1000
PAGE_BYTES = 8_000_000
NAMED = 20


class LeftOut(NamedTuple):
    id: str
    why: str


class Synced(Struct):
    """What an exchange did. `left_out`: rows that are no facts, named when they are first met; `left_out_count`: all of
    the place, also those that were named before that day."""

    sent: int = 0
    received: int = 0
    left_out: list[LeftOut] = field(default_factory=list)
    left_out_count: int = 0


OnPage = Callable[[Synced], None]
"""Called after each page; may raise to break off."""


def open_place(address: str) -> Place:
    """A server's address, or a file. Raises `UserError`."""
    if address.partition("://")[0].lower() in SCHEMES:
        from app.archive.postgres import open_server  # loads psycopg

        return open_server(address)
    return FilePlace(Path(address))


def sync(archive: Archive, address: str, on_page: OnPage = lambda _done: None) -> Synced:
    """Raises `UserError`; what was exchanged before that stays."""
    with closing(open_place(address)) as place, archive.opened() as here:
        last = archive.last_own()
        done = _sync(here, place, on_page)
        archive.note_exchange(place.name, last)
        return done


def _sync(here: sqlite3.Connection, place: Place, on_page: OnPage) -> Synced:
    done = Synced()
    today = f"{version()} {datetime.now(UTC):%Y-%m-%d}"
    # After a day, or with another version of the program, they are looked at again.
    here.execute('DELETE FROM refused WHERE "on" <> ?', (today,))
    mine, theirs = _own_buckets(here, place.name), place.buckets()
    for bucket in sorted(mine.keys() | theirs.keys()):
        if mine.get(bucket) == theirs.get(bucket):
            continue
        own = lengths_in(here, "own.facts", bucket)
        ours = own | lengths_in(here, "main.facts", bucket)
        refused = _refused(here, place.name, bucket)
        there = place.lengths(bucket)
        wanted = {id_: length for id_, length in there.items() if id_ not in ours and id_ not in refused}
        for ids in _pages(wanted):
            _take(here, place, ids, wanted, done, today)
            on_page(done)
        for ids in _pages({id_: length for id_, length in ours.items() if id_ not in there}):
            done.sent += place.add(_rows(here, ids))
            on_page(done)
    done.left_out_count = here.execute("SELECT count(*) FROM refused WHERE place = ?", (place.name,)).fetchone()[0]
    return done


def _take(
    here: sqlite3.Connection, place: Place, ids: list[str], lengths: Mapping[str, int], done: Synced, today: str
) -> None:
    """One page: check each row, keep the good ones and remember the others."""
    rows = {str(row[0]): row for row in place.rows([id_ for id_ in ids if lengths[id_] <= MAX_CONTENT_BYTES])}
    good: list[Row] = []
    bad: list[LeftOut] = []
    for id_ in ids:
        try:
            if lengths[id_] > MAX_CONTENT_BYTES:
                raise BadRow("too large")
            if id_ not in rows:
                raise BadRow("cannot be read")
            row = check_row(rows[id_])
            _check_record(row)
            good.append(row)
        except BadRow as error:
            bad.append(LeftOut(id_, clean(str(error), longest=200)))
    before = here.total_changes
    here.execute("BEGIN IMMEDIATE")
    try:
        here.executemany(INSERT.replace("INTO facts", "INTO main.facts"), good)
        done.received += here.total_changes - before
        remember = "INSERT INTO refused VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"
        here.executemany(remember, [(place.name, one.id, one.why, today) for one in bad])
        here.execute("COMMIT")
    except BaseException:
        here.execute("ROLLBACK")
        raise
    done.left_out += bad[: max(0, NAMED - len(done.left_out))]


def _check_record(row: Row) -> None:
    """Of a check: looked at once, where the row comes in. Raises `BadRow`."""
    check = content_of(row, PreflightCheck)
    if check is None:
        return
    said = {"verdict": check.verdict, "is_void": check.is_void, "is_simulated": check.is_simulated}
    if not is_of_row(check.document, said, module=row.module, station=row.station, made_at=row.made_at):
        raise BadRow("its record says something else")


def _own_buckets(here: sqlite3.Connection, place: str) -> Buckets:
    """With the ids of rows that are left out, else the two sides would never be equal. SQLite joins the ids: to read
    each of 600,000 into Python takes three times as long."""
    found: dict[str, tuple[int, str]] = {}
    since = ""
    while (first := here.execute(_FIRST, {"since": since, "place": place}).fetchone()[0]) is not None:
        bucket = first[:BUCKET]
        ends = {"since": bucket, "until": f"{bucket}g", "place": place}
        count, ids = here.execute(_TOGETHER, ends).fetchone()
        found[bucket] = (count, digest_of(ids))
        since = f"{bucket}g"
    return found


_FIRST = """
    SELECT min(id) FROM (
        SELECT min(id) AS id FROM main.facts WHERE id >= :since
        UNION ALL SELECT min(id) FROM own.facts WHERE id >= :since
        UNION ALL SELECT min(id) FROM refused WHERE place = :place AND id >= :since
    )
"""
_TOGETHER = """
    SELECT count(*), group_concat(id, '') FROM (
        SELECT id FROM main.facts WHERE id >= :since AND id < :until
        UNION SELECT id FROM own.facts WHERE id >= :since AND id < :until
        UNION SELECT id FROM refused WHERE place = :place AND id >= :since AND id < :until
        ORDER BY id
    )
"""


def _refused(here: sqlite3.Connection, place: str, bucket: str) -> set[str]:
    query = "SELECT id FROM refused WHERE place = ? AND id >= ? AND id < ?"
    return {id_ for (id_,) in here.execute(query, (place, bucket, f"{bucket}g"))}


def _rows(here: sqlite3.Connection, ids: list[str]) -> list[Row]:
    found = {row[0]: Row(*row) for table in ("main.facts", "own.facts") for row in rows_in(here, table, ids)}
    return [found[id_] for id_ in sorted(found)]


def _pages(lengths: Mapping[str, int]) -> Iterator[list[str]]:
    page: list[str] = []
    size = 0
    for id_ in sorted(lengths):
        if page and (len(page) == PAGE_ROWS or size + lengths[id_] > PAGE_BYTES):
            yield page
            page, size = [], 0
        page.append(id_)
        size += min(lengths[id_], MAX_CONTENT_BYTES)
    if page:
        yield page
