"""What a checkout needs: its .venv with the locked packages, and what Linux has to have for Qt.

A stamp in .venv says what it was made from. It is removed before anything there is changed and written at the end, so
an interrupted installation has none, and is repeated.
"""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from subprocess import DEVNULL, PIPE, STDOUT

from app.system.libraries import ALWAYS, FOR_X, install_command, missing

ROOT = Path(__file__).resolve().parent.parent
LOCK = ROOT / "packaging" / "lock.txt"
PYPROJECT = ROOT / "pyproject.toml"
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
VENV_PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "made-from.txt"
PROGRAM, TESTS, PACKAGES = EXTENTS = ("program", "tests", "packages")
"""What .venv is for: each needs what those before it need, and the lines of the lock below its own name."""
FOR_TESTS = {"initdb": "postgresql", "Xvfb": "xvfb", "xdotool": "xdotool"}
FOR_PACKAGES = {"objdump": "binutils", "appstreamcli": "appstream", "desktop-file-validate": "desktop-file-utils"}
"""Programs, each with Debian's package."""
FONT = Path("/usr/share/fonts/truetype/wqy")


class SetupError(Exception):
    """A sentence for the user: what is missing and what to type."""


def make_ready(extent: str, *, is_yes: bool = False) -> None:
    """Make sure that Linux and .venv have what is needed. Raises SetupError or OSError."""
    if is_current(extent):
        return
    if sys.platform == "linux":
        _require_system_packages(extent, is_yes=is_yes)
    _install(extent)


def is_current(extent: str) -> bool:
    """Whether .venv has what is needed, for this Python and in this place."""
    enough = EXTENTS[EXTENTS.index(extent) :]
    return _found_stamp() in [_wanted_stamp(one) for one in enough] and VENV_PYTHON.exists()


def _wanted_stamp(extent: str) -> list[str]:
    made_from = hashlib.sha256(LOCK.read_bytes() + PYPROJECT.read_bytes()).hexdigest()
    return [f"{ROOT}: {sys.version.split()[0]}", made_from, extent]


def _found_stamp() -> list[str]:
    return STAMP.read_text(encoding="utf-8").splitlines() if STAMP.is_file() else []


def locked(extent: str) -> list[str]:
    """The lines of the lock for this extent."""
    further = EXTENTS[EXTENTS.index(extent) + 1 :]
    lines = LOCK.read_text(encoding="utf-8").splitlines()
    heads = [number for number, line in enumerate(lines) if line.strip("# ") in further]
    return [line for line in lines[: min(heads, default=len(lines))] if "==" in line]


def _install(extent: str) -> None:
    is_reused = _found_stamp()[:1] == _wanted_stamp(extent)[:1] and VENV_PYTHON.exists()
    STAMP.unlink(missing_ok=True)
    if not is_reused:
        if VENV.is_symlink():
            VENV.unlink()
        say(f"Creating .venv with Python {sys.version.split()[0]}...")
        run([sys.executable, "-m", "venv", "--clear", str(VENV)], f"Python could not make {VENV}")
    listed, packages = VENV / "requirements.txt", locked(extent)
    listed.write_text("\n".join(packages), encoding="utf-8")
    say(f"Installing {len(packages)} packages from packaging/lock.txt into .venv...")
    _pip("install", "--no-deps", "--requirement", str(listed))
    _pip("install", "--no-deps", "--no-build-isolation", "--editable", str(ROOT))
    _pip("check")
    STAMP.write_text("\n".join(_wanted_stamp(extent)), encoding="utf-8")


def _pip(*arguments: str) -> None:
    """By uv where it is there and can do it, as it cannot where only pip's settings name the index; else by pip."""
    uv = shutil.which("uv")
    if uv is not None:
        try:
            run([uv, "pip", arguments[0], "--python", str(VENV_PYTHON), *arguments[1:]], "uv failed")
            return
        except SetupError:
            say("uv could not do it; pip is asked.")
    run([str(VENV_PYTHON), "-m", "pip", "--disable-pip-version-check", *arguments], f"pip {arguments[0]} failed")


def run(
    command: Sequence[str], failure: str | None, *, variables: Mapping[str, str] | None = None, folder: Path = ROOT
) -> str:
    """Run a program to its end, with these variables in addition, and return what it printed.

    Raises SetupError where it fails, if `failure` says what that means.
    """
    environ = {**os.environ, "PIP_USER": "0", **(variables or {})}
    done = subprocess.run(
        command, cwd=folder, env=environ, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, errors="replace", check=False
    )
    if done.returncode != 0 and failure is not None:
        raise SetupError(f"{done.stdout}\n{failure}; it says why above.")
    return done.stdout


def say(sentence: str) -> None:
    print(sentence, flush=True)


def _require_system_packages(extent: str, *, is_yes: bool) -> None:
    """Install what the system lacks if this user is root, else name it with the command.

    Raises SetupError where something is missing that nothing works without.
    """
    lacking = _required() | _useful(extent)
    command = install_command(lacking.values())
    if lacking and command is not None and os.geteuid() == 0 and _agrees(command, is_yes=is_yes):
        quiet = {"DEBIAN_FRONTEND": "noninteractive"}
        run(["apt-get", "update", "-q"], None, variables=quiet)  # one of several sources may fail
        words = ["apt-get", "install", "-q", "-y", "--no-install-recommends", *lacking.values()]
        run(words, "apt-get failed", variables=quiet)
        importlib.invalidate_caches()
        lacking = _required()
    if lacking:
        advice = f"Type: {command}" if command else "Install the packages of this system that have it."
        sentence = f"The system lacks {', '.join(lacking)}. {advice}"
        if _required():
            raise SetupError(sentence)
        say(f"{sentence}\nMost things work without.")


def _required() -> dict[str, str]:
    lacking = missing(ALWAYS)
    if importlib.util.find_spec("ensurepip") is None:  # Debian has it apart from Python
        lacking["Python's module venv"] = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"
    return lacking


def _useful(extent: str) -> dict[str, str]:
    """What a window on a screen, Chinese text, some tests and building packages need."""
    fonts = shutil.which("fc-list")
    has_chinese = bool(run([fonts, ":lang=zh-cn", "file"], None).strip()) if fonts else FONT.is_dir()
    programs = {PROGRAM: {}, TESTS: FOR_TESTS, PACKAGES: FOR_TESTS | FOR_PACKAGES}[extent]
    # Debian's PostgreSQL has its programs in a folder of its own.
    path = os.pathsep.join([os.environ.get("PATH", os.defpath), *map(str, Path("/usr/lib/postgresql").glob("*/bin"))])
    absent = {name: package for name, package in programs.items() if shutil.which(name, path=path) is None}
    return missing(FOR_X) | ({} if has_chinese else {"a Chinese font": "fonts-wqy-microhei"}) | absent


def _agrees(command: str, *, is_yes: bool) -> bool:
    """Ask at a terminal; scripts, containers and continuous integration are not asked."""
    say(f"The system lacks packages. This installs them: {command}")
    if is_yes or os.environ.get("CI") or sys.stdin is None or not sys.stdin.isatty():
        return True
    return input("Install now? [Y/n] ").strip().lower() in ("", "y", "yes")
