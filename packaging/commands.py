"""The commands of bootstrap.py: each installs what is missing, then runs one thing."""

import argparse
import io
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import environment
import system_libraries
from environment import BIN, ROOT, VENV_PYTHON, SetupError

from app.system.screen import window_obstacle

OFFSCREEN_DEMO_S = 10
EVIDENCE = ROOT / "build" / "demo"


class Command(NamedTuple):
    """A command: its help, and a function from arguments to the exit code."""

    explanation: str
    run: Callable[[list[str]], int]


def call(program: Sequence[str | Path], **variables: str) -> int:
    """Run a program in the root of the checkout; returns its exit code, 130 if it was interrupted.

    ``variables`` are defaults of environment variables.
    """
    sys.stdout.flush()
    words = [str(word) for word in program]
    with subprocess.Popen(words, cwd=ROOT, env={**variables, **os.environ}) as process:
        while True:
            try:
                code = process.wait()
                break
            except KeyboardInterrupt:  # the terminal has interrupted the program, too: wait for it
                continue
    return code if code >= 0 else 128 - code


def _python(*arguments: str) -> list[str | Path]:
    return [VENV_PYTHON, *arguments]


def _take_none(arguments: list[str]) -> None:
    if arguments:
        raise SetupError(f"This command takes no arguments: {' '.join(arguments)}", exit_code=2)


def _test(arguments: list[str]) -> int:
    """Run the tests in parallel, more than there are cores, since a quarter of their time is waiting; `-n 0` runs one
    after the other. Each process more takes 5 s of processor time and 400 MB."""
    at_a_time = min(8, 2 * (os.cpu_count() or 1))
    side_by_side = ("-n", str(at_a_time), "--dist", "worksteal")
    return call(_python("-m", "pytest", *side_by_side, *arguments), QT_QPA_PLATFORM="offscreen")


def _check(arguments: list[str]) -> int:
    _take_none(arguments)
    return max(
        call(_python("-m", "ruff", "check", ".")),
        call(_python("-m", "ruff", "format", "--check", ".")),
        call(_python("-m", "mypy")),
    )


def _demo(arguments: list[str]) -> int:
    program: list[str | Path] = [BIN / "dps-s", "gui", "--demo"]
    platform = os.environ.get("QT_QPA_PLATFORM", "")
    is_hidden = platform in ("offscreen", "minimal")
    reason = f"QT_QPA_PLATFORM asks for no screen ({platform})." if is_hidden else window_obstacle()
    if reason is None:
        return call([*program, *arguments])
    print(f"{reason} The window now runs offscreen for {OFFSCREEN_DEMO_S} seconds with the simulated module.")
    code = call(
        [*program, "--offscreen-seconds", str(OFFSCREEN_DEMO_S), "--evidence", EVIDENCE, *arguments],
        QT_QPA_PLATFORM="offscreen",
    )
    if code == 0:
        print("Screenshots and values:")
        for path in sorted(EVIDENCE.iterdir()):
            print(f"  {path}")
    return code


def _run(arguments: list[str]) -> int:
    return call([BIN / "dps-s", *arguments])


def _offscreen(module: str) -> Callable[[list[str]], int]:
    return lambda arguments: call(_python("-m", module, *arguments), QT_QPA_PLATFORM="offscreen")


def _script(path: str) -> Callable[[list[str]], int]:
    return lambda arguments: call(_python(path, *arguments))


def _nightly(arguments: list[str]) -> int:
    """Run everything that takes hours, whatever fails; the worst exit code."""
    _take_none(arguments)
    os.environ["HYPOTHESIS_PROFILE"] = "thorough"
    gestures = [["gestures", "--every", "28"], ["gestures", "--sequences", "200"]]
    campaigns = [["soak", "--seconds", "1800"], *gestures, ["adversary"], ["bench"]]
    return max(_test([]), *(COMMANDS[name].run(words) for name, *words in campaigns))


def _setup(arguments: list[str]) -> int:
    _take_none(arguments)
    print(f"Everything is installed in {environment.VENV}.")
    return 0


COMMANDS: dict[str, Command] = {
    "demo": Command("open the window on the simulated module (arguments go to dps-s gui)", _demo),
    "test": Command("run the tests (arguments go to pytest)", _test),
    "check": Command("run ruff and mypy", _check),
    "bench": Command("run the benchmark", _offscreen("tests.benchmarks")),
    "soak": Command("run the endurance test", _offscreen("tests.soak")),
    "gestures": Command("try careless gestures, or random hands", _offscreen("tests.gestures")),
    "adversary": Command("run every command against every fault and lie", _offscreen("tests.adversary")),
    "nightly": Command("run the tests thoroughly, then all campaigns; takes hours", _nightly),
    "run": Command("run dps-s with the arguments", _run),
    "translations": Command("update, check or merge the translations", _script("docs/generate/translations.py")),
    "package": Command("build all packages into dist/ and test them", _script("packaging/package.py")),
    "windows": Command("test and build for Windows, under Wine (Linux, as root)", _script("packaging/windows/lane.py")),
    "setup": Command("only install what is needed", _setup),
}


def main(arguments: list[str]) -> int:
    """Run one command; returns its exit code (3: the machine lacks something that its user has to install)."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # pip may print characters that the console lacks
    parser = argparse.ArgumentParser(
        prog="bootstrap.py",
        description="Set up DPS-S Configurator in this checkout, then run one thing.",
        epilog="\n".join(["commands:", *(f"  {name:<14}{command.explanation}" for name, command in COMMANDS.items())]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--yes", action="store_true", help="do not ask before system packages are installed")
    parser.add_argument("command", choices=COMMANDS, metavar="command")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="passed on")
    first = next((number for number, word in enumerate(arguments) if not word.startswith("-")), len(arguments))
    chosen = parser.parse_args(arguments[: first + 1])
    passed_on = arguments[first + 1 :]
    extent = environment.PROGRAM if chosen.command in ("demo", "run") else environment.EVERYTHING
    is_first = not environment.is_current(extent)
    if {"-h", "--help"}.intersection(passed_on[:1]) and (chosen.command == "demo" or is_first):
        print(f"bootstrap.py {chosen.command}: {COMMANDS[chosen.command].explanation}")  # without installing anything
        return 0
    if chosen.yes:
        os.environ[environment.YES] = "1"
    try:
        system_libraries.make_ready(
            is_first=is_first,
            is_screen_wanted=chosen.command in ("demo", "run"),
            is_packaging=chosen.command == "package",
            is_testing=chosen.command in ("setup", "test"),
        )
        environment.make_ready(extent)
        return COMMANDS[chosen.command].run(passed_on)
    except SetupError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("Interrupted; the next run continues.", file=sys.stderr)
        return 130
