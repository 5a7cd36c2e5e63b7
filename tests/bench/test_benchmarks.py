"""The quick benchmarks run, and the page has all; how quick anything is, is not asserted."""

import sys
from collections.abc import Callable, Iterable

import pytest

from tests.bench import logs, reading
from tests.bench.__main__ import NAMES
from tests.bench.kit import Figure
from tests.support.processes import ROOT

QUICK: dict[str, Callable[[], Iterable[Figure]]] = {
    "reading": lambda: reading.reading(rounds=1, turns=1, processes=1),
    "logs": lambda: logs.logs(logs=2, seconds=20.0),
}


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")
@pytest.mark.parametrize("name", QUICK)
def test_it_runs(name: str) -> None:
    assert [figure for figure in QUICK[name]() if not figure.measured] == []


def test_the_page_has_every_benchmark() -> None:
    page = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if f"\n| {name} |" not in page] == []
