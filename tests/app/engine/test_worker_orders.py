"""An order does not wait for the port: it ends the read that waits for bytes."""

import sys
import time
from collections.abc import Callable

import pytest
import serial

from app.engine import transport
from app.engine.procedure import Job
from app.engine.worker import Batch, Worker
from app.procedures.find import await_module
from app.procedures.lock import lock
from app.procedures.read import read_everything
from app.simulator import bench
from protocol.catalogue import STATUS
from tests.support.patience import PATIENCE_S, in_time
from tests.support.processes import run_module
from tests.support.terminals import STATUS_FRAME, Terminal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")
pytest_plugins = ["tests.support.port_fixtures"]

_FOR_EVER_S = 2 * PATIENCE_S


def ignore(_: Batch) -> None:
    pass


@pytest.mark.parametrize("is_windows", [False, True])
@pytest.mark.promise("j")
def test_an_interrupt_ends_the_lingering_after_the_first_byte_and_loses_none(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch, *, is_windows: bool
) -> None:
    line = transport.open_line(terminal.name, 115200)
    if is_windows:
        monkeypatch.setattr(line, "_interrupts", None)
        monkeypatch.setattr(serial.Serial, "cancel_read", lambda _self: None)  # cancels only a read that is waiting
    terminal.send(STATUS_FRAME)
    line.interrupt()
    with in_time(PATIENCE_S):
        assert line.read(PATIENCE_S, _FOR_EVER_S) + line.read(PATIENCE_S, 0.0) == STATUS_FRAME
    line.close()


def test_a_socket_that_cannot_be_interrupted_is_none_the_worse() -> None:
    with run_module("--tcp", "127.0.0.1:0") as module:
        line = transport.open_line(module.port, 115200)
        line.interrupt()
        line.write(STATUS.query().encode())
        heard, ends_s = b"", time.monotonic() + PATIENCE_S
        while len(heard) < len(STATUS_FRAME) and time.monotonic() < ends_s:
            heard += line.read(PATIENCE_S, 0.05)  # of a socket it waits for `READ_SLICE_S` only
        assert heard.startswith(b"Au\x32")
        line.close()


@pytest.mark.parametrize("options", ["", "&delay-ms=60"])
@pytest.mark.parametrize("leave", [Worker.close, Worker.stop])
@pytest.mark.promise("l")
def test_a_lock_goes_out_although_the_port_is_closed_at_once(options: str, leave: Callable[[Worker], object]) -> None:
    """Whoever presses LOCK and leaves gets it: the closing waits for it, within its limit."""
    worker = Worker(ignore)
    worker.start()
    try:
        worker.open(f"sim://lock-and-leave?active=yes&uptime=60{options}", 115200)
        assert worker.submit(Job(await_module())).wait(PATIENCE_S)
        reading = worker.submit(Job(read_everything()))
        locking = worker.submit(Job(lock(), outlives=True), is_urgent=True)
        leave(worker)
        assert locking.wait(PATIENCE_S)
        assert reading.wait(PATIENCE_S)
        assert not bench.module("lock-and-leave").module.state.is_active
        assert locking.outcome().is_acknowledged or locking.outcome().is_locked  # repeated, the report may come first
    finally:
        assert worker.stop(PATIENCE_S)
        bench.remove_bench("lock-and-leave")
