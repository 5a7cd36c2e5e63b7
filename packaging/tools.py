"""The programs that building and judging the packages needs from the system."""

import shutil
import sys
from typing import Final, NamedTuple


class Tool(NamedTuple):
    """A program and the package that has it, per package manager."""

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


def missing_tools() -> tuple[Tool, ...]:
    """Those that are not on the search path; Windows and macOS bring what PyInstaller needs."""
    if not sys.platform.startswith("linux"):
        return ()
    return tuple(tool for tool in FOR_LINUX if shutil.which(tool.program) is None)
