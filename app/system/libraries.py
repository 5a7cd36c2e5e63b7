"""Whether a window can open: Qt's libraries on Linux with the packages that have them, and the screen.

On other systems the PySide6 wheel contains everything. Standard library only: used before anything is installed.
"""

import ctypes
import os
import shutil
import sys
from collections.abc import Iterable, Mapping
from typing import Final

from app.text.i18n import tr
from app.text.messages import join_sentences

# Those that others bring with them, or that every system has, are left out.
ALWAYS: Final = {
    "libglib-2.0.so.0": "libglib2.0-0",  # newer releases call it libglib2.0-0t64, and know this name, too
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libfontconfig.so.1": "libfontconfig1",
    "libdbus-1.so.3": "libdbus-1-3",
}
FOR_X: Final = {
    "libX11-xcb.so.1": "libx11-xcb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-shape.so.0": "libxcb-shape0",
}


def missing(libraries: Mapping[str, str]) -> dict[str, str]:
    """Return the libraries that cannot be loaded."""
    lacking: dict[str, str] = {}
    for name, package in libraries.items():
        try:
            ctypes.CDLL(name)
        except OSError:
            lacking[name] = package
    return lacking


def install_command(packages: Iterable[str]) -> str | None:
    """Return what a person types to install these packages of Debian; None on another system."""
    return f"sudo apt-get install {' '.join(packages)}" if shutil.which("apt-get") else None


def window_obstacle() -> str | None:
    """Why no window can open; None if nothing prevents it."""
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and platform in ("", "xcb", "wayland") and not has_screen:
        return tr("No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.")
    return missing_libraries()


def missing_libraries() -> str | None:
    """The missing libraries and the command that installs them; None if nothing is missing."""
    if not sys.platform.startswith("linux"):
        return None
    is_x = bool(os.environ.get("DISPLAY")) and os.environ.get("QT_QPA_PLATFORM", "") in ("", "xcb")
    lacking = missing(ALWAYS | FOR_X if is_x and os.environ.get("XDG_SESSION_TYPE") != "wayland" else ALWAYS)
    if not lacking:
        return None
    what = tr("Missing system libraries: {names}.", names=", ".join(lacking))
    command = install_command(lacking.values())
    return what if command is None else join_sentences((what, tr("Type: {command}", command=command)))
