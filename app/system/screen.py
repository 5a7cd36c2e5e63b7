"""Checks whether a window can open, before Qt aborts with an unhelpful message (Linux only)."""

import os
import sys

from app.system.qt_libraries import install_command, missing, wanted_libraries
from app.text.i18n import tr
from app.text.sentences import join_sentences


def window_obstacle() -> str | None:
    """Why no window can open; None if nothing prevents it."""
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and platform in ("", "xcb", "wayland") and not has_screen:
        return tr("No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.")
    return missing_libraries()


def missing_libraries() -> str | None:
    """The missing libraries and the command that installs them; None if nothing is missing."""
    lacking = missing(wanted_libraries()) if sys.platform.startswith("linux") else {}
    if not lacking:
        return None
    what = tr("Missing system libraries: {names}.", names=", ".join(lacking))
    command = install_command(lacking.values())
    return what if command is None else join_sentences((what, tr("Type: {command}", command=command)))
