"""Runs the table of careless gestures and writes the counts to build/gestures.md.

python -m tests.gestures               one in 293 tries (a prime, so that all gaps occur)
python -m tests.gestures --every 1     the whole table; takes hours
"""

import argparse
import sys
from collections import Counter, defaultdict
from pathlib import Path

from tests.gestures.gesture_table import GESTURES, Tally, run_table

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
    """Write the file; exit code 1 if a gesture completed an act."""
    parser = argparse.ArgumentParser(prog="python -m tests.gestures", description="Run the table of careless gestures.")
    parser.add_argument("--every", type=int, default=293, help="take each n-th try only (default: 293)")
    tallies = run_table(parser.parse_args().every)
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text(table(tallies), encoding="utf-8", newline="\n")
    return 1 if any(tally.left for tally in tallies) else 0


if __name__ == "__main__":
    sys.exit(main())
