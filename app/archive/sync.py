"""The facts of all stations: this one and a place get the same rows, in both directions.

Both sides tell, for each three days, how many facts they have and a digest of their ids. Where these differ the ids are
compared, and the missing rows are copied in pages, each its own commit. Nothing is remembered from one exchange to the
next that could be wrong after a crash, a restored copy or a moved server: whatever is committed late, by whomever, is
in the next comparison. So an exchange may be broken off anywhere, repeated, and run beside others.
"""

import sqlite3
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from msgspec import Struct, field

from app import version
from app.archive.archive import Archive
from app.archive.places import FilePlace, PostgresPlace, digests, is_server, lengths_in, rows_in
from app.records.verification import is_of_row
from app.store.fact_store import INSERT
from app.store.rows import MAX_CONTENT_BYTES, BadRow, PreflightCheck, Row, check_row, content_of
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


# Called after each page; may raise to break off.
OnPage = Callable[[Synced], None]


def sync(archive: Archive, address: str, on_page: OnPage = lambda _done: None) -> Synced:
    """`address`: of a server, or a file. Raises `UserError`; what was exchanged before that stays."""
    with (
        closing(PostgresPlace(address) if is_server(address) else FilePlace(Path(address))) as place,
        archive.opened() as here,
    ):
        last = here.execute("SELECT coalesce(max(rowid), 0) FROM own.facts").fetchone()[0]
        done = _Exchange(here, place, on_page).run()
        archive.note_exchange(place.name, last)
        return done


class _Exchange:
    """`here`: of `Archive.opened`."""

    def __init__(self, here: sqlite3.Connection, place: FilePlace | PostgresPlace, on_page: OnPage) -> None:
        self._here = here
        self._place = place
        self._on_page = on_page
        self._today = f"{version()} {datetime.now(UTC):%Y-%m-%d}"
        self._done = Synced()

    def run(self) -> Synced:
        # After a day, or with another version of the program, what was left out is looked at again.
        self._here.execute('DELETE FROM refused WHERE "on" <> ?', (self._today,))
        # With what was left out, else the two sides would never be equal.
        left_out = "CREATE TEMP TABLE left_out AS SELECT id FROM refused WHERE place = ?"
        self._here.execute(left_out, (self._place.name,))
        ours = digests(self._here, "main.facts", "own.facts", "temp.left_out")
        theirs = self._place.buckets()
        for bucket in sorted(ours.keys() | theirs.keys()):
            if ours.get(bucket) != theirs.get(bucket):
                self._exchange(bucket)
        count = "SELECT count(*) FROM refused WHERE place = ?"
        self._done.left_out_count = self._here.execute(count, (self._place.name,)).fetchone()[0]
        return self._done

    def _exchange(self, bucket: str) -> None:
        ours = lengths_in(self._here, bucket)
        theirs = self._place.lengths(bucket)
        left_out = self._here.execute("SELECT id FROM left_out")
        known = ours.keys() | {id_ for (id_,) in left_out}
        for ids in _pages(theirs, known):
            self._receive(ids, theirs)
            self._on_page(self._done)
        for ids in _pages(ours, theirs):
            rows = [Row(*row) for row in rows_in(self._here, ids)]
            self._done.sent += self._place.add(sorted(rows, key=lambda row: row.id))
            self._on_page(self._done)

    def _receive(self, ids: list[str], lengths: Mapping[str, int]) -> None:
        """One page: each row is checked, the good ones are kept and the others are remembered."""
        small = [id_ for id_ in ids if lengths[id_] <= MAX_CONTENT_BYTES]
        rows = {row[0]: row for row in self._place.rows(small)}
        good: list[Row] = []
        bad: list[LeftOut] = []
        for id_ in ids:
            try:
                if lengths[id_] > MAX_CONTENT_BYTES:
                    raise BadRow("too large")
                if id_ not in rows:
                    raise BadRow("cannot be read")
                good.append(_checked(rows[id_]))
            except BadRow as error:
                bad.append(LeftOut(id_, clean(str(error), longest=200)))
        before = self._here.total_changes
        with self._here:  # which commits, or rolls back where it fails
            self._here.execute("BEGIN IMMEDIATE")
            self._here.executemany(INSERT.replace("INTO facts", "INTO main.facts"), good)
            received = self._here.total_changes - before
            remember = "INSERT INTO refused VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"
            self._here.executemany(remember, [(self._place.name, one.id, one.why, self._today) for one in bad])
        self._done.received += received
        self._done.left_out += bad[: NAMED - len(self._done.left_out)]


def _checked(row: tuple[Any, ...]) -> Row:
    """The record of a check is verified once, where its row comes in. Raises `BadRow`."""
    checked = check_row(row)
    check = content_of(checked, PreflightCheck)
    if check is not None and not is_of_row(check, checked):
        raise BadRow("its record says something else")
    return checked


def _pages(lengths: Mapping[str, int], known: Collection[str]) -> Iterator[list[str]]:
    """Those that are not known, in their order. `lengths`: bytes of the content, by id."""
    page: list[str] = []
    size = 0
    for id_ in sorted(lengths.keys() - set(known)):
        if page and (len(page) == PAGE_ROWS or size + lengths[id_] > PAGE_BYTES):
            yield page
            page = []
            size = 0
        page.append(id_)
        size += min(lengths[id_], MAX_CONTENT_BYTES)
    if page:
        yield page
