"""When the worker hands a batch over: reports that say the same in their time, whatever changed at once."""

from itertools import pairwise

import pytest

from app.engine import worker as worker_module
from app.engine.transport import PortTrouble
from app.engine.worker import PUBLISH_EVERY_S, Batch, Job, PortState, Worker
from app.procedures.settings_reading import read_settings
from app.procedures.stream import StreamSwitch, watch
from protocol.catalogue import SERIAL_OUTPUT
from protocol.events import Answered
from protocol.link_states import Presence
from tests.support.line.sim_line import FakeClock, SimulatedLine

_STEP_S = 0.02
_STREAM_HZ = 50


class _Line(SimulatedLine):
    def interrupt(self) -> None: ...

    def abort(self) -> None: ...


class _TurnedWorker(Worker):
    """Turned by the test, on a simulated module that streams."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.clock = FakeClock()
        self.batches: list[Batch] = []
        super().__init__(self.batches.append, clock=self.clock, with_sleep=None)
        options = {"uptime": 60, "noise": 0, "active": "yes", "rate": _STREAM_HZ}
        self.line = _Line(self.clock, options)
        monkeypatch.setattr(worker_module, "open_line", lambda _port, _baud_rate: self.line)
        switch = StreamSwitch()
        self.open("sim", 115200, lambda: watch(switch))
        self.turn_for(6.0)
        assert self.batches[-1].device.is_streaming
        self.batches.clear()

    def turn_for(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        while self.clock.now_s < end_s:
            self._turn()
            self._publish()


def test_reports_that_say_the_same_come_ten_times_a_second_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.turn_for(10.0)
    assert 8 * 10.0 < len(worker.batches) <= 10 * 10.0
    assert all(later.at - one.at >= PUBLISH_EVERY_S for one, later in pairwise(worker.batches))
    assert sum(len(batch.samples) for batch in worker.batches) > 9.9 * _STREAM_HZ


@pytest.mark.parametrize(("every_s", "gather_s"), [(0.2, 0.02), (1.0, 0.025)])
def test_a_stream_is_gathered_for_a_tenth_of_the_interval_between_batches(
    every_s: float, gather_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, limits_s = _TurnedWorker(monkeypatch), list[float]()
    read = worker.line.read
    worker.publish_every_s = every_s
    worker.turn_for(0.1)

    def noted(longest_s: float, gather_s: float) -> bytes:
        limits_s.extend((longest_s, gather_s))
        return read(longest_s, gather_s)

    monkeypatch.setattr(worker.line, "read", noted)
    worker.line.bench.power_off()
    worker.turn_for(1.0)
    assert PUBLISH_EVERY_S == 1 / 10
    assert max(limits_s[::2]) == pytest.approx(0.05)
    assert max(limits_s[1::2]) == pytest.approx(gather_s)


def test_no_report_waits_longer_than_a_batch_may_take(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.turn_for(10.0)
    waits_s = [batch.at - sample.at for batch in worker.batches for sample in batch.samples]
    assert max(waits_s) <= PUBLISH_EVERY_S + 1 / _STREAM_HZ


def test_the_report_of_a_trigger_is_handed_over_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.line.bench.set_tilt(120)
    worker.turn_for(5.0)
    batch = next(batch for batch in worker.batches if any(sample.triggered for sample in batch.samples))
    assert [sample.triggered for sample in batch.samples].index(True) == len(batch.samples) - 1
    assert batch.at == batch.samples[-1].at


def test_the_report_of_another_activation_is_handed_over_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    for is_active in (False, True):
        worker.batches.clear()
        worker.line.bench.module.state.is_active = is_active
        worker.turn_for(0.5)
        batch = next(batch for batch in worker.batches if any(one.active is is_active for one in batch.samples))
        assert [sample.active for sample in batch.samples].index(is_active) == len(batch.samples) - 1
        assert batch.at == batch.samples[-1].at


def test_a_reading_that_differs_is_handed_over_at_once_and_one_that_does_not_with_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.publish_every_s = 100.0
    worker.turn_for(5.0)
    assert not worker.batches
    worker.line.bench.set_cell(3.5)
    worker.turn_for(2.0)
    (batch,) = worker.batches
    assert batch.device.values["cell_voltage_v"].value == pytest.approx(3.5, abs=0.05)
    assert batch.device.values["cell_voltage_v"].at == batch.at


def test_the_end_of_a_job_is_handed_over_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.publish_every_s = 100.0
    job = worker.submit(Job(read_settings()))
    worker.turn_for(5.0)
    (batch,) = [batch for batch in worker.batches if batch.finished]
    assert list(batch.finished) == [job]
    assert worker.clock.now_s - batch.at > 3.0


@pytest.mark.parametrize(
    ("what", "took_s", "trouble", "has_answered"),
    [("good", 0.0, None, True), ("mute", 0.3, None, False), ("unplugged", 0.0, PortTrouble.LOST, False)],
)
def test_closing_switches_the_stream_off_within_its_limit(
    what: str, took_s: float, trouble: PortTrouble | None, has_answered: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = _TurnedWorker(monkeypatch)
    if what == "mute":
        worker.line.bench.change(mute=True)
    elif what == "unplugged":
        worker.line.bench.unplug()
    worker.close()
    began = worker.clock.now_s
    worker._turn()
    assert worker.clock.now_s - began == pytest.approx(took_s, abs=0.03)
    connection = worker.batches[-1].connection
    assert connection.state is PortState.CLOSED
    assert (connection.trouble and connection.trouble.trouble) is trouble
    events = [event for batch in worker.batches for event in batch.events]
    answers = [event for event in events if isinstance(event, Answered) and event.request == SERIAL_OUTPUT.set(False)]
    assert len(answers) == has_answered


def test_a_lost_module_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _TurnedWorker(monkeypatch)
    worker.line.bench.power_off()
    worker.turn_for(20.0)
    batch = next(batch for batch in worker.batches if batch.device.presence is Presence.OFFLINE)
    assert batch.device.presence_since == batch.at
