"""Fixtures for tests of the command line; a test file enables them with `pytest_plugins`."""

import threading
import time
from functools import partial
from itertools import count
from types import SimpleNamespace

import pytest

import app.__main__ as program
from app.engine import transport
from app.engine.procedure import Procedure, Result
from app.engine.session import MAX_STEP_S, Session
from app.engine.worker import Worker
from app.simulator import bench as benches
from app.terminal.connection import Conversation
from tests.support.cli_line import Program, run_here

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
def dps_s(capsys: pytest.CaptureFixture[str]) -> Program:
    return partial(run_here, capsys)


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
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the clock forward where a command would wait for what the simulated module behind `port` answers."""
    monotonic, step, run, skipped_s = time.monotonic, Session.step, Conversation.run, 0.0
    conversations, workers = set[int](), set[int]()

    class Changed(threading.Condition):
        def wait(self, timeout: float | None = None) -> bool:
            nonlocal skipped_s
            # Beside another one that would be late.
            if timeout is None or workers != {threading.get_ident()} or len(conversations) != 1:
                return super().wait(timeout)
            skipped_s += timeout
            return False

    def clock() -> float:
        return monotonic() + skipped_s

    def stepped(session: Session, longest_s: float = MAX_STEP_S) -> None:
        waits_for_disk = any(run.waiting_since() is not None for run in session._runs())
        (workers.add if session.is_busy and not waits_for_disk else workers.discard)(threading.get_ident())
        step(session, longest_s)

    def ran(conversation: Conversation, procedure: Procedure[Result]) -> Result:
        conversations.add(id(conversation))
        try:
            return run(conversation, procedure)
        finally:
            conversations.discard(id(conversation))

    monkeypatch.setattr(Session, "step", stepped)
    monkeypatch.setattr(Conversation, "run", ran)
    monkeypatch.setattr(benches, "threading", SimpleNamespace(Condition=Changed, RLock=threading.RLock))
    monkeypatch.setattr(time, "monotonic", clock)
    for kind in Worker, benches.SimulatedBench:
        monkeypatch.setitem(vars(kind)["__init__"].__kwdefaults__, "clock", clock)
