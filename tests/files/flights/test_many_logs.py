"""Logs in worker processes: all are returned, reading can be cancelled, a crash costs one log; no process is left."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from app.flights.judge import TriggerLimits
from app.flights.many_logs import LogOrder, SummarisedLog, summarise_logs
from tests.support.flights import log_bytes as made
from tests.support.processes import ran

TIMES = np.arange(0, 10, 0.1)


@pytest.fixture
def logs(tmp_path: Path) -> list[Path]:
    """The n-th tilts to 50° + n; the one before the last cannot be read."""
    paths = [tmp_path / f"{number:02}.ulg" for number in range(12)]
    for number, path in enumerate(paths):
        path.write_bytes(made.ulog_bytes(made.ulog_attitude(TIMES, 50.0 + number) + made.ulog_force(TIMES, 1.0)))
    paths[-2].write_bytes(b"no log")
    return paths


def fired(found: list[SummarisedLog]) -> list[str]:
    return [one.path.stem for one in sorted(found) if one.firings]


def test_every_log_comes_back_once(logs: list[Path]) -> None:
    order = LogOrder(limits=TriggerLimits(attitude_threshold_deg=58))
    for processes in (1, 2):
        found = list(summarise_logs(logs, order, processes=processes))
        assert sorted(one.path for one in found) == logs
        assert [one.path for one in found if one.flight is None] == [logs[-2]]
        assert all((one.why_not is None) == (one.flight is not None) for one in found)
        assert fired(found) == ["08", "09", "11"]


@pytest.mark.parametrize("processes", [1, 2])
def test_reading_can_be_cancelled_between_logs(logs: list[Path], processes: int) -> None:
    found: list[SummarisedLog] = []
    found.extend(summarise_logs(logs, LogOrder(), is_cancelled=lambda: bool(found), processes=processes))
    assert 1 <= len(found) < len(logs)


@pytest.mark.promise("g")
def test_a_crashed_process_costs_only_its_log(logs: list[Path]) -> None:
    """Also where more crash than there are processes."""
    order = LogOrder(columns=EndsProcess())  # type: ignore[arg-type]
    tables = [path.with_suffix(".csv") for path in logs[:3]]
    for table in tables:
        table.write_text("a,b\n1,2\n", encoding="utf-8")
    found = {log.path: log for log in summarise_logs([*tables, *logs[3:6]], order, processes=2)}
    assert sorted(found) == sorted([*tables, *logs[3:6]])
    why_not = {path: one.why_not.in_english() for path, one in found.items() if one.why_not is not None}
    assert why_not == dict.fromkeys(tables, "cannot be read.")


class EndsProcess:
    """Ends the process when a reader uses the columns."""

    def __iter__(self) -> None:
        os._exit(9)


PROGRAM = """
import os, sys
from pathlib import Path
from app.flights.many_logs import LogOrder, summarise_logs

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for number, _ in enumerate(summarise_logs(sorted(folder.glob("*.csv")), LogOrder(), processes=2)):
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
