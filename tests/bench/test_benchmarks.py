"""The benchmarks run and print results; speed is not asserted."""

import sys
from types import ModuleType, SimpleNamespace

import pytest

from app.samples.ring_buffers import Series
from tests.bench import __main__ as program
from tests.bench import link, logs, parser, reading
from tests.bench.__main__ import NAMES
from tests.bench.figures import Figure
from tests.bench.window import reserve
from tests.support.processes import ROOT
from ui.pages.live.data import LiveData


def test_parser_and_link_are_measured() -> None:
    rows = parser.figures(frames=80, rounds=1)
    assert [row.is_met is not None for row in rows] == [True, *[False] * 5]
    assert all("frames/s" in row.measured for row in rows)
    (exchange,) = link.figures(exchanges=10, rounds=1)
    assert "x line" in exchange.measured


def test_what_others_write_finds_the_same_frames() -> None:
    chunks = [parser.stream(50)[at : at + 7] for at in range(0, 400, 7)]
    assert parser.parse(chunks) == parser.parse_with_construct(chunks) == 50
    assert 0 < parser.parse_with_construct([parser.corrupted(b"".join(chunks), 0.05)]) < 50


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")
def test_reading_everything_is_compared_with_bare_exchanges() -> None:
    exchanges, process = reading.figures(rounds=1, turns=1, processes=1)
    assert "bare" in exchanges.measured
    assert "script" in process.measured


def test_a_folder_of_logs_is_timed() -> None:
    assert [row.is_met for row in logs.figures(logs=5, seconds=20.0)] == [True] * len(logs.KINDS)


def test_the_memory_of_plots_is_reserved_without_a_sample() -> None:
    data = LiveData()
    data.tilt, data.acceleration, data._flags = (Series(100) for _ in range(3))
    reserve(SimpleNamespace(data=data))
    assert data.tilt.last is None


def test_missed_aims_are_marked_and_set_the_exit_code_only_with_strict(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = ModuleType("slow", "How slow it is.")
    slow.figures = lambda: [Figure("speed", "9", ">= 10", is_met=False)]  # type: ignore[attr-defined]
    monkeypatch.setattr(program, "import_module", lambda _name: slow)
    assert program.main(["parser"]) == 0
    assert program.main(["parser", "--strict"]) == 1
    shown = capsys.readouterr().out
    assert "## parser\n\nHow slow it is.\n" in shown
    assert "| speed | 9 | >= 10 | MISSED |" in shown
    assert "1 of 1 aims missed" in shown
    with pytest.raises(SystemExit) as end:
        program.main(["nonsense"])
    assert end.value.code == 2


def test_the_page_has_every_benchmark() -> None:
    page = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if f"\n| {name} |" not in page] == []
    assert all((ROOT / f"tests/bench/{name}.py").exists() for name in NAMES)
