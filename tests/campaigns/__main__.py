"""`python -m tests.campaigns`: what takes minutes to hours, of which the tests run a part.

    walk --rounds 20        every job and everything that may happen at any of its frames, so often at another frame
    lines --seconds 3600    how often a conversation ends without reason on bad lines
    commands --rounds 1000  the command line at random modules
    hands --rounds 20000    random hands at the window, and what happens to the module meanwhile
    soak --seconds 1800     the window, a module in another process and everything that happens to a line

All but the last are in virtual time. They run in a home of their own, hands at another scale with QT_SCALE_FACTOR=2.
The same seed repeats the same. Exit code 1 for anything that must not be.
"""

import argparse
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PySide6.QtWidgets import QApplication

from tests.campaigns import commands
from tests.campaigns.hands import run
from tests.campaigns.soak import soak
from tests.campaigns.walk import FAULTS, HAPPENINGS, LINES, cells, walk, watched
from tests.support.line import odd_module


def _walk(seeds: range) -> int:
    """Of exchanges it is counted how many were not noticed: under half a second of silence that is a blind spot."""
    runs, unnoticed, broken = Counter[str](), Counter[str](), 0
    for seed in seeds:
        for result in walk(cells(seed=seed)):
            name = result.plan.happening
            runs[name] += 1
            unnoticed[name] += result.is_unnoticed
            if result.findings and (name in FAULTS or HAPPENINGS[name].must_end):
                broken += 1
                print(f"{result.plan}: {'; '.join(result.findings)}", flush=True)
    for name, count in runs.items():
        print(f"{name:<40}{count:>6} runs, in {unnoticed[name]:>5} the conversation went on")
    return broken


def _lines(seconds: float, seed: int) -> int:
    broken = 0
    for name, line in LINES.items():
        for streams in (False, True):
            found = watched(*line, seconds, streams=streams, seed=seed)
            ends = ", ".join(f"{count} x {reason}" for reason, count in found.ends.items()) or "no end"
            how = "streamed" if streams else "polled"
            print(f"{name:<40}{how:<10}{ends}, {found.unanswered} not answered in {seconds:.0f} s", flush=True)
            broken += bool(found.ends)
    return broken


def _commands(seeds: range) -> int:
    with tempfile.TemporaryDirectory() as folder:
        texts, broken = commands.campaign(seeds, Path(folder))
    print("\n".join(texts))
    return broken


def _hands(rounds: int, seed: int) -> int:
    report = run(QApplication(sys.argv[:1]), rounds, seed)
    print(f"{report.sequences} sequences; left: {dict(report.frames)}", *report.faults, sep="\n")
    return len(report.faults)


def _soak(seconds: float, seed: int) -> int:
    complaints = soak(seconds, seed)
    print("\n".join(complaints) or "all as it should be")
    return len(complaints)


@contextmanager
def confined_home() -> Iterator[None]:
    """Make a temporary folder the home, the working folder and the place of temporary files of this process: a file
    dialog of Qt once took the folder away in which the tests were started, by one press of Delete."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="dps-s-", ignore_cleanup_errors=True) as name:
        os.environ |= {"HOME": name, "TMPDIR": name}
        os.environ |= {f"XDG_{one}_HOME": f"{name}/{one.lower()}" for one in ("CONFIG", "DATA", "STATE", "CACHE")}
        for one in ("APPDATA", "LOCAL_APPDATA", "COMMON_APPDATA", "PERSONAL"):
            os.environ[f"WIN_PD_OVERRIDE_{one}"] = f"{name}/{one.lower()}"
        tempfile.tempdir = name
        os.chdir(name)
        try:
            yield
        finally:
            os.chdir(before)
            tempfile.tempdir = None


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.campaigns", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("walk", "lines", "commands", "hands", "soak"))
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1, help="of the first round")
    parser.add_argument("--seconds", type=float, default=3600.0, help="(default: %(default)s)")
    args = parser.parse_args()
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    odd_module.install()
    seeds = range(args.seed, args.seed + args.rounds)
    with confined_home():
        broken = {
            "walk": lambda: _walk(seeds),
            "lines": lambda: _lines(args.seconds, args.seed),
            "commands": lambda: _commands(seeds),
            "hands": lambda: _hands(args.rounds, args.seed),
            "soak": lambda: _soak(args.seconds, args.seed),
        }[args.what]()
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
