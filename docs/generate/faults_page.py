"""Write docs/faults.md: what comes of each fault in each procedure and phase, as run on the simulated module.

python docs/generate/faults_page.py             write it
python docs/generate/faults_page.py --check     exit 1 when it is out of date
"""

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.faults.fault_kinds import FAULTS  # noqa: E402  the tests lie beside this folder
from tests.faults.fault_rows import ROWS  # noqa: E402
from tests.faults.fault_table import LONGEST_S, Result, Row, clean_requests, run_cell, target_index  # noqa: E402
from tests.faults.faulty_port import Phase  # noqa: E402

PAGE = ROOT / "docs" / "faults.md"
Cells = Mapping[tuple[str, Phase], Result]
"""Those of one row, by the name of the fault and the phase."""

INTRODUCTION = """\
# Faults of the line

Written by `docs/generate/faults_page.py` from a run of all cells; `tests/faults/test_faults.py` runs them and keeps
this page current. {faults} faults, {procedures} procedures, {phases} phases: {cells} cells.

In every cell the following held, or the test would fail:

- The procedure ended within {longest} s (of the fake clock), with its typed result or the port's own error, never
  another one.
- Nothing was claimed, in the result or in what is shown as certain, that the module does not hold.
- Nothing but questions was sent twice. (On purpose: LOCK, and switching the stream off at the end of `watch`.)
- No thread and no open port was left; with the port closed nothing is shown as certain any more.

## What the program does about each

{behaviours}

## What came of it

The struck request is the first one that changes the module, where the procedure has one, else its second question.
"port error": the procedure ended with the port's error, as it should.

"""


def run_row(row: Row) -> Cells:
    """Every fault in every phase of one procedure."""
    index = target_index(row)
    return {(fault.name, phase): run_cell(row, fault, phase, index) for fault in FAULTS for phase in Phase}


def lines(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    heads = tuple(heads)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (heads, ["---"] * len(heads), *rows))


def page(sections: Sequence[str]) -> str:
    """The text of docs/faults.md."""
    return introduction() + "\n\n".join(sections) + "\n"


def introduction() -> str:
    """What stands before the sections."""
    return INTRODUCTION.format(
        faults=len(FAULTS),
        procedures=len({row.name for row in ROWS}),
        phases=len(Phase),
        cells=len(ROWS) * len(FAULTS) * len(Phase),
        longest=f"{LONGEST_S:.0f}",
        behaviours=lines(("Fault", "What the program does"), ((fault.name, fault.behaviour) for fault in FAULTS)),
    )


def section(row: Row, cells: Cells) -> str:
    """One row of the table, with its heading."""
    struck = clean_requests(row)[target_index(row)]
    kind = "question" if struck.is_repeatable else "change"
    rows = [[fault.name, *(cells[fault.name, phase].says for phase in Phase)] for fault in FAULTS]
    return "\n\n".join(
        (
            f"### `{row.title}`",
            f"Struck: `{struck.encode().hex(' ').upper()}` ({struck.command.title}, {kind}).",
            lines(("Fault", *(phase.value for phase in Phase)), rows),
        )
    )


def main(arguments: list[str] | None = None) -> int:
    """Write the page, or check it; 1 when it is out of date."""
    parser = argparse.ArgumentParser(description="Write docs/faults.md from a run of all cells.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when the page is out of date")
    options = parser.parse_args(arguments)
    text = page([section(row, run_row(row)) for row in ROWS])
    if options.check:
        is_current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == text
        if not is_current:
            print(f"{PAGE} is out of date: run python docs/generate/faults_page.py", file=sys.stderr)
        return 0 if is_current else 1
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
