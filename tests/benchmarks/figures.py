"""What a benchmark found: rows of one table, each with its aim and whether it was met."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Figure:
    """One row. `is_met` is None where there is no aim: the row only informs."""

    name: str
    measured: str
    aim: str = ""
    is_met: bool | None = None

    @property
    def verdict(self) -> str:
        return "" if self.is_met is None else "met" if self.is_met else "MISSED"


class _Row(NamedTuple):
    name: str
    measured: str
    aim: str
    verdict: str


_HEAD = _Row("", "measured", "aim", "")


def table(figures: Iterable[Figure]) -> str:
    """Aligned columns, one figure a line."""
    rows = [_HEAD, *(_Row(one.name, one.measured, one.aim, one.verdict) for one in figures)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def quantile(values: Iterable[float], share: float) -> float:
    """The value that `share` (0 … 1) of all do not exceed. Raises ValueError without values."""
    ordered = sorted(values)
    if not ordered:
        raise ValueError("nothing was measured")
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
