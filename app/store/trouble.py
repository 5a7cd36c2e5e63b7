"""What a person reads where the store cannot be used."""

import errno
import shutil
import sqlite3
from contextlib import suppress
from enum import Enum
from pathlib import Path

from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

MIN_FREE_BYTES = 64 * 1024
"""With less there is no room for a commit."""


class StoreFault(Enum):
    """The value is a sentence in English with the place for the file, translatable."""

    FULL = marked("The disk is full: {file} cannot be written.")
    READ_ONLY = marked("The program may not write into {file}.")
    NEWER = marked("{file} needs a newer version of this program.")
    BUSY = marked("{file} is held by another program.")
    DAMAGED = marked("{file} is damaged.")
    FAILED = marked("{file} cannot be used.")
    OPENING = marked("{file} is still being opened.")


class StoreTrouble(UserError):
    """The store cannot be opened, read or written. What was stored before is kept. `detail` is for the log."""

    code = ErrorCode.STORE

    def __init__(self, fault: StoreFault, path: Path, detail: str = "") -> None:
        super().__init__(fault.value, file=path)
        self.fault, self.path, self.detail = fault, path, detail

    def __str__(self) -> str:
        return f"{self.path}: {self.fault.name}: {self.detail}"


_FAULTS = {
    "SQLITE_FULL": StoreFault.FULL,
    "SQLITE_READONLY": StoreFault.READ_ONLY,
    "SQLITE_CANTOPEN": StoreFault.READ_ONLY,
    "SQLITE_PERM": StoreFault.READ_ONLY,
    "SQLITE_BUSY": StoreFault.BUSY,
    "SQLITE_LOCKED": StoreFault.BUSY,
    "SQLITE_CORRUPT": StoreFault.DAMAGED,
    "SQLITE_NOTADB": StoreFault.DAMAGED,
}


def trouble_of(error: sqlite3.Error | OSError, path: Path) -> StoreTrouble:
    if isinstance(error, OSError):
        fault = StoreFault.FULL if error.errno == errno.ENOSPC else StoreFault.READ_ONLY
        return StoreTrouble(fault, path, str(error))
    name = getattr(error, "sqlite_errorname", "") or ""
    fault = next((fault for start, fault in _FAULTS.items() if name.startswith(start)), StoreFault.FAILED)
    if fault in (StoreFault.READ_ONLY, StoreFault.FAILED) and _is_full(path):
        fault = StoreFault.FULL  # of a full disk SQLite only says that a file beside it cannot be opened
    return StoreTrouble(fault, path, str(error))


def _is_full(path: Path) -> bool:
    with suppress(OSError):
        return shutil.disk_usage(path.parent).free < MIN_FREE_BYTES
    return False
