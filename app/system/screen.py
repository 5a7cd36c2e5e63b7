"""Checks whether a window can open, before Qt aborts with an unhelpful message (Linux only)."""

import ctypes
import os
import sys

from app.system.qt_libraries import install_command, missing, wanted_libraries
from app.text.i18n import tr
from app.text.sentences import join_sentences


def window_obstacle() -> str | None:
    """Why no window can open; None if nothing prevents it."""
    if not sys.platform.startswith("linux"):
        return None
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    x, wayland = os.environ.get("DISPLAY"), os.environ.get("WAYLAND_DISPLAY")
    if platform in ("", "xcb", "wayland") and not (x or wayland):
        return tr("No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.")
    lacking = missing_libraries()
    if lacking is not None:
        return lacking
    if platform == "xcb" or (not platform and not wayland):
        return tr("The screen {screen} does not let this user open a window.", screen=x) if _refuses_x() else None
    return None


def missing_libraries() -> str | None:
    """The missing libraries and the command that installs them; None if nothing is missing."""
    lacking = missing(wanted_libraries()) if sys.platform.startswith("linux") else {}
    if not lacking:
        return None
    what = tr("Missing system libraries: {names}.", names=", ".join(lacking))
    command = install_command(lacking.values())
    return what if command is None else join_sentences((what, tr("Type: {command}", command=command)))


def _refuses_x() -> bool:
    """Whether the X server named by DISPLAY is missing or refuses this user."""
    try:
        xcb = ctypes.CDLL("libxcb.so.1")
    except OSError:
        return False
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(None, None))
    is_refused = bool(xcb.xcb_connection_has_error(connection))
    xcb.xcb_disconnect(connection)
    return is_refused
