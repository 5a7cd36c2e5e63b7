"""Trigger records are never thrown away, never invented, and never "none" where nothing was answered."""

from collections import Counter
from itertools import product
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.procedures.history import (
    History,
    Pass,
    _agree,
    _is_damaged_slot,
    _read_once,
    _with_strays,
    history_of,
    read_history,
)
from app.simulator.memory import record_frame
from protocol.catalogue import RECORD_CODE, TRIGGER_RECORDS
from protocol.events import Answered
from protocol.frame import encode_long
from protocol.messages import EmptySlot, TriggerRecord, decode, decode_record
from tests.module.options import Options
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import Rig, engine_view, settled_rig
from tests.support.thorough import some

RECORD_LIES: tuple[dict[str, Any], ...] = (
    {"drop_records": "1/2,1/3,1/4,1/5"},
    {"drop_records": "2/1"},
    {"drop_records": "1/2,2/3,3/4"},
    {"drop_records": "1/1,2/1,3/1,4/1,5/1,6/1,7/1,8/1,9/1"},
    {"mute_codes": "35"},
    {"mute_codes": "35/2"},
    {"double_codes": "35"},
    {"double_codes": "35", "double_ms": "30"},
    {"double_codes": "01,35", "double_ms": "5"},
    {"foreign_replies": "35:22"},
    {"drop": "0.1"},
    {"drop": "0.3"},
    {"corrupt": "0.004"},
    {"corrupt": "0.02"},
    {"lose": "0.01"},
    {"double": "0.5"},
    {"min_gap_ms": "2"},
    {"half_duplex": "yes"},
    {"lag_ms": "700"},
)
RECORD_DIALECTS: tuple[dict[str, Any], ...] = tuple(
    {"records": records, "empty_slots": empty} for records in ("together", "spaced", "pieces")
    for empty in ("none", "zeros", "ones")
)  # fmt: skip


def record(number: int) -> TriggerRecord:
    body = bytes((0x35, 0x01, number, 0, 108, 2, 60, 5, 160, 0, 1, 12, 200))
    decoded = decode_record(b"Au" + body + bytes((sum(body) & 0xFF,)))
    assert isinstance(decoded, TriggerRecord)
    return decoded


ONE, TWO = record(1), record(2)


def record_faults(options: dict[str, Any]) -> list[str]:
    """What one reading of the history claims of the records that the module holds, and is not so."""
    rig = Rig({"uptime": 60, "noise": 0} | options)
    rig.step_for(1.0)
    if not rig.conversation.is_going:
        return []
    held = Counter(record_frame(data) for data in rig.bench.module.memory.records)
    try:
        history = rig.run(read_history())
    except Interrupted:
        return []  # nothing is claimed
    shown = Counter(one.raw for one in history.all)
    found = []
    if Counter(one.raw for one in history.records) - held:
        found.append("certain, and the module never had it")
    if history.is_confirmed and shown != held:
        found.append("complete, and it is not")
    if history.is_confirmed and not history.is_answered:
        found.append("complete without an answer")
    if not history.is_answered and shown:
        found.append("records without an answer")
    return found


@pytest.mark.parametrize("lie", RECORD_LIES, ids=str)
@pytest.mark.promise("f")
def test_no_lie_loses_or_invents_a_record(lie: dict[str, Any]) -> None:
    for number, (quirks, count) in some(enumerate(product(RECORD_DIALECTS, (0, 1, 9))), one_in=4):
        assert record_faults({**quirks, **lie, "history": count, "seed": number}) == [], (lie, quirks, count)


def test_a_record_that_came_once_and_was_lost_later_is_still_listed() -> None:
    rig = settled_rig(history=1, **{"drop-records": "1/2,1/3,1/4,1/5", "empty-slots": "zeros"})
    history = rig.run(read_history())
    assert [one.raw for one in history.seen_once] == [one.raw for one in history.all]
    assert len(history.all) == 1
    assert not history.is_confirmed


@pytest.mark.promise("f")
def test_a_slot_never_used_that_was_damaged_on_the_line_is_no_record() -> None:
    slots = []
    for fill, bit, place in product((0x00, 0xFF), (0, 5, 7), (2, 5, 12)):
        body = bytearray((0x35, 0x01, *[fill] * 11))
        body[place] ^= 1 << bit  # and the sum, which fits again
        slots.append(decode_record(b"Au" + body + bytes((sum(body) & 0xFF,))))
    assert all(isinstance(slot, TriggerRecord) for slot in slots)
    reading, sight = _read_once(), engine_view()
    next(reading)
    reading.send(sight)
    reading.send(Answered(TRIGGER_RECORDS.query(), (ONE, *slots), 1, 0.01, 0.0))
    with pytest.raises(StopIteration) as end:
        reading.send(sight)
    assert end.value.value == Pass((ONE,), is_clean=False)
    damaged = slots[0]
    assert isinstance(damaged, TriggerRecord)
    assert _with_strays(History((ONE,)), (damaged, TWO)).seen_once == (TWO,)


@pytest.mark.promise("f")
def test_there_are_never_more_empty_slots_than_the_records_leave() -> None:
    empty = EmptySlot(b"")
    history = history_of([Pass((ONE, TWO, *[empty] * 7)), Pass((ONE, *[empty] * 8)), Pass((TWO, *[empty] * 8))])
    assert len(history.all) == 2
    assert history.empty_slots == 7
    history = history_of([Pass((ONE, *[empty] * 8)), Pass((TWO, *[empty] * 8))])
    assert len(history.seen_once) == 2
    assert history.empty_slots == 7


@pytest.mark.promise("g")
def test_records_that_come_after_their_query_was_given_up_are_listed() -> None:
    """By a module that does not keep to the order of the questions."""
    rig = ModuleRig(Options(delays={RECORD_CODE: 0.3}, in_order=False, empty_slot=None)).begin()
    for source in (0x02, 0x08):
        rig.module.trigger(rig.clock(), source)
    rig.module.triggered = False
    history = rig.run(read_history())
    assert {one.raw[2:-1] for one in history.all} == set(rig.module.records)
    assert history.is_answered
    assert not history.is_confirmed


@pytest.mark.promise("f")
def test_a_query_that_is_never_answered_is_unknown_and_never_none() -> None:
    history = settled_rig(history=3, **{"mute-codes": "35"}).run(read_history())
    assert (history.is_answered, history.is_confirmed, history.all) == (False, False, ())


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


SLOT = encode_long(0x35, b"\x01" + bytes(11))


def empty() -> EmptySlot:
    found = decode(SLOT)
    assert isinstance(found, EmptySlot)
    return found


A, B, C = ONE, TWO, record(3)


@pytest.mark.parametrize(
    ("data", "is_damaged"),
    [
        (bytes(11), False),
        (b"\x01" + bytes(10), True),
        (b"\x03" + bytes(10), False),
        (b"\x01\x01" + bytes(9), False),
        (b"\xff" * 11, False),
        (b"\xfe" + b"\xff" * 10, True),
        (b"\xfc" + b"\xff" * 10, False),
    ],
)
def test_an_unused_slot_with_one_flipped_bit_is_no_record(data: bytes, is_damaged: bool) -> None:
    assert _is_damaged_slot(encode_long(0x35, b"\x01" + data)) is is_damaged


def test_a_reading_is_doubled_where_each_record_came_an_even_number_of_times() -> None:
    assert Pass((A, A)).is_doubled
    assert Pass((A, B, B, A)).is_doubled
    assert Pass((A, A, A, A, empty())).is_doubled
    assert not Pass((A, A, A)).is_doubled
    assert not Pass((A, A, B)).is_doubled
    assert not Pass((empty(), empty())).is_doubled


def test_two_clean_equal_readings_that_hold_everything_agree() -> None:
    clean, dirty = Pass((A, B), is_clean=True), Pass((A, B))
    assert _agree([clean, clean])
    assert _agree([Pass((A,)), clean, clean])
    assert not _agree([clean])
    assert not _agree([dirty, clean])
    assert not _agree([clean, dirty])
    assert not _agree([clean, Pass((B, A), is_clean=True)])
    assert not _agree([Pass((C,)), clean, clean])
    assert not _agree([Pass((A, A)), clean, clean])
    assert not _agree([Pass((), is_clean=True)] * 2)


def test_a_record_is_certain_in_two_readings_and_an_equal_second_one_only_where_confirmed() -> None:
    assert history_of([Pass((A, B)), Pass((A, C))]) == History((A,), seen_once=(B, C), is_answered=True)
    assert history_of([Pass((A, A)), Pass((A, A))]) == History((A,), seen_once=(A,), is_answered=True)
    confirmed = history_of([Pass((A, B, A))] * 2, is_confirmed=True)
    assert confirmed == History((A, B, A), is_confirmed=True, is_answered=True)
    assert confirmed.all == (A, B, A)
    assert history_of([Pass((C,)), Pass((A, B))]).all == (A, B, C), "the fullest reading is first"
    assert history_of([]) == History()
