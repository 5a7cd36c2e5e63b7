"""Finds and installs the packages that the program needs from a Linux system, all at once."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final, NamedTuple

from environment import QT_PROVEN, VENV_PYTHON, SetupError, has_venv_module, install_with_apt, say, venv_package
from tools import FOR_TESTS, Tool, has_server, missing_for_keys, missing_tools

from app.system.qt_libraries import (
    FOR_X,
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


class Needed(NamedTuple):
    """Missing packages of the system; `further` are optional."""

    packages: list[str]
    further: list[str]
    reasons: list[str]
    optional: list[str]
    """Reasons for `further`."""


def make_ready(*, is_screen_wanted: bool, is_packaging: bool = False, is_testing: bool = False) -> None:
    """Make sure that the system has everything, before anything is downloaded.

    Installs it if this user may, else raises SetupError with one command for all of it. Optional packages (a Chinese
    font, Qt's libraries for a screen that is not there yet, PostgreSQL for its tests) are installed with the others,
    and never stop anything; the first two are checked only until Qt was proven to start.
    """
    if sys.platform != "linux":
        return
    manager = package_manager()

    def needed_now() -> Needed:
        return _needed(manager, is_screen_wanted=is_screen_wanted, is_packaging=is_packaging, is_testing=is_testing)

    needed = needed_now()
    if needed.packages:
        _install(manager, [*needed.packages, *needed.further], reason=" and ".join(needed.reasons))
        still = needed_now()
        if still.packages:
            raise SetupError(f"Still missing after the installation: {', '.join(still.packages)}.")
    elif needed.further:
        try:
            _install(manager, needed.further, reason=" and ".join(needed.optional))
        except SetupError as error:
            say(f"{error}\nEverything else works without it.")


def _needed(manager: str | None, *, is_screen_wanted: bool, is_packaging: bool, is_testing: bool) -> Needed:
    packages, further, reasons, wishes = [], [], [], []
    if not VENV_PYTHON.exists() and not has_venv_module():
        packages.append(venv_package(manager))
        reasons.append("Python's venv module is missing")
    lacking = missing(wanted_libraries(is_screen_wanted=is_screen_wanted))
    if lacking:
        packages += _names(lacking, manager)
        reasons.append("System libraries of Qt are missing")
    tools = missing_tools() if is_packaging else ()
    if tools:
        packages += _tool_names(tools, manager)
        reasons.append("programs that build packages are missing")
    if packages or not QT_PROVEN.exists():
        further += [name for name in _names(missing(FOR_X), manager) if name not in packages]
        if manager is not None and not has_chinese_font():
            further.append(CHINESE_FONT[manager])
        wishes += ["A screen and Chinese text need more packages"] * bool(further)
    if is_testing and not has_server():
        further += _tool_names((FOR_TESTS,), manager)
        wishes.append("The tests of the archive server need PostgreSQL")
    if is_testing and missing_for_keys():
        further += _tool_names(missing_for_keys(), manager)
        wishes.append("The tests with real keys need an X server")
    return Needed(packages, further, reasons, wishes)


def _tool_names(tools: tuple[Tool, ...], manager: str | None) -> list[str]:
    return [tool.program if manager is None else getattr(tool, manager) for tool in tools]


def _names(libraries: tuple[Library, ...], manager: str | None) -> list[str]:
    return [library.soname for library in libraries] if manager is None else package_names(libraries, manager)


def _install(manager: str | None, names: list[str], *, reason: str) -> None:
    if manager == "apt":
        install_with_apt(names, reason=reason)
    elif manager is not None:
        prefix = "" if os.geteuid() == 0 else "sudo "
        raise SetupError(f"{reason}. Type: {prefix}{INSTALL[manager]} {' '.join(names)}")
    else:
        raise SetupError(f"{reason}: {', '.join(names)}. Install the packages that contain them, then run this again.")


def prove_qt(venv_python: Path) -> None:
    """Start Qt once for each .venv. Raises SetupError if it does not start."""
    if sys.platform != "linux" or QT_PROVEN.exists():
        return
    problem = _problem_with_qt(venv_python, platform="offscreen")
    if problem:
        raise SetupError(f"{problem}\nQt does not start on this system; what it says is above.")
    QT_PROVEN.touch()


def _problem_with_qt(venv_python: Path, platform: str | None = None) -> str | None:
    """What Qt prints if it cannot open a window, else None; ``platform`` replaces the environment's."""
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
    """A sentence if no window can be shown here, else None."""
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


def has_chinese_font() -> bool:
    """Asks fontconfig; without it, checks the names of font files."""
    if shutil.which("fc-list"):
        listed = subprocess.run(["fc-list", ":lang=zh-cn", "file"], capture_output=True, check=False)
        return bool(listed.stdout.strip())
    return any(
        name in path.as_posix().lower()
        for folder in _FONT_FOLDERS
        for path in Path(folder).expanduser().rglob("*.[ot]t[cf]")
        for name in _CHINESE_FONT_NAMES
    )
