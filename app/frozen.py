"""Start of the packaged program: `dps-s` without a Python of the system.

PyInstaller's bundle runs this file first. It restores the library path for the programs that it starts, and shows
errors on Windows, where a window's program has no console.
"""

import io
import os
import sys
from multiprocessing import freeze_support

_ICON_ERROR = 0x10
"""MB_ICONERROR"""


def give_back_library_path() -> None:
    """The bundle's libraries are for this program alone, not for the browser or the lister of ports that it starts."""
    original = os.environ.pop("LD_LIBRARY_PATH_ORIG", None)
    if original is not None:
        os.environ["LD_LIBRARY_PATH"] = original
    else:
        os.environ.pop("LD_LIBRARY_PATH", None)


def _run_without_console() -> int:
    """Windows gives a window's program no output; what would have been said there is shown when it ends in failure."""
    said = io.StringIO()
    sys.stdout = sys.stderr = said
    code = _run()
    if code and said.getvalue().strip():
        _show_error(said.getvalue().strip())
    return code


def _show_error(text: str) -> None:
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.user32.MessageBoxW(None, text, "DPS-S Configurator", _ICON_ERROR)


def _run() -> int:
    from app.__main__ import main

    return main()


def begin() -> int:
    """The whole program; its exit code."""
    if sys.platform.startswith("linux"):
        give_back_library_path()
    return _run_without_console() if sys.stdout is None else _run()


if __name__ == "__main__":
    freeze_support()  # a worker process is this program too; it never gets further than here
    sys.exit(begin())
