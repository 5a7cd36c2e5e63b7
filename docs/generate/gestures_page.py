"""Write docs/gestures.md: what came of every careless gesture at every button of a dangerous act.

python docs/generate/gestures_page.py               write it, from one in 293 tries (a prime: all gaps come up)
python docs/generate/gestures_page.py --every 1     from the whole table; takes hours
"""

import argparse
import sys
from collections import Counter, defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.gestures.gesture_table import ACTS, GAPS_S, GESTURES, GRID_PX, LANGUAGES, SCALES, SIZES, Tally, run_table  # noqa: E402

PAGE = ROOT / "docs" / "gestures.md"

INTRODUCTION = """\
# Careless gestures

Written by `docs/generate/gestures_page.py` from a run of `tests/gestures/gesture_table.py`;
`tests/gestures/test_gestures.py` holds that every row is here and runs a part of the table, the soak runs more.

At every point of a grid of {grid} px over the first button of every act, in a real window on a simulated module, the
pointer stays where it is and presses: {gestures}; with gaps of {gaps} ms; in windows of {sizes}; in {languages}; at a
scale of {scales}. The events go to the window as the platform sends them: Qt finds the button under the pointer.

Nothing may be sent or begun by any of them. The same hands complete each act by its whole gesture
(`test_gestures.py::test_the_whole_gesture_completes_each`). Number of tries in this run, one in {every} of the table:

{table}

**{tries} tries, {left} of them completed an act.**
"""

CAMPAIGN = """\
## Clumsy hands

`tests/gestures/clumsy.py`: pointer, keys, scrolling, resizing and turning of pages at random, on the pages Commands,
Settings and Pre-flight (and Tests, which came after the last campaign: 900 sequences since, none without its gesture),
on a module that becomes active and locked meanwhile. Beside it
`tests/gestures/observer.py` judges every dangerous frame as it leaves: one without a whole gesture of its own
is a fault. Some gestures are made whole, so that frames do leave. Parts in which the observer itself was wrong (it
did not know how long a check may wait, nor that Settings writes triggers, too) do not count; they were run again
after it had been corrected.

The last campaign, in parts of 1,000 sequences:

- offscreen: 10,000 sequences, 85,685 events
- X11 under Xvfb: 10,000 sequences, 85,479 events
- left, each by its whole gesture: activate 43, forbid deploying 51, deploy 2, shut down 20, baud rate 8, zero 25,
  attitude trigger enabled by a check 578, free-fall trigger enabled by a check 576, write to an active module 30

**20,000 sequences, 171,164 events, 1,333 watched frames, 0 of them without a whole gesture.**
"""


def page(tallies: list[Tally], every: int) -> str:
    """The text of docs/gestures.md."""
    rows: dict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
    left: Counter[tuple[str, str, str]] = Counter()
    for tally in tallies:
        key = (tally.act, tally.size, tally.language)
        rows[key].update(tally.tries)
        left[key] += len(tally.left)
    heads = ("Act", "Window", "Language", *GESTURES, "completed")
    lines = [heads, ["---"] * 3 + ["---:"] * (len(GESTURES) + 1)]
    lines += [[*key, *(f"{tries[gesture]:,}" for gesture in GESTURES), str(left[key])] for key, tries in rows.items()]
    return (
        INTRODUCTION.format(
            grid=GRID_PX,
            gestures=" · ".join(GESTURES),
            gaps=", ".join(f"{gap * 1000:.0f}" for gap in GAPS_S),
            sizes=" and ".join(f"{width}×{height}" for width, height in SIZES),
            languages=", ".join(LANGUAGES),
            scales=" and ".join(f"{scale * 100} %" for scale in SCALES),
            every=every,
            table="\n".join("| " + " | ".join(line) + " |" for line in lines),
            tries=f"{sum(sum(tries.values()) for tries in rows.values()):,}",
            left=sum(left.values()),
        )
        + "\n"
        + CAMPAIGN
    )


def is_complete(text: str) -> bool:
    """Whether every act has its row for each window and language, with tries and nothing completed."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
    found = {tuple(row[:3]) for row in rows[2:] if row[-1] == "0" and all(cell not in ("0", "") for cell in row[4:-1])}
    wanted = {
        (act.name, f"{width}×{height}", language) for act in ACTS for width, height in SIZES for language in LANGUAGES
    }
    return found == wanted and "of them completed an act" in text


def main(arguments: list[str] | None = None) -> int:
    """Write the page; 1 when a gesture completed an act."""
    parser = argparse.ArgumentParser(description="Write docs/gestures.md from a run of the table of gestures.")
    parser.add_argument("--every", type=int, default=293, help="take each n-th try only (default: 293)")
    options = parser.parse_args(arguments)
    tallies = run_table(options.every)
    PAGE.write_text(page(tallies, options.every), encoding="utf-8", newline="\n")
    return 1 if any(tally.left for tally in tallies) else 0


if __name__ == "__main__":
    sys.exit(main())
