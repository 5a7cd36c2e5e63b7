"""A row of results, and a measurement in a process of its own, so that none influences the next."""

import json
import sys
from typing import Any, NamedTuple

from tests.support.processes import ran

_OFFSCREEN = "propagateSizeHints"
"""A warning of the offscreen platform, which has no window manager."""


class Figure(NamedTuple):
    """`is_met` is None if there is no aim."""

    name: str
    measured: str
    aim: str = ""
    is_met: bool | None = None

    @property
    def row(self) -> str:
        """As Markdown, which docs/performance.md is written in."""
        verdict = "" if self.is_met is None else "met" if self.is_met else "MISSED"
        return f"| {self.name} | {self.measured} | {self.aim} | {verdict} |"


def measured(program: str, *words: object) -> dict[str, Any]:
    """What `python -m tests.bench.PROGRAM words…` prints as JSON. Raises RuntimeError if it fails."""
    done = ran(sys.executable, "-m", f"tests.bench.{program}", *words, QT_QPA_PLATFORM="offscreen")
    if done.returncode or not done.stdout:
        raise RuntimeError(f"{program} failed:\n{done.stderr[-2000:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    print(*(line for line in done.stderr.splitlines() if _OFFSCREEN not in line), sep="\n", end="", file=sys.stderr)
    return found
