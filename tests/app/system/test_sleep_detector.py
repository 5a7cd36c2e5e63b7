"""The computer slept: how that is noticed, and that nothing from before is believed, finished or sent again."""

import time
from collections.abc import Iterator

import pytest

from app.engine.device import StaleReason
from app.engine.procedure import Ask, Inspect, Procedure, Slept
from app.engine.session import Session
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Job, PortState, Worker
from app.procedures.act import perform
from app.procedures.lock import lock
from app.procedures.read import READABLE, read_everything
from app.procedures.stream import StreamSwitch, watch
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.simulator import bench
from app.system.sleep_detector import MAX_TURN_S, SHORTEST_S, SleepDetector, plus_time_asleep, sleepless_clock
from protocol.catalogue import SERIAL_OUTPUT, Hazard
from protocol.link_states import Presence
from tests.support.journals import FakeJournal
from tests.support.line.batches import Batches
from tests.support.line.sim_line import INSTANT_S, Rig
from tests.support.patience import PATIENCE_S

NIGHT_S = 8 * 3600.0
CLOCK_TICK_S = 0.05
"""Windows counts interrupt time in steps of up to 0.016 s."""
EVERYTHING = {command.key for command in READABLE[3:]}


class Lid:
    """A clock that goes on while `asleep_s` is added to; the other one, the rig's, stands still meanwhile."""

    def __init__(self, rig: Rig) -> None:
        self.asleep_s = 0.0
        self._rig = rig

    def __call__(self) -> float:
        return self._rig.clock.now_s + self.asleep_s

    def close_for(self, seconds: float) -> None:
        self.asleep_s += seconds


class SleepyRig(Rig):
    """A rig on a computer with a lid."""

    def __init__(self, options: dict[str, object] | None = None) -> None:
        super().__init__({"uptime": 60, "noise": 0} | (options or {}))
        self.lid = Lid(self)
        self.session = Session(self.line, self.clock, asleep_s=SleepDetector(self.clock, self.lid).poll)
        self.clock.now_s += INSTANT_S

    def watched(self) -> None:
        self.session.run_in_background(watch(StreamSwitch()))
        self.step_for(4)
        assert self.stale() == set()

    def stale(self) -> set[str]:
        view = self.session.device.view(self.clock.now_s)
        return {key for key in EVERYTHING if view.fresh(key, self.clock.now_s) is None}


# The judgement


@pytest.mark.parametrize(
    ("awake_s", "with_sleep_s", "expected"),
    [
        (0.02, 0.02, 0.0),
        (0.02, 0.02 + NIGHT_S, NIGHT_S),
        (0.02, 0.02 + SHORTEST_S / 2, 0.0),
        (NIGHT_S, NIGHT_S, NIGHT_S),
        (NIGHT_S, None, NIGHT_S),
        (MAX_TURN_S / 2, None, 0.0),
        (MAX_TURN_S / 2, MAX_TURN_S / 2, 0.0),
    ],
    ids=["awake", "slept", "blinked", "stopped as a whole", "no second clock", "slow disk", "slow disk, two clocks"],
)
def test_sleep_is_what_the_clocks_disagree_about_or_a_turn_that_took_far_too_long(
    awake_s: float, with_sleep_s: float | None, expected: float
) -> None:
    with_sleep = None if with_sleep_s is None else iter((100.0, 100.0 + with_sleep_s)).__next__
    sleeps = SleepDetector(iter((10.0, 10.0 + awake_s)).__next__, with_sleep)
    assert sleeps.poll() == pytest.approx(expected)


def test_each_sleep_is_told_once() -> None:
    rig = SleepyRig()
    sleeps = SleepDetector(rig.clock, rig.lid)
    rig.lid.close_for(60)
    assert sleeps.poll() == pytest.approx(60)
    assert sleeps.poll() == 0


@pytest.mark.parametrize("leap_s", [NIGHT_S, -NIGHT_S])
def test_a_time_of_day_that_leaps_changes_nothing(leap_s: float, monkeypatch: pytest.MonkeyPatch) -> None:
    sleeps = SleepDetector(time.monotonic, sleepless_clock())
    true_time = time.time
    monkeypatch.setattr(time, "time", lambda: true_time() + leap_s)
    assert sleeps.poll() == 0


@pytest.mark.parametrize("goes_on_asleep", [True, False], ids=["Windows", "Linux"])
@pytest.mark.promise("a")
def test_a_sleep_shorter_than_a_long_turn_is_seen_by_what_two_clocks_disagree_about(goes_on_asleep: bool) -> None:
    """Windows' monotonic clock goes on asleep: alone it shows only sleeps that are longer than any turn."""
    awake_s, asleep_s = 100.0, 0.0

    def clock() -> float:
        return awake_s + asleep_s * goes_on_asleep

    sleeps = SleepDetector(clock, plus_time_asleep(clock, lambda: 7 + awake_s + asleep_s, lambda: 3 + awake_s))
    awake_s += MAX_TURN_S / 2
    assert sleeps.poll() == 0
    asleep_s += SHORTEST_S
    assert sleeps.poll() == pytest.approx(SHORTEST_S)
    asleep_s += NIGHT_S
    assert sleeps.poll() == pytest.approx(NIGHT_S)
    assert sleeps.poll() == 0


def test_this_system_tells_of_sleep_and_its_clock_goes_as_fast_as_the_monotonic_one() -> None:
    clock = sleepless_clock()
    assert clock is not None

    def least_and_most_asleep_s() -> tuple[float, float]:
        before_s = time.monotonic()
        now_s = clock()
        return now_s - time.monotonic() - CLOCK_TICK_S, now_s - before_s + CLOCK_TICK_S

    (least_s, most_s), (least_later_s, most_later_s) = least_and_most_asleep_s(), least_and_most_asleep_s()
    assert most_s >= 0
    assert max(least_s, least_later_s) <= min(most_s, most_later_s)


# What follows from it


def test_everything_is_doubted_and_then_read_again() -> None:
    rig = SleepyRig({"rate": 50})
    rig.watched()
    before = len(rig.line.requests)
    rig.lid.close_for(NIGHT_S)
    rig.session.step()
    view = rig.session.device.view(rig.clock.now_s)
    assert {known.stale_reason for known in view.values.values()} == {StaleReason.LINK_LOST}
    assert not view.is_streaming
    assert view.presence is Presence.OFFLINE
    assert view.last_sleep is not None
    assert view.last_sleep.lasted_s == pytest.approx(NIGHT_S, abs=1)
    rig.step_for(4)
    assert rig.stale() == set()
    assert rig.session.device.view(rig.clock.now_s).presence is Presence.ONLINE
    sent = rig.line.requests[before:]
    assert {command.query() for command in READABLE} <= set(sent)
    assert {request for request in sent if not request.is_repeatable} <= {SERIAL_OUTPUT.set(True)}


def test_without_a_second_clock_a_turn_that_took_a_night_is_a_sleep() -> None:
    rig = SleepyRig()
    rig.session = Session(rig.line, rig.clock, asleep_s=SleepDetector(rig.clock).poll)
    rig.watched()
    rig.clock.now_s += NIGHT_S
    rig.session.step()
    assert rig.stale() == EVERYTHING
    rig.step_for(4)
    assert rig.stale() == set()


@pytest.mark.parametrize("steps", range(0, 18, 2))
@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN])
def test_what_was_confirmed_before_the_sleep_is_not_sent_after_it(act: Act, steps: int) -> None:
    rig = SleepyRig({"delay_ms": 60})
    run = rig.started(perform(act, FakeJournal(), permit=rig.permit(act)))
    for _ in range(steps):
        rig.session.step()
    assert not run.is_done
    before = rig.line.requests
    rig.lid.close_for(NIGHT_S)
    rig.step_until(lambda: run.is_done)
    rig.step_for(2)
    assert not [request for request in rig.line.requests[len(before) :] if request.hazard is Hazard.DANGEROUS]
    if run.result is not None:
        assert run.result.outcome in (Outcome.UNKNOWN, Outcome.NOT_SENT)
        assert (run.result.outcome is Outcome.UNKNOWN) == (REQUESTS[act] in before)
    else:
        assert isinstance(run.error, Slept)
        assert REQUESTS[act] not in before


def test_what_was_decided_in_the_turn_in_which_it_fell_asleep_is_not_sent() -> None:
    rig = SleepyRig()
    rig.watched()

    def decided() -> Procedure[None]:
        yield Inspect()
        rig.lid.close_for(NIGHT_S)
        yield Ask(SERIAL_OUTPUT.set(False))

    run = rig.started(decided())
    rig.step_for(2)
    assert isinstance(run.error, Slept)
    assert SERIAL_OUTPUT.set(False) not in rig.line.requests


def test_what_runs_and_what_waits_ends_with_the_sleep() -> None:
    rig = SleepyRig({"delay_ms": 50})
    reading, waiting = rig.started(read_everything()), rig.started(read_everything())
    rig.step_for(0.1)
    rig.lid.close_for(NIGHT_S)
    rig.step_for(0.5)
    for run in (reading, waiting):
        assert isinstance(run.error, Slept)
        assert float(str(run.error).split()[-2]) == pytest.approx(NIGHT_S, abs=1)
    assert rig.run(read_everything()).errors == {}


@pytest.mark.parametrize("steps", range(0, 12, 2))
def test_lock_is_carried_out_all_the_same(steps: int) -> None:
    rig = SleepyRig({"active": True, "delay_ms": 60})
    rig.watched()
    locking = rig.started(lock(), is_urgent=True)
    for _ in range(steps):
        rig.session.step()
    rig.lid.close_for(NIGHT_S)
    assert rig.end(locking).is_locked
    assert not rig.bench.module.state.is_active


def test_what_had_arrived_is_kept_with_the_time_of_its_arrival(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = SleepyRig({"rate": 50})
    rig.watched()
    rig.session.device.take_samples()
    began_s, read = rig.clock.now_s, rig.line.read

    def sleep_while_reading(longest_s: float, gather_s: float) -> bytes:
        data = b""
        while not data:
            data = read(longest_s, gather_s)
        rig.clock.now_s += NIGHT_S  # a clock that goes on asleep: the gap tells
        monkeypatch.undo()
        return data

    monkeypatch.setattr(rig.line, "read", sleep_while_reading)
    rig.session.step()
    samples = rig.session.device.take_samples()
    assert samples
    assert all(sample.at < began_s + 1 for sample in samples)
    assert rig.stale() == EVERYTHING


def test_what_waited_in_the_driver_is_not_taken_for_new() -> None:
    rig = SleepyRig({"rate": 50})
    rig.watched()
    rig.session.device.take_samples()
    rig.clock.now_s += 0.1  # five reports come, and nobody reads them
    rig.lid.close_for(NIGHT_S)
    rig.session.step()
    assert rig.session.device.take_samples() == []
    assert rig.stale() == EVERYTHING


def test_a_port_that_died_asleep_is_lost() -> None:
    rig = SleepyRig()
    rig.watched()
    rig.bench.unplug()
    rig.lid.close_for(NIGHT_S)
    with pytest.raises(PortError) as lost:
        rig.session.step()
    assert lost.value.trouble is PortTrouble.LOST


# With the worker's thread


@pytest.fixture
def sim() -> Iterator[str]:
    yield "sim://asleep?uptime=60"
    bench.remove_bench("asleep")


def test_the_worker_notices(sim: str) -> None:
    leap = {"s": 0.0}
    batches = Batches()
    worker = Worker(batches, with_sleep=lambda: time.monotonic() + leap["s"])
    worker.start()
    try:
        worker.open(f"{sim}&mute-codes=35", 115200, lambda: watch(StreamSwitch()))
        batches.until(lambda batch: _fresh(batch) >= EVERYTHING)
        job = worker.submit(Job(read_everything()))
        leap["s"] = NIGHT_S
        woken = batches.until(lambda batch: batch.device.last_sleep is not None)
        assert woken.connection.state is PortState.OPEN
        batches.mark()
        batches.until(lambda batch: _fresh(batch) >= EVERYTHING)
        assert job.wait(PATIENCE_S)
    finally:
        assert worker.stop(PATIENCE_S)


def _fresh(batch: Batch) -> set[str]:
    return {key for key in EVERYTHING if batch.device.fresh(key, batch.at) is not None}
