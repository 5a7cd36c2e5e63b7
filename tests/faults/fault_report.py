"""Writes what came of the faults, one file for each row, into build/faults/."""

from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path

from tests.faults.fault_kinds import FAULTS
from tests.faults.fault_table import Result, Row, clean_requests, run_cell, target_index
from tests.faults.faulty_port import Phase
from tests.support.thorough import some

FOLDER = Path(__file__).parents[2] / "build" / "faults"
Cells = Mapping[tuple[str, Phase], Result]
"""Results of one row by fault and phase."""


NOT_RUN = Result("", (), 0.0, has_struck=False)


def run_row(row: Row, number: int) -> Cells:
    """Faults in phases of one procedure: a tenth of all, from another one on in each row `number`."""
    index = target_index(row)
    cells = some(product(FAULTS, Phase), one_in=10, first=number)
    return {(fault.name, phase): run_cell(row, fault, phase, index) for fault, phase in cells}


def lines(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    heads = tuple(heads)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (heads, ["---"] * len(heads), *rows))


def behaviours() -> str:
    """The table of docs/safety.md."""
    return lines(("Fault", "What the program does"), ((fault.name, fault.behaviour) for fault in FAULTS))


def write_row(row: Row, cells: Cells) -> Path:
    struck = clean_requests(row)[target_index(row)]
    kind = "query" if struck.is_repeatable else "change"
    table = [[fault.name, *(cells.get((fault.name, phase), NOT_RUN).says for phase in Phase)] for fault in FAULTS]
    text = "\n\n".join((
        f"# `{row.title}`",
        f"Struck request: `{struck.encode().hex(' ').upper()}` ({struck.command.title}, {kind}).",
        lines(("Fault", *(phase.value for phase in Phase)), table),
    ))  # fmt: skip
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{row.title.replace(': ', '-')}.md"
    path.write_text(f"{text}\n", encoding="utf-8", newline="\n")
    return path
