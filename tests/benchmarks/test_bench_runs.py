"""The benchmarks and the soak run and print results; speed is not asserted."""

import datetime
import sys
from importlib import import_module
from types import ModuleType

import pytest

from tests.benchmarks import __main__ as program
from tests.benchmarks import link, others, parser, reading
from tests.benchmarks.figures import Durations, Figure, quantile, table
from tests.benchmarks.runs import MODULES
from tests.benchmarks.window import page
from tests.soak.faults import Mistakes


def test_the_parser_is_measured_clean_and_corrupted() -> None:
    found = parser.figures(frames=400, rounds=1)
    assert len(found) == 6
    assert all("frames/s" in one.measured for one in found)
    assert [one.is_met is not None for one in found] == [True, *[False] * 5]


def test_what_others_write_finds_the_same_frames() -> None:
    chunks = [parser.stream(50)[at : at + 7] for at in range(0, 400, 7)]
    assert others.parse_bytewise(chunks) == others.parse_with_construct(chunks) == 50
    assert 0 < others.parse_with_construct([parser.corrupted(b"".join(chunks), 0.05)]) < 50


def test_the_link_is_measured() -> None:
    (found,) = link.figures(exchanges=50, rounds=1)
    assert "x line" in found.measured


def test_the_page_has_every_figure_and_what_was_done() -> None:
    found = {"parser": [Figure("speed", "9 x line", ">= 10", is_met=False)], "link": [Figure("exchange", "7 µs")]}
    text = page.page(found, datetime.date(2026, 11, 20))
    assert "on 2026-11-20" in text
    assert "| speed | 9 x line | >= 10 | MISSED |" in text
    assert "| exchange | 7 µs |  |  |" in text
    assert all(" ".join((module.__doc__ or "").split()) in text for module in (parser, link))


def test_the_page_that_is_kept_has_every_benchmark() -> None:
    kept = page.PAGE.read_text(encoding="utf-8")
    assert [line[3:] for line in kept.splitlines() if line.startswith("## ")] == list(program.NAMES)


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")
def test_reading_everything_is_compared_with_bare_exchanges() -> None:
    exchanges, process = reading.figures(rounds=1, turns=1, processes=1)
    assert "bare" in exchanges.measured
    assert "script" in process.measured
    assert {exchanges.verdict, process.verdict} <= {"met", "MISSED"}


def test_durations_take_the_same_memory_however_many_they_are() -> None:
    durations, few = Durations(), [0.0, 0.00004, 0.0123, 0.31, 2.5]
    for one in few:
        durations.add(one)
    assert durations.longest_s == durations.quantile_s(1) == 2.5
    for share in (0.0, 0.3, 0.5, 0.7):
        assert 0 <= durations.quantile_s(share) - quantile(few, share) <= 0.0001 + 1e-9
    before = sum(map(sys.getsizeof, vars(durations).values()))
    for at in range(10_000):
        durations.add(at * 1e-4)
    assert sum(map(sys.getsizeof, vars(durations).values())) == before


def test_the_table_marks_missed_aims() -> None:
    lines = table([Figure("speed", "9", ">= 10", is_met=False), Figure("weight", "1 kg")]).splitlines()
    assert lines[1].split() == ["speed", "9", ">=", "10", "MISSED"]
    assert lines[2].split() == ["weight", "1", "kg"]


def test_missed_aims_set_the_exit_code_only_with_strict(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = ModuleType("slow")
    slow.figures = lambda: [Figure("speed", "9", ">= 10", is_met=False)]  # type: ignore[attr-defined]
    monkeypatch.setattr(program, "import_module", lambda _name: slow)
    assert program.main(["parser"]) == 0
    assert program.main(["parser", "--strict"]) == 1
    assert "1 of 1 aims missed" in capsys.readouterr().out


def test_a_benchmark_that_does_not_exist_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        program.main(["nonsense"])
    assert end.value.code == 2
    assert "nonsense" in capsys.readouterr().err


@pytest.mark.parametrize(("share", "expected"), [(0.0, 1.0), (0.5, 3.0), (0.99, 5.0), (1.0, 5.0)])
def test_a_quantile_is_one_of_the_values(share: float, expected: float) -> None:
    assert quantile([5, 1, 4, 2, 3], share) == expected


def test_the_soak_reports_uncaught_exceptions() -> None:
    with Mistakes() as mistakes:
        error = ValueError("unexpected")
        sys.excepthook(ValueError, error, None)
    assert len(mistakes.texts) == 1
    assert "unexpected" in mistakes.texts[0]


@pytest.mark.parametrize("name", list(MODULES))
def test_each_benchmark_is_found_and_measures(name: str) -> None:
    assert callable(import_module(MODULES[name]).figures)
