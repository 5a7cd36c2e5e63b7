"""What Qt needs from a Linux system, looked for and installed before Qt is started."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

from environment import QT_PROVEN, SetupError, install_with_apt, say

from app.system.qt_libraries import (
    INSTALL,
    Library,
    missing,
    package_manager,
    package_names,
    wanted_libraries,
)

CHINESE_FONT: Final = {
    "apt": "fonts-wqy-microhei",
    "dnf": "wqy-microhei-fonts",
    "pacman": "wqy-microhei",
    "zypper": "wqy-microhei-fonts",
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
