"""What has facts: this computer, a server, a file. One shape for all, so that one code makes their union."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Protocol

from app.archive.facts import Fact, FactRow
from app.text.messages import UserMessage, message
from app.text.sentences import error_text
from protocol.translatable import marked

BUCKET: Final = 2
"""Characters of an id by which a set is compared part by part."""

Digests = Mapping[str, tuple[int, str]]
"""By the beginning of the ids: how many facts there are, and a digest of them."""


class FactSet(Protocol):
    """Facts are only ever added. Raises `ArchiveTrouble` where it cannot be read or written."""

    def digests(self) -> Digests:
        """What differs in a part differs here."""
        ...

    def rows(self, buckets: Sequence[str]) -> Mapping[str, str]:
        """The digest of each row whose id begins with one of these, by id."""
        ...

    def read(self, ids: Sequence[str]) -> Sequence[FactRow]:
        """Unchecked, in any order; those that are there."""
        ...

    def add(self, facts: Sequence[Fact]) -> int:
        """All of them or none are in it when this returns; how many are new. What is there already stays as it is."""
        ...


class ArchiveTrouble(Exception):
    """A server or file cannot be used. `message` is for people; nothing of a password is in it."""

    def __init__(self, message: UserMessage) -> None:
        super().__init__(message.in_english())
        self.message = message


@contextmanager
def file_troubles(text: str, file: Path) -> Iterator[None]:
    """What the system says of a file as an `ArchiveTrouble`; `text` has the places `file` and `why`."""
    try:
        yield
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise ArchiveTrouble(message(text, file=file, why=error_text(error))) from error


CANNOT_READ: Final = marked("{file} cannot be read: {why}.")
CANNOT_WRITE: Final = marked("{file} cannot be written: {why}.")


def digest_of(rows: Iterable[tuple[str, str]]) -> str:
    """Of the rows of one part, by id."""
    together = "".join(digest for _, digest in sorted(rows))
    return hashlib.md5(together.encode(), usedforsecurity=False).hexdigest()


def digests_of_rows(rows: Iterable[tuple[str, str]]) -> Digests:
    parts: dict[str, list[tuple[str, str]]] = {}
    for id_, digest in rows:
        parts.setdefault(id_[:BUCKET], []).append((id_, digest))
    return {bucket: (len(part), digest_of(part)) for bucket, part in parts.items()}
