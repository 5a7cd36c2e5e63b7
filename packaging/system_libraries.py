"""Finds and installs the packages that the program needs from a Linux system, all at once."""

import importlib.util
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from environment import VENV_PYTHON, SetupError, install_with_apt, say

from app.system.qt_libraries import (
    FOR_X,
    INSTALL,
    Requirement,
    missing,
    package_manager,
    package_names,
    wanted_libraries,
)

FOR_PACKAGES: Final = (
    Requirement("objdump", "binutils", "binutils", "binutils", "binutils"),
    Requirement("dpkg-deb", "dpkg", "dpkg", "dpkg", "dpkg"),
    Requirement("appstreamcli", "appstream", "appstream", "appstream", "AppStream"),
    Requirement("desktop-file-validate", *4 * ("desktop-file-utils",)),
)
_DATABASE: Final = Requirement("initdb", "postgresql", "postgresql-server", "postgresql", "postgresql-server")
FOR_REAL_KEYS: Final = (
    Requirement("Xvfb", "xvfb", "xorg-x11-server-Xvfb", "xorg-server-xvfb", "xorg-x11-server-Xvfb"),
    Requirement("xdotool", "xdotool", "xdotool", "xdotool", "xdotool"),
)
"""An X server without a screen, for the tests that press keys and click as a person does."""
_CHINESE_FONT: Final = Requirement(
    "a Chinese font", "fonts-wqy-microhei", "wqy-microhei-fonts", "wqy-microhei", "wqy-microhei-fonts"
)


class Need(NamedTuple):
    """What something is missing for."""

    reason: str
    lacking: tuple[Requirement, ...]
    is_optional: bool = False


def make_ready(*, is_first: bool, is_screen_wanted: bool, is_packaging: bool = False, is_testing: bool = False) -> None:
    """Make sure that the system has everything, before anything is downloaded.

    Installs it if this user may, else raises SetupError with one command for all of it. Optional packages (a Chinese
    font, Qt's libraries for a screen that is not there yet, both at the first time only, PostgreSQL and an X server for
    their tests) are installed with the others, and never stop anything.
    """
    if sys.platform != "linux":
        return
    manager = package_manager()
    needs_now = partial(_needs, manager, is_first=is_first, is_screen_wanted=is_screen_wanted,
                        is_packaging=is_packaging, is_testing=is_testing)  # fmt: skip
    needs = needs_now()
    required = [need for need in needs if not need.is_optional]
    if required:
        _install(manager, needs, reason=" and ".join(need.reason for need in required))
        still = [need for need in needs_now() if not need.is_optional]
        if still:
            raise SetupError(f"Still missing after the installation: {', '.join(_names(still, manager))}.")
    elif needs:
        try:
            _install(manager, needs, reason=" and ".join(need.reason for need in needs))
        except SetupError as error:
            say(f"{error}\nEverything else works without it.")


def _needs(
    manager: str | None, *, is_first: bool, is_screen_wanted: bool, is_packaging: bool, is_testing: bool
) -> list[Need]:
    needs = [Need("System libraries of Qt are missing", missing(wanted_libraries(is_screen_wanted=is_screen_wanted)))]
    if not VENV_PYTHON.exists() and not has_venv_module():
        needs.insert(0, Need("Python's venv module is missing", (_venv_package(manager),)))
    if is_packaging:
        needs.append(Need("programs that build packages are missing", _not_here(FOR_PACKAGES)))
    if is_first:
        for_later = missing(FOR_X) if has_chinese_font() else (*missing(FOR_X), _CHINESE_FONT)
        needs.append(Need("A screen and Chinese text need more packages", for_later, is_optional=True))
    if is_testing:
        needs.append(Need("The tests of the archive server need PostgreSQL", _not_here((_DATABASE,)), is_optional=True))
        needs.append(Need("The tests with real keys need an X server", _not_here(FOR_REAL_KEYS), is_optional=True))
    return [need for need in needs if need.lacking]


def _not_here(programs: tuple[Requirement, ...]) -> tuple[Requirement, ...]:
    """Debian's PostgreSQL has its programs in a folder of its own."""
    path = os.pathsep.join([os.environ.get("PATH", os.defpath), *map(str, Path("/usr/lib/postgresql").glob("*/bin"))])
    return tuple(program for program in programs if shutil.which(program.name, path=path) is None)


def has_venv_module() -> bool:
    """Whether this Python has ``venv`` and ``ensurepip``, which Debian and Ubuntu package separately."""
    return all(importlib.util.find_spec(name) for name in ("venv", "ensurepip"))


def _venv_package(manager: str | None) -> Requirement:
    """The package that has them; raises SetupError if no package of the system has."""
    if sys.base_prefix != "/usr" or manager != "apt":
        raise SetupError(
            f"This Python ({sys.executable}) was built without ensurepip: use another Python 3.11 or later."
        )
    return Requirement("venv", f"python{sys.version_info.major}.{sys.version_info.minor}-venv", "", "", "")


def _names(needs: list[Need], manager: str | None) -> list[str]:
    lacking = tuple(one for need in needs for one in need.lacking)
    return [one.name for one in lacking] if manager is None else package_names(lacking, manager)


def _install(manager: str | None, needs: list[Need], *, reason: str) -> None:
    names = _names(needs, manager)
    if manager == "apt":
        install_with_apt(names, reason=reason)
    elif manager is not None:
        prefix = "" if os.geteuid() == 0 else "sudo "
        raise SetupError(f"{reason}. Type: {prefix}{INSTALL[manager]} {' '.join(names)}")
    else:
        raise SetupError(f"{reason}: {', '.join(names)}. Install the packages that contain them, then run this again.")


def has_chinese_font() -> bool:
    """Asks fontconfig; without it, the package is asked for, which does no harm where it is there."""
    if shutil.which("fc-list") is None:
        return False
    listed = subprocess.run(["fc-list", ":lang=zh-cn", "file"], capture_output=True, check=False)
    return bool(listed.stdout.strip())
