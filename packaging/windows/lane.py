"""Tests the program for Windows under Wine:  python3 packaging/bootstrap.py windows [WHAT]

Without arguments all suites of suites.py are run. `package` builds and tests bundle and installer. `quick` runs a short
part if Wine is prepared. The results are in build/windows/results.md.
"""

import argparse
import re
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1]))

from environment import SetupError, run, say

from windows import wine
from windows.suites import INSTALLER, NOT_JUDGED, QUICK, SUITES, Suite

_OPTIONS: Final = ("-q", "-p", "no:cacheprovider", "--tb=short")
_SCREEN: Final = ("xvfb-run", "-a", "-s", "-screen 0 1920x1080x24")


class Result(NamedTuple):
    """Result of a suite; `note` says why it did not end."""

    suite: Suite
    passed: int = 0
    failed: tuple[str, ...] = ()
    not_judged: int = 0
    not_for_windows: int = 0
    seconds: float = 0.0
    note: str = ""

    @property
    def is_well(self) -> bool:
        return not self.failed and not self.note


def run_suite(suite: Suite, limit_s: float) -> Result:
    """Run it for `limit_s` at most."""
    report = wine.DRIVE / "report.xml"
    report.unlink(missing_ok=True)
    not_judged = [name for name in NOT_JUDGED if name.partition("::")[0].startswith(suite.tests)]
    # A test on Linux starts many Windows programs; else five minutes are enough for each test.
    hang_s = limit_s if suite.platform is None else min(limit_s, 300)
    words = [*suite.tests, *_OPTIONS, "-o", f"faulthandler_timeout={hang_s:.0f}"]
    words += [f"--deselect={name}" for name in not_judged]
    started = time.monotonic()
    text = _on_linux(words, report, limit_s) if suite.platform is None else _on_windows(words, suite.platform, limit_s)
    seconds = time.monotonic() - started
    (wine.PLACE / "logs").mkdir(exist_ok=True)
    name = re.sub(r"\W+", "-", suite.title).lower()
    (wine.PLACE / "logs" / f"{name}.txt").write_text(text, encoding="utf-8")
    if not report.is_file():
        return Result(suite, not_judged=len(not_judged), seconds=seconds, note="did not come to its end")
    return _read(suite, report, len(not_judged), seconds)


def _on_windows(words: Sequence[str], platform: str, limit_s: float) -> str:
    program = [wine.PYTHON, "-m", "pytest", *words, "--junitxml=C:\\report.xml"]
    command = wine.with_variables(program, QT_QPA_PLATFORM=platform)
    if platform == "windows":
        command = [*_SCREEN, *command]
    done = wine.inside(command, folder="/place/prefix/drive_c/source", limit_s=limit_s)
    wine.shut_down()
    return done.stdout


def _on_linux(words: Sequence[str], report: Path, limit_s: float) -> str:
    command = ["timeout", f"{limit_s:.0f}", sys.executable, "-m", "pytest", "-n", "0", *words, f"--junitxml={report}"]
    return run(command, None, variables={"DPS_S_UNDER_WINE": "1"})


def _read(suite: Suite, report: Path, not_judged: int, seconds: float) -> Result:
    passed, skipped, failed = 0, 0, []
    for case in ET.parse(report).iter("testcase"):  # noqa: S314  our own
        name = f"{case.get('classname', '').replace('.', '/')}.py::{case.get('name')}"
        if case.find("failure") is not None or case.find("error") is not None:
            failed.append(name)
        elif case.find("skipped") is not None:
            skipped += 1
        else:
            passed += 1
    return Result(suite, passed, tuple(dict.fromkeys(failed)), not_judged, skipped, seconds)


def table(results: Sequence[Result], when: datetime) -> str:
    """The results as Markdown."""
    rows = [
        f"| {result.suite.title} | {result.passed} | {len(result.failed)} | {result.not_judged} "
        f"| {result.not_for_windows} | {result.seconds:.0f} s{f', {result.note}' if result.note else ''} |"
        for result in results
    ]
    sums = [sum(column) for column in zip(*((result.passed, len(result.failed), result.not_judged,
            result.not_for_windows, result.seconds) for result in results), strict=True)]  # fmt: skip
    named = [f"- `{name}`" for result in results for name in result.failed]
    return "\n".join([
        f"{when:%Y-%m-%d}, Wine 10, Python 3.13 for Windows:",
        "",
        "| suite | passed | failed | unknown under Wine | not for Windows | time |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows,
        f"| **all** | **{sums[0]}** | **{sums[1]}** | **{sums[2]}** | **{sums[3]}** | **{sums[4]:.0f} s** |",
        *(["", "Failed:", "", *named] if named else []),
        "",
    ])  # fmt: skip


def run_suites(suites: Sequence[Suite]) -> int:
    """Run them one after the other; returns 1 if something failed."""
    wine.copy_source()
    results = []
    for suite in suites:
        say(f"{suite.title} ...")
        results.append(run_suite(suite, suite.limit_s))
        result = results[-1]
        say(f"  {result.passed} passed, {len(result.failed)} failed, {result.seconds:.0f} s {result.note}")
        for name in result.failed:
            say(f"  failed: {name}")
    text = table(results, datetime.now(UTC))
    (wine.PLACE / "results.md").write_text(text, encoding="utf-8")
    say(text)
    return 0 if all(result.is_well for result in results) else 1


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="bootstrap.py windows", description="Test the program for Windows under Wine."
    )
    titles = [suite.title for suite in SUITES]
    parser.add_argument(
        "what", nargs="*", help=f"setup, quick, package, or suites by their titles: {'; '.join(titles)}"
    )
    chosen = parser.parse_args(arguments).what
    try:
        if chosen == ["quick"]:
            if not wine.is_prepared():
                say("Wine is not prepared here (bootstrap.py windows setup does it), so nothing was run for Windows.")
                return 0
            return run_suites([QUICK])
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
