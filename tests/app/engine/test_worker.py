"""The worker on real ports: its thread, its batches, and what becomes of them when the port goes away."""

import time
from collections.abc import Iterator

import pytest

from app.engine.procedure import PortLost
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Job, PortState, Worker
from app.procedures.handshake import handshake
from app.procedures.history import read_history
from app.procedures.read import READABLE, read_everything
from app.procedures.stream import StreamSwitch, watch
from app.simulator import bench
from protocol.events import Received
from protocol.messages import Status
from tests.support.line.batches import Batches
from tests.support.patience import PATIENCE_S, quickest
from tests.support.processes import RunningModule, run_module

pytest_plugins = ["tests.support.port_fixtures"]


@pytest.fixture
def sim() -> Iterator[str]:
    yield "sim://worker-test?uptime=60"
    bench.remove_bench("worker-test")


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


def samples_in(batches: Batches) -> int:
    return sum(len(batch.samples) for batch in batches.all)


def status_frames_in(batches: Batches) -> int:
    events = (event for batch in batches.all for event in batch.events)
    return sum(isinstance(event, Received) and isinstance(event.message, Status) for event in events)


def has_trouble(batch: Batch) -> bool:
    return batch.connection.trouble is not None


def test_a_procedure_runs_and_its_result_comes_in_a_batch(worker: Worker, batches: Batches, sim: str) -> None:
    worker.open(sim, 115200)
    job = worker.submit(Job(handshake()))
    assert job.wait(PATIENCE_S)
    assert job.outcome() is None
    batches.until(lambda batch: job in batch.finished)


def test_a_job_without_a_port_ends_at_once(worker: Worker) -> None:
    job = worker.submit(Job(handshake()))
    assert job.wait(PATIENCE_S)
    with pytest.raises(PortLost):
        job.outcome()


def test_a_port_that_is_not_there_is_a_trouble_in_a_batch(worker: Worker, batches: Batches) -> None:
    worker.open("/dev/there-is-no-such-port", 115200)
    trouble = batches.until(has_trouble).connection.trouble
    assert trouble is not None
    assert trouble.trouble is PortTrouble.MISSING
    job = worker.submit(Job(handshake()))
    assert job.wait(PATIENCE_S)
    assert job.run.error is trouble


def test_unplugged_in_the_middle_ends_the_job_with_the_reason(worker: Worker, batches: Batches, sim: str) -> None:
    worker.open(f"{sim}&delay-ms=400", 115200)
    batches.until(is_open)
    job = worker.submit(Job(read_everything()))
    batches.until(lambda batch: len(batch.samples) > 0)
    bench.module("worker-test").unplug()
    assert job.wait(PATIENCE_S)
    with pytest.raises(PortError) as lost:
        job.outcome()
    assert lost.value.trouble is PortTrouble.LOST
    last = batches.until(has_trouble)
    assert all(known.is_stale for known in last.device.values.values())


def test_the_port_can_be_opened_again_after_it_was_lost(worker: Worker, batches: Batches, sim: str) -> None:
    worker.open(sim, 115200)
    batches.until(is_open)
    bench.module("worker-test").unplug()
    batches.until(has_trouble)
    bench.module("worker-test").plug()
    worker.open(sim, 115200)
    assert worker.submit(Job(handshake())).wait(PATIENCE_S)


def test_what_runs_on_one_port_ends_before_another_is_opened(worker: Worker, batches: Batches, sim: str) -> None:
    """And the stream that was switched on there is switched off there."""
    worker.open(f"{sim}&rate=200", 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    job = worker.submit(Job(watch(StreamSwitch())))
    worker.open("/dev/there-is-no-such-port", 115200)
    batches.until(has_trouble)
    assert job.wait(PATIENCE_S)
    assert not bench.module("worker-test").state().is_streaming


def test_a_cancelled_job_answers_within_200_ms(worker: Worker, batches: Batches, sim: str) -> None:
    worker.open(f"{sim}&mute=yes", 115200)
    batches.until(is_open)

    def sent(batch: Batch | None) -> int:
        return 0 if batch is None or batch.link is None else batch.link.counters.sent

    def cancelled_in_s() -> float:
        before = sent(batches.last)
        job = worker.submit(Job(read_everything()))
        batches.until(lambda batch: sent(batch) > before)
        start_s = time.monotonic()
        job.cancel()
        assert job.wait(PATIENCE_S)
        return time.monotonic() - start_s

    assert quickest(cancelled_in_s, 0.2) <= 0.2


def test_closing_switches_the_stream_off_again(worker: Worker, batches: Batches, sim: str) -> None:
    worker.open(f"{sim}&rate=200", 115200, lambda: watch(StreamSwitch()))
    batches.until(lambda batch: batch.device.is_streaming)
    batches.mark()
    worker.close()
    batches.until(lambda batch: batch.connection.state is PortState.CLOSED)
    assert not bench.module("worker-test").state().is_streaming


@pytest.mark.parametrize("options", ["", "&mute=yes", "&rate=1440&stream-at-boot=yes", "&delay-ms=900"])
def test_stopping_takes_at_most_half_a_second_whatever_is_under_way(options: str, batches: Batches, sim: str) -> None:
    def stopped_in_s() -> float:
        worker = Worker(batches)
        worker.start()
        worker.open(sim + options, 115200, lambda: watch(StreamSwitch()))
        job = worker.submit(Job(read_history()))
        heard = len(batches.all)
        batches.until(lambda batch: is_open(batch) and len(batches.all) > heard)
        start_s = time.monotonic()
        assert worker.stop(PATIENCE_S)
        assert job.is_done
        return time.monotonic() - start_s

    assert quickest(stopped_in_s, 0.6) <= 0.6


def test_stop_is_idempotent_and_needs_no_start(batches: Batches) -> None:
    worker = Worker(batches)
    assert worker.stop()
    worker.start()
    assert worker.stop()
    assert worker.stop()


def test_a_stream_at_line_rate_from_another_process_arrives_whole(worker: Worker, batches: Batches) -> None:
    """1,440 status frames a second over a real pseudo-terminal: every one reaches the device, none is rejected."""
    with run_module("--rate", "1440", "--uptime", "60") as module:
        worker.open(module.port, 115200, lambda: watch(StreamSwitch(), read_all=False))
        batches.until(lambda batch: batch.device.is_streaming)
        seen = samples_in(batches)
        batches.until(lambda _: samples_in(batches) > seen + 3000)
        worker.close()
        closed = batches.until(lambda batch: batch.connection.state is PortState.CLOSED and samples_in(batches) > 0)
        assert closed.connection.trouble is None
    last = [batch.link for batch in batches.all if batch.link is not None][-1]
    assert last.counters.rejected == 0
    assert samples_in(batches) == status_frames_in(batches)


def test_reading_everything_over_a_pseudo_terminal(worker: Worker, batches: Batches, module: RunningModule) -> None:
    worker.open(module.port, 115200)
    job = worker.submit(Job(read_everything()))
    assert job.wait(PATIENCE_S)
    everything = job.outcome()
    assert everything.errors == {}
    assert len(everything.values) == len(READABLE) - 1
