"""Start of the packaged program: `dps-s` without a Python of the system.

PyInstaller's bundle runs this file first. It restores the library path for the programs that it starts, names the
system libraries that Qt lacks before Qt aborts, and shows errors on Windows, where a window's program has no console.
"""

import io
import os
import sys
from collections.abc import Sequence
from multiprocessing import freeze_support
from pathlib import Path

WINDOW = "gui"
NEEDS_QT = ("preflight",)
"""Sub-commands that load Qt without opening a window."""
LACKING = 3
_ICON_ERROR = 0x10
"""MB_ICONERROR"""


def give_back_library_path() -> None:
    """The bundle's libraries are for this program alone, not for the browser or the lister of ports that it starts."""
    original = os.environ.pop("LD_LIBRARY_PATH_ORIG", None)
    if original is not None:
        os.environ["LD_LIBRARY_PATH"] = original
    else:
        os.environ.pop("LD_LIBRARY_PATH", None)


def what_qt_lacks(words: Sequence[str]) -> str | None:
    """The sentence about the screen or the system libraries without which Qt would die, or None where it will start.

    `words` are the command line's. Nothing is looked for where Qt is not wanted.
    """
    is_window = not words or words[0] == WINDOW or (words[0].startswith("-") and words[0] not in _ANSWERED_AT_ONCE)
    is_window |= bool(words) and Path(words[0]).is_file()
    asks_for_help = "-h" in words or "--help" in words
    if not sys.platform.startswith("linux") or asks_for_help or not (is_window or words[0] in NEEDS_QT):
        return None
    if is_window and _is_screen_missing():
        return (
            "There is no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set); dps-s --help tells what needs none."
        )
    return _missing_libraries(is_window=is_window)


_ANSWERED_AT_ONCE = ("-h", "--help", "--version")


def _is_screen_missing() -> bool:
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    is_there = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return platform in ("", "xcb", "wayland") and not is_there


def _missing_libraries(*, is_window: bool) -> str | None:
    from app.system.qt_libraries import lacking_sentence, wanted_libraries

    asked = (Path(sys._MEIPASS) / "system-libraries.txt").read_text(encoding="utf-8").split()  # type: ignore[attr-defined]
    wanted = wanted_libraries(is_screen_wanted=is_window)
    return lacking_sentence(tuple(library for library in wanted if library.soname in asked))


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
    sentence = what_qt_lacks(sys.argv[1:])
    if sentence is not None:
        print(sentence, file=sys.stderr)
        return LACKING
    return _run_without_console() if sys.stdout is None else _run()


if __name__ == "__main__":
    freeze_support()  # a worker process is this program too; it never gets further than here
    sys.exit(begin())
