"""Atomic file writes, file locks, and what the system says against them as a sentence."""

import errno
import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Final

from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.translatable import marked

if sys.platform == "win32":
    import ctypes
    import msvcrt
    from ctypes import wintypes

    class _Overlapped(ctypes.Structure):
        """The locked byte: beyond the end of any file, because a locked byte cannot be read by others."""

        _fields_ = (
            ("internal", ctypes.c_void_p),
            ("internal_high", ctypes.c_void_p),
            ("offset", wintypes.DWORD),
            ("offset_high", wintypes.DWORD),
            ("event", wintypes.HANDLE),
        )

    _FAIL_AT_ONCE, _EXCLUSIVE = 1, 2
    _LOCKED_BYTE = 0x7FFFFFFF
    """In units of 4 GiB."""
else:
    import fcntl

CANNOT_READ: Final = marked("{file} cannot be read: {why}.")
CANNOT_WRITE: Final = marked("{file} cannot be written: {why}.")
DRAFT_CHARACTERS = 40
"""Length of the target's name in the draft's: at four bytes a character it fits into 255 bytes."""


@contextmanager
def file_troubles(text: str, file: Path) -> Iterator[None]:
    """Converts errors of the file system to `UserError`; `text` has the placeholders `file` and `why`."""
    try:
        yield
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise UserError(text, file=file, why=error_text(error)) from error


@contextmanager
def whole_file(path: Path, *, is_private: bool = False) -> Iterator[IO[bytes]]:
    """Replaces the file atomically when the block ends; readers see the old or the new file, also after a crash. If the
    block raises, the old file remains.

    As with QSaveFile and git, the target of a symbolic link is replaced. A link of another user in a folder writable by
    everybody is refused, as by Linux. A pipe or a device is written to directly. Raises OSError.
    """
    path = _target_of(path)
    if path.exists() and not path.is_file():
        with path.open("wb") as file:
            yield file
        return
    with draft_of(path, is_private=is_private) as draft, draft.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def draft_of(path: Path, *, is_private: bool = False) -> Iterator[Path]:
    """An empty file beside `path` that replaces it atomically when the block ends, unless the block raises.

    `is_private`: nobody else may read it. Raises OSError.
    """
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:DRAFT_CHARACTERS]}.", suffix=".part")
    os.close(handle)
    draft = Path(name)
    try:
        yield draft
        if not is_private:
            with suppress(OSError):
                draft.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        draft.replace(path)
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes, *, is_private: bool = False) -> None:
    """Replaces the file by `data`; see `whole_file`. Raises OSError; the old file then remains."""
    with whole_file(path, is_private=is_private) as file:
        file.write(data)


def private_opener(path: str, flags: int) -> int:
    """For `open`: creates files that only this user can read."""
    return os.open(path, flags, 0o600)


def lock(file: IO[bytes], *, is_shared: bool = False) -> None:
    """Lock until the file is closed or the process ends. Never waits.

    Raises OSError if it is locked by another process.
    """
    if sys.platform == "win32":
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        flags = _FAIL_AT_ONCE | (0 if is_shared else _EXCLUSIVE)
        where = _Overlapped(offset_high=_LOCKED_BYTE)
        handle = wintypes.HANDLE(msvcrt.get_osfhandle(file.fileno()))
        if not kernel.LockFileEx(handle, flags, 0, 1, 0, ctypes.byref(where)):
            raise ctypes.WinError(ctypes.get_last_error())
    else:
        fcntl.flock(file, (fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def _target_of(path: Path) -> Path:
    """Resolves symbolic links. Raises OSError for a loop and for a link of another user."""
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
    """It can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
