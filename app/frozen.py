"""Entry point of PyInstaller's bundle.

Restores the library path for programs that `dps-s` starts, and shows errors on Windows, where a windowed program has
no console.
"""

import io
import os
import sys
from multiprocessing import freeze_support

_ICON_ERROR = 0x10
"""MB_ICONERROR"""


def restore_library_path() -> None:
    """Programs that this one starts, such as the browser, must not load the bundle's libraries."""
    original = os.environ.pop("LD_LIBRARY_PATH_ORIG", None)
    if original is not None:
        os.environ["LD_LIBRARY_PATH"] = original
    else:
        os.environ.pop("LD_LIBRARY_PATH", None)


def _run_without_console() -> int:
    """Run without standard output; what was printed is shown in a message box if the program fails."""
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
    from app.start import interruptible

    return interruptible(_main)


def _main() -> int:
    from app.__main__ import main

    return main()


def begin() -> int:
    """Run the program; returns the exit code."""
    if sys.platform.startswith("linux"):
        restore_library_path()
    return _run_without_console() if sys.stdout is None else _run()


if __name__ == "__main__":
    freeze_support()  # worker processes run this file, too, and end here
    sys.exit(begin())
