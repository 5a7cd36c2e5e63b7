"""Libraries that the programs in a folder need from a Linux system, found with `objdump`."""

import os
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

_MAGIC: Final = b"\x7fELF"
_NEEDED: Final = re.compile(r"^\s+NEEDED\s+(\S+)$", re.MULTILINE)
_RUN_PATH: Final = re.compile(r"^\s+(?:RUNPATH|RPATH)\s+(\S+)$", re.MULTILINE)
_GLIBC: Final = re.compile(r"\bGLIBC_(\d+)\.(\d+)\b")


class Glibc(NamedTuple):
    """A version of the C library."""

    major: int
    minor: int


@dataclass(frozen=True, slots=True)
class Wanted:
    """What one file needs; `glibc` may be None."""

    path: Path
    libraries: frozenset[str]
    glibc: Glibc | None


def wanted_by(folder: Path) -> Iterator[Wanted]:
    """What each program and library below `folder` needs."""
    for path in sorted(folder.rglob("*")):
        if path.is_symlink() or not path.is_file() or not _is_elf(path):
            continue
        shown = _shown(path)
        versions = [Glibc(int(major), int(minor)) for major, minor in _GLIBC.findall(shown)]
        yield Wanted(path, frozenset(_NEEDED.findall(shown)), max(versions, default=None))


def _shown(path: Path) -> str:
    state = path.stat()
    return _dumped(path, state.st_size, state.st_mtime_ns)


@cache
def _dumped(path: Path, _size: int, _changed: int) -> str:
    """Cached; size and time make sure that a changed file is read again."""
    variables = {**os.environ, "LC_ALL": "C"}  # independent of the locale
    done = subprocess.run(["objdump", "-p", str(path)], capture_output=True, text=True, check=True, env=variables)
    return done.stdout


def foreign_run_path(path: Path) -> str | None:
    """The absolute run path of a library, or None.

    A Python that was not built by a distribution writes its folder into all that it compiles.
    """
    found = _RUN_PATH.search(_shown(path)) if _is_elf(path) else None
    return found[1] if found is not None and found[1].startswith("/") else None


def make_run_path_relative(path: Path, run_path: str) -> None:
    """Overwrite that run path by ``$ORIGIN``, the library's folder. The file keeps its length and layout."""
    own = b"$ORIGIN"
    old = run_path.encode()
    if len(old) < len(own):
        raise ValueError(f"the run path {run_path} of {path} has no room for {own.decode()}")
    content = path.read_bytes()
    path.write_bytes(content.replace(old + b"\0", own.ljust(len(old) + 1, b"\0")))


def _is_elf(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) == _MAGIC


def glibc_wanted(folder: Path) -> Glibc:
    """The oldest C library with which everything in `folder` starts."""
    return max(one.glibc for one in wanted_by(folder) if one.glibc is not None)


def outside_libraries(folder: Path) -> dict[str, list[Path]]:
    """Libraries that are needed and not in `folder`, each with the files that need it."""
    found = list(wanted_by(folder))
    inside = {path.name for path in folder.rglob("*") if path.is_file()}
    outside: dict[str, list[Path]] = {}
    for one in found:
        for library in sorted(one.libraries - inside):
            outside.setdefault(library, []).append(one.path)
    return outside
