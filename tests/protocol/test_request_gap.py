"""Modules that need a pause between requests, or do not hear while they send: read and written all the same."""

from typing import Any

import pytest

from app.procedures.read import READABLE, read_everything
from app.procedures.write_all import SettingChange, WriteContext, write_all
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, SERIAL_OUTPUT, SETTINGS
from protocol.events import Sent
from protocol.request_gap import CLEAR_S, LOST_IN_A_ROW, MAX_S, ONCE_S, QUESTION_S, STREAM_LATE_S, Gap
from tests.support.journals import FakeJournal
from tests.support.line.link_bench import PULSE, Bench
from tests.support.line.sim_line import Rig
from tests.support.thorough import some

SET = BY_NAME["freefall_time"].set(1.2)
QUESTION = BY_NAME["freefall_time"].query()
VALUES = {"attitude_threshold": 70, "freefall_acceleration": 0.4, "freefall_time": 1.2, "light_threshold": 2.0}
SEEDS = some(range(8), one_in=3)


def read_and_write(rig: Rig) -> None:
    everything = rig.run(read_everything())
    assert everything.errors == {}
    write_values(rig)


def write_values(rig: Rig) -> None:
    changes = [SettingChange(BY_NAME[name], value) for name, value in VALUES.items()]
    report = rig.run(write_all(changes, WriteContext(journal=FakeJournal())))
    assert [written.verified for written in report.results] == [True] * len(VALUES), report
    memory = rig.bench.module.memory
    assert (memory.attitude_threshold, memory.freefall_time) == (70, 120)


@pytest.mark.parametrize("jitter_ms", [0.0, 3.0])
@pytest.mark.parametrize("gap_ms", [5.0, 10.0, 20.0, 30.0])
@pytest.mark.promise("k")
def test_a_module_that_needs_a_gap_is_read_and_written(gap_ms: float, jitter_ms: float) -> None:
    for seed in SEEDS:
        options: dict[str, Any] = {"min_gap_ms": gap_ms, "jitter_ms": jitter_ms, "seed": seed}
        read_and_write(Rig(options))
        write_values(Rig(options))


@pytest.mark.parametrize("gap_ms", [0.0, 5.0])
@pytest.mark.parametrize("hz", [10.0, 50.0, 200.0])
@pytest.mark.promise("k")
def test_a_half_duplex_module_that_streams_is_read_and_written(hz: float, gap_ms: float) -> None:
    for seed in SEEDS:
        rig = Rig({"half_duplex": True, "rate": hz, "stream_at_boot": True, "seed": seed, "min_gap_ms": gap_ms})
        rig.step_for(0.3 + seed * 0.0007)
        read_and_write(rig)
        assert rig.bench.module.is_streaming, "it is left as it was"


def test_a_quick_module_is_read_without_any_pause() -> None:
    rig = Rig()
    rig.run(read_everything())
    began_s = rig.clock()
    rig.run(read_everything())
    bare_s = sum((6 + command.layout.value) * 10 / 115200 for command in READABLE)
    assert rig.clock() - began_s <= 1.3 * bare_s


@pytest.mark.promise("k")
def test_lock_leaves_at_once_and_a_set_does_not() -> None:
    bench = Bench()
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE, after_s=0.003)
    asked_at = bench.now
    assert bench.link.ask(SET, bench.now) == []
    assert not bench.link.has_left
    assert bench.link.next_deadline() == pytest.approx(asked_at + ONCE_S)
    assert bench.link.abandon(bench.now) == [], "it has not left, so nothing is unknown"
    (sent,) = bench.link.ask(ACTIVATION.set(False), bench.now)
    assert isinstance(sent, Sent)
    assert sent.at == asked_at


def ask(gap: Gap, *, attempts: int) -> None:
    for attempt in range(attempts):
        gap.sent(is_repeated=attempt > 0, now=0.0)
    gap.answered()


def test_the_pause_begins_where_quick_questions_are_lost_one_after_the_other() -> None:
    gap = Gap()
    for _ in range(LOST_IN_A_ROW - 1):
        ask(gap, attempts=2)
    ask(gap, attempts=1)
    for _ in range(LOST_IN_A_ROW - 1):
        ask(gap, attempts=3)
    assert gap.question_s == 0.0
    ask(gap, attempts=2)
    assert gap.question_s == QUESTION_S
    ask(gap, attempts=1)
    gap.on_reply(1.0)
    assert gap.due(QUESTION, 1.0, is_repeated=False, now=1.0) == 1.0 + QUESTION_S, "it stays"


def test_what_is_never_answered_teaches_nothing() -> None:
    rig = Rig({"mute_codes": "14,33"})
    for _ in range(5):
        rig.run(read_everything())
    assert rig.session._link.gap.question_s == 0.0


def test_nothing_is_held_back_for_longer_than_the_longest_pause() -> None:
    bench = Bench()
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    asked_at = bench.now
    bench.link.ask(SERIAL_OUTPUT.set(True), bench.now)
    sent: list[Sent] = []
    while not sent:
        bench.now += 0.01
        sent = [event for event in bench.link.receive(PULSE, bench.now) if isinstance(event, Sent)]
        sent += [event for event in bench.link.tick(bench.now) if isinstance(event, Sent)]
    assert sent[0].at - asked_at == pytest.approx(MAX_S, abs=0.011)


def test_every_setting_waits_for_a_quiet_line() -> None:
    for command in SETTINGS:
        gap = Gap()
        gap.on_reply(1.0)
        value = next(iter(sorted(command.write.allowed))) if command.write is not None else 0
        request = command.set(command.write.decode(value)) if command.write is not None else QUESTION
        assert gap.due(request, 1.0, is_repeated=False, now=1.0) == 1.0 + ONCE_S
    assert Gap().due(QUESTION, 1.0, is_repeated=False, now=1.0) == 1.0


def streaming(*times_s: float) -> Gap:
    gap = Gap()
    for time_s in times_s:
        gap.on_streamed(time_s)
    return gap


@pytest.mark.parametrize(
    ("times_s", "asked_at", "due_at"),
    [
        ([], 2.0, 2.0),
        ([1.0], 2.0, 2.0),
        ([0.0, 1.0], 1.0, 1.0),  # directly after a report
        ([0.0, 1.0], 2.0 - CLEAR_S - 0.001, 2.0 - CLEAR_S - 0.001),
        ([0.0, 1.0], 2.0 - CLEAR_S, 2.0 + STREAM_LATE_S),
        ([0.0, 1.0], 2.0 + STREAM_LATE_S + 0.001, 2.0 + STREAM_LATE_S + 0.001),  # the report is missing
        ([0.0, 1.125], 2.125, 2.125),  # a pause of more than a second: nothing is due
        ([0.0, 1.0, 2.125], 3.125, 3.125),
        ([0.0, 0.5, 0.5 + 2**-12], 1.0, 1.0 + 2**-12 + STREAM_LATE_S),  # two reports in one read
        ([0.0, 0.5, 1.5], 2.0, 2.0 + STREAM_LATE_S),  # the shortest interval counts
    ],
)
def test_a_set_leaves_between_two_streamed_reports(times_s: list[float], asked_at: float, due_at: float) -> None:
    gap = streaming(*times_s)
    assert gap.due(SET, asked_at, is_repeated=False, now=asked_at) == pytest.approx(due_at)
    assert gap.due(QUESTION, asked_at, is_repeated=True, now=asked_at) == pytest.approx(due_at)
    assert gap.due(QUESTION, asked_at, is_repeated=False, now=asked_at) == asked_at
    assert gap.due(ACTIVATION.set(False), asked_at, is_repeated=True, now=asked_at) == asked_at
