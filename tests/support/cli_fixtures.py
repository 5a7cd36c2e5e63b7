"""Fixtures for tests of the command line; a test file enables them with `pytest_plugins`."""

from itertools import count

import pytest

import app.__main__ as program
from app.engine import transport
from tests.support.check_pace import hurry_check

_numbers = count(1)


@pytest.fixture
def speaks_english(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    monkeypatch.delenv(program.DEBUG, raising=False)


@pytest.fixture
def wire(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Record every host frame that is written, in order."""
    frames: list[bytes] = []
    write = transport.SerialLine.write

    def recorded(line: transport.SerialLine, data: bytes) -> None:
        frames.extend(data[start : start + 6] for start in range(0, len(data), 6))
        write(line, data)

    monkeypatch.setattr(transport.SerialLine, "write", recorded)
    return frames


@pytest.fixture
def port() -> str:
    """Return the URL of a new simulated module."""
    return f"sim://cli{next(_numbers)}"


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the waits, for tests of what follows them."""
    monkeypatch.setattr("app.procedures.handshake.HANDSHAKE_WAITS_S", (0.2, 0.2))
    monkeypatch.setattr("app.procedures.stream.LISTEN_FIRST_S", 0.3)


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the pre-flight check."""
    hurry_check(monkeypatch)
