"""Files that are there whole or not at all: the one way in which what a person saves is written."""

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

DRAFT_CHARACTERS = 40
"""Of the target's name in that of the draft: at four bytes each they fit into a file name's 255 bytes."""


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Replaces the file in one step when the block ends: whoever reads it, also after a crash, finds the old or the
    new, whole. Whatever stops the block, the old file stays.

    As QSaveFile and git do, a link stays and the file that it leads to is replaced; a link that another user has put
    into a folder that everybody may write into is refused, as Linux does. What cannot be replaced, a pipe or a device,
    is written to. Raises OSError.
    """
    path = _target_of(path)
    if path.exists() and not path.is_file():
        with path.open("wb") as file:
            yield file
        return
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:DRAFT_CHARACTERS]}.", suffix=".part")
    draft = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        with suppress(OSError):
            draft.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        draft.replace(path)
    except BaseException:
        with suppress(OSError):
            draft.unlink()
        raise


def write_whole(path: Path, data: bytes) -> None:
    """Replaces the file by `data`; see `whole_file`. Raises OSError; the old file then stays."""
    with whole_file(path) as file:
        file.write(data)


def _target_of(path: Path) -> Path:
    """The file that `path` leads to. Raises OSError for a link in a circle, and for one of a stranger."""
    if path.is_symlink():
        folder, owner = path.parent.stat(), path.lstat().st_uid
        is_for_all = folder.st_mode & stat.S_ISVTX and folder.st_mode & stat.S_IWOTH
        if is_for_all and owner not in (os.geteuid(), folder.st_uid):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    real = Path(os.path.realpath(path))
    if real.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return real


def _umask() -> int:
    """The only way to read it is to set it; nobody else makes files meanwhile."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
