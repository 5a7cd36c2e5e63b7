"""Runs the simulated module in another process, on a pseudo-terminal."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROGRAM = (sys.executable, "-m", "app")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}


@dataclass(frozen=True, slots=True)
class RunningModule:
    """A running `dps-s simulate`; `port` is the pseudo-terminal to open."""

    process: "subprocess.Popen[str]"
    port: str

    def tell(self, line: str) -> None:
        """Send a control line, such as "tilt 70", and wait for the answer."""
        assert self.process.stdin is not None
        assert self.process.stderr is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        self.process.stderr.readline()


@contextmanager
def run_module(*options: str) -> Iterator[RunningModule]:
    """Run `dps-s simulate` with these options; terminate it at the end."""
    with subprocess.Popen(
        [*PROGRAM, "simulate", *options],
        cwd=ROOT, env=ENVIRONMENT, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        try:
            assert process.stdout is not None
            port = process.stdout.readline().strip()
            assert port, "the simulated module did not start"
            yield RunningModule(process, port)
        finally:
            process.terminate()
            process.communicate(timeout=10)
