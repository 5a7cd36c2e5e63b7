"""Logs in `.gz` and `.zip`: unpacked into a folder of their own while they are read, in bounded size."""

import gzip
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO, Final

from app.flights.flight_log import unreadable
from app.flights.records import MAX_BYTES
from app.flights.refused import SPREADSHEET
from app.text.user_error import UserError
from protocol.translatable import marked

GZIP: Final = b"\x1f\x8b"
ZIP: Final = b"PK\x03\x04"
_AT_ONCE: Final = 1 << 20
MAX_MEMBERS: Final = 10_000
# What the libraries raise for a damaged or an encrypted archive.
_DAMAGED: Final = (zipfile.BadZipFile, gzip.BadGzipFile, zlib.error, EOFError, RuntimeError, NotImplementedError)


def members_of(path: Path) -> list[str]:
    """The names of the files in a zip archive, sorted. Raises `UserError`, OSError."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = [one.filename for one in archive.infolist()[:MAX_MEMBERS] if not one.is_dir()]
    except _DAMAGED as error:
        raise unreadable(marked("damaged, or encrypted")) from error
    if "[Content_Types].xml" in names or "mimetype" in names:
        raise UserError(SPREADSHEET)
    return sorted(name for name in names if not _is_hidden(name))


def _is_hidden(name: str) -> bool:
    parts = PurePosixPath(name).parts
    return "__MACOSX" in parts or any(part.startswith(".") for part in parts)


def archive_of(path: Path) -> tuple[Path, str] | None:
    """The zip archive and the member that a path such as `logs.zip/7.ulg` means; None for any other path."""
    for parent in path.parents:
        if parent.is_file():
            return (parent, path.relative_to(parent).as_posix()) if zipfile.is_zipfile(parent) else None
    return None


@contextmanager
def unpacked(path: Path, member: str | None = None) -> Iterator[Path]:
    """Yields the path of the unpacked file. `member`: of a zip archive. Raises `UserError`, OSError."""
    with tempfile.TemporaryDirectory(prefix="dps-s-") as folder:
        name = PurePosixPath(member).name if member is not None else path.stem
        target = Path(folder) / (name or "log")
        try:
            if member is None:
                with gzip.open(path) as packed:
                    _copy(packed, target)
            else:
                with zipfile.ZipFile(path) as archive, archive.open(member) as packed:
                    _copy(packed, target)
        except KeyError as error:
            raise unreadable(marked("not in the archive any more")) from error
        except _DAMAGED as error:
            raise unreadable(marked("damaged, or encrypted")) from error
        yield target


def _copy(packed: IO[bytes] | gzip.GzipFile, target: Path) -> None:
    size = 0
    with target.open("wb") as file:
        while part := packed.read(_AT_ONCE):
            size += len(part)
            if size > MAX_BYTES:
                raise unreadable(marked("too large"))
            file.write(part)
