"""Results of a benchmark: table rows with aim and whether it was met."""

from array import array
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

_CLASS_S: Final = 0.0001
_CLASSES: Final = 10_001
"""The last class is for a second and more."""


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


class Durations:
    """Any number of durations in the same memory: a list of them would grow as a leak does. The longest is exact, a
    quantile is rounded up to 0.1 ms."""

    def __init__(self) -> None:
        self._counts = array("Q", bytes(8 * _CLASSES))
        self.longest_s = 0.0

    def add(self, duration_s: float) -> None:
        self._counts[min(_CLASSES - 1, max(0, int(duration_s / _CLASS_S)))] += 1
        self.longest_s = max(self.longest_s, duration_s)

    def quantile_s(self, share: float) -> float:
        """As `quantile`, at most the longest."""
        sums = list(accumulate(self._counts))
        if not sums[-1]:
            raise ValueError("nothing was measured")
        class_ = bisect_left(sums, min(sums[-1], int(share * sums[-1]) + 1))
        return self.longest_s if class_ == _CLASSES - 1 else min(self.longest_s, (class_ + 1) * _CLASS_S)
