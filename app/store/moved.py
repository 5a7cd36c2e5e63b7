"""The store's file was removed, moved or replaced while the program has it open; Windows refuses that, others do not.

SQLite would go on writing into a file without a name. So before each use the places of the file, its write-ahead log
and its index are compared with what was there at the opening. What is open still holds everything:

    nothing at the place, or without our log     it is written there again
    one that holds less, is damaged or empty     it is written there again; a damaged one stays under another name
    one that holds all of it                     another window has put it there; it is used
    one that went on elsewhere                   it stays; what is open is kept beside it, and no longer used

A fact names the one before by its hash, so who has the last one has all.
"""

import os
import sqlite3
from collections.abc import Callable
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from app.store.copies import write_copy
from app.store.schema import check_copy

COMPANIONS = ("", "-wal", "-shm")
Places = tuple[tuple[int, int] | None, ...]
"""Device and number of the file, its log and its index; None: nothing is there. Empty on Windows."""


class MovedOn(Exception):
    """The file at the place is another one. `aside`: where what is open was written."""

    def __init__(self, aside: Path) -> None:
        self.aside = aside
        super().__init__(f"another file is in its place; what was open is kept as {aside}")


def companions(path: Path) -> tuple[Path, ...]:
    return tuple(path.with_name(path.name + companion) for companion in COMPANIONS)


def places(path: Path) -> Places:
    return tuple(_place(file) for file in companions(path)) if os.name != "nt" else ()


def _place(file: Path) -> tuple[int, int] | None:
    try:
        found = file.stat()
    except FileNotFoundError:
        return None
    return found.st_dev, found.st_ino


class Opened(NamedTuple):
    """`writing` holds the lock for writing: programs that share what lost its place come one after the other."""

    path: Path
    places: Places
    writing: sqlite3.Connection
    reading: sqlite3.Connection


def put_back(opened: Opened, clock: Callable[[], datetime]) -> None:
    """Raises `MovedOn`, OSError or `sqlite3.Error`."""
    path = opened.path
    check_copy(opened.reading)  # a damaged one takes the place of none
    path.parent.mkdir(parents=True, exist_ok=True)
    for file, place in tuple(zip(companions(path), opened.places, strict=True))[1:]:
        if place is not None and _place(file) == place:
            file.unlink()  # SQLite would apply it to the other file
    try:
        if _place(path) in (None, opened.places[0]) or not _holds_all(opened):
            write_copy(opened.reading, path)
    except sqlite3.OperationalError:
        raise
    except sqlite3.DatabaseError:
        set_aside(path, clock)
        write_copy(opened.reading, path)
    except LookupError:
        aside = free_name(path, clock)
        write_copy(opened.reading, aside)
        raise MovedOn(aside) from None


def _holds_all(opened: Opened) -> bool:
    """The file at the place; False where it holds a part. Raises LookupError where neither has all of the other's,
    `sqlite3.DatabaseError` where it is not good."""
    with closing(sqlite3.connect(opened.path)) as other:
        check_copy(other)
        if _has(other, _last(opened.writing)):
            return True
        if _has(opened.writing, _last(other)):
            return False
        raise LookupError


def _last(connection: sqlite3.Connection) -> str | None:
    row = connection.execute("SELECT hash FROM facts ORDER BY number DESC LIMIT 1").fetchone()
    return row[0] if row else None


def _has(connection: sqlite3.Connection, fact: str | None) -> bool:
    return fact is None or connection.execute("SELECT 1 FROM facts WHERE hash = ?", (fact,)).fetchone() is not None


def set_aside(path: Path, clock: Callable[[], datetime]) -> Path:
    """Rename the file, and its write-ahead log with it: together they may be repaired one day."""
    aside = free_name(path, clock)
    for source, target in reversed(tuple(zip(companions(path), companions(aside), strict=True))):
        if source.exists():
            source.rename(target)
    return aside


def free_name(path: Path, clock: Callable[[], datetime]) -> Path:
    stamp = clock().strftime("%Y%m%d-%H%M%S")
    number = 1
    while (aside := path.with_name(f"{path.stem}.aside-{stamp}-{number}{path.suffix}")).exists():
        number += 1
    return aside
