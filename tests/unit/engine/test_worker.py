"""The worker: its thread, when it hands a batch over, and what becomes of the jobs when the port goes away."""

import sys
import threading
from collections.abc import Callable, Iterator

import pytest

from app.engine import worker as worker_module
from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Job, Pause, Procedure
from app.engine.session import Session
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import OWED_FOR_S, Batch, PortState, Worker
from app.procedures.history import read_history
from app.procedures.lock import Locked, lock
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from app.simulator import bench
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from protocol.catalogue import ACTIVATION, LOCK, SERIAL_OUTPUT
from protocol.events import Answered, Began, Ended, EndReason, Sent
from tests.support.line.sim_line import FakeClock, SimulatedLine
from tests.support.patience import PATIENCE_S


class Batches:
    """A worker's callback; `until` waits for a batch that is enough."""

    def __init__(self) -> None:
        self.all: list[Batch] = []
        self._came = threading.Condition()

    def __call__(self, batch: Batch) -> None:
        with self._came:
            self.all.append(batch)
            self._came.notify_all()

    def until(self, is_enough: Callable[[Batch], bool]) -> None:
        with self._came:
            assert self._came.wait_for(lambda: any(map(is_enough, self.all)), PATIENCE_S), self.all[-1:]


@pytest.fixture
def batches() -> Batches:
    return Batches()


@pytest.fixture
def sim() -> Iterator[str]:
    yield "sim://worker-test?uptime=60"
    bench.remove_bench("worker-test")


def is_open(batch: Batch) -> bool:
    return batch.connection.state is PortState.OPEN


@pytest.mark.parametrize("options", ["", "&mute=yes", "&rate=1440", "&lag-ms=900"])
def test_it_stops_whatever_is_under_way(options: str, batches: Batches, sim: str) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(sim + options, 115200, lambda: watch(StreamSwitch()))
    job = worker.submit(Job(read_history(), conversation=None))
    batches.until(is_open)
    assert worker.stop(PATIENCE_S)
    assert job.is_done


def test_a_thread_that_computes_keeps_it_waiting_for_a_millisecond(batches: Batches) -> None:
    """Not for Python's five, of which there are many in one turn: it ends a conversation on a busy computer."""
    sys.setswitchinterval(0.005)
    worker = Worker(batches)
    worker.start()
    assert sys.getswitchinterval() == pytest.approx(0.001)
    assert worker.stop(PATIENCE_S)


@pytest.mark.promise("l")
def test_it_stops_also_with_a_fault_of_our_own_while_it_closes(
    batches: Batches, sim: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = Worker(batches)
    worker.start()
    worker.open(sim, 115200)
    batches.until(is_open)
    monkeypatch.setattr(Session, "cancel_all", lambda _session: 1 / 0)
    assert worker.stop(PATIENCE_S)
    assert batches.all[-1].connection.state is PortState.CLOSED


_STREAM_HZ = 50


class _Line(SimulatedLine):
    def interrupt(self) -> None: ...

    def abort(self) -> None: ...


class _TurnedWorker(Worker):
    """Turned by the test, on a simulated module that streams."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, hz: int = _STREAM_HZ) -> None:
        self.clock = FakeClock()
        self.batches: list[Batch] = []
        super().__init__(self.batches.append, clock=self.clock)
        self.line = _Line(self.clock, SimulatedBench(Setup(active=True, rate=hz), clock=self.clock))
        monkeypatch.setattr(worker_module, "open_line", lambda _port, _baud_rate: self.opened())
        switch = StreamSwitch()
        self.open("sim", 115200, lambda: watch(switch))
        self.turn_for(6.0)
        assert self.batches[-1].conversation.is_streaming
        self.batches.clear()

    def opened(self) -> _Line:
        self.line.bench.holder = self.line
        return self.line

    def turn_for(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        while self.clock.now_s < end_s:
            if self._session is None and self._orders.empty():
                self.clock.now_s = end_s  # nothing to do but to wait for orders
            else:
                self._turn()


@pytest.mark.promise("j")
def test_the_report_of_a_trigger_is_handed_over_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.line.bench.set_world(tilt_deg=120)
    worker.turn_for(5.0)
    batch = next(batch for batch in worker.batches if any(sample.triggered for sample in batch.samples))
    assert [sample.triggered for sample in batch.samples].index(True) == len(batch.samples) - 1
    assert batch.at == batch.samples[-1].at


@pytest.mark.parametrize(
    ("what", "took_s", "trouble", "has_answered"),
    [("good", 0.0, None, True), ("mute", 0.3, None, False), ("unplugged", 0.0, PortErrorKind.LOST, False)],
)
def test_closing_switches_the_stream_off_within_its_limit(
    what: str, took_s: float, trouble: PortErrorKind | None, has_answered: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = _TurnedWorker(monkeypatch)
    if what == "mute":
        worker.line.bench.change(mute=True)
    elif what == "unplugged":
        worker.line.bench.unplug()
    worker.close()
    began = worker.clock.now_s
    worker._turn()
    assert worker.clock.now_s - began == pytest.approx(took_s, abs=0.07)  # a set waits for a quiet line
    connection = worker.batches[-1].connection
    assert connection.state is PortState.CLOSED
    assert (connection.trouble and connection.trouble.kind) is trouble
    events = [event for batch in worker.batches for event in batch.events]
    answers = [event for event in events if isinstance(event, Answered) and event.request == SERIAL_OUTPUT.set(False)]
    assert len(answers) == has_answered


# One conversation after another


@pytest.mark.promise("f")
def test_no_batch_mixes_two_conversations(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    for end in (worker.treat_as_another, worker.line.bench.restart, worker.treat_as_another):
        end()
        worker.turn_for(1.0)
    began_at: dict[int, float] = {}
    for batch in worker.batches:
        talk = batch.conversation
        began_at.setdefault(talk.number, talk.began_at)
        for sample in batch.samples:
            assert sample.at >= talk.began_at
            assert talk.ended is None or sample.at <= talk.ended.at
        ends = [event for event in batch.events if isinstance(event, Began | Ended)]
        assert len(ends) <= 1
    assert list(began_at) == [1, 2, 3, 4]


@pytest.mark.promise("a")
def test_what_was_decided_at_a_port_is_not_done_at_the_next_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Conversations are numbered over the program's life, and not anew at each port."""
    worker = _TurnedWorker(monkeypatch)
    worker.line.sent.clear()
    worker.open("another", 115200)
    worker.turn_for(1.0)
    assert worker.batches[-1].conversation.number == 2
    decided_before = worker.submit(Job(activating(), conversation=1))
    worker.turn_for(0.5)
    assert isinstance(decided_before.error, Interrupted)
    assert ACTIVATION.set(True) not in worker.line.requests


# LOCK that is owed


def activating() -> Procedure[None]:
    yield Ask(ACTIVATION.set(True), is_deliberate=True)
    yield Pause(10.0)


class _OwingWorker(_TurnedWorker):
    """With a conversation in which an activation was interrupted."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, is_lost: bool = True) -> None:
        super().__init__(monkeypatch)
        self._make_lock = lambda: Job(lock(), conversation=None)
        self.submit(Job(activating(), conversation=1))
        self.turn_for(0.5)
        assert self.line.bench.module.state.is_active
        if is_lost:
            self.line.bench.unplug()
            self.turn_for(0.2)
            self.line.bench.plug()

    def reopen(self, adapter: str = "", after_s: float = 1.0) -> list[Batch]:
        self.clock.now_s += after_s
        self.line.sent.clear()
        self.batches.clear()
        self.open("sim", 115200, lambda: watch(StreamSwitch()), adapter=adapter)
        self.turn_for(2.0)
        return self.batches


@pytest.mark.promise("j")
def test_an_owed_lock_goes_first_in_the_next_conversation_on_the_same_adapter(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _OwingWorker(monkeypatch)
    assert worker.batches[-1].is_lock_owed
    batches = worker.reopen()
    events = [event for batch in batches for event in batch.events]
    begins = next(at for at, event in enumerate(events) if isinstance(event, Began))
    sent = [event.request for event in events[begins:] if isinstance(event, Sent)]
    assert sent[0] == LOCK, "before the window's first question, too"
    assert not worker.line.bench.module.state.is_active
    (locked,) = [job for batch in batches for job in batch.finished]
    assert locked.outcome().is_locked
    assert not batches[-1].is_lock_owed


@pytest.mark.promise("l")
def test_an_owed_lock_stays_owed_where_the_port_is_lost_as_the_conversation_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    worker = _OwingWorker(monkeypatch)
    made: list[Job[Locked]] = []

    def make_lock() -> Job[Locked]:
        made.append(Job(lock(), conversation=None))
        return made[-1]

    def lose_the_port() -> Procedure[None]:
        raise PortError(PortErrorKind.LOST, "sim", "gone")

    worker._make_lock = make_lock
    worker.batches.clear()
    worker.open("sim", 115200, lose_the_port)
    worker.turn_for(1.0)
    batches = worker.batches
    assert batches[-1].connection.state is PortState.CLOSED
    assert batches[-1].is_lock_owed
    assert all(job.is_done for job in made)


@pytest.mark.parametrize(("adapter", "after_s"), [("another", 1.0), ("", OWED_FOR_S)])
@pytest.mark.promise("f")
def test_it_is_not_sent_to_another_adapter_or_after_a_minute(
    adapter: str, after_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = _OwingWorker(monkeypatch)
    batches = worker.reopen(adapter, after_s)
    assert LOCK not in worker.line.requests
    assert batches[-1].is_lock_owed, "it stands beside LOCK"
    worker.submit(Job(lock(), conversation=None), is_urgent=True)
    worker.turn_for(0.5)
    assert not worker.batches[-1].is_lock_owed


@pytest.mark.promise("j")
def test_a_lock_that_is_pressed_while_the_port_is_away_is_owed(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker._make_lock = lambda: Job(lock(), conversation=None)
    worker.line.bench.module.state.is_active = True
    worker.line.bench.unplug()
    worker.turn_for(0.2)
    ends = [event.reason for batch in worker.batches for event in batch.events if isinstance(event, Ended)]
    assert ends == [EndReason.PORT_LOST]
    pressed = worker.submit(Job(lock(), conversation=None), is_urgent=True)
    worker.turn_for(0.1)
    assert pressed.is_done
    assert worker.batches[-1].is_lock_owed
    worker.line.bench.plug()
    worker.open("sim", 115200)
    worker.turn_for(1.0)
    assert not worker.line.bench.module.state.is_active


@pytest.mark.parametrize("options", ["", "&lag-ms=60"])
@pytest.mark.parametrize("leave", [Worker.close, Worker.stop])
@pytest.mark.promise("l")
def test_a_lock_goes_out_although_the_port_is_closed_at_once(options: str, leave: Callable[[Worker], object]) -> None:
    """Whoever presses LOCK and leaves gets it: the closing waits for it, within its limit."""
    batches = Batches()
    worker = Worker(batches)
    worker.start()
    try:
        worker.open(f"sim://lock-and-leave?active=yes&uptime=60{options}", 115200)
        batches.until(lambda batch: batch.conversation.is_going)
        reading = worker.submit(Job(read_everything(), conversation=1))
        locking = worker.submit(Job(lock(), conversation=None), is_urgent=True)
        leave(worker)
        assert locking.wait(PATIENCE_S)
        assert reading.wait(PATIENCE_S)
        assert not bench.module("lock-and-leave").module.state.is_active
        assert locking.outcome().is_acknowledged or locking.outcome().is_locked  # repeated, the report may come first
    finally:
        assert worker.stop(PATIENCE_S)
        bench.remove_bench("lock-and-leave")
