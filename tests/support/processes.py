"""Runs the simulated module in another process, on a pseudo-terminal."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support.patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
PROGRAM = (sys.executable, "-m", "app")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}


@dataclass(frozen=True, slots=True)
class RunningModule:
    """A running `dps-s simulate`; `port` is the pseudo-terminal to open."""

    process: "subprocess.Popen[str]"
    port: str


@contextmanager
def run_module(*options: str) -> Iterator[RunningModule]:
    """Run `dps-s simulate` with these options; terminate it at the end."""
    with subprocess.Popen(
        [*PROGRAM, "simulate", *options],
        cwd=ROOT, env=ENVIRONMENT, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        try:
            assert process.stdout is not None
            port = process.stdout.readline().strip()
            assert port, "the simulated module did not start"
            yield RunningModule(process, port)
        finally:
            process.terminate()
            process.communicate(timeout=PATIENCE_S)
