"""Once a day a copy of the store; the newest seven are kept."""

import logging
import os
import sqlite3
from contextlib import closing
from datetime import datetime
from pathlib import Path

from app.store.opening import COPIES, connect_to_read, copies_of, copy_name
from app.system.files import private_opener

_log = logging.getLogger(__name__)

COPIES_KEPT = 7


def copy_if_due(path: Path, now: datetime) -> None:
    """To be called in a thread of its own: an act's intent would wait for it. A copy that fails is logged."""
    target = path.parent / COPIES / copy_name(path, now)
    draft = target.with_suffix(".part")
    try:
        if target.exists() or _is_new(path):
            return
        target.parent.mkdir(exist_ok=True)
        _copy(path, draft)
        draft.replace(target)
        for old in copies_of(path, now)[COPIES_KEPT:]:
            old.unlink(missing_ok=True)
    except (sqlite3.Error, OSError) as error:
        _log.warning("The store could not be copied: %s", error)


def _is_new(path: Path) -> bool:
    """It holds nothing but the name of its station: it is copied when it is opened again."""
    with closing(connect_to_read(path)) as connection:
        return len(connection.execute("SELECT 1 FROM facts LIMIT 2").fetchall()) < 2


def _copy(path: Path, draft: Path) -> None:
    """Whole and on the disk. Raises `sqlite3.Error`, as for a store that is damaged, or OSError."""
    draft.unlink(missing_ok=True)
    with open(draft, "xb", opener=private_opener):
        pass
    with closing(connect_to_read(path)) as source:
        source.execute("VACUUM INTO ?", (str(draft),))
    with draft.open("rb+") as file:
        os.fsync(file.fileno())  # VACUUM INTO itself does not wait for the disk
