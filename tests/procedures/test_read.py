"""What is read, how many frames each procedure costs, and who is there directly before a frame."""

from collections.abc import Callable
from typing import Any

import pytest

from app.engine.procedure import Ask, Procedure
from app.procedures.act import perform
from app.procedures.read import READABLE, read_everything, read_settings, who_is_there
from app.procedures.write import SettingChange, WriteContext, write_all
from app.safety.journal import REQUESTS, Act
from protocol.catalogue import BY_NAME
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import Rig, settled_rig

ALL = {"light_threshold_v": 1.8, "attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6}
FOUR = {"freefall_time": 1.4, "attitude_threshold": 65, "light_threshold": 2.0, "freefall_acceleration": 0.4}


def write(values: dict[str, float]) -> Procedure[Any]:
    changes = [SettingChange(BY_NAME[name], value) for name, value in values.items()]
    return write_all(changes, WriteContext(journal=FakeJournal()))


def activate(rig: Rig) -> Procedure[Any]:
    return perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE))


@pytest.mark.parametrize(
    ("begin", "most"),
    [
        (lambda _rig: read_everything(), 11),
        (activate, 9),
        (lambda _rig: write({"freefall_time": 1.4}), 26),
        (lambda _rig: write(FOUR), 43),
    ],
    ids=["read everything", "activate", "one setting", "four settings"],
)
def test_what_it_costs(begin: Callable[[Rig], Procedure[Any]], most: int) -> None:
    """In frames, the link's own and the heartbeat that is due now and then included."""
    rig = Rig({"uptime": 60, "noise": 0}).begin()
    assert len(rig.line.requests) <= 2, "for the beginning"
    before = len(rig.line.requests)
    rig.run(begin(rig))
    assert len(rig.line.requests) - before <= most + 1


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
    rig = settled_rig(delay_ms=200.0, mute_codes="14,22")
    everything = rig.run(read_everything())
    assert set(everything.errors) == {"light_v", "freefall_time_s"}
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
