"""No worker process outlives the program."""

import sys
from pathlib import Path

from tests.support.processes import ran

PROGRAM = """
import os, sys
from pathlib import Path
from app.flight_analysis.many_logs import summarise_logs

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
