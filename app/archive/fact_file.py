"""Facts in one file, for stations without a server, carried on a USB stick.

    JSON Lines   a header line, then one fact per line
    export       adds what the file lacks; facts exported by others remain
    import       adds what this computer lacks

A file is a set of facts like a server. Its content is not trusted: altered facts are reported and skipped.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final, NamedTuple

from app.archive.content import MAX_LENGTH
from app.archive.fact_set import BUCKET, CANNOT_READ, CANNOT_WRITE, Digests, StoredRow, digests_of_rows, file_troubles
from app.archive.facts import (
    FACT_COLUMNS,
    MAX_REFUSALS,
    Fact,
    FactRefused,
    FactRow,
    RefusedFact,
    checked,
    row_digest,
)
from app.system.files import whole_file
from app.text.user_error import UserError
from protocol.translatable import marked

FORMAT: Final = "dps-s archive"
VERSION: Final = 1
_MAX_LINE_LENGTH: Final = 2 * MAX_LENGTH
_COPIED_AT_ONCE: Final = 1 << 20


class _Place(NamedTuple):
    start: int
    length: int
    digest: str


class FactFile:
    """A `FactSet` over a file."""

    def __init__(self, path: Path, *, is_new: bool = False) -> None:
        """`is_new`: the file may be missing. Raises `UserError`."""
        self.path = path
        self.refused: list[RefusedFact] = []
        """Lines that are not valid facts; of many only the first."""
        self.refused_count = 0
        self._places: dict[str, _Place] = {}
        self._added: set[str] = set()
        self._draft: IO[bytes] | None = None
        with file_troubles(CANNOT_READ, path):
            if not is_new or path.exists():
                with path.open("rb") as file:
                    self._scan(file)

    def digests(self) -> Digests:
        return digests_of_rows((id_, place.digest) for id_, place in self._places.items())

    def rows(self, buckets: Sequence[str]) -> Mapping[str, StoredRow]:
        wanted = set(buckets)
        return {
            id_: StoredRow(place.digest, min(place.length, MAX_LENGTH))
            for id_, place in self._places.items()
            if id_[:BUCKET] in wanted
        }

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        places = sorted(self._places[one] for one in ids if one in self._places)
        with file_troubles(CANNOT_READ, self.path), self.path.open("rb") as file:
            return [_row(_line_at(file, place)) for place in places]

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Writes the old content and the facts added inside the block in one step; on an error the file is unchanged.
        Raises `UserError`."""
        try:
            with file_troubles(CANNOT_WRITE, self.path), whole_file(self.path) as file:
                self._copy_to(file)
                self._draft = file
                yield
        finally:
            self._draft = None

    def add(self, facts: Sequence[Fact]) -> int:
        """Only inside `writing`."""
        if self._draft is None:
            raise RuntimeError("nothing is being written")
        new = {one.id: one for one in facts if one.id not in self._places and one.id not in self._added}
        for fact in new.values():
            row = dict(zip(FACT_COLUMNS, fact.row, strict=True))
            self._draft.write(json.dumps(row, separators=(",", ":")).encode("ascii") + b"\n")
        self._added |= new.keys()
        return len(new)

    def _copy_to(self, file: IO[bytes]) -> None:
        """Copies the existing content, or writes the header line."""
        last = b"\n"
        if not self.path.is_file():
            file.write(json.dumps({"format": FORMAT, "version": VERSION}).encode() + b"\n")
            return
        with self.path.open("rb") as old:
            while part := old.read(_COPIED_AT_ONCE):
                file.write(part)
                last = part[-1:]
        if last != b"\n":  # a truncated file
            file.write(b"\n")

    def _scan(self, file: IO[bytes]) -> None:
        head = _parsed(file.readline(_MAX_LINE_LENGTH))
        if head.get("format") != FORMAT:
            raise UserError(marked("{path} is not an archive file."), path=self.path)
        if head.get("version") != VERSION:
            text = marked("{file} needs a newer version of this program.")
            raise UserError(text, file=self.path)
        start = file.tell()
        while line := file.readline(_MAX_LINE_LENGTH):
            length = len(line)
            rest = line
            while not rest.endswith(b"\n") and (rest := file.readline(_MAX_LINE_LENGTH)):
                length += len(rest)  # one line that is too long, not several
            row = _row(line)
            try:
                fact = checked(row)
            except FactRefused as error:
                self.refused_count += 1
                if len(self.refused) < MAX_REFUSALS:
                    self.refused.append(error.refusal)
            else:
                self._places[fact.id] = _Place(start, len(line), row_digest(fact.row))
            start += length


def _line_at(file: IO[bytes], place: _Place) -> bytes:
    file.seek(place.start)
    return file.read(place.length)


def _row(line: bytes) -> FactRow:
    value = _parsed(line)
    return tuple(value.get(name) for name in FACT_COLUMNS)


def _parsed(line: bytes) -> Mapping[str, object]:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return value if isinstance(value, dict) else {}
