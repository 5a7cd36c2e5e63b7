"""Results of a benchmark: table rows with aim and whether it was met."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """One row. `is_met` is None if there is no aim."""

    name: str
    measured: str
    aim: str = ""
    is_met: bool | None = None

    @property
    def verdict(self) -> str:
        return "" if self.is_met is None else "met" if self.is_met else "MISSED"


def table(figures: Iterable[Figure]) -> str:
    """As Markdown, which docs/performance.md is written in."""
    rows = (f"| {figure.name} | {figure.measured} | {figure.aim} | {figure.verdict} |" for figure in figures)
    return "\n".join(["| what | measured | aim | |", "| --- | --- | --- | --- |", *rows])


def quantile(values: Iterable[float], share: float) -> float:
    """The quantile `share` (0 … 1). Raises ValueError without values."""
    ordered = sorted(values)
    if not ordered:
        raise ValueError("nothing was measured")
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
