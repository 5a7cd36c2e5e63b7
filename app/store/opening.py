"""Opens and copies the store's file; says what a person reads where that cannot be done.

not there, empty     made; from the newest good copy, where there is one
damaged, another's   set aside under another name, and as above
of a development build   set aside; what it leaves ACTIVE is taken over
a newer version's, held, not writable    left alone: `StoreTrouble`

Its audit log had an intent (`act`) and what came of it (`outcome`, linked by the intent's hash), both as JSON.
"""

import errno
import json
import logging
import os
import shutil
import sqlite3
from contextlib import closing, suppress
from datetime import UTC, datetime
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from app.safety.left_active import LEFT
from app.text.messages import ErrorCode, UserError, UserMessage, joined, message
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


_log = logging.getLogger(__name__)

FILE_NAME = "dps-s.sqlite"
# "DPSS": how our file is told from another program's.
APPLICATION_ID = 0x44505353
LAYOUT = 20
# How long another program may hold the file before a call fails.
BUSY_S = 5.0
COPIES = "copies"
COPIES_KEPT = 7
_KEPT = "BEGIN SELECT RAISE(ABORT, 'facts are only ever added'); END"
TABLES = (
    """
    CREATE TABLE facts (
        id TEXT PRIMARY KEY,
        kind TEXT NOT NULL,
        module TEXT,
        station TEXT NOT NULL,
        made_at TEXT NOT NULL,
        content TEXT NOT NULL
    ) STRICT
    """,
    "CREATE INDEX facts_of_module ON facts (module, kind, made_at)",
    "CREATE INDEX facts_of_kind ON facts (kind, made_at)",
    f"CREATE TRIGGER facts_not_changed BEFORE UPDATE ON facts {_KEPT}",
    f"CREATE TRIGGER facts_not_removed BEFORE DELETE ON facts {_KEPT}",
    "CREATE TABLE state (key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT",
)


class Opened(NamedTuple):
    """`notice`: what a person should know. `former`: a file of a development build that was set aside."""

    connection: sqlite3.Connection
    notice: UserMessage | None = None
    former: Path | None = None


class _OfDevelopment(sqlite3.DatabaseError):
    """The layout is one that was never released."""


def open_file(path: Path) -> Opened:
    """Raises `sqlite3.Error`, `OSError` or `StoreTrouble`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(OSError):
        path.parent.chmod(0o700)  # what is in it is for this user only
    was_there = path.exists() and path.stat().st_size > 0
    try:
        if not was_there and copies_of(path):
            raise sqlite3.DatabaseError("empty or gone")
        return Opened(connect(path))
    except sqlite3.OperationalError:
        raise  # a lock, a full disk or a missing permission: the file itself is not bad
    except sqlite3.DatabaseError as error:
        aside = _set_aside(path)
        copy = _restore(path)
        parts = []
        if was_there:
            parts.append(message(marked("The records cannot be used and are kept as {file}."), file=aside))
        if copy is None:
            parts.append(message(marked("New records are started.")))
        else:
            text = marked("Records restored from the copy of {when}; later ones are missing.")
            parts.append(message(text, when=copy.name.split(".")[1]))
        return Opened(connect(path), joined(parts, " "), aside if isinstance(error, _OfDevelopment) else None)


def connect(path: Path, *, is_checked: bool = True) -> sqlite3.Connection:
    """The file; made where it is missing. `is_checked`: as a whole, which takes a second for 200 MB. Raises as
    `open_file`."""
    # As an address, so that a file may be attached as one that is only read.
    address = path.absolute().as_uri()
    connection = sqlite3.connect(address, uri=True, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
    try:
        is_new = not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if not is_new:
            _check(connection, path, is_whole=is_checked)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA recursive_triggers = ON")  # else INSERT OR REPLACE removes a row in silence
        if is_new:
            make_tables(connection)
    except BaseException:
        connection.close()
        raise
    return connection


def connect_to_read(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=BUSY_S)


def make_tables(connection: sqlite3.Connection) -> None:
    """In one transaction. Another program may have made them while this one waited for the lock."""
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        if not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            for statement in TABLES:
                connection.execute(statement)
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version = {LAYOUT}")


def _check(connection: sqlite3.Connection, path: Path, *, is_whole: bool = True) -> None:
    """Raises `sqlite3.DatabaseError` for one that is damaged or of something else, `StoreTrouble` for a newer one."""
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    layout = connection.execute("PRAGMA user_version").fetchone()[0]
    if application != APPLICATION_ID:
        raise sqlite3.DatabaseError("of another program")
    if layout > LAYOUT:
        raise StoreTrouble(StoreFault.NEWER, path, f"layout {layout}")
    if layout < LAYOUT:
        raise _OfDevelopment("of a development build")
    if is_whole and connection.execute("PRAGMA quick_check(1)").fetchone()[0] != "ok":
        raise sqlite3.DatabaseError("damaged")


def _set_aside(path: Path) -> Path:
    """The file, its log and its index under another name; what is put in its place must not meet an old log."""
    aside = path.with_name(f"{path.stem}.aside-{datetime.now(UTC):%Y%m%d-%H%M%S-%f}{path.suffix}")
    for end in ("", "-wal", "-shm"):
        with suppress(FileNotFoundError):
            Path(f"{path}{end}").replace(f"{aside}{end}")
    return aside


# Copies


def copies_of(path: Path) -> list[Path]:
    """The newest first."""
    return sorted((path.parent / COPIES).glob(f"{path.stem}.*{path.suffix}"), reverse=True)


def copy_if_due(path: Path, now: datetime) -> None:
    """Once a day, in a thread of its own: an act's intent would wait for it. The newest seven are kept. A copy that
    fails is logged."""
    target = path.parent / COPIES / f"{path.stem}.{now.astimezone(UTC):%Y%m%d}{path.suffix}"
    draft = target.with_suffix(".part")
    try:
        with closing(connect_to_read(path)) as source:
            # One that knows only its own station is copied when it is opened again.
            if target.exists() or len(source.execute("SELECT 1 FROM facts LIMIT 2").fetchall()) < 2:
                return
            target.parent.mkdir(exist_ok=True)
            draft.unlink(missing_ok=True)
            source.execute("VACUUM INTO ?", (str(draft),))
        with draft.open("rb+") as file:
            os.fsync(file.fileno())  # VACUUM INTO itself does not wait for the disk
        draft.replace(target)
        for old in copies_of(path)[COPIES_KEPT:]:
            old.unlink(missing_ok=True)
    except (sqlite3.Error, OSError) as error:
        _log.warning("The store could not be copied: %s", error)


def _restore(path: Path) -> Path | None:
    """Which copy took the place of the file; it stays."""
    for copy in copies_of(path):
        with closing(connect_to_read(copy)) as connection, suppress(sqlite3.DatabaseError, StoreTrouble):
            _check(connection, copy)
            shutil.copyfile(copy, path)
            return copy
    return None


_QUERY = """
    SELECT a.number, a.made_at, a.payload, o.payload FROM facts a
    LEFT JOIN facts o ON o.kind = 'outcome' AND o.link = a.hash
    WHERE a.kind = 'act' AND a.link IN ('activate', 'lock', 'shutdown') ORDER BY a.number
"""
_LEAVES_ACTIVE = (("activate", "confirmed"), ("activate", "unknown"), ("lock", "refused"), ("lock", "unknown"))


def former_state(path: Path) -> dict[str, object]:
    """By key of the state; empty where the file cannot be read, which is logged."""
    try:
        with closing(connect_to_read(path)) as connection:
            rows = connection.execute(_QUERY).fetchall()
        return _left(rows)
    except (sqlite3.Error, ValueError, LookupError, TypeError, AttributeError) as error:  # nothing in it is trusted
        _log.warning("What %s leaves ACTIVE cannot be read: %s", path, error)
        return {}


def _left(rows: list[tuple[int, str, str, str | None]]) -> dict[str, object]:
    left: dict[str, tuple[str, dict[str, object]]] = {}
    for number, at, payload, ended in rows:
        content = json.loads(payload)
        outcome = "unknown" if ended is None else json.loads(ended)["outcome"]
        act, port, detail = content["act"], str(content["port"]), content["detail"]
        module, adapter = str(detail.get("module", "")), str(detail.get("adapter", ""))
        # A module without a name is known by its connection.
        known_as = module or f"{detail.get('run')} {adapter} {port}"
        if port.startswith("sim://"):
            continue
        if (act, outcome) in _LEAVES_ACTIVE:
            state: dict[str, object] = {"module": module, "port": port, "adapter": adapter, "at": at}
            state["is_lock_unconfirmed"] = act == "lock"
            left[known_as] = f"{LEFT}former {number}", state
        elif act != "activate" and outcome == "confirmed" and not detail.get("is_in_doubt"):
            left.pop(known_as, None)
    return dict(left.values())
