"""`python -m tests.campaigns`: what takes minutes to hours, of which the tests run a part.

    walk --rounds 20        every job and everything that may happen at any of its frames, so often at another frame,
                            and at so many modules that speak, fail and lie in their own way
    lines --seconds 3600    how often a conversation ends without reason on bad lines
    hands --rounds 20000    random hands at the window, and what happens to the module meanwhile
    soak --seconds 1800     the window, a module in another process and everything that happens to a line

All but the last are in virtual time. They run in a home of their own, hands at another scale with QT_SCALE_FACTOR=2.
The same seed repeats the same. Exit code 1 for anything that must not be.
"""

import argparse
import itertools
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path

from PySide6.QtWidgets import QApplication

from tests.campaigns import hands
from tests.campaigns.soak import soak
from tests.campaigns.walk import EXCHANGES, LINES, cells, odd_cells, walk, watched

# Each prints what it finds as it goes, and returns what must not be.


def _walk(args: argparse.Namespace) -> list[str]:
    """Of exchanges it is counted how many were not noticed: under half a second of silence that is a blind spot."""
    runs, unnoticed, broken = Counter[str](), Counter[str](), list[str]()
    for seed in range(args.seed, args.seed + args.rounds):
        for result in walk(itertools.chain(cells(seed=seed), odd_cells([seed]))):
            name = result.plan.happening
            runs[name] += 1
            unnoticed[name] += result.is_unnoticed
            if result.findings and (name not in EXCHANGES or EXCHANGES[name].must_end):
                broken.append(f"{result.plan}: {'; '.join(result.findings)}")
    for name, count in runs.items():
        print(f"{name or 'nothing':<40}{count:>6} runs, in {unnoticed[name]:>5} the conversation went on")
    return broken


def _lines(args: argparse.Namespace) -> list[str]:
    broken = []
    for (name, line), streams in product(LINES.items(), (False, True)):
        found = watched(*line, args.seconds, streams=streams, seed=args.seed)
        ends = ", ".join(f"{count} x {reason}" for reason, count in found.ends.items()) or "no end"
        how = "streamed" if streams else "polled"
        print(f"{name:<40}{how:<10}{ends}, {found.unanswered} not answered in {args.seconds:.0f} s", flush=True)
        broken += [f"{name}, {how}: {ends}"] * bool(found.ends)
    return broken


def _hands(args: argparse.Namespace) -> list[str]:
    report = hands.run(QApplication(sys.argv[:1]), args.rounds, args.seed)
    print(f"{report.sequences} sequences; left: {dict(report.frames)}")
    return report.faults


CAMPAIGNS: dict[str, Callable[[argparse.Namespace], list[str]]] = {
    "walk": _walk,
    "lines": _lines,
    "hands": _hands,
    "soak": lambda args: soak(args.seconds, args.seed),
}


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
    parser.add_argument("what", choices=CAMPAIGNS)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1, help="of the first round")
    parser.add_argument("--seconds", type=float, default=3600.0, help="(default: %(default)s)")
    args = parser.parse_args()
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    with confined_home():
        broken = CAMPAIGNS[args.what](args)
    print(*broken or ["all as it should be"], sep="\n")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
