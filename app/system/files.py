"""Files that are replaced as a whole, files that are held, and the folder of the program's data."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final

from protocol.translatable import marked

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

CANNOT_READ: Final = marked("{file} cannot be read: {why}.")
CANNOT_WRITE: Final = marked("{file} cannot be written: {why}.")
# Windows lets nobody else read a locked byte, so that is one beyond the end of any file.
_LOCKED_BYTE: Final = 0x7FFFFFFF
_DRAFT_CHARACTERS: Final = 40  # of the file's name in the draft's; of four bytes each they fit into the 255 of a name


@contextmanager
def whole_file(path: Path, *, is_private: bool = False) -> Iterator[IO[bytes]]:
    """Replace the file when the block ends: readers see the old or the new one, also after a crash. If the block
    raises, the old one remains.

    What a symbolic link of this user leads to is replaced, and the link of somebody else itself. A pipe or a device is
    written to directly. `is_private`: nobody else may read it. Raises OSError.
    """
    if path.is_symlink() and (sys.platform == "win32" or path.lstat().st_uid == os.geteuid()):
        path = Path(os.path.realpath(path))
    if path.exists() and not path.is_file():
        with path.open("wb") as file:
            yield file
        return
    draft = path.with_name(f".{path.name[:_DRAFT_CHARACTERS]}.{os.urandom(4).hex()}.part")
    try:
        with open(draft, "xb", opener=private_opener if is_private else None) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        if path.exists() and not is_private:
            import shutil  # which loads all that packs files

            shutil.copymode(path, draft)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes, *, is_private: bool = False) -> None:
    """Replace the file by `data`; see `whole_file`."""
    with whole_file(path, is_private=is_private) as file:
        file.write(data)


def private_opener(path: str, flags: int) -> int:
    # For `open`: create files that only this user can read.
    return os.open(path, flags, 0o600)


def lock(file: IO[bytes], *, is_shared: bool = False) -> None:
    # Hold the file until it is closed or the process ends. Never waits: raises OSError if another process holds it.
    # `is_shared`: others may hold it so, too; not on Windows.
    if sys.platform == "win32":
        os.lseek(file.fileno(), _LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(file, (fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def data_folder() -> Path:
    from platformdirs import user_data_path

    return user_data_path("dps-s-configurator", appauthor=False)
