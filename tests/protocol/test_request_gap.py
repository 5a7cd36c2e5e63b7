"""Modules that need a pause between requests, or do not hear while they send: read and written all the same."""

from typing import Any

import pytest

from app.procedures.read import READABLE, read_everything
from app.procedures.write_all import SettingChange, WriteContext, write_all
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, SERIAL_OUTPUT, SETTINGS
from protocol.events import Sent
from protocol.request_gap import (
    CLEAR_S,
    LONGEST_PATIENCE,
    MAX_S,
    ONCE_S,
    ONCE_UNTRIED_S,
    PATIENCE,
    PAUSES_S,
    STREAM_LATE_S,
    Gap,
)
from tests.support.journals import FakeJournal
from tests.support.line.link_bench import PULSE, Bench, named
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
def test_a_module_that_needs_a_gap_is_read_and_written(gap_ms: float, jitter_ms: float) -> None:
    for seed in SEEDS:
        options: dict[str, Any] = {"min_gap_ms": gap_ms, "jitter_ms": jitter_ms, "seed": seed}
        read_and_write(Rig(options))
        write_values(Rig(options))


@pytest.mark.parametrize("gap_ms", [0.0, 5.0])
@pytest.mark.parametrize("hz", [10.0, 50.0, 200.0])
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


def test_lock_leaves_at_once_and_a_set_does_not() -> None:
    bench = Bench()
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE, after_s=0.003)
    asked_at = bench.now
    assert bench.link.ask(SET, bench.now) == []
    assert not bench.link.has_left
    assert bench.link.next_deadline() == pytest.approx(asked_at + 0.05), "no short pause has been answered yet"
    assert bench.link.abandon(bench.now) == [], "it has not left, so nothing is unknown"
    (sent,) = bench.link.ask(ACTIVATION.set(False), bench.now)
    assert isinstance(sent, Sent)
    assert sent.at == asked_at


def test_a_set_waits_less_once_a_quick_request_was_answered() -> None:
    bench = Bench()
    for name, reply in (("charging", "41 75 33 01 00 34"), ("active", "41 75 30 01 00 31")):
        bench.ask(named(name).query())
        bench.hear(bytes.fromhex(reply))
    bench.ask(SET)
    (sent,) = [event for event in bench.events if isinstance(event, Sent) and event.request == SET]
    assert sent.at - 100.006 == pytest.approx(0.015)


def lose(gap: Gap, now: float, pause_s: float) -> float:
    """A question `pause_s` after a reply is lost, the second one after 200 ms is answered."""
    gap.on_reply(now)
    gap.sent(is_repeated=False, now=now + pause_s)
    gap.sent(is_repeated=True, now=now + pause_s + 0.2)
    gap.answered()
    return now + 1.0


def answer(gap: Gap, now: float, pause_s: float) -> float:
    gap.on_reply(now)
    gap.sent(is_repeated=False, now=now + pause_s)
    gap.answered()
    return now + 1.0


def test_nothing_is_learnt_from_questions_that_are_never_answered() -> None:
    gap = Gap()
    for now in range(10):
        gap.on_reply(now)
        gap.sent(is_repeated=False, now=now + 0.001)
        gap.sent(is_repeated=False, now=now + 0.3)
        gap.answered()
    assert gap.question_s == 0.0


def test_the_pause_grows_where_quick_questions_are_lost_and_is_tried_shorter_with_care() -> None:
    gap, now = Gap(), 0.0
    seen = []
    for _ in range(9):
        now = lose(gap, now, gap.question_s + 0.001)
        seen.append(gap.question_s)
    assert seen == [0.0] * 2 + [PAUSES_S[1]] * 3 + [PAUSES_S[2]] * 3 + [PAUSES_S[3]]
    assert gap.once_s >= gap.question_s
    for count in range(PATIENCE):
        assert gap.question_s == PAUSES_S[3], count
        now = answer(gap, now, gap.question_s)
    assert gap.question_s == PAUSES_S[2], "tried again"
    for _ in range(3):
        now = lose(gap, now, gap.question_s)
    assert gap.question_s == PAUSES_S[3]
    for count in range(2 * PATIENCE):
        assert gap.question_s == PAUSES_S[3], count
        now = answer(gap, now, gap.question_s)
    assert gap.question_s == PAUSES_S[2]


def test_a_line_that_loses_whatever_the_pause_gets_none() -> None:
    rig = Rig({"drop": 0.35, "direction": "both", "seed": 4})
    gap = rig.session._link.gap
    held = []
    for _ in range(40):
        rig.run(read_everything(), limit_s=300)
        held.append(gap.question_s)
    assert held.count(0.0) >= 30, held
    assert max(held) <= PAUSES_S[2]


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
        assert gap.due(request, 1.0, is_repeated=False, now=1.0) >= 1.01
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


def test_a_set_waits_for_the_shorter_time_while_quick_requests_are_answered() -> None:
    assert 0.0 < ONCE_S < ONCE_UNTRIED_S < MAX_S
    gap, now = Gap(), 0.0
    assert gap.once_s == ONCE_UNTRIED_S
    now = answer(gap, now, PAUSES_S[2])
    assert gap.once_s == ONCE_UNTRIED_S, "16 ms is no shorter pause than the 15 ms that would be used"
    now = answer(gap, now, PAUSES_S[1])
    assert gap.once_s == ONCE_S
    for _ in range(3):
        now = lose(gap, now, PAUSES_S[1])
    assert gap.once_s == ONCE_UNTRIED_S


def test_the_longest_pause_is_kept_where_nothing_shorter_works_and_tried_ever_more_rarely() -> None:
    gap, now = Gap(), 0.0
    for _ in range(3 * len(PAUSES_S)):
        now = lose(gap, now, gap.question_s)
    longest_s = gap.question_s
    assert longest_s == PAUSES_S[-1]
    while gap.question_s == longest_s:
        now = answer(gap, now, longest_s)
    tries = []
    for _ in range(7):
        for _ in range(3):
            now = lose(gap, now, gap.question_s)
        answers = 0
        while gap.question_s == longest_s:
            now = answer(gap, now, longest_s)
            answers += 1
        tries.append(answers)
    assert tries == [min(PATIENCE * 2**number, LONGEST_PATIENCE) for number in range(1, 8)]
