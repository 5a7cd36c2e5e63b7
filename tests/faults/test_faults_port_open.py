"""Faults of an open port, on pseudo-terminals: it is closed in time with one of our messages and no invented value."""

import sys

import pytest

from app.engine import transport
from app.engine.transport import PortTrouble
from app.engine.worker import Batch, Job, PortState, Worker
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from protocol.events import Rejected
from protocol.link_states import Presence
from tests.support.line.batches import Batches
from tests.support.patience import PATIENCE_S
from tests.support.processes import RunningModule
from tests.support.terminals import CLOSING_S, STATUS_FRAME, Terminal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
pytest_plugins = ["tests.support.port_fixtures"]


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


def trouble_of(batch: Batch) -> PortTrouble | None:
    return None if batch.connection.trouble is None else batch.connection.trouble.trouble


def is_online(batch: Batch) -> bool:
    return is_open(batch) and batch.device.presence is Presence.ONLINE


def test_unplugged_in_the_middle_of_everything(worker: Worker, batches: Batches, module: RunningModule) -> None:
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(is_online)
    job = worker.submit(Job(read_everything()))
    module.process.kill()  # its pseudo-terminal goes with it
    lost = batches.until(lambda batch: trouble_of(batch) is PortTrouble.LOST)
    assert all(known.is_stale for known in lost.device.values.values())
    assert job.wait(PATIENCE_S)


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
    assert closed.device.values == {}
    assert seen.device.known("tilt_deg", seen.at) is None


def test_writing_and_closing_end_within_half_a_second() -> None:
    from app.engine.worker import CLOSING_LIMIT_S

    assert transport.WRITE_LIMIT_S <= CLOSING_S - 0.1
    assert CLOSING_LIMIT_S <= CLOSING_S - 0.05
