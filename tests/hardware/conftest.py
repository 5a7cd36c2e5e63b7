"""The port to test at, and the command line that is run on it."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
LIMIT_S = 120.0


class Ran(NamedTuple):
    """What a command printed and how it ended."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[dict[str, Any]]:
        """The JSON objects that were printed, one a line."""
        return [json.loads(line) for line in self.out.splitlines()]


Run = Callable[..., Ran]


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("hardware", "a real module")
    group.addoption("--port", help="the port of the module; without it these tests are skipped")
    group.addoption("--may-write", action="store_true", help="settings are changed, too, and set back")


@pytest.fixture
def port(request: pytest.FixtureRequest) -> str:
    named = request.config.getoption("--port", default=None)
    if named is None:
        pytest.skip("no port: pytest tests/hardware --port PORT")
    return str(named)


@pytest.fixture
def may_write(request: pytest.FixtureRequest) -> None:
    if not request.config.getoption("--may-write", default=False):
        pytest.skip("changes settings: add --may-write")


@pytest.fixture
def run(port: str) -> Run:
    """Runs `dps-s` with these words at the port, in a process of its own."""

    def run_words(*words: str) -> Ran:
        command = [sys.executable, "-m", "app", words[0], "--port", port, *words[1:]]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        return Ran(done.returncode, done.stdout, done.stderr)

    return run_words
