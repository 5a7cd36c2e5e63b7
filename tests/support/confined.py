"""Confines a process that acts at random: what it does to files, it does in a home of its own.

A file dialog of Qt once took the folder away in which the tests were started, by one press of Delete. So random hands
never run in a process that could write anywhere else.
"""

import ctypes
import os
import shutil
import struct
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

_CREATE_RULESET: Final = 444
_ADD_RULE: Final = 445
_RESTRICT_SELF: Final = 446
_RULE_PATH_BENEATH: Final = 1
_NO_NEW_PRIVILEGES: Final = 38
"""Of `prctl`."""
_WRITE_FILE: Final = 1 << 1
_REMOVE_AND_MAKE: Final = sum(1 << bit for bit in range(4, 13))
"""Removing folders and files, and making each kind of entry."""
_MOVE: Final = 1 << 13
_TRUNCATE: Final = 1 << 14
_WRITING: Final = _WRITE_FILE | _REMOVE_AND_MAKE | _MOVE | _TRUNCATE
_VERSION_WITH_TRUNCATE: Final = 3
DEVICES: Final = Path("/dev")
"""Pseudo-terminals and shared memory."""


class NotConfined(Exception):
    """Nothing keeps this process in its home, and it may write everywhere."""


def own_home(home: Path) -> None:
    """Makes `home` the home, the working folder and the place of temporary files of this process."""
    home.mkdir(parents=True, exist_ok=True)
    os.environ["HOME"] = str(home)
    for one in ("CONFIG", "DATA", "STATE", "CACHE"):
        os.environ[f"XDG_{one}_HOME"] = str(home / one.lower())
    for one in ("APPDATA", "LOCAL_APPDATA", "COMMON_APPDATA", "PERSONAL"):
        os.environ[f"WIN_PD_OVERRIDE_{one}"] = str(home / one.lower())
    temporary = home / "tmp"
    temporary.mkdir(exist_ok=True)
    tempfile.tempdir = str(temporary)
    os.environ["TMPDIR"] = str(temporary)
    os.chdir(home)


def confine(home: Path) -> None:
    """Lets this process and those that it starts write below `home` only, for good.

    Raises NotConfined where the system cannot do that and this is a user who may write everywhere.
    """
    own_home(home)
    if sys.platform == "linux" and _landlock_version() >= _VERSION_WITH_TRUNCATE:
        _restrict(home, DEVICES)
    elif hasattr(os, "geteuid") and os.geteuid() == 0:
        raise NotConfined("random input never runs as root where nothing confines it")


@contextmanager
def confined_home() -> Iterator[Path]:
    """A temporary home, to which this process is confined for good."""
    folder = Path(tempfile.mkdtemp(prefix="dps-s-hands-"))
    confine(folder)
    try:
        yield folder
    finally:
        # It can empty its home, but not remove it, which is an entry of the folder above: an empty folder stays.
        shutil.rmtree(folder, ignore_errors=True)


def _syscall(number: int, *words: object) -> int:
    result: int = ctypes.CDLL(None, use_errno=True).syscall(number, *words)
    return result


def _landlock_version() -> int:
    """0 or less without Landlock."""
    return _syscall(_CREATE_RULESET, None, 0, 1)


def _restrict(*folders: Path) -> None:
    wanted = struct.pack("=Q", _WRITING)
    rules = _syscall(_CREATE_RULESET, wanted, len(wanted), 0)
    if rules < 0:
        raise NotConfined(os.strerror(ctypes.get_errno()))
    try:
        for folder in folders:
            below = os.open(folder, os.O_PATH | os.O_CLOEXEC)  # type: ignore[attr-defined,unused-ignore]
            try:
                rule = struct.pack("=Qi", _WRITING, below)
                if _syscall(_ADD_RULE, rules, _RULE_PATH_BENEATH, rule, 0):
                    raise NotConfined(os.strerror(ctypes.get_errno()))
            finally:
                os.close(below)
        ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
        if _syscall(_RESTRICT_SELF, rules, 0):
            raise NotConfined(os.strerror(ctypes.get_errno()))
    finally:
        os.close(rules)
