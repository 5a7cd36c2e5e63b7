"""Faults of a port that is open, on real pseudo-terminals: closed in time, said in our own words, nothing invented."""

import os
import select
import sys
import threading
import time
from contextlib import suppress

import pytest

from app.engine import transport
from app.engine.procedure import Ask, Procedure
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Job, PortState, Worker
from app.procedures.greet import greet
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from protocol.catalogue import BY_NAME
from protocol.events import OutcomeUnknown, Rejected
from protocol.link_states import Presence
from tests.support.line.batches import Batches
from tests.support.processes import RunningModule
from tests.support.terminals import CLOSING_S, STATUS_FRAME, Terminal, in_time

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
pytest_plugins = ["tests.support.port_fixtures"]

ENOUGH_STOLEN = 12


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


def trouble_of(batch: Batch) -> PortTrouble | None:
    return None if batch.connection.trouble is None else batch.connection.trouble.trouble


def is_online(batch: Batch) -> bool:
    return is_open(batch) and batch.device.presence is Presence.ONLINE


def has_trouble(batches: Batches) -> bool:
    return batches.last is not None and batches.last.connection.trouble is not None


def test_unplugged_in_the_middle_of_everything(worker: Worker, batches: Batches, module: RunningModule) -> None:
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(is_online)
    job = worker.submit(Job(read_everything()))
    module.tell("unplug")
    lost = batches.until(lambda batch: trouble_of(batch) is PortTrouble.LOST)
    assert all(known.is_stale for known in lost.device.values.values())
    assert job.wait(1)


def test_a_write_that_blocks_ends_as_stuck_and_closes_in_time(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    terminal.choke()
    with in_time():
        job = worker.submit(Job(greet()))
        batches.until(lambda batch: trouble_of(batch) is PortTrouble.STUCK)
    assert job.wait(1)
    assert isinstance(job.run.error, PortError)


def test_the_window_closes_in_time_while_a_write_blocks(batches: Batches, terminal: Terminal) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(terminal.name, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.link is not None and batch.link.counters.sent > 0)
    terminal.choke()
    worker.submit(Job(read_everything()))
    with in_time():
        assert worker.stop(2.0)


def test_closed_while_a_stream_and_a_procedure_are_under_way(batches: Batches, module: RunningModule) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    job = worker.submit(Job(read_everything()))
    with in_time():
        assert worker.stop(2.0)
    assert job.is_done
    last = batches.last
    assert last is not None
    assert all(known.is_stale for known in last.device.values.values())


def test_bytes_after_closing_are_nobodys(worker: Worker, batches: Batches, terminal: Terminal) -> None:
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
    seen = batches.until(lambda batch: any(isinstance(event, Rejected) for event in batch.events), limit_s=2)
    assert closed.device.values == {}
    assert seen.device.known("tilt_deg", seen.at) is None


def test_half_a_frame_at_opening_is_rejected_and_the_next_one_read(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    terminal.send(STATUS_FRAME[3:] + STATUS_FRAME)
    seen = batches.until(lambda batch: batch.device.fresh("tilt_deg", batch.at) == 5)
    assert seen.link is not None
    assert seen.link.counters.rejected == len(STATUS_FRAME) - 3


def test_a_login_prompt_is_noise_and_no_module(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    worker.open(terminal.name, 115200)
    batches.until(is_open)
    job = worker.submit(Job(greet()))
    terminal.send(b"\r\nDebian GNU/Linux 12 ttyS0\r\n\r\nlogin: ")
    assert job.wait(4)
    assert not job.outcome().is_answered
    last = batches.last
    assert last is not None
    assert last.device.presence is Presence.OFFLINE


def test_an_echo_is_no_module(worker: Worker, batches: Batches, terminal: Terminal) -> None:
    is_over = threading.Event()

    def echo() -> None:
        while not is_over.wait(0.01):
            try:
                terminal.send(os.read(terminal.master, 4096))
            except BlockingIOError:
                continue
            except OSError:
                return

    thread = threading.Thread(target=echo)
    thread.start()
    try:
        worker.open(terminal.name, 115200)
        job = worker.submit(Job(greet()))
        assert job.wait(4)
        silence = job.outcome().silence
        assert silence is not None
        assert silence.value == "echo"
    finally:
        is_over.set()
        thread.join()


def test_a_second_program_that_reads_too_does_no_harm(worker: Worker, batches: Batches, module: RunningModule) -> None:
    """Linux does not keep a program out that does not ask: every byte goes to one of the two."""
    worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    thief = os.open(module.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        end_s = time.monotonic() + 5.0
        stolen = 0
        while stolen < ENOUGH_STOLEN and time.monotonic() < end_s:
            if not has_trouble(batches):
                select.select([thief], [], [], 0.05)
            with suppress(BlockingIOError):
                stolen += len(os.read(thief, 3))
        assert stolen >= ENOUGH_STOLEN
    finally:
        os.close(thief)
    last = batches.last
    assert last is not None
    if trouble_of(last) is not None:  # the driver may take the other reader for an unplugged cable
        assert trouble_of(last) is PortTrouble.LOST
        worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
    batches.mark()
    seen = batches.until(
        lambda batch: is_online(batch) and batch.device.fresh("tilt_deg", batch.at) is not None, limit_s=10
    )
    assert seen.device.fresh("tilt_deg", seen.at) == 0


def test_an_unanswered_act_is_of_unknown_outcome_and_not_sent_again(
    worker: Worker, batches: Batches, terminal: Terminal
) -> None:
    def activate() -> Procedure[object]:
        return (yield Ask(BY_NAME["activation"].set(True), is_deliberate=True))

    worker.open(terminal.name, 115200)
    batches.until(is_open)
    job = worker.submit(Job(activate()))
    assert job.wait(3)
    assert isinstance(job.outcome(), OutcomeUnknown)
    sent = os.read(terminal.master, 4096)
    assert sent.count(BY_NAME["activation"].set(True).encode()) == 1


def test_the_limits_of_writing_and_closing_fit_into_half_a_second() -> None:
    from app.engine.worker import CLOSING_LIMIT_S

    assert transport.WRITE_LIMIT_S <= CLOSING_S - 0.1
    assert CLOSING_LIMIT_S <= CLOSING_S - 0.05


def test_a_clock_that_leaps_does_not_hurt_the_worker(batches: Batches, module: RunningModule) -> None:
    """As a monotonic clock does that counts the time asleep."""
    leap = {"s": 0.0}
    worker = Worker(batches, clock=lambda: time.monotonic() + leap["s"])
    worker.start()
    try:
        worker.open(module.port, 115200, lambda: watch(StreamSwitch()))
        batches.until(lambda batch: batch.device.is_streaming)
        leap["s"] = 3600.0
        batches.mark()
        batches.until(lambda batch: is_online(batch) and batch.device.fresh("tilt_deg", batch.at) is not None)
    finally:
        assert worker.stop(2.0)
