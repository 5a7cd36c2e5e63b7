"""The examples of docs/flight-logs.md, executed."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from app import __main__ as program
from tests.support.flights import log_bytes as made

PAGE = Path(__file__).parents[2] / "docs" / "flight-logs.md"
MAX_LINES = 150
TIMES = np.arange(0, 20, 0.1)


def examples() -> list[tuple[str, str]]:
    """Each command line, and what it prints with its exit code."""
    block = re.findall(r"^```\n(.*?)^```", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)[0]
    parts = [part.partition("\n") for part in block.split("$ dps-s ")[1:]]
    return [(line, said) for line, _, said in parts]


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tilts = np.where(TIMES >= 12.35, 61.2, 5.0)
    Path("crash.ulg").write_bytes(made.ulog_bytes(made.ulog_attitude(TIMES, tilts) + made.ulog_force(TIMES, 1.0)))
    tables = (
        ("calm.csv", "time_s,tilt_deg,acceleration_g", 1, ",1"),
        ("tilt-only.csv", "time_s,tilt_deg", 1, ""),
        ("odd.csv", "when,angle,load", 1000, ",1"),
    )
    for name, head, per_s, rest in tables:
        rows = "".join(f"{at_s * per_s:.1f},5{rest}\n" for at_s in TIMES)
        Path(name).write_text(f"{head}\n{rows}", encoding="utf-8")


@pytest.mark.usefixtures("logs")
@pytest.mark.parametrize(("line", "said"), examples())
def test_an_example_prints_what_the_page_says(line: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    code = program.main(shlex.split(line))
    assert f"{capsys.readouterr().out}(exit code {code})\n" == said


def test_the_page_stays_a_table() -> None:
    assert len(examples()) == 4
    assert len(PAGE.read_text("utf-8").splitlines()) <= MAX_LINES
