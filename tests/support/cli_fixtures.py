"""Fixtures for tests of the command line; a test file enables them with `pytest_plugins`."""

from collections.abc import Callable, Iterator
from functools import partial, partialmethod
from itertools import count
from typing import Any

import pytest

from app.engine import transport
from tests.support.cli_line import Program, run_here
from tests.support.line.sim_line import SimulatedLine
from tests.support.patience import PATIENCE_S
from tests.support.virtual_cli import VirtualCli

_numbers = count(1)
_DISK_LIMITS = (
    "app.safety.journal.DURABLE_LIMIT_S",
    "app.procedures.write.DURABLE_LIMIT_S",
    "app.terminal.records.READ_LIMIT_S",
)


@pytest.fixture
def speaks_english(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also on a slow disk: the limits after which a command goes on without its store are not met."""
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    for limit in _DISK_LIMITS:
        monkeypatch.setattr(limit, PATIENCE_S)


@pytest.fixture
def wire(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Record every host frame that is written, in order."""
    frames: list[bytes] = []

    def recorded(line: Any, data: bytes, *, write: Callable[[Any, bytes], None]) -> None:
        frames.extend(data[start : start + 6] for start in range(0, len(data), 6))
        write(line, data)

    for kind in transport.SerialLine, SimulatedLine:
        monkeypatch.setattr(kind, "write", partialmethod(recorded, write=kind.write))
    return frames


@pytest.fixture
def dps_s(capsys: pytest.CaptureFixture[str]) -> Program:
    return partial(run_here, capsys)


@pytest.fixture
def port() -> str:
    """Return the URL of a new simulated module."""
    return f"sim://cli{next(_numbers)}"


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the waits, for tests of what follows them."""
    monkeypatch.setattr("app.cli.monitor.LISTEN_S", 0.3)


@pytest.fixture
def no_waiting() -> Iterator[None]:
    """The simulated modules are on a clock that goes as far as a command waits."""
    with VirtualCli().in_time():
        yield
