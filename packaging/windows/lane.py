"""Tests the program for Windows under Wine:  python3 packaging/bootstrap.py windows [WHAT]

Without arguments all suites of suites.py are run. `package` builds and tests bundle and installer. What pytest
printed is in build/windows/logs.
"""

import argparse
import os
import re
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

sys.path.insert(0, str(Path(__file__).parents[1]))

from environment import ROOT, SetupError, say

from windows import wine
from windows.suites import INSTALLER, NOT_JUDGED, SUITES, Suite

_OPTIONS: Final = ("-q", "-p", "no:cacheprovider", "--tb=short")
_SCREEN: Final = ("xvfb-run", "-a", "-s", "-screen 0 1920x1080x24")


def run_suite(suite: Suite) -> bool:
    """Run it and say what failed and pytest's last line; whether all went well."""
    say(f"{suite.title} ...")
    # A test on Linux starts many Windows programs; else five minutes are enough for each test.
    hang_s = suite.limit_s if suite.platform is None else min(suite.limit_s, 300)
    words = ["-m", "pytest", *suite.tests, *_OPTIONS, "-o", f"faulthandler_timeout={hang_s}"]
    words += [f"--deselect={name}" for name in NOT_JUDGED if name.partition("::")[0].startswith(suite.tests)]
    done = _on_linux(words, suite.limit_s) if suite.platform is None else _on_windows(words, suite)
    log = wine.PLACE / "logs" / f"{re.sub(r'[^a-z0-9]+', '-', suite.title.lower())}.txt"
    log.parent.mkdir(exist_ok=True)
    log.write_text(done.stdout, encoding="utf-8")
    lines = done.stdout.rstrip().splitlines() or [""]
    for line in (*(line for line in lines if line.startswith(("FAILED", "ERROR"))), lines[-1]):
        say(f"  {line}")
    if done.returncode != 0:
        say(f"  ended with {done.returncode}; {log} has all of it")
    return done.returncode == 0


def _on_windows(words: Sequence[str], suite: Suite) -> "subprocess.CompletedProcess[str]":
    command = wine.with_variables([wine.PYTHON, *words], QT_QPA_PLATFORM=suite.platform or "")
    if suite.platform == "windows":
        command = [*_SCREEN, *command]
    done = wine.inside(command, folder=wine.SOURCE, limit_s=suite.limit_s)
    wine.shut_down()
    return done


def _on_linux(words: Sequence[str], limit_s: int) -> "subprocess.CompletedProcess[str]":
    command = ["timeout", str(limit_s), sys.executable, *words, "-n", "0"]
    variables = {**os.environ, "DPS_S_UNDER_WINE": "1"}
    return subprocess.run(
        command, cwd=ROOT, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, errors="replace", check=False,
    )  # fmt: skip


def run_suites(suites: Sequence[Suite]) -> int:
    """Run them one after the other; returns 1 if something failed."""
    wine.copy_source()
    unwell = [suite.title for suite in suites if not run_suite(suite)]
    say(f"Not well: {'; '.join(unwell)}" if unwell else "All is well.")
    return 1 if unwell else 0


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="bootstrap.py windows", description="Test the program for Windows under Wine."
    )
    titles = "; ".join(suite.title for suite in SUITES)
    parser.add_argument("what", nargs="*", help=f"setup, package, or suites by their titles: {titles}")
    chosen = parser.parse_args(arguments).what
    try:
        started = time.monotonic()
        wine.prepare()
        say(f"Windows is ready in {wine.PLACE.name} ({time.monotonic() - started:.0f} s).")
        if chosen == ["setup"]:
            return 0
        if chosen == ["package"]:
            from windows.make_package import make_package

            made = make_package()
            say(f"{made.name}: {made.stat().st_size / 1e6:.1f} MB, {time.monotonic() - started:.0f} s")
            return run_suites([INSTALLER])
        return run_suites([suite for suite in SUITES if not chosen or suite.title in chosen])
    except SetupError as error:
        print(error, file=sys.stderr)
        return error.exit_code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
