"""Fixtures for tests of the command line; a test file enables them with `pytest_plugins`."""

import sys
import threading
from functools import partial
from itertools import count
from types import SimpleNamespace
from typing import Any

import pytest

from app.cli.commands import ENTRIES
from app.engine import transport
from app.engine.procedure import Procedure, Result
from app.engine.session import MAX_STEP_S, Session
from app.engine.worker import Worker
from app.simulator import bench as benches
from app.system import clock
from app.terminal.connection import OpenPort
from tests.support.cli_line import Program, run_here
from tests.support.patience import PATIENCE_S

_numbers = count(1)
_DISK_LIMITS = (
    "app.safety.journal.DURABLE_LIMIT_S",
    "app.procedures.write.DURABLE_LIMIT_S",
    "app.terminal.records.READ_LIMIT_S",
    "app.terminal.records.LEFT_LIMIT_S",
    "app.cli.lock.STORE_LIMIT_S",
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
    monkeypatch.setattr("app.cli.monitor.LISTEN_S", 0.3)


@pytest.fixture
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the clock forward where a command would wait for what the simulated module behind `port` answers."""
    steady, step, run, skipped_s = clock.steady_time, Session.step, OpenPort.run, 0.0
    ports, workers = set[int](), set[int]()

    class Changed(threading.Condition):
        def wait(self, timeout: float | None = None) -> bool:
            nonlocal skipped_s
            # Beside another one that would be late. One may have ended in the middle of a job.
            busy = workers & {thread.ident for thread in threading.enumerate()}
            if timeout is None or busy != {threading.get_ident()} or len(ports) != 1:
                return super().wait(timeout)
            skipped_s += timeout
            return False

    def now() -> float:
        return steady() + skipped_s

    def stepped(session: Session, longest_s: float = MAX_STEP_S) -> None:
        waits_for_disk = any(job.is_awaiting for job in session._jobs)
        (workers.add if session.is_busy and not waits_for_disk else workers.discard)(threading.get_ident())
        step(session, longest_s)

    def ran(opened: OpenPort, procedure: Procedure[Result], **options: Any) -> Result:
        ports.add(id(opened))
        try:
            return run(opened, procedure, **options)
        finally:
            ports.discard(id(opened))

    monkeypatch.setattr(Session, "step", stepped)
    monkeypatch.setattr(OpenPort, "run", ran)
    monkeypatch.setattr(benches, "threading", SimpleNamespace(Condition=Changed, RLock=threading.RLock))
    for entry in ENTRIES:
        entry.load()  # so that each has the clock of this test, and not of the one that loads it first
    for module in list(sys.modules.values()):
        if getattr(module, "steady_time", None) is steady:
            monkeypatch.setattr(module, "steady_time", now)
    for kind in Worker, benches.SimulatedBench:
        monkeypatch.setitem(vars(kind)["__init__"].__kwdefaults__, "clock", now)
