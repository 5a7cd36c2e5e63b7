"""What a person reads where the store cannot be used."""

import errno
import shutil
import sqlite3
from contextlib import suppress
from enum import Enum
from pathlib import Path

from app.text.user_error import ErrorCode, UserError
from protocol.translatable import marked

# With less there is no room for a commit.
MIN_FREE_BYTES = 64 * 1024


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
        self.fault = fault
        self._detail = f"{path}: {fault.name}: {detail}"

    def __str__(self) -> str:
        return self._detail


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
    else:
        # "SQLITE_IOERR_WRITE" is told by its first two words.
        name = "_".join((getattr(error, "sqlite_errorname", None) or "").split("_")[:2])
        fault = _FAULTS.get(name, StoreFault.FAILED)
        if fault in (StoreFault.READ_ONLY, StoreFault.FAILED) and _is_full(path):
            fault = StoreFault.FULL  # of a full disk SQLite only says that a file beside it cannot be opened
    return StoreTrouble(fault, path, str(error))


def _is_full(path: Path) -> bool:
    with suppress(OSError):
        return shutil.disk_usage(path.parent).free < MIN_FREE_BYTES
    return False
