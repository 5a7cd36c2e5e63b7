"""What Qt wants from a Linux system, looked for before Qt can die of its absence with a riddle.

Elsewhere the PySide6 wheel brings everything.  The libraries are tried by loading them, which takes
milliseconds and names exactly what is missing; the packages are those of Debian 12 and 13, Fedora, Arch and
openSUSE.
"""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final, NamedTuple

from environment import QT_PROVEN, SetupError, install_with_apt, say


class Library(NamedTuple):
    """A shared library and the package that has it, per package manager."""

    soname: str
    apt: str
    dnf: str
    pacman: str
    zypper: str


# fmt: off
ALWAYS: Final = (
    Library("libstdc++.so.6", "libstdc++6", "libstdc++", "gcc-libs", "libstdc++6"),
    Library("libglib-2.0.so.0", "libglib2.0-0", "glib2", "glib2", "libglib-2_0-0"),
    Library("libGL.so.1", "libgl1", "libglvnd-glx", "libglvnd", "Mesa-libGL1"),
    Library("libEGL.so.1", "libegl1", "libglvnd-egl", "libglvnd", "Mesa-libEGL1"),
    Library("libX11.so.6", "libx11-6", "libX11", "libx11", "libX11-6"),
    Library("libxkbcommon.so.0", "libxkbcommon0", "libxkbcommon", "libxkbcommon", "libxkbcommon0"),
    Library("libfreetype.so.6", "libfreetype6", "freetype", "freetype2", "libfreetype6"),
    Library("libfontconfig.so.1", "libfontconfig1", "fontconfig", "fontconfig", "fontconfig"),
    Library("libdbus-1.so.3", "libdbus-1-3", "dbus-libs", "dbus", "libdbus-1-3"),
    Library("libgssapi_krb5.so.2", "libgssapi-krb5-2", "krb5-libs", "krb5", "krb5"),
    Library("libbrotlidec.so.1", "libbrotli1", "libbrotli", "brotli", "libbrotlidec1"),
    Library("libzstd.so.1", "libzstd1", "libzstd", "zstd", "libzstd1"),
)
FOR_X: Final = (
    Library("libX11-xcb.so.1", "libx11-xcb1", "libX11-xcb", "libx11", "libX11-xcb1"),
    Library("libxkbcommon-x11.so.0", "libxkbcommon-x11-0", "libxkbcommon-x11", "libxkbcommon-x11",
            "libxkbcommon-x11-0"),
    Library("libxcb-cursor.so.0", "libxcb-cursor0", "xcb-util-cursor", "xcb-util-cursor", "libxcb-cursor0"),
    Library("libxcb-icccm.so.4", "libxcb-icccm4", "xcb-util-wm", "xcb-util-wm", "libxcb-icccm4"),
    Library("libxcb-image.so.0", "libxcb-image0", "xcb-util-image", "xcb-util-image", "libxcb-image0"),
    Library("libxcb-keysyms.so.1", "libxcb-keysyms1", "xcb-util-keysyms", "xcb-util-keysyms",
            "libxcb-keysyms1"),
    Library("libxcb-render-util.so.0", "libxcb-render-util0", "xcb-util-renderutil", "xcb-util-renderutil",
            "libxcb-render-util0"),
    Library("libxcb-shape.so.0", "libxcb-shape0", "libxcb", "libxcb", "libxcb-shape0"),
    Library("libxcb-xkb.so.1", "libxcb-xkb1", "libxcb", "libxcb", "libxcb-xkb1"),
)
FOR_WAYLAND: Final = (
    Library("libwayland-client.so.0", "libwayland-client0", "libwayland-client", "wayland",
            "libwayland-client0"),
    Library("libwayland-cursor.so.0", "libwayland-cursor0", "libwayland-cursor", "wayland",
            "libwayland-cursor0"),
    Library("libwayland-egl.so.1", "libwayland-egl1", "libwayland-egl", "wayland", "libwayland-egl1"),
)
# fmt: on
CHINESE_FONT: Final = {
    "apt": "fonts-wqy-microhei",
    "dnf": "wqy-microhei-fonts",
    "pacman": "wqy-microhei",
    "zypper": "wqy-microhei-fonts",
}
INSTALL: Final = {
    "apt": "apt-get install",
    "dnf": "dnf install",
    "pacman": "pacman -S",
    "zypper": "zypper install",
}
_FONT_FOLDERS: Final = ("/usr/share/fonts", "/usr/local/share/fonts", "~/.local/share/fonts", "~/.fonts")
_CHINESE_FONT_NAMES: Final = ("wqy", "cjk", "sourcehan", "source-han", "droidsansfallback", "uming", "ukai")
_PROBE: Final = "from PySide6.QtWidgets import QApplication, QWidget; a = QApplication([]); QWidget().grab()"
_PROBE_LIMIT_S: Final = 60


def make_ready(venv_python: Path, *, is_screen_wanted: bool) -> None:
    """Make sure that Qt can start; raises SetupError with the command to type where it cannot.

    Qt itself is started, and a font with Chinese glyphs looked for, once for each .venv only: it takes longer.
    """
    if sys.platform != "linux":
        return
    lacking = missing(wanted_libraries(is_screen_wanted=is_screen_wanted))
    if lacking:
        _install(lacking, reason="Qt needs system libraries that are not here")
        still = missing(lacking)
        if still:
            names = ", ".join(library.soname for library in still)
            raise SetupError(f"The packages are installed, yet {names} cannot be loaded.")
    if not QT_PROVEN.exists():
        problem = _problem_with_qt(venv_python, platform="offscreen")
        if problem:
            raise SetupError(f"{problem}\nQt does not start on this system; what it says is above.")
        _look_for_chinese_font()
        QT_PROVEN.touch()


def wanted_libraries(*, is_screen_wanted: bool) -> tuple[Library, ...]:
    """The libraries for a window on the screen that there is, or for none."""
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    has_x = bool(os.environ.get("DISPLAY")) and platform in ("", "xcb")
    has_wayland = bool(os.environ.get("WAYLAND_DISPLAY")) and platform in ("", "wayland")
    if not is_screen_wanted:
        return ALWAYS
    if has_wayland and (not has_x or os.environ.get("XDG_SESSION_TYPE") == "wayland"):
        return ALWAYS + FOR_WAYLAND
    return ALWAYS + FOR_X if has_x else ALWAYS


def missing(libraries: tuple[Library, ...]) -> tuple[Library, ...]:
    """Those that the loader does not find or cannot load."""
    return tuple(library for library in libraries if not _loads(library.soname))


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


def package_names(libraries: tuple[Library, ...], manager: str) -> list[str]:
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
    """Is this a system that renamed libraries when it widened the time (Debian 13, Ubuntu 24.04, Mint 22)?

    ``os_release`` is the text of /etc/os-release.
    """
    pairs = (line.split("=", 1) for line in os_release.splitlines() if "=" in line)
    release = {key: value.strip('"') for key, value in pairs}
    name, number = release.get("ID", ""), release.get("VERSION_ID", "").split(".")[0]
    first_renamed = {"ubuntu": 24, "linuxmint": 22}.get(name, 13)
    # Debian's testing states no number, and is newer than all that do.
    return int(number) >= first_renamed if number.isdigit() else name == "debian"


def _install(libraries: tuple[Library, ...], *, reason: str) -> None:
    manager = package_manager()
    if manager == "apt":
        install_with_apt(package_names(libraries, "apt"), reason=reason)
    elif manager is not None:
        names = " ".join(package_names(libraries, manager))
        prefix = "" if os.geteuid() == 0 else "sudo "
        raise SetupError(f"{reason}. Type: {prefix}{INSTALL[manager]} {names}")
    else:
        names = ", ".join(library.soname for library in libraries)
        raise SetupError(f"{reason}: {names}. Install what holds them, then run this again.")


def _problem_with_qt(venv_python: Path, platform: str | None = None) -> str | None:
    """What Qt prints when it cannot open a window, else None; ``platform`` replaces the environment's."""
    variables = dict(os.environ) if platform is None else {**os.environ, "QT_QPA_PLATFORM": platform}
    try:
        run = subprocess.run(
            [venv_python, "-c", _PROBE],
            env=variables,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_PROBE_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"Qt did not open a window within {_PROBE_LIMIT_S} s."
    return None if run.returncode == 0 else run.stderr.strip() or f"Qt ended with code {run.returncode}."


def why_no_screen(venv_python: Path) -> str | None:
    """The sentence when no window can be seen from here, else None."""
    if sys.platform != "linux":
        return None
    if os.environ.get("QT_QPA_PLATFORM", "") in ("offscreen", "minimal"):
        return f"QT_QPA_PLATFORM asks for no screen ({os.environ['QT_QPA_PLATFORM']})."
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "There is no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set)."
    problem = _problem_with_qt(venv_python)
    if problem:
        screen = os.environ.get("WAYLAND_DISPLAY") or os.environ.get("DISPLAY")
        return f"The screen {screen} does not let this user open a window (Qt: {problem.splitlines()[0]})."
    return None


def _look_for_chinese_font() -> None:
    """Install a font with Chinese glyphs where that may be done, else say how: without it there are boxes."""
    if has_chinese_font():
        return
    manager = package_manager()
    reason = "No font with Chinese glyphs is here"
    if manager == "apt" and os.geteuid() == 0:
        try:
            install_with_apt([CHINESE_FONT[manager]], reason=reason)
        except SetupError as error:
            say(f"{error}\nEnglish works without it.")
    elif manager is not None:
        command = f"{INSTALL[manager]} {CHINESE_FONT[manager]}"
        say(f"{reason}; English works without one. For Chinese type: sudo {command}")
    else:
        say(f"{reason}; English works without one.")


def has_chinese_font() -> bool:
    """Asks fontconfig, or looks at the names of font files where its programs are not installed."""
    if shutil.which("fc-list"):
        listed = subprocess.run(["fc-list", ":lang=zh-cn", "file"], capture_output=True, check=False)
        return bool(listed.stdout.strip())
    return any(
        name in path.as_posix().lower()
        for folder in _FONT_FOLDERS
        for path in Path(folder).expanduser().rglob("*.[ot]t[cf]")
        for name in _CHINESE_FONT_NAMES
    )
