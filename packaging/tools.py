"""Programs of the system that building and checking packages, and testing, need."""

import shutil
import sys
from pathlib import Path
from typing import Final, NamedTuple


class Tool(NamedTuple):
    """A program, and its package for each package manager."""

    program: str
    apt: str
    dnf: str
    pacman: str
    zypper: str


FOR_LINUX: Final = (
    Tool("objdump", "binutils", "binutils", "binutils", "binutils"),
    Tool("dpkg-deb", "dpkg", "dpkg", "dpkg", "dpkg"),
    Tool("appstreamcli", "appstream", "appstream", "appstream", "AppStream"),
    Tool(
        "desktop-file-validate", "desktop-file-utils", "desktop-file-utils", "desktop-file-utils", "desktop-file-utils"
    ),
)

FOR_TESTS: Final = Tool("initdb", "postgresql", "postgresql-server", "postgresql", "postgresql-server")
"""PostgreSQL, whose server the tests of the archive start."""
FOR_REAL_KEYS: Final = (
    Tool("Xvfb", "xvfb", "xorg-x11-server-Xvfb", "xorg-server-xvfb", "xorg-x11-server-Xvfb"),
    Tool("xdotool", "xdotool", "xdotool", "xdotool", "xdotool"),
)
"""An X server without a screen, for the tests that press keys and click as a person does."""
_OF_DEBIAN: Final = Path("/usr/lib/postgresql")
"""Folder of its programs on Debian, by version."""


def has_server() -> bool:
    return shutil.which(FOR_TESTS.program) is not None or any(_OF_DEBIAN.glob(f"*/bin/{FOR_TESTS.program}"))


def missing_for_keys() -> tuple[Tool, ...]:
    return tuple(tool for tool in FOR_REAL_KEYS if shutil.which(tool.program) is None)


def missing_tools() -> tuple[Tool, ...]:
    """Those that are not in PATH. Windows and macOS have what PyInstaller needs."""
    if not sys.platform.startswith("linux"):
        return ()
    return tuple(tool for tool in FOR_LINUX if shutil.which(tool.program) is None)
