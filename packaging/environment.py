"""The .venv of a checkout: created, updated and repaired.

A stamp in it records what it was made from.  The stamp is removed before anything in .venv is changed and written at
the end, so an interrupted installation has none, and is repeated.
"""

import contextlib
import hashlib
import importlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(1, str(ROOT))  # for modules of the program that the set-up uses
LOCK = ROOT / "packaging" / "lock.txt"
PYPROJECT = ROOT / "pyproject.toml"
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
VENV_PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "bootstrap.json"
PROGRAM, EVERYTHING = "program", "everything"
_DEVELOPMENT = "# what building and testing it need"
"""The line of the lock that separates what the program needs from the rest."""
YES = "DPS_S_SETUP_YES"
"""Environment variable: install without asking. `--yes` sets it."""


class SetupError(Exception):
    """A sentence for the user: what is missing and what to type."""

    def __init__(self, sentence: str, *, exit_code: int = 3) -> None:
        super().__init__(sentence)
        self.exit_code = exit_code


def wanted_stamp(extent: str) -> dict[str, str]:
    """The stamp of a current .venv.  It has the path, which scripts in .venv contain."""
    return {
        "extent": extent,
        "root": str(ROOT),
        "python": f"{sys.implementation.name} {sys.version_info.major}.{sys.version_info.minor}",
        "lock": hashlib.sha256(LOCK.read_bytes()).hexdigest(),
        "pyproject": hashlib.sha256(PYPROJECT.read_bytes()).hexdigest(),
    }


def locked(extent: str) -> list[str]:
    """The lines of the lock for this extent."""
    text = LOCK.read_text(encoding="utf-8")
    if extent == PROGRAM:
        text = text.partition(_DEVELOPMENT)[0]
    return [line for line in text.splitlines() if "==" in line]


def found_stamp() -> dict[str, str]:
    """The stamp of the present .venv; empty if there is none or it is incomplete."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def make_ready(extent: str = EVERYTHING) -> None:
    """Make sure that .venv has everything, or with `PROGRAM` what the program needs.  Raises SetupError."""
    if is_current(extent):
        return
    with _only_one():
        if is_current(extent):  # another process made it meanwhile
            return
        try:
            _make(extent)
        except OSError as error:
            raise SetupError(f"{VENV} cannot be created: {error}.") from error


def is_current(extent: str = EVERYTHING) -> bool:
    """Whether .venv has what this extent needs."""
    return found_stamp() in (wanted_stamp(extent), wanted_stamp(EVERYTHING)) and _runs()


def _runs() -> bool:
    """Whether the Python of .venv starts, which fails after its base Python was removed."""
    command = [str(VENV_PYTHON), "-I", "-S", "-c", ""]
    try:
        return subprocess.run(command, capture_output=True, timeout=60, check=False).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def _make(extent: str) -> None:
    started = time.monotonic()
    required, present = wanted_stamp(extent), found_stamp()
    can_be_reused = (present.get("root"), present.get("python")) == (required["root"], required["python"]) and _runs()
    STAMP.unlink(missing_ok=True)
    if not can_be_reused:
        _rebuild()
    listed = VENV / "requirements.txt"
    packages = locked(extent)
    listed.write_text("\n".join(packages) + "\n", encoding="utf-8")
    say(f"Installing {len(packages)} packages from packaging/lock.txt into .venv...")
    # The lock names all packages; pip takes its index from the user's settings.
    _pip("install", "--no-compile", "--no-deps", "--requirement", str(listed))
    _pip("install", "--no-deps", "--no-build-isolation", "--editable", str(ROOT))
    _pip("check")
    half = STAMP.with_suffix(".half")
    half.write_text(json.dumps(required, indent=1), encoding="utf-8")
    half.replace(STAMP)
    say(f"Installed in {time.monotonic() - started:.0f} s.")


def _rebuild() -> None:
    if not os.access(ROOT, os.W_OK):
        raise SetupError(f"{ROOT} cannot be written by this user, but .venv is created there.")
    if VENV.is_symlink() or VENV.is_file():
        VENV.unlink()
    elif VENV.exists():
        if Path(sys.prefix).resolve() == VENV.resolve():
            raise SetupError(f"{VENV} has to be created again, but this is its own Python: use another Python.")
        say("The .venv is broken, incomplete or of another Python: creating it again.")
        shutil.rmtree(VENV)
    say(f"Creating .venv with Python {sys.version.split()[0]}...")
    run([sys.executable, "-m", "venv", str(VENV)], f"Python's own venv module could not make {VENV}", exit_code=3)


def install_with_apt(packages: Sequence[str], *, reason: str) -> None:
    """Install Debian packages if this user is root and agrees, else raise SetupError with the command to type."""
    names = " ".join(packages)
    if os.geteuid() != 0:
        raise SetupError(f"{reason}. Type: sudo apt-get install {names}")
    say(f"{reason}. This installs it:\n  apt-get install --no-install-recommends {names}")
    if not _agrees():
        raise SetupError(f"Nothing was installed. Type: apt-get install {names}")
    for command in (["update", "-q"], ["install", "-q", "-y", "--no-install-recommends", *packages]):
        # The update may fail for one of several sources: the installation is tried in any case.
        failure = f"apt-get install {names} failed" if command[0] == "install" else None
        run(["apt-get", *command], failure, exit_code=3, variables={"DEBIAN_FRONTEND": "noninteractive"})
    importlib.invalidate_caches()


def _agrees() -> bool:
    """Ask at a terminal; scripts, containers and continuous integration are not asked."""
    if os.environ.get("CI") or os.environ.get(YES) or sys.stdin is None or not sys.stdin.isatty():
        return True
    try:
        answer = input("Install now? [Y/n] ")
    except EOFError:
        return False
    return answer.strip().lower() in ("", "y", "yes")


def _pip(*arguments: str) -> None:
    """By uv where it is there and can do it, as it cannot where only pip's settings name the index; else by pip."""
    variables = {"PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_USER": "0"}
    uv = shutil.which("uv")
    if uv is not None:
        try:
            run([uv, "pip", arguments[0], "--python", str(VENV_PYTHON), *arguments[1:]], "uv failed")
            return
        except SetupError:
            say("uv could not do it; pip is asked.")
    run([str(VENV_PYTHON), "-m", "pip", *arguments], f"pip {arguments[0]} failed", variables=variables)


def run(
    command: Sequence[str],
    failure: str | None,
    *,
    variables: Mapping[str, str] = MappingProxyType({}),
    folder: Path = ROOT,
    exit_code: int = 4,
    limit_s: float | None = None,
) -> str:
    """Run a program to its end, and return what it printed. `variables` are added to the environment.

    Raises SetupError where it fails, if `failure` says what that means.
    """
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **variables}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, errors="replace", check=False, timeout=limit_s,
    )  # fmt: skip
    if done.returncode != 0 and failure is not None:
        raise SetupError(f"{done.stdout}\n{failure}; it says why above.", exit_code=exit_code)
    return done.stdout


@contextlib.contextmanager
def _only_one() -> Iterator[None]:
    """Let one process at a time change .venv, if the platform has file locks."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    with LOCK.open("rb") as lock:
        with contextlib.suppress(OSError):  # some network drives have no locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def say(sentence: str) -> None:
    print(sentence, flush=True)
