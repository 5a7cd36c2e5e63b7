"""Trigger records are never thrown away, never invented, and never "none" where nothing was answered."""

import os
from collections import Counter
from itertools import product
from typing import Any

import pytest

from app.engine.device import DeviceView
from app.engine.procedure import EngineView, LinkView
from app.limits.expectations import Expectations, Past
from app.preflight.evidence import Evidence
from app.preflight.findings import Case, CheckResult
from app.preflight.module_checks import trigger_records
from app.procedures.history import History, Pass, _read_once, _with_strays, history_of, read_history
from app.simulator.memory import record_frame
from protocol.catalogue import TRIGGER_RECORDS
from protocol.events import Answered, Counters
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from tests.support.line.sim_line import settled_rig
from tests.support.records.record_lies import RECORD_DIALECTS, RECORD_LIES, read_records

IS_THOROUGH = os.environ.get("HYPOTHESIS_PROFILE") == "thorough"


def record(number: int) -> TriggerRecord:
    body = bytes((0x35, 0x01, number, 0, 108, 2, 60, 5, 160, 0, 1, 12, 200))
    decoded = decode_record(b"Au" + body + bytes((sum(body) & 0xFF,)))
    assert isinstance(decoded, TriggerRecord)
    return decoded


ONE, TWO = record(1), record(2)


@pytest.mark.parametrize("lie", RECORD_LIES, ids=str)
def test_no_lie_loses_or_invents_a_record(lie: dict[str, Any]) -> None:
    for number, (quirks, count) in list(enumerate(product(RECORD_DIALECTS, (0, 1, 9))))[:: 1 if IS_THOROUGH else 4]:
        read = read_records({**quirks, **lie, "history": count, "seed": number})
        assert read.faults == [], (lie, quirks, count)


def test_a_record_that_came_once_and_was_lost_later_is_still_listed() -> None:
    rig = settled_rig(history=1, **{"drop-records": "1/2,1/3,1/4,1/5", "empty-slots": "zeros"})
    history = rig.run(read_history())
    assert [one.raw for one in history.seen_once] == [one.raw for one in history.all]
    assert len(history.all) == 1
    assert not history.is_confirmed


def test_a_slot_never_used_that_was_damaged_on_the_line_is_no_record() -> None:
    slots = []
    for fill, bit in product((0x00, 0xFF), (0, 5, 7)):
        body = bytearray((0x35, 0x01, *[fill] * 11))
        body[5] ^= 1 << bit  # and the sum, which fits again
        slots.append(decode_record(b"Au" + body + bytes((sum(body) & 0xFF,))))
    assert all(isinstance(one, TriggerRecord) for one in slots)
    reading, sight = _read_once(), EngineView(0.0, 0.0, 115200, DeviceView(), LinkView(Counters(), None, None, 0))
    next(reading)
    reading.send(sight)
    reading.send(Answered(TRIGGER_RECORDS.query(), (ONE, *slots), 1, 0.01, 0.0))
    with pytest.raises(StopIteration) as end:
        reading.send(sight)
    assert end.value.value == Pass((ONE,), is_clean=False)
    damaged = slots[0]
    assert isinstance(damaged, TriggerRecord)
    assert _with_strays(History((ONE,)), (damaged, TWO)).seen_once == (TWO,)


def test_there_are_never_more_empty_slots_than_the_records_leave() -> None:
    empty = EmptySlot(b"")
    history = history_of([Pass((ONE, TWO, *[empty] * 7)), Pass((ONE, *[empty] * 8)), Pass((TWO, *[empty] * 8))])
    assert len(history.all) == 2
    assert history.empty_slots == 7
    history = history_of([Pass((ONE, *[empty] * 8)), Pass((TWO, *[empty] * 8))])
    assert len(history.seen_once) == 2
    assert history.empty_slots == 7


def test_records_that_come_after_their_query_was_given_up_are_listed() -> None:
    rig = settled_rig(history=3)
    rig.bench.change(delay_ms=1100.0)
    history = rig.run(read_history())
    assert {one.raw for one in history.seen_once} == {record_frame(data) for data in rig.bench.module.memory.records}
    assert len(history.all) == 3
    assert history.is_answered
    assert not history.is_confirmed


def test_a_query_that_is_never_answered_is_unknown_and_never_none() -> None:
    history = settled_rig(history=3, **{"mute-codes": "35"}).run(read_history())
    assert (history.is_answered, history.is_confirmed, history.is_line_dead) == (False, False, False)
    evidence = Evidence(history=history)
    assert (
        trigger_records(Case(evidence=evidence, expectations=Expectations(), past=Past())).result is CheckResult.UNKNOWN
    )
    by_a_person = Case(evidence=evidence, expectations=Expectations(), past=Past(), are_records_looked_at=True)
    assert trigger_records(by_a_person).result is CheckResult.WARN


def test_ten_percent_of_lost_frames_never_pass_for_a_complete_reading() -> None:
    for seed in range(60):
        read = read_records({"history": 9, "drop": 0.1, "records": "spaced", "seed": seed})
        assert read.faults == []


def test_an_unclean_pass_confirms_nothing() -> None:
    rig = settled_rig(history=2, **{"mute-codes": "35/3"})
    assert rig.run(read_history()).is_confirmed
    rig = settled_rig(history=2)
    rig.bench.change(garbage=1.0)
    assert not rig.run(read_history()).is_confirmed


@pytest.mark.parametrize(
    ("passes", "certain", "once"),
    [
        ([[ONE], []], [], [ONE]),
        ([[ONE], [TWO]], [], [ONE, TWO]),
        ([[ONE, TWO], [TWO]], [TWO], [ONE]),
        ([[ONE, ONE], [ONE]], [ONE], [ONE]),
        ([[ONE, ONE], [ONE, ONE]], [ONE], [ONE]),
        ([[], [], [ONE, TWO], [ONE]], [ONE], [TWO]),
    ],
)
def test_the_union_of_all_passes(
    passes: list[list[TriggerRecord | EmptySlot]], certain: list[TriggerRecord], once: list[TriggerRecord]
) -> None:
    history = history_of([Pass(tuple(one)) for one in passes])
    assert (list(history.records), list(history.seen_once)) == (certain, once)
    assert history.is_answered


def test_two_equal_records_on_a_good_line_are_two() -> None:
    rig = settled_rig(history=2)
    records = rig.bench.module.memory.records
    records.append(records[-1])
    history = rig.run(read_history())
    assert history.is_confirmed
    assert Counter(one.raw for one in history.records).most_common(1)[0][1] == 2
