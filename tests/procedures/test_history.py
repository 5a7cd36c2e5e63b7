"""Trigger records are never thrown away, never invented, and never "none" where nothing was answered."""

from collections import Counter
from itertools import product
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.procedures.history import read_history
from app.simulator.module import record_frame
from tests.support.line.sim_line import Rig, settled_rig
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
    {"drop": "0.1"},
    {"drop": "0.3"},
    {"corrupt": "0.004"},
    {"corrupt": "0.02"},
    {"lose": "0.01"},
    {"double": "0.5"},
    {"lag_ms": "700"},
)
RECORD_DIALECTS: tuple[dict[str, Any], ...] = tuple(
    {"records": records, "empty_slots": empty} for records in ("together", "spaced", "pieces")
    for empty in ("none", "zeros", "ones")
)  # fmt: skip


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
def test_a_query_that_is_never_answered_is_unknown_and_never_none() -> None:
    history = settled_rig(history=3, **{"mute-codes": "35"}).run(read_history())
    assert (history.is_answered, history.is_confirmed, history.all) == (False, False, ())
