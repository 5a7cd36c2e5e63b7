"""The programs that building and judging the packages needs from the system, installed where this user may."""

import os
import shutil
import sys
from typing import Final, NamedTuple

from environment import SetupError, install_with_apt

from app.system.qt_libraries import INSTALL, package_manager


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


def need_tools() -> None:
    """Make sure that all are here; raises SetupError with the command to type where they cannot be installed.

    Windows and macOS bring what PyInstaller needs.
    """
    if not sys.platform.startswith("linux"):
        return
    reason = "Programs that build packages are not here"
    lacking = missing_tools()
    if not lacking:
        return
    manager = package_manager()
    if manager == "apt":
        install_with_apt([tool.apt for tool in lacking], reason=reason)
        lacking = missing_tools()
        if lacking:
            raise SetupError(f"The packages are installed, yet {_names(lacking)} cannot be found.")
    elif manager is not None:
        packages = " ".join(getattr(tool, manager) for tool in lacking)
        prefix = "" if os.geteuid() == 0 else "sudo "
        raise SetupError(f"{reason}. Type: {prefix}{INSTALL[manager]} {packages}")
    else:
        raise SetupError(f"{reason}: {_names(lacking)}. Install them, then run this again.")


def missing_tools() -> tuple[Tool, ...]:
    """Those that are not on the search path."""
    return tuple(tool for tool in FOR_LINUX if shutil.which(tool.program) is None)


def _names(tools: tuple[Tool, ...]) -> str:
    return ", ".join(tool.program for tool in tools)
