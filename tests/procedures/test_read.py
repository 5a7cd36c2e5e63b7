"""What is read, who is there directly before a frame, trigger records, light by measurement."""

from collections import Counter
from copy import deepcopy
from itertools import product
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Procedure
from app.procedures.act import perform
from app.procedures.history import read_history
from app.procedures.light import (
    ENOUGH_SAMPLES,
    TOO_CLOSE,
    TOO_FEW,
    Band,
    LightDirection,
    Proposal,
    measure_light,
    propose,
)
from app.procedures.read import READABLE, read_everything, read_settings, who_is_there
from app.procedures.write import SettingChange, WriteContext, write_all
from app.safety.journal import REQUESTS, Act
from app.simulator.module import LIGHT_BAY_CLOSED_V, LIGHT_BAY_OPEN_V
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from tests.module.module import Module
from tests.module.options import Options
from tests.module.wire import FROM_MODULE, with_sum
from tests.support.journals import FakeJournal
from tests.support.line.frames import lose
from tests.support.line.module_line import ModuleRig, Wear
from tests.support.line.sim_line import settled_rig
from tests.support.thorough import some

ALL = {"light_threshold_v": 1.8, "attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6}


def write(values: dict[str, float]) -> Procedure[Any]:
    changes = [SettingChange(BY_NAME[name], value) for name, value in values.items()]
    return write_all(changes, WriteContext(journal=FakeJournal()))


def test_everything_is_asked_once_the_state_first_and_the_boot_count_last() -> None:
    rig = settled_rig()
    before = len(rig.line.requests)
    everything = rig.run(read_everything())
    codes = [request.command for request in rig.line.requests[before:]]
    assert codes == list(READABLE)
    assert codes[:3] == [BY_NAME["active"], BY_NAME["triggered"], BY_NAME["status"]]
    assert codes[-1] is BY_NAME["boot_count"]
    assert everything.errors == {}
    assert everything.values.items() > ALL.items()
    assert everything.status is not None
    assert not everything.contradictions


def test_what_a_module_does_not_know_is_named_and_the_rest_is_read() -> None:
    rig = settled_rig(lag_ms=200.0)
    lose(rig.bench, 0x14, 0x22)
    assert set(rig.run(read_everything()).errors) == {"light_v", "freefall_time_s"}
    reading = rig.run(read_settings())
    assert set(reading.errors) == {"freefall_time_s"}
    assert reading.values.keys() == ALL.keys() - {"freefall_time_s"} | {"boot_count"}
    assert not reading.is_complete


# Who is there


@pytest.mark.parametrize(
    ("instead", "is_active", "key", "said"),
    [
        ({0x30: "01 01"}, 0, "active", "30: ACTIVE, status: LOCKED."),
        ({0x30: "01 00"}, 1, "active", "30: LOCKED, status: ACTIVE."),
        ({0x31: "01 01"}, 0, "triggered", "31: TRIGGERED, status: not triggered."),
    ],
)
@pytest.mark.promise("h")
def test_a_status_that_30_or_31_contradicts_is_named(
    instead: dict[int, str], is_active: int, key: str, said: str
) -> None:
    rig = ModuleRig(Options(instead=instead))
    rig.module.settings[0x10] = is_active
    rig.begin()
    everything = rig.run(read_everything())
    assert {name: one.in_english() for name, one in everything.contradictions.items()} == {key: said}
    present = rig.run(who_is_there())
    assert present.contradiction is not None
    assert present.contradiction.in_english() == said


@pytest.mark.parametrize(
    "options",
    [
        Options(instead={0x30: "01 01"}),
        Options(instead={0x31: "01 01"}),
        Options(lost_queries={0x30: -1}),
        Options(lost_queries={0x31: -1}),
        Options(lost_queries={0x32: -1}),
    ],
    ids=["30 lies", "31 lies", "no 30", "no 31", "no status"],
)
@pytest.mark.promise("h")
def test_nothing_is_written_and_nothing_done_then(options: Options) -> None:
    rig = ModuleRig(options).begin()
    report = rig.run(write({"freefall_time": 1.2}))
    assert report.is_refused
    for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY):
        done = rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))
        assert done.refusals
    assert rig.module.log.sets() == rig.module.log.acts() == []


@pytest.mark.parametrize("act", [None, Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
@pytest.mark.promise("h")
def test_directly_before_a_frame_who_is_there_is_asked_the_boot_count_last(act: Act | None) -> None:
    rig = ModuleRig().begin()
    if act is None:
        rig.run(write({"freefall_time": 1.2}))
        sent = BY_NAME["freefall_time"].set(1.2)
    else:
        rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))
        sent = REQUESTS[act]
    entries = rig.module.log.got()
    at = next(number for number, entry in enumerate(entries) if entry.frame == sent.encode())
    assert [entry.code for entry in entries[at - 4 : at]] == [0x30, 0x31, 0x32, 0x23]
    assert entries[at].at_s - entries[at - 1].at_s < 0.1


@pytest.mark.promise("a")
def test_who_is_there_begins_behind_a_fence() -> None:
    assert next(who_is_there()) == Ask(BY_NAME["active"].query(), is_fenced=True)


FIRST, SECOND, THIRD, EVERY = frozenset((1,)), frozenset((2,)), frozenset((3,)), frozenset(range(1, 10))
RECORD_LIES: tuple[tuple[dict[str, Any], Wear], ...] = (
    ({"lost_records": dict.fromkeys((2, 3, 4, 5), FIRST)}, Wear()),
    ({"lost_records": {1: SECOND}}, Wear()),
    ({"lost_records": {2: FIRST, 3: SECOND, 4: THIRD}}, Wear()),
    ({"lost_records": {1: EVERY}}, Wear()),
    ({"lost_records": dict.fromkeys(range(2, 9), EVERY)}, Wear()),
    ({"lost_queries": {0x35: -1}}, Wear()),
    ({"query_copies": {0x35: [0.0]}}, Wear()),
    ({"query_copies": {0x35: [0.03]}}, Wear()),
    ({"query_copies": {0x01: [0.005], 0x35: [0.005]}}, Wear()),
    ({}, Wear(loss=0.1)),
    ({}, Wear(loss=0.3)),
    ({}, Wear(turned_bytes=0.004)),
    ({}, Wear(turned_bytes=0.02)),
    ({}, Wear(lag_s=0.7)),
)
RECORD_DIALECTS = tuple(product((0.0, 0.02), (None, 0x00, 0xFF)))


def module_with(count: int, **options: Any) -> Module:
    """It has fired so often."""
    module = Module(Options(**deepcopy(options)), now=1000.0)
    for number in range(count):
        module.trigger(1060.0 + 90 * number, 1 << number % 4)
    module.triggered = False
    return module


def record_faults(module: Module, wear: Wear, seed: int) -> list[str]:
    """What one reading of the history claims of the records that the module holds, and is not so."""
    rig = ModuleRig(modules=(module,), wear=wear, seed=seed)
    rig.step_for(1.0)
    if not rig.conversation.is_going:
        return []
    held = Counter(with_sum(FROM_MODULE + body) for body in module.records)
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


@pytest.mark.parametrize(("lie", "wear"), RECORD_LIES, ids=str)
@pytest.mark.promise("f")
def test_no_lie_loses_or_invents_a_record(lie: dict[str, Any], wear: Wear) -> None:
    for number, ((gap_s, empty), count) in some(enumerate(product(RECORD_DIALECTS, (0, 1, 9))), one_in=4):
        module = module_with(count, record_gap_s=gap_s, empty_slot=empty, **lie)
        assert record_faults(module, wear, number) == [], (lie, wear, gap_s, empty, count)


@pytest.mark.parametrize(
    ("count", "lie", "certain", "seen_once", "is_answered"),
    [
        (1, {"lost_records": dict.fromkeys((2, 3, 4, 5), FIRST)}, 0, 1, True),
        (1, {"query_copies": {0x01: [0.002]}}, 1, 0, True),  # a line that doubles heartbeats
        (3, {"lost_queries": {0x35: -1}}, 0, 0, False),
    ],
)
@pytest.mark.promise("f")
def test_what_is_lost_or_doubled_is_listed_and_confirmed_by_nothing(
    count: int, lie: dict[str, Any], certain: int, seen_once: int, is_answered: bool
) -> None:
    """One that came once is kept, and no answer is unknown and never "none"."""
    history = ModuleRig(modules=(module_with(count, **lie),)).begin().run(read_history())
    assert (len(history.records), len(history.seen_once)) == (certain, seen_once)
    assert (history.is_answered, history.is_confirmed) == (is_answered, False)


def test_two_equal_passes_confirm_nothing_if_something_was_lost_or_damaged_in_the_first() -> None:
    rig = ModuleRig(modules=(module_with(1),)).begin()
    rig.line.inject(bytes(3), after_s=0.2)
    assert rig.run(read_history()).is_confirmed
    assert len(rig.module.log.got(0x35)) == 3


def band(low: int, high: int, count: int = ENOUGH_SAMPLES) -> Band:
    return Band(tuple(low if number % 2 else high for number in range(count)))


@pytest.mark.parametrize(("inverted", "direction"), [(False, LightDirection.RISES), (True, LightDirection.FALLS)])
def test_the_direction_is_found_and_the_threshold_lies_between(
    inverted: bool, direction: LightDirection, monkeypatch: pytest.MonkeyPatch
) -> None:
    if inverted:
        monkeypatch.setattr("app.simulator.module.LIGHT_BAY_OPEN_V", LIGHT_BAY_CLOSED_V)
        monkeypatch.setattr("app.simulator.module.LIGHT_BAY_CLOSED_V", LIGHT_BAY_OPEN_V)
    rig = settled_rig()
    closed = rig.run(measure_light())
    rig.bench.set_world(bay_is_open=True)
    opened = rig.run(measure_light())
    proposal = propose(closed, opened)
    assert isinstance(proposal, Proposal)
    assert proposal.direction is direction
    assert len(closed.raws) == len(opened.raws) == 20
    low, high = sorted((closed, opened), key=lambda one: one.low_v)
    assert low.high_v < proposal.threshold_v < high.low_v
    assert proposal.margin_v == pytest.approx((2.5 - 0.3) / 2, abs=0.11)


@pytest.mark.parametrize(
    ("closed", "opened", "found"),
    [
        (band(3, 9), band(5, 6), TOO_CLOSE),
        (band(3, 5), band(6, 9), TOO_CLOSE),
        (band(6, 9), band(3, 5), TOO_CLOSE),
        (band(3, 5, 9), band(20, 21), TOO_FEW),
        (band(3, 5), band(20, 21, 9), TOO_FEW),
    ],
)
def test_no_threshold_where_there_is_no_gap(closed: Band, opened: Band, found: UserMessage) -> None:
    assert propose(closed, opened) is found
