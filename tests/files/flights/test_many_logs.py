"""Logs in worker processes: all are returned, reading can be cancelled, a crash is said; no process is left."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer
from app.flights.read_log import SummarisedLog, summarise_logs
from tests.support.flights import log_bytes as made
from tests.support.processes import ran

TIMES = np.arange(0, 10, 0.1)


@pytest.fixture
def logs(tmp_path: Path) -> list[Path]:
    """The n-th tilts to 50° + n; the one before the last cannot be read."""
    paths = [tmp_path / f"{number:02}.ulg" for number in range(12)]
    for number, path in enumerate(paths):
        path.write_bytes(made.ulog_bytes(TIMES, 50.0 + number, 1.0))
    paths[-2].write_bytes(b"no log")
    return paths


def fired(found: list[SummarisedLog]) -> list[str]:
    limits = TriggerLimits(attitude_threshold_deg=58)
    flights = {one.path.stem: one.flight for one in found if one.flight is not None}
    return sorted(name for name, flight in flights.items() if flight.outcome(limits).answer is Answer.FIRES)


def test_every_log_comes_back_once(logs: list[Path]) -> None:
    for processes in (1, 2):
        found = list(summarise_logs(logs, processes=processes))
        assert sorted(one.path for one in found) == logs
        assert [one.path for one in found if one.flight is None] == [logs[-2]]
        assert all((one.why_not is None) == (one.flight is not None) for one in found)
        assert fired(found) == ["08", "09", "11"]


@pytest.mark.parametrize("processes", [1, 2])
def test_reading_can_be_cancelled_between_logs(logs: list[Path], processes: int) -> None:
    found: list[SummarisedLog] = []
    found.extend(summarise_logs(logs, is_cancelled=lambda: bool(found), processes=processes))
    assert 1 <= len(found) < len(logs)


@pytest.mark.promise("g")
def test_a_process_that_was_killed_leaves_no_log_out_of_the_result(logs: list[Path]) -> None:
    table = logs[0].with_suffix(".csv")
    table.write_text("a,b\n1,2\n", encoding="utf-8")
    paths = [*logs[1:6], table, *logs[6:]]
    found = list(summarise_logs(paths, EndsProcess(), processes=2))  # type: ignore[arg-type]
    assert sorted(one.path for one in found) == sorted(paths)
    why_not = {one.path: one.why_not.in_english() for one in found if one.why_not is not None}
    assert why_not[table] == "the program that reads it ended."


class EndsProcess:
    """Ends the process when a reader uses the columns."""

    def __iter__(self) -> None:
        os._exit(9)


PROGRAM = """
import os, sys
from pathlib import Path
from app.flights.read_log import summarise_logs

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for number, _ in enumerate(summarise_logs(sorted(folder.glob("*.csv")), processes=2)):
        print("read", flush=True)
        os._exit(0)
"""


def test_workers_end_with_a_killed_program(tmp_path: Path) -> None:
    """The output ends when the last worker ends, since each holds it open."""
    for number in range(40):
        (tmp_path / f"{number}.csv").write_text("time_s,tilt_deg\n0,1\n1,2\n", encoding="utf-8")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM, encoding="utf-8")
    assert ran(sys.executable, program, tmp_path).stdout == "read\n"
