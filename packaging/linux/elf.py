"""What programs and libraries want from a Linux system, as `objdump` shows it."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from environment import run

_RUN_PATH: Final = re.compile(r"^\s+(?:RUNPATH|RPATH)\s+(/\S+)$", re.MULTILINE)
_OWN_FOLDER: Final = b"$ORIGIN"


def shown(folder: Path) -> Iterator[tuple[Path, str]]:
    """Each program and library below `folder` with what it says of itself."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink():
            with path.open("rb") as file:
                is_program = file.read(4) == b"\x7fELF"
            if is_program:
                yield path, run(["objdump", "-p", str(path)], "objdump failed", variables={"LC_ALL": "C"})


def make_run_paths_relative(folder: Path) -> None:
    """A Python that was not built by a distribution writes its folder into all that it compiles.

    The library's own folder takes its place; the file keeps its length and layout.
    """
    for path, said in shown(folder):
        match = _RUN_PATH.search(said)
        if match is not None:
            old = match[1].encode()
            if len(old) < len(_OWN_FOLDER):
                raise ValueError(f"the run path {match[1]} of {path} has no room for {_OWN_FOLDER.decode()}")
            content = path.read_bytes()
            path.write_bytes(content.replace(old + b"\0", _OWN_FOLDER.ljust(len(old) + 1, b"\0")))
