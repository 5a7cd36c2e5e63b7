"""Writes docs/performance.md: the results of all benchmarks, with a description of each."""

import datetime
import platform
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Final

from app import version
from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import MODULES, cores
from tests.support.processes import ROOT

PAGE: Final = ROOT / "docs" / "performance.md"
_HEAD: Final = """\
# Performance

Written by `make bench` (`python3 packaging/bootstrap.py bench`) on {day}: version {version}, Python {python},
{system}, {cores} cores, offscreen. Other work on a machine makes every figure worse, so what is compared is measured
by turns in one run, and the ratios say more than the times. "Line" is 115200 baud: 1,440 status frames a second.
`make bench ARGS="parser gui"` runs some of them; `--strict` exits with 1 where an aim was missed. No test asserts how
quick anything is.

What others would do, each in `tests/benchmarks/`: a byte loop with a buffer and a parser declared with `construct`
(`others.py`), the same questions asked with bare pyserial (`reading.py`), four plots of pyqtgraph, tuned and as in its
tutorial (`others.py`).
"""


def page(found: Mapping[str, Iterable[Figure]], day: datetime.date) -> str:
    """The text for these figures by name of the benchmark."""
    lines = [
        _HEAD.format(
            day=day.isoformat(), version=version(), python=platform.python_version(), system=platform.system(),
            cores=cores(),
        )
    ]  # fmt: skip
    for name, figures in found.items():
        about = " ".join((import_module(MODULES[name]).__doc__ or "").split())
        lines += [f"## {name}", "", about, "", "| what | measured | aim | |", "| --- | --- | --- | --- |"]
        lines += [f"| {one.name} | {one.measured} | {one.aim} | {one.verdict} |" for one in figures]
        lines.append("")
    return "\n".join(lines)


def write_page(found: Mapping[str, Iterable[Figure]]) -> None:
    today = datetime.datetime.now(datetime.UTC).date()
    PAGE.write_text(page(found, today), encoding="utf-8")
