"""The system libraries that Qt needs on Linux, and the packages that contain them.

On other systems the PySide6 wheel contains everything. The libraries are checked by loading them. The packages are
those of Debian 12 and 13, Fedora, Arch and openSUSE. Standard library only: used before anything is installed.
"""

import ctypes
import os
import shutil
from pathlib import Path
from typing import Final, NamedTuple


class Requirement(NamedTuple):
    """A shared library, or a program of a checkout's set-up, and its package per package manager."""

    name: str
    apt: str
    dnf: str
    pacman: str
    zypper: str


# fmt: off
ALWAYS: Final = (
    Requirement("libstdc++.so.6", "libstdc++6", "libstdc++", "gcc-libs", "libstdc++6"),
    Requirement("libglib-2.0.so.0", "libglib2.0-0", "glib2", "glib2", "libglib-2_0-0"),
    Requirement("libGL.so.1", "libgl1", "libglvnd-glx", "libglvnd", "Mesa-libGL1"),
    Requirement("libEGL.so.1", "libegl1", "libglvnd-egl", "libglvnd", "Mesa-libEGL1"),
    Requirement("libX11.so.6", "libx11-6", "libX11", "libx11", "libX11-6"),
    Requirement("libxkbcommon.so.0", "libxkbcommon0", "libxkbcommon", "libxkbcommon", "libxkbcommon0"),
    Requirement("libfreetype.so.6", "libfreetype6", "freetype", "freetype2", "libfreetype6"),
    Requirement("libfontconfig.so.1", "libfontconfig1", "fontconfig", "fontconfig", "fontconfig"),
    Requirement("libdbus-1.so.3", "libdbus-1-3", "dbus-libs", "dbus", "libdbus-1-3"),
    Requirement("libzstd.so.1", "libzstd1", "libzstd", "zstd", "libzstd1"),
)
FOR_X: Final = (
    Requirement("libX11-xcb.so.1", "libx11-xcb1", "libX11-xcb", "libx11", "libX11-xcb1"),
    Requirement("libxkbcommon-x11.so.0", "libxkbcommon-x11-0", "libxkbcommon-x11", "libxkbcommon-x11",
            "libxkbcommon-x11-0"),
    Requirement("libxcb-cursor.so.0", "libxcb-cursor0", "xcb-util-cursor", "xcb-util-cursor", "libxcb-cursor0"),
    Requirement("libxcb-icccm.so.4", "libxcb-icccm4", "xcb-util-wm", "xcb-util-wm", "libxcb-icccm4"),
    Requirement("libxcb-image.so.0", "libxcb-image0", "xcb-util-image", "xcb-util-image", "libxcb-image0"),
    Requirement("libxcb-keysyms.so.1", "libxcb-keysyms1", "xcb-util-keysyms", "xcb-util-keysyms",
            "libxcb-keysyms1"),
    Requirement("libxcb-render-util.so.0", "libxcb-render-util0", "xcb-util-renderutil", "xcb-util-renderutil",
            "libxcb-render-util0"),
    Requirement("libxcb-shape.so.0", "libxcb-shape0", "libxcb", "libxcb", "libxcb-shape0"),
    Requirement("libxcb-xkb.so.1", "libxcb-xkb1", "libxcb", "libxcb", "libxcb-xkb1"),
)
FOR_WAYLAND: Final = (
    Requirement("libwayland-client.so.0", "libwayland-client0", "libwayland-client", "wayland",
            "libwayland-client0"),
    Requirement("libwayland-cursor.so.0", "libwayland-cursor0", "libwayland-cursor", "wayland",
            "libwayland-cursor0"),
    Requirement("libwayland-egl.so.1", "libwayland-egl1", "libwayland-egl", "wayland", "libwayland-egl1"),
)
# fmt: on
INSTALL: Final = {
    "apt": "apt-get install",
    "dnf": "dnf install",
    "pacman": "pacman -S",
    "zypper": "zypper install",
}


def wanted_libraries(*, is_screen_wanted: bool) -> tuple[Requirement, ...]:
    """The libraries for a window on the present screen, or for offscreen use."""
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    has_x = bool(os.environ.get("DISPLAY")) and platform in ("", "xcb")
    has_wayland = bool(os.environ.get("WAYLAND_DISPLAY")) and platform in ("", "wayland")
    if not is_screen_wanted:
        return ALWAYS
    if has_wayland and (not has_x or os.environ.get("XDG_SESSION_TYPE") == "wayland"):
        return ALWAYS + FOR_WAYLAND
    return ALWAYS + FOR_X if has_x else ALWAYS


def missing(libraries: tuple[Requirement, ...]) -> tuple[Requirement, ...]:
    return tuple(library for library in libraries if not _loads(library.name))


def _loads(soname: str) -> bool:
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def package_manager() -> str | None:
    """``apt``, ``dnf``, ``pacman`` or ``zypper``, whichever is here."""
    programs = {"apt": "apt-get", "dnf": "dnf", "zypper": "zypper", "pacman": "pacman"}
    return next((name for name, program in programs.items() if shutil.which(program)), None)


def package_names(libraries: tuple[Requirement, ...], manager: str) -> list[str]:
    """The packages to install, each once."""
    names = dict.fromkeys(getattr(library, manager) for library in libraries)
    if manager == "apt" and _is_after_time_t_64():
        return [name + "t64" if name == "libglib2.0-0" else name for name in names]
    return list(names)


def _is_after_time_t_64() -> bool:
    try:
        return has_time_t_64_names(Path("/etc/os-release").read_text(encoding="utf-8"))
    except OSError:
        return False


def has_time_t_64_names(os_release: str) -> bool:
    """Whether packages were renamed for 64-bit time_t (Debian 13, Ubuntu 24.04, Mint 22).

    ``os_release`` is the text of /etc/os-release.
    """
    pairs = (line.split("=", 1) for line in os_release.splitlines() if "=" in line)
    release = {key: value.strip('"') for key, value in pairs}
    name, number = release.get("ID", ""), release.get("VERSION_ID", "").split(".")[0]
    first_renamed = {"ubuntu": 24, "linuxmint": 22}.get(name, 13)
    # Debian testing has no version number and is newer than all releases.
    return int(number) >= first_renamed if number.isdigit() else name == "debian"
