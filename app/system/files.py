"""Atomic file writes: whole or not at all."""

import errno
import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

if sys.platform == "win32":
    import ctypes
    import msvcrt
    from ctypes import wintypes

    class _Overlapped(ctypes.Structure):
        """Which byte is locked: one that no file has, because nobody else can read a locked one."""

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

DRAFT_CHARACTERS = 40
"""Of the target's name in that of the draft: at four bytes each they fit into a file name's 255 bytes."""


@contextmanager
def whole_file(path: Path, *, is_private: bool = False) -> Iterator[IO[bytes]]:
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
    with draft_of(path, is_private=is_private) as draft, draft.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def draft_of(path: Path, *, is_private: bool = False) -> Iterator[Path]:
    """An empty file beside `path` that takes its place in one step when the block ends, unless the block raises.

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
    """Replaces the file by `data`; see `whole_file`. Raises OSError; the old file then stays."""
    with whole_file(path, is_private=is_private) as file:
        file.write(data)


def private_opener(path: str, flags: int) -> int:
    """For `open`: nobody else may read what it makes."""
    return os.open(path, flags, 0o600)


def lock(file: IO[bytes], *, is_shared: bool = False) -> None:
    """Until the file is closed, at the latest when the program ends, however it ends. Never waits.

    Raises OSError where another one holds it.
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
