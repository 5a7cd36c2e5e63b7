"""Write and prove, against the simulated module in every dialect and on bad lines: "verified" is never a lie."""

from dataclasses import replace
from typing import Any

import pytest

from app.procedures.stream import StreamSwitch
from app.procedures.write import (
    SettingChange,
    WriteContext,
    WriteFault,
    WriteReport,
    Written,
    set_each,
    why_not_verified,
    write_all,
)
from app.safety.journal import Act, Outcome
from app.safety.permit import Interlock
from protocol.catalogue import BOOT_COUNT, BY_NAME, HEARTBEAT_REPLY
from protocol.fields import Value, ValueRefused
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import Rig, settled_rig

READABLE: dict[str, Any] = {
    "light_threshold": 2.1,
    "attitude_threshold": 70,
    "freefall_acceleration": 0.4,
    "freefall_time": 1.2,
}


def changes(**values: Value) -> list[SettingChange]:
    return [SettingChange(BY_NAME[name], value) for name, value in values.items()]


def write(rig: Rig | ModuleRig, context: WriteContext | None = None, /, **values: Any) -> WriteReport:
    """Write what a person accepted."""
    wanted = changes(**values)
    context = replace(context or WriteContext(journal=FakeJournal()), accepted_risks=frozenset(wanted))
    return rig.run(write_all(wanted, context), limit_s=300.0)


def write_one(rig: Rig, name: str, value: Value) -> Written:
    wanted: dict[str, Any] = {name: value}
    (written,) = write(rig, **wanted).results
    return written


def sets(rig: Rig) -> list[str]:
    return [request.command.name for request in rig.line.requests if request.is_set]


# What becomes of one


@pytest.mark.parametrize("by_one", [set(), {0x21, 0x22}])
def test_e02_a_value_that_stands_is_verified(by_one: set[int]) -> None:
    rig = ModuleRig(Options(acknowledged_by_one=by_one)).begin()
    report = write(rig, **READABLE)
    assert report.is_fine
    assert [written.verified for written in report.results] == [True] * 4
    assert [rig.module.settings[code] for code in (0x15, 0x20, 0x21, 0x22)] == [21, 70, 4, 120]


@pytest.mark.parametrize("code", [0x16, 0x17])
def test_e08_what_cannot_be_read_back_is_acknowledged_and_never_verified(code: int) -> None:
    rig = ModuleRig(Options(freefall_code=code)).begin()
    for value in (False, True):
        report = write(rig, freefall_trigger=value, attitude_trigger=value, serial_output=value)
        for written in report.results:
            assert (written.verified, written.read_back, written.fault) == (None, None, None)
            assert written.is_acknowledged
        assert [rig.module.settings[one] for one in (0x16, 0x17, 0x13)] == [not value, not value, value]


@pytest.mark.promise("f")
def test_a_set_goes_out_once_and_is_read_back_twice_and_again_a_second_later() -> None:
    rig = ModuleRig().begin()
    assert write(rig, freefall_acceleration=0.4, freefall_time=1.2).is_fine
    for code in (0x21, 0x22):
        entries = rig.module.log.got(code)
        assert [entry.is_set for entry in entries] == [False, True, False, False, False]
        last_set = rig.module.log.sets()[-1]
        assert entries[-1].at_s - last_set.at_s >= 1.0


@pytest.mark.parametrize("by_one", [set(), {0x22}])
@pytest.mark.parametrize(
    ("options", "name", "wanted", "stands", "fault", "outcome"),
    [
        ({"ignored_sets": {0x22: -1}}, "freefall_time", 1.2, 1.6, WriteFault.NOT_SET, Outcome.REFUSED),
        ({"reverts": {0x22: (0.0, 50)}}, "freefall_time", 0.1, 0.5, WriteFault.NOT_SET, Outcome.REFUSED),
        ({"lowest_attitude_deg": 55}, "attitude_threshold", 40, 60, WriteFault.NOT_SET, Outcome.REFUSED),
        ({"lost_sets": {0x22: -1}}, "freefall_time", 1.2, 1.6, WriteFault.NOT_SET, Outcome.REFUSED),
        ({"lost_queries": {0x22: -1}}, "freefall_time", 1.2, None, WriteFault.NO_READ_BACK, Outcome.UNKNOWN),
        ({"lost_sets": {0x16: -1}}, "attitude_trigger", False, None, WriteFault.NO_REPLY, Outcome.UNKNOWN),
    ],
)
def test_a_module_that_goes_its_own_way_is_shown_as_what_it_is(
    by_one: set[int], options: dict[str, Any], name: str, wanted: Value, stands: Value, fault: WriteFault,
    outcome: Outcome,
) -> None:  # fmt: skip
    rig, journal = ModuleRig(Options(acknowledged_by_one=by_one, **options)).begin(), FakeJournal()
    (written,) = write(rig, WriteContext(journal=journal), **{name: wanted}).results
    assert (written.read_back, written.fault) == (stands, fault)
    assert not written.verified
    assert journal.outcomes == {0: outcome}


@pytest.mark.promise("g")
def test_one_bad_value_and_nothing_is_sent() -> None:
    rig = settled_rig()
    with pytest.raises(ValueRefused, match=r"0\.5 g and 0\.6 g"):
        write(rig, freefall_time=1.2, freefall_acceleration=0.55)
    assert rig.acts == []


def test_a_setting_that_cannot_be_read_at_the_end_is_not_verified() -> None:
    rig = ModuleRig().begin()

    def stop_answering(question: Any) -> None:
        is_read_back = len(rig.module.log.got(0x22)) >= 4 and not question.is_set
        rig.module.options.lost_queries = {0x22: -1} if is_read_back else {}

    rig.module.at_frame = stop_answering
    report = write(rig, freefall_time=1.2)
    assert [written.fault for written in report.results] == [WriteFault.NO_READ_BACK]
    assert not report.is_fine


# Several in one go


def test_each_is_logged() -> None:
    rig, journal = settled_rig(), FakeJournal()
    report = write(
        rig, WriteContext(journal=journal),
        attitude_trigger=False, freefall_time=1.2, freefall_trigger=True, attitude_threshold=70,
    )  # fmt: skip
    assert sets(rig) == ["freefall_time", "freefall_trigger", "attitude_threshold", "attitude_trigger"]
    assert [written.verified for written in report.results] == [True, None, True, None]
    assert report.is_fine
    assert [intent[0] for intent in journal.intents] == [Act.WRITE] * 4
    assert journal.outcomes == dict.fromkeys(range(4), Outcome.CONFIRMED)


def test_a_heartbeat_between_check_and_set_is_looked_into_and_the_set_goes_on() -> None:
    """It may be a restart's, as of a module that was plugged in a moment ago."""
    rig = settled_rig()
    module = rig.bench.module
    end = at_frame(rig.bench, 2, lambda: module.send(HEARTBEAT_REPLY, rig.clock.now_s), code=BOOT_COUNT.code)
    written = write_one(rig, "attitude_threshold", 70)
    end()
    assert written.verified
    assert sets(rig) == ["attitude_threshold"]


@pytest.mark.parametrize("is_unlocked", [False, True])
@pytest.mark.promise("d")
def test_an_active_module_is_not_changed_unless_unlocked(is_unlocked: bool) -> None:
    rig, journal = settled_rig(active=True), FakeJournal()
    report = write(rig, WriteContext(journal=journal, is_unlocked=is_unlocked), freefall_time=1.2, light_threshold=2.0)
    assert sets(rig) == (["freefall_time", "light_threshold"] if is_unlocked else [])
    if not is_unlocked:
        assert [refusal.condition for refusal in report.refusals] == [Interlock.MAY_WRITE]
        assert {written.fault for written in report.results} == {WriteFault.NOT_ALLOWED}
        assert {written.verified for written in report.results} == {False}
        said = why_not_verified(report.results[1], report)
        assert said is not None
        assert said.in_english() == "not sent: The module is ACTIVE: lock it first."
        assert journal.outcomes == {0: Outcome.NOT_SENT}


def test_a_module_that_becomes_active_during_a_pause_is_changed_no_further() -> None:
    rig, journal = settled_rig(), FakeJournal()

    def activate() -> None:
        if len(journal.intents) == 2:
            journal.is_held = True
            rig.bench.module.activate(is_active=True)

    journal.on_begin = activate
    report = write(rig, WriteContext(journal=journal), freefall_time=1.2, light_threshold=2.0)
    assert sets(rig) == ["freefall_time"]
    assert report.results[1].fault is WriteFault.NOT_ALLOWED


@pytest.mark.promise("h")
def test_the_module_is_asked_after_a_wait_for_the_disk() -> None:
    """Somebody else activated it meanwhile: its last report is less than a second old, and from before that."""
    rig, journal = settled_rig(StreamSwitch()), FakeJournal()
    journal.is_held = True
    job = rig.job(write_all(changes(freefall_time=1.2), WriteContext(journal=journal)))
    rig.step_until(lambda: job.frees_line)
    rig.step_for(0.3)
    rig.bench.module.activate(is_active=True)
    journal.flush()
    assert [refusal.condition for refusal in rig.end(job).refusals] == [Interlock.MAY_WRITE]
    assert sets(rig) == []


def test_what_was_found_is_kept_before_the_first_set() -> None:
    rig, kept = settled_rig(), list[Any]()
    sent: list[int] = []

    def store(settings: Any, boot_count: int | None) -> None:
        kept.append((settings["freefall_time_s"], boot_count))
        sent.append(len(sets(rig)))

    write(rig, WriteContext(journal=FakeJournal(), keep_as_found=store), freefall_time=1.2)
    assert sent == [0]
    assert kept == [(1.6, rig.bench.module.memory.boot_count)]


# What takes protection away


RISKY: list[tuple[str, Value]] = [
    ("light_threshold", 0.0),
    ("attitude_trigger", False),
    ("freefall_trigger", False),
    ("attitude_threshold", 54),
    ("attitude_threshold", 91),
    ("freefall_acceleration", 0.7),
    ("freefall_time", 0.49),
]


@pytest.mark.parametrize(("name", "value"), RISKY)
@pytest.mark.promise("g")
def test_nothing_that_takes_protection_away_is_sent_unless_a_person_accepted_it(name: str, value: Value) -> None:
    """By the engine itself, so that no place where a write begins can leave the question out."""
    rig, journal = settled_rig(), FakeJournal()
    harmless: dict[str, Value] = {"light_threshold": 2.0} if name != "light_threshold" else {"attitude_threshold": 60}
    wanted = changes(**harmless, **{name: value})
    others = frozenset(changes(attitude_trigger=True, freefall_trigger=True, attitude_threshold=1))
    for accepted in (frozenset(), others - frozenset(wanted)):
        context = WriteContext(journal=journal, is_unlocked=True, accepted_risks=accepted)
        for procedure in (write_all, set_each):
            report = rig.run(procedure(wanted, context))
            assert [refusal.condition for refusal in report.refusals] == [Interlock.RISK_ACCEPTED]
            assert {written.fault for written in report.results} == {WriteFault.NOT_ALLOWED}
            assert BY_NAME[name].title in report.refusals[0].sentence
    assert (sets(rig), journal.intents) == ([], [])
    context = WriteContext(journal=journal, accepted_risks=frozenset(wanted))
    assert rig.run(write_all(wanted, context)).refusals == ()
    assert set(sets(rig)) == {*harmless, name}


@pytest.mark.parametrize("after_s", [0.02, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("count", [1, 4])
@pytest.mark.promise("f")
def test_a_setting_that_reverts_soon_after_it_was_verified_is_not(after_s: float, count: int) -> None:
    values: dict[str, Any] = dict([*READABLE.items()][:count])
    reverting = BY_NAME[[*values][-1]]
    report = write(ModuleRig(Options(reverts={reverting.code: (after_s, None)})).begin(), **values)
    said = {written.command: written for written in report.results}
    assert said[reverting].fault is WriteFault.CHANGED
    assert not any(written.verified for written in report.results)
    assert not report.is_fine
