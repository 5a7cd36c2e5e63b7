"""Interface of a set of facts: this computer, a server or a file."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NamedTuple, Protocol

from app.archive.facts import Fact, FactRow
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

BUCKET: Final = 2
"""Number of leading characters of an id that select a part of the set for comparison."""

Digests = Mapping[str, tuple[int, str]]
"""By bucket: the number of facts and their digest."""


class StoredRow(NamedTuple):
    """What is known of a row before it is read. `length`: of its payload, in characters."""

    digest: str
    length: int


class FactSet(Protocol):
    """Append-only. Raises `UserError` if it cannot be read or written."""

    def digests(self) -> Digests:
        """Differs for each bucket whose content differs."""
        ...

    def rows(self, buckets: Sequence[str]) -> Mapping[str, "StoredRow"]:
        """The rows in these buckets, by id."""
        ...

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        """The existing rows with these ids, unchecked, in any order."""
        ...

    def add(self, facts: Sequence[Fact]) -> int:
        """Add all of them or none; return the number of new ones. Existing facts are not changed."""
        ...


@contextmanager
def file_troubles(text: str, file: Path) -> Iterator[None]:
    """Converts errors of the file system to `UserError`; `text` has the placeholders `file` and `why`."""
    try:
        yield
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise UserError(text, file=file, why=error_text(error)) from error


CANNOT_READ: Final = marked("{file} cannot be read: {why}.")
CANNOT_WRITE: Final = marked("{file} cannot be written: {why}.")


def digest_of(rows: Iterable[tuple[str, str]]) -> str:
    """Digest of the rows of one bucket, in order of their ids."""
    together = "".join(digest for _, digest in sorted(rows))
    return hashlib.md5(together.encode(), usedforsecurity=False).hexdigest()


def digests_of_rows(rows: Iterable[tuple[str, str]]) -> Digests:
    parts: dict[str, list[tuple[str, str]]] = {}
    for id_, digest in rows:
        parts.setdefault(id_[:BUCKET], []).append((id_, digest))
    return {bucket: (len(part), digest_of(part)) for bucket, part in parts.items()}
