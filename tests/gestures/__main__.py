"""Runs the table of careless gestures and writes the counts to build/gestures.md, or random hands.

python -m tests.gestures                      one in 293 tries (a prime, so that all gaps occur)
python -m tests.gestures --every 1            the whole table; takes hours
python -m tests.gestures --sequences 20000    random hands, and what happens to the module meanwhile
"""

import argparse
import json
import os
import sys
from collections import Counter, defaultdict
from dataclasses import asdict
from pathlib import Path

from PySide6.QtWidgets import QApplication

from tests.gestures.clumsy import run
from tests.gestures.gesture_table import GESTURES, Tally, run_table, run_windows

TARGET = Path(__file__).parents[2] / "build" / "gestures.md"


def table(tallies: list[Tally]) -> str:
    rows: dict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
    left: Counter[tuple[str, str, str]] = Counter()
    for tally in tallies:
        key = (tally.act, tally.size, tally.language)
        rows[key].update(tally.tries)
        left[key] += len(tally.left)
    heads = ("Act", "Window", "Language", *GESTURES, "completed")
    lines = [heads, ["---"] * 3 + ["---:"] * (len(GESTURES) + 1)]
    lines += [[*key, *(f"{tries[gesture]:,}" for gesture in GESTURES), str(left[key])] for key, tries in rows.items()]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def main() -> int:
    """Exit code 1 if a gesture completed an act, or random hands found anything."""
    parser = argparse.ArgumentParser(prog="python -m tests.gestures", description="Run careless gestures.")
    parser.add_argument("--every", type=int, default=293, help="take each n-th try only (default: 293)")
    parser.add_argument("--first", type=int, default=0, help="begin with this try")
    parser.add_argument("--sequences", type=int, default=0, help="random hands instead of the table")
    parser.add_argument("--seed", type=int, default=1, help="the same seed, the same hands")
    parser.add_argument("--scale", type=int, help="this scale only, as QT_SCALE_FACTOR has set it; prints JSON")
    given = parser.parse_args()
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    if not given.sequences and given.scale is None:
        tallies = run_table(given.every, given.first)
        TARGET.parent.mkdir(exist_ok=True)
        TARGET.write_text(table(tallies), encoding="utf-8", newline="\n")
        return 1 if any(tally.left for tally in tallies) else 0
    application = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(application, QApplication)
    if given.scale is not None:
        print(json.dumps([asdict(tally) for tally in run_windows(application, given.scale, given.every, given.first)]))
        return 0
    report = run(application, given.sequences, given.seed, is_told=True)
    print("\n".join(report.faults[:10]))
    return 1 if report.faults else 0


if __name__ == "__main__":
    sys.exit(main())
