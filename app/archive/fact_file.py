"""Facts in one file, for stations without a server, carried on a USB stick.

    JSON Lines   a header line, then one fact per line
    export       adds what the file lacks; facts exported by others remain
    import       adds what this computer lacks

The content of a file is not trusted: altered facts are reported and skipped.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

from app.archive.content import MAX_LENGTH
from app.archive.exchange import PAGE, PAGE_LENGTH, Exchanged, OnProgress, sendable
from app.archive.facts import FACT_COLUMNS, Fact, RefusedFact, checked
from app.archive.local_facts import LocalFacts
from app.store.facts import object_in
from app.system.files import CANNOT_READ, CANNOT_WRITE, file_troubles, whole_file
from app.text.user_error import UserError
from protocol.translatable import marked

FORMAT: Final = "dps-s archive"
VERSION: Final = 1
_MAX_LINE_LENGTH: Final = 2 * MAX_LENGTH
_COPIED_AT_ONCE: Final = 1 << 20


def import_facts(here: LocalFacts, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
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
    on_page(done)
    return done


def export_facts(here: LocalFacts, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
    """Writes the old content and what it lacks in one step; a missing file is created, and on an error it is as it was.
    Raises `UserError`."""
    done = Exchanged()
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
            raise UserError(marked("{path} is not an archive file."), path=path)
        if head.get("version") != VERSION:
            raise UserError(marked("{file} needs a newer version of this program."), file=path)
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
