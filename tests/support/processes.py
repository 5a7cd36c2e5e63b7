"""Runs in another process: the simulated module on a pseudo-terminal, the program itself, and pieces of code."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple

from tests.support.patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
LONGEST_S = 4 * PATIENCE_S
PROGRAM = (sys.executable, "-m", "app")


def environment(**own: str) -> dict[str, str]:
    """That of the test, whose files are in a folder of its own."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1", **own}


def ran(*command: object, **own: str) -> "subprocess.CompletedProcess[str]":
    """Run it to its end in the checkout; `own`: variables of its environment. Again where the machine stood still for a
    moment, which ends a conversation on a real port."""
    for _ in range(5):
        done = subprocess.run(
            [*map(str, command)],
            cwd=ROOT, env=environment(**own), capture_output=True, encoding="utf-8", timeout=LONGEST_S, check=False,
        )  # fmt: skip
        if "silent for a moment" not in done.stdout + done.stderr:
            break
    return done


def ran_code(code: str, *words: object, **own: str) -> "subprocess.CompletedProcess[str]":
    return ran(sys.executable, "-c", code, *words, **own)


class Running(NamedTuple):
    """A process, and what it says and is told; `port` is the pseudo-terminal of a module."""

    process: "subprocess.Popen[str]"
    out: IO[str]
    errors: IO[str]
    told: IO[str]
    port: str = ""

    def tell(self, line: str) -> str:
        """Return the line that it answers."""
        self.told.write(f"{line}\n")
        self.told.flush()
        return self.out.readline().strip()

    def end(self) -> tuple[int, str, str]:
        """Its exit code and the rest of what it says."""
        out, errors = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, errors


@contextmanager
def running(*command: object, **own: str) -> Iterator[Running]:
    """Start it in the checkout; killed at the end."""
    with subprocess.Popen(
        [*map(str, command)], cwd=ROOT, env=environment(**own), encoding="utf-8",
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            yield Running(process, process.stdout, process.stderr, process.stdin)
        finally:
            process.kill()


@contextmanager
def run_module(*options: str) -> Iterator[Running]:
    """Run `dps-s simulate` with these options."""
    with running(*PROGRAM, "simulate", *options) as module:
        port = module.out.readline().strip()
        assert port, "the simulated module did not start"
        yield module._replace(port=port)
        module.process.terminate()
        module.end()


@contextmanager
def module_apart(link: Path, *options: str) -> Iterator[Running]:
    """The independent module; see `tests.module.__main__`, also for what it can be told. `link` leads to it."""
    with running(sys.executable, "-m", "tests.module", link, *options) as module:
        module.out.readline()
        yield module
        module.end()
