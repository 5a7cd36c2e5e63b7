"""A home of its own for a process that acts at random.

A file dialog of Qt once took the folder away in which the tests were started, by one press of Delete. The program's
dialogs are read-only since, and random hands get none; still they run where there is nothing to lose.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def confined_home() -> Iterator[Path]:
    """Make a temporary folder the home, the working folder and the place of temporary files of this process."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="dps-s-hands-", ignore_cleanup_errors=True) as name:
        home = Path(name)
        os.environ |= {"HOME": name, "TMPDIR": name}
        os.environ |= {f"XDG_{one}_HOME": str(home / one.lower()) for one in ("CONFIG", "DATA", "STATE", "CACHE")}
        for one in ("APPDATA", "LOCAL_APPDATA", "COMMON_APPDATA", "PERSONAL"):
            os.environ[f"WIN_PD_OVERRIDE_{one}"] = str(home / one.lower())
        tempfile.tempdir = name
        os.chdir(home)
        try:
            yield home
        finally:
            os.chdir(before)
            tempfile.tempdir = None
