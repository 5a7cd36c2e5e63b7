"""The commands of bootstrap.py: each installs what is missing, then runs one thing."""

import io
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from environment import BIN, PACKAGES, PROGRAM, ROOT, TESTS, VENV, VENV_PYTHON, SetupError, is_current, make_ready, run

OFFSCREEN_DEMO_S = 10
EVIDENCE = ROOT / "build" / "demo"


def call(program: Sequence[str | Path], **variables: str) -> int:
    """Run a program in the root of the checkout, with defaults of variables; returns its exit code."""
    sys.stdout.flush()
    with subprocess.Popen(program, cwd=ROOT, env={**variables, **os.environ}) as process:
        while True:
            try:
                code = process.wait()
            except KeyboardInterrupt:  # the terminal has interrupted the program, too: wait for it
                continue
            return code if code >= 0 else 128 - code


def _python(*words: str) -> Callable[[list[str]], int]:
    """A command that runs the Python of .venv with these words, without a screen."""
    return lambda arguments: call([VENV_PYTHON, *words, *arguments], QT_QPA_PLATFORM="offscreen")


def _test(arguments: list[str]) -> int:
    """Run more tests at a time than there are cores, as a quarter of their time is waiting."""
    at_a_time = min(8, 2 * (os.cpu_count() or 1))
    return _python("-m", "pytest", "-n", str(at_a_time), "--dist", "worksteal")(arguments)


def _check(_arguments: list[str]) -> int:
    checks = (["ruff", "check", "."], ["ruff", "format", "--check", "."], ["mypy"])
    return max([_python("-m", *check)([]) for check in checks])


def _demo(arguments: list[str]) -> int:
    program: list[str | Path] = [BIN / "dps-s", "gui", "--demo"]
    obstacle = _why_no_window()
    if not obstacle:
        return call([*program, *arguments])
    print(f"{obstacle} The window now runs offscreen for {OFFSCREEN_DEMO_S} seconds with the simulated module.")
    program += ["--offscreen-seconds", str(OFFSCREEN_DEMO_S), "--evidence", EVIDENCE, *arguments]
    # Qt would warn again and again of what that platform lacks.
    code = call(program, QT_QPA_PLATFORM="offscreen", QT_LOGGING_RULES="default.warning=false")
    if code == 0:
        print("A picture of it:", *sorted(EVIDENCE.iterdir()), sep="\n  ")
    return code


def _why_no_window() -> str:
    platform = os.environ.get("QT_QPA_PLATFORM", "")
    if platform in ("offscreen", "minimal"):
        return f"QT_QPA_PLATFORM asks for no screen ({platform})."
    question = "from app.system.libraries import window_obstacle; print(window_obstacle() or '')"
    return run([str(VENV_PYTHON), "-c", question], None).strip()


def _setup(_arguments: list[str]) -> int:
    print(f"Everything is installed in {VENV}.")
    return 0


# What each command does, what it needs in .venv, and a function from its arguments to the exit code.
COMMANDS: dict[str, tuple[str, str, Callable[[list[str]], int]]] = {
    "demo": ("open the window on the simulated module; arguments go to dps-s gui", PROGRAM, _demo),
    "test": ("run the tests; arguments go to pytest", TESTS, _test),
    "check": ("run ruff and mypy", TESTS, _check),
    "setup": ("only install what the others need", TESTS, _setup),
    "translations": ("update or check the translations", TESTS, _python("docs/generate/translations.py")),
    "package": ("build all packages into dist/ and use them", PACKAGES, _python("packaging/package.py")),
}


def main(arguments: list[str]) -> int:
    """Run one command; returns its exit code (3: the machine lacks something that its user has to install)."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # pip may print characters that the console lacks
    is_yes = arguments[:1] == ["--yes"]
    name, *passed_on = arguments[is_yes:] or [""]
    if name not in COMMANDS:
        usage = [f"  {command:<14}{COMMANDS[command][0]}" for command in COMMANDS]
        print("bootstrap.py [--yes] COMMAND [ARGUMENTS]; --yes installs system packages unasked.", *usage, sep="\n")
        return 0 if name in ("-h", "--help") else 2
    if "--yes" in passed_on:
        passed_on.remove("--yes")
        is_yes = True
    explanation, extent, do = COMMANDS[name]
    if passed_on[:1] in (["-h"], ["--help"]) and (name == "demo" or not is_current(extent)):
        print(f"bootstrap.py {name}: {explanation}")  # without installing anything
        return 0
    try:
        make_ready(extent, is_yes=is_yes)
    except (SetupError, OSError) as error:
        print(error, file=sys.stderr)
        return 3
    except (KeyboardInterrupt, EOFError):
        print("Interrupted; the next run continues.", file=sys.stderr)
        return 130
    return do(passed_on)
