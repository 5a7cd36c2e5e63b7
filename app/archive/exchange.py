"""Exchanges facts with a server or a file, page by page, until both have all.

Each page is complete in itself, and missing facts are found by comparison. An exchange may therefore be interrupted at
any point, repeated, or run in parallel with another one: the next exchange adds what is missing.

A file is for stations without a server, carried on a USB stick: JSON Lines, a header line, then one fact per line.
What others exported into it remains; its content is not trusted.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Final

from app.archive.archive import Archive
from app.archive.content import MAX_LENGTH
from app.archive.facts import FACT_COLUMNS, MAX_REFUSALS, Fact, RefusedFact, StoredRow, checked, stored_fact, too_long
from app.archive.module_names import names_of, note_services
from app.archive.server_url import server_url
from app.store.facts import object_in
from app.system.files import CANNOT_READ, CANNOT_WRITE, file_troubles, whole_file
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.archive.postgres import PostgresFacts

PAGE: Final = 200
PAGE_LENGTH: Final = 8 * MAX_LENGTH
"""Characters read at a time, however long the facts are."""
BUCKETS_AT_ONCE: Final = 16
"""Compared at a time: at most a sixteenth of the set."""


@dataclass(slots=True)
class Exchanged:
    """`refused`: rows of the other side that were not imported, of which `MAX_REFUSALS` are listed. `damaged`: facts
    of this side that were not sent."""

    sent: int = 0
    received: int = 0
    refused: list[RefusedFact] = field(default_factory=list)
    damaged: list[RefusedFact] = field(default_factory=list)
    refused_count: int = 0

    @property
    def is_whole(self) -> bool:
        return not self.refused_count and not self.damaged

    def refuse(self, rows: Sequence[RefusedFact]) -> None:
        self.refused += rows[: MAX_REFUSALS - len(self.refused)]
        self.refused_count += len(rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArchiveStatus:
    """`not_shared`: records of this station that are not known to be on the server `place`. `last_at`: time of the last
    complete exchange with it; None if there was none."""

    stations: Mapping[str, int]
    """Number of records by public key."""
    place: str | None
    not_shared: int
    last_at: str | None
    conflicts: int


def status_of(archive: Archive, url: str | None) -> ArchiveStatus:
    """`url`: the configured server. Raises `UserError`."""
    conflicts = names_of(archive).conflicts
    place = server_url(url).shown if url else None
    not_shared, last_at = archive.not_shared(place)
    return ArchiveStatus(
        stations=archive.counts(), place=place, not_shared=not_shared, last_at=last_at, conflicts=len(conflicts)
    )


OnProgress = Callable[[Exchanged], None]
"""Called after each page; may raise to interrupt."""


def sync(here: Archive, url: str, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
    """Exchange with a server. Raises `UserError`; facts exchanged before that remain."""
    from app.archive.postgres import open_server

    here.collect()
    with closing(open_server(url)) as there:
        last = here.last_number()
        done = exchange(here, there, on_page=on_page)
        if not done.damaged:
            here.note_exchange(there.url.shown, last)
    note_services(here)
    return done


def exchange(
    here: Archive, there: "PostgresFacts", *, on_page: OnProgress = lambda _done: None, page: int = PAGE
) -> Exchanged:
    """Raises `UserError`; facts exchanged before that remain."""
    done = Exchanged()
    mine, theirs = here.digests(), there.digests()
    differing = [bucket for bucket in sorted(mine.keys() | theirs.keys()) if mine.get(bucket) != theirs.get(bucket)]
    for start in range(0, len(differing), BUCKETS_AT_ONCE):
        buckets = differing[start : start + BUCKETS_AT_ONCE]
        known, offered = here.rows(buckets), there.rows(buckets)
        # Includes facts that differ on both sides: one of them was altered and is reported.
        other = {id_: row for id_, row in offered.items() if id_ not in known or known[id_].digest != row.digest}
        done.refuse([too_long(id_) for id_, row in other.items() if row.length > MAX_LENGTH])
        for ids in _pages({id_: row for id_, row in other.items() if row.length <= MAX_LENGTH}, page):
            rows = {str(row[0]): row for row in there.read(ids)}
            facts, refused = _sorted(checked(rows.get(id_, (id_,))) for id_ in ids)  # one that is no text is not found
            done.received += here.add(facts)
            done.refuse(refused)
            on_page(done)
        for facts, damaged in sendable(here, {id_: row for id_, row in known.items() if id_ not in offered}, page):
            done.sent += there.add(facts)
            done.damaged += damaged
            on_page(done)
    return done


def sendable(
    here: Archive, rows: Mapping[str, StoredRow], page: int = PAGE
) -> Iterator[tuple[list[Fact], list[RefusedFact]]]:
    """Pages of these facts, and of those that were damaged since they were stored."""
    for ids in _pages(rows, page):
        yield _sorted(stored_fact(row, rows[str(row[0])].digest) for row in here.read(ids))


def _sorted(facts: Iterable[Fact | RefusedFact]) -> tuple[list[Fact], list[RefusedFact]]:
    everything = list(facts)
    good = [fact for fact in everything if isinstance(fact, Fact)]
    return good, [fact for fact in everything if isinstance(fact, RefusedFact)]


def _pages(rows: Mapping[str, StoredRow], page: int) -> Iterator[Sequence[str]]:
    """Ids of at most `page` rows and `PAGE_LENGTH` characters."""
    ids: list[str] = []
    length = 0
    for id_, row in rows.items():
        if ids and (len(ids) >= page or length + row.length > PAGE_LENGTH):
            yield ids
            ids, length = [], 0
        ids.append(id_)
        length += row.length
    if ids:
        yield ids


FORMAT: Final = "dps-s archive"
VERSION: Final = 1
_MAX_LINE_LENGTH: Final = 2 * MAX_LENGTH
_COPIED_AT_ONCE: Final = 1 << 20


def import_facts(here: Archive, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
    """Raises `UserError`; facts imported before that remain."""
    done, page, length = Exchanged(), list[Fact](), 0
    for fact in facts_in(path):
        if isinstance(fact, RefusedFact):
            done.refuse([fact])
            continue
        page.append(fact)
        length += len(fact.payload)
        if len(page) >= PAGE or length > PAGE_LENGTH:
            done.received += here.add(page)
            page, length = [], 0
            on_page(done)
    done.received += here.add(page)
    note_services(here)
    on_page(done)
    return done


def export_facts(here: Archive, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
    """Writes the old content and what it lacks in one step; a missing file is created, and on an error it is as it was.
    Raises `UserError`."""
    done = Exchanged()
    here.collect()
    there = {fact.id for fact in facts_in(path) if isinstance(fact, Fact)} if path.exists() else set()
    missing = {id_: row for id_, row in here.rows([*here.digests()]).items() if id_ not in there}
    with file_troubles(CANNOT_WRITE, path), whole_file(path) as file:
        _copy(path, file)
        for facts, damaged in sendable(here, missing):
            for fact in facts:
                row = dict(zip(FACT_COLUMNS, fact.row, strict=True))
                file.write(json.dumps(row, separators=(",", ":")).encode("ascii") + b"\n")
            done.sent += len(facts)
            done.damaged += damaged
            on_page(done)
    return done


def facts_in(path: Path) -> Iterator[Fact | RefusedFact]:
    """Raises `UserError` if it cannot be read or is no archive file."""
    with file_troubles(CANNOT_READ, path), path.open("rb") as file:
        head = object_in(file.readline(_MAX_LINE_LENGTH))
        if head.get("format") != FORMAT:
            raise UserError(CANNOT_READ, file=path, why=message(marked("unknown kind of file")))
        if head.get("version") != VERSION:
            raise UserError(CANNOT_READ, file=path, why=message(marked("written by a newer version")))
        while line := file.readline(_MAX_LINE_LENGTH):
            rest = line
            while not rest.endswith(b"\n") and (rest := file.readline(_MAX_LINE_LENGTH)):
                pass  # one line that is too long, not several
            value = object_in(line)
            yield checked(tuple(value.get(name) for name in FACT_COLUMNS))


def _copy(path: Path, target: IO[bytes]) -> None:
    """Copies the existing content, or writes the header line."""
    last = b"\n"
    if not path.is_file():
        target.write(json.dumps({"format": FORMAT, "version": VERSION}).encode() + b"\n")
        return
    with path.open("rb") as old:
        while part := old.read(_COPIED_AT_ONCE):
            target.write(part)
            last = part[-1:]
    if last != b"\n":  # a truncated file
        target.write(b"\n")
