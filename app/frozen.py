"""Entry point of PyInstaller's bundle, and of `dps-s-window` where pip installed it.

Restores the library path for programs that `dps-s` starts, and shows errors on Windows, where a windowed program has
no console.
"""

import io
import os
import sys
from collections.abc import Callable
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


def _run_without_console(run: Callable[[], int]) -> int:
    """Run without standard output; what was printed is shown in a message box if the program fails."""
    output = io.StringIO()
    sys.stdout = sys.stderr = output
    code = run()
    if code and output.getvalue().strip():
        _show_error(output.getvalue().strip())
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
    return _run_without_console(_run) if sys.stdout is None else _run()


def open_installed() -> int:
    """Run the program that pip installed where no console is opened; returns the exit code."""
    from app.start import main

    return _run_without_console(main) if sys.stdout is None else main()


if __name__ == "__main__":
    freeze_support()  # worker processes run this file, too, and end here
    sys.exit(begin())
