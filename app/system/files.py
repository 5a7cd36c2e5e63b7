"""Files that are replaced as a whole, files that are held, and what the system says against it as a sentence."""

import os
import shutil
import sys
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
    _LOCKED_BYTE = 0x7FFFFFFF  # in units of 4 GiB
else:
    import fcntl

CANNOT_READ: Final = marked("{file} cannot be read: {why}.")
CANNOT_WRITE: Final = marked("{file} cannot be written: {why}.")
_DRAFT_CHARACTERS = 40  # of the file's name in the draft's; of four bytes each they fit into the 255 of a name


@contextmanager
def file_troubles(text: str, file: Path) -> Iterator[None]:
    """Convert errors of the file system to `UserError`; `text` has the place-holders `file` and `why`."""
    try:
        yield
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise UserError(text, file=file, why=error_text(error)) from error


@contextmanager
def whole_file(path: Path, *, is_private: bool = False) -> Iterator[IO[bytes]]:
    """Replace the file when the block ends: readers see the old or the new one, also after a crash. If the block
    raises, the old one remains.

    What a symbolic link of this user leads to is replaced, and the link of somebody else itself. A pipe or a device is
    written to directly. `is_private`: nobody else may read it. Raises OSError.
    """
    if path.is_symlink() and _is_own(path):
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
            shutil.copymode(path, draft)
        draft.replace(path)
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes, *, is_private: bool = False) -> None:
    """Replace the file by `data`; see `whole_file`."""
    with whole_file(path, is_private=is_private) as file:
        file.write(data)


def _is_own(link: Path) -> bool:
    return sys.platform == "win32" or link.lstat().st_uid == os.geteuid()


def private_opener(path: str, flags: int) -> int:
    """For `open`: create files that only this user can read."""
    return os.open(path, flags, 0o600)


def lock(file: IO[bytes], *, is_shared: bool = False) -> None:
    """Hold the file until it is closed or the process ends. Never waits: raises OSError if another process holds it."""
    if sys.platform == "win32":
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        flags = _FAIL_AT_ONCE | (0 if is_shared else _EXCLUSIVE)
        where = _Overlapped(offset_high=_LOCKED_BYTE)
        handle = wintypes.HANDLE(msvcrt.get_osfhandle(file.fileno()))
        if not kernel.LockFileEx(handle, flags, 0, 1, 0, ctypes.byref(where)):
            raise ctypes.WinError(ctypes.get_last_error())
    else:
        fcntl.flock(file, (fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
