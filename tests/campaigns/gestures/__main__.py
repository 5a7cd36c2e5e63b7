"""Runs the table of careless gestures, or random hands; exit code 1 if one completed an act, or anything was wrong.

python -m tests.campaigns.gestures                      one in 293 tries (a prime, so that all gaps occur)
python -m tests.campaigns.gestures --every 1            the whole table; takes hours
python -m tests.campaigns.gestures --sequences 20000    random hands, and what happens to the module meanwhile
"""

import argparse
import os
import subprocess
import sys
from itertools import product
from pathlib import Path

from PySide6.QtWidgets import QApplication

from tests.campaigns.gestures.clumsy import run
from tests.campaigns.gestures.gesture_table import LANGUAGES, SIZES, run_window
from tests.support.confined import confined_home
from tests.support.line import odd_module

ROOT = Path(__file__).parents[3]
SCALE = "QT_SCALE_FACTOR"


def _run_table(application: QApplication, every: int, first: int) -> int:
    """At the scale of this process, which Qt reads once; then at the other one, in another."""
    tries, left = 0, list[str]()
    for size, language in product(SIZES, LANGUAGES):
        for count, of_act in run_window(application, size, language, every=every, first_try=first):
            tries += count
            left += [f"{size[0]}×{size[1]}, {language}: {one}" for one in of_act]
    print(f"{tries:,} tries, {len(left)} completed", *left, sep="\n", flush=True)
    if SCALE in os.environ:
        return len(left)
    words = [sys.executable, "-m", "tests.campaigns.gestures", "--every", str(every), "--first", str(first)]
    return len(left) + subprocess.run(words, cwd=ROOT, env={**os.environ, SCALE: "2"}, check=False).returncode


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.gestures", description="Run careless gestures.")
    parser.add_argument("--every", type=int, default=293, help="take each n-th try only (default: 293)")
    parser.add_argument("--first", type=int, default=0, help="begin with this try")
    parser.add_argument("--sequences", type=int, default=0, help="random hands instead of the table")
    parser.add_argument("--seed", type=int, default=1, help="the same seed, the same hands")
    given = parser.parse_args()
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    odd_module.install()
    application = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(application, QApplication)
    if not given.sequences:
        return 1 if _run_table(application, given.every, given.first) else 0
    report = run(application, given.sequences, given.seed)
    print("\n".join(report.faults[:10]))
    return 1 if report.faults else 0


if __name__ == "__main__":
    with confined_home():
        sys.exit(main())
