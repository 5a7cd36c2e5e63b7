"""`python -m tests.campaigns`: what takes minutes to hours, of which the tests run a part.

    walk --rounds 20        every job and everything that may happen at any of its frames, so often at another frame
    lines --seconds 3600    how often a conversation ends without reason on bad lines
    commands --rounds 1000  the program at random modules, eight at once, a few seconds each
    hands --rounds 20000    random hands at the window, and what happens to the module meanwhile

The first two are in virtual time: an hour takes a minute. The last one runs in a home of its own, and at another
scale with QT_SCALE_FACTOR=2. The same seed repeats the same. Exit code 1 for anything that
must not be.
"""

import argparse
import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

from PySide6.QtWidgets import QApplication

from tests.campaigns import commands
from tests.campaigns.confined import confined_home
from tests.campaigns.hands import run
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


def _hands(sequences: int, seed: int) -> int:
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    odd_module.install()
    report = run(QApplication(sys.argv[:1]), sequences, seed)
    print(f"{report.sequences} sequences; left: {dict(report.frames)}", *report.faults, sep="\n")
    return len(report.faults)


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.campaigns", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("walk", "lines", "commands", "hands"))
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1, help="of the first round")
    parser.add_argument("--seconds", type=float, default=3600.0, help="on each line (default: %(default)s)")
    args = parser.parse_args()
    if args.what == "hands":
        with confined_home():
            return int(_hands(args.rounds, args.seed) > 0)
    seeds = range(args.seed, args.seed + args.rounds)
    if args.what == "lines":
        return int(_lines(args.seconds, args.seed) > 0)
    return int((_walk(seeds) if args.what == "walk" else _commands(seeds)) > 0)


if __name__ == "__main__":
    sys.exit(main())
