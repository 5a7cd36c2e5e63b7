"""Real ports, on pseudo-terminals: errors of the system and of pyserial become our own, and everything ends in time."""

import errno
import os
import sys
import termios
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import serial

from app.engine import transport
from app.engine.conversation import Interrupted
from app.engine.procedure import Job
from app.engine.transport import PortError, PortTrouble, SerialLine, open_line
from app.engine.worker import Batch, PortState, Worker
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from protocol.catalogue import STATUS
from protocol.events import EndReason, Rejected
from tests.support.line.batches import Batches
from tests.support.patience import PATIENCE_S
from tests.support.processes import RunningModule, ran_code
from tests.support.terminals import STATUS_FRAME, Terminal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")

NOBODY = 65534
"""An unprivileged user that exists on every system."""


def test_a_port_without_permission(terminal: Terminal) -> None:
    """Root may open everything, so the child process changes its user first."""
    Path(terminal.name).chmod(0)
    code = (
        "import os, sys\nfrom app.engine.transport import PortError, open_line\n"
        "nobody = int(sys.argv[2])\n"
        "if os.geteuid() == 0:\n    os.setgroups([])\n    os.setgid(nobody)\n    os.setuid(nobody)\n"
        "try:\n    open_line(sys.argv[1], 115200)\nexcept PortError as error:\n    print(error.trouble.value)"
    )
    done = ran_code(code, terminal.name, NOBODY)
    assert done.stdout.strip() == "not allowed", done.stderr


RAISED = pytest.mark.parametrize(
    "error",
    [
        serial.SerialException("device reports readiness to read but returned no data"),
        termios.error(errno.EIO, "Input/output error"),
        TypeError("'NoneType' object cannot be interpreted as an integer"),
    ],
    ids=["SerialException", "termios.error", "TypeError"],
)


@pytest.fixture
def fail(error: Exception) -> Callable[..., Any]:
    def fail(*_: object) -> Any:
        raise error

    return fail


@pytest.fixture
def line(terminal: Terminal) -> Iterator[SerialLine]:
    line = open_line(terminal.name, 115200)
    yield line
    line.close()


@RAISED
@pytest.mark.parametrize("where", ["write", "reset_input_buffer", "close"])
@pytest.mark.promise("k")
def test_any_error_of_pyserial_is_a_lost_port(
    where: str, fail: Callable[..., Any], line: SerialLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(os if where == "write" else serial.Serial, where, fail)
        match where:
            case "close":
                line.close()  # never raises
            case "write":
                with pytest.raises(PortError):
                    line.write(STATUS.query().encode())
            case _:
                with pytest.raises(PortError):
                    line.use_rate(9600)
    line.close()


@RAISED
@pytest.mark.parametrize("where", ["select", "os.read", "fileno", "read", "pyserial's read", "pyserial's in_waiting"])
@pytest.mark.promise("k")
def test_any_error_of_a_read_is_a_lost_port(
    where: str, fail: Callable[..., Any], line: SerialLine, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        if "pyserial" in where:  # the way used on Windows, and for ports given by a URL
            patch.setattr(line, "_interrupts", None)
        match where:
            case "select":
                patch.setattr(transport, "select", SimpleNamespace(select=fail))
            case "os.read":
                patch.setattr(transport, "os", SimpleNamespace(read=fail))
            case "fileno":
                patch.setattr(serial.Serial, "fileno", fail)
            case "pyserial's in_waiting":
                patch.setattr(serial.Serial, "read", lambda *_: STATUS_FRAME[:1])
                patch.setattr(serial.Serial, "in_waiting", property(fail))
            case _:  # an unplugged adapter is readable and has nothing; then pyserial is asked
                patch.setattr(transport, "os", SimpleNamespace(read=lambda *_: b""))
                patch.setattr(serial.Serial, "read", fail)
        terminal.send(STATUS_FRAME)
        with pytest.raises(PortError) as lost:
            line.read(10.0, 0.0)
    assert lost.value.trouble is PortTrouble.LOST


@pytest.mark.parametrize("longest_s", [0.0, 0.01])
@pytest.mark.parametrize("port", ["terminal", "terminal, by pyserial", "loop://", "sim://read-after-close"])
@pytest.mark.promise("k")
def test_a_read_after_the_close_is_a_lost_port(
    port: str, longest_s: float, terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = open_line(port if "://" in port else terminal.name, 115200)
    if "pyserial" in port:
        monkeypatch.setattr(line, "_interrupts", None)
    line.close()
    with pytest.raises(PortError) as lost:
        line.read(longest_s, 0.0)
    assert lost.value.trouble is PortTrouble.LOST


# An open port: it is closed in time with one of our messages and no invented value


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


def trouble_of(batch: Batch) -> PortTrouble | None:
    return None if batch.connection.trouble is None else batch.connection.trouble.trouble


def test_unplugged_in_the_middle_of_everything(worker: Worker, batches: Batches, module: RunningModule) -> None:
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(
        lambda batch: batch.conversation.is_going and batch.conversation.known("active", batch.at) is not None
    )
    job = worker.submit(Job(read_everything()))
    module.process.kill()  # its pseudo-terminal goes with it
    lost = batches.until(lambda batch: trouble_of(batch) is PortTrouble.LOST)
    assert "active" in lost.conversation.values
    assert all(lost.conversation.fresh(key, lost.at) is None for key in lost.conversation.values)
    assert job.wait(PATIENCE_S)
    assert isinstance(job.error, Interrupted)
    assert job.error.reason is EndReason.PORT_LOST


def test_bytes_after_closing_are_ignored(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    batches.mark()
    worker.close()
    closed = batches.until(lambda batch: batch.connection.state is PortState.CLOSED)
    terminal.send(STATUS_FRAME * 10)
    worker.open(terminal.name, 115200)
    batches.mark()
    batches.until(is_open)
    terminal.send(b"\x00")
    seen = batches.until(lambda batch: any(isinstance(event, Rejected) for event in batch.events))
    assert closed.conversation.values == {}
    assert seen.conversation.known("tilt_deg", seen.at) is None
