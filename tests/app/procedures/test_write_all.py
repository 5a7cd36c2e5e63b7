"""Several settings in one go: allowed or refused each time, kept before, logged, claimed no further than it goes."""

from concurrent.futures import Future
from dataclasses import replace
from functools import partial

import pytest

from app.engine.identity import Expected, IdentityEvidence
from app.engine.procedure import Cancelled
from app.engine.snapshots import Snapshot
from app.preflight.evidence import Evidence, FlagState
from app.preflight.run import run_preflight
from app.procedures.act import Armed
from app.procedures.lock import lock
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import SetReply, WriteFault, Written
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all, write_logged
from app.safety.acts import Act
from app.safety.consequences import risks
from app.safety.interlocks import Interlock
from app.safety.journal import NoJournal, Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME, SETTINGS, Request
from protocol.fields import Value, ValueRefused
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import Rig


def changes(**values: Value) -> list[SettingChange]:
    return [SettingChange(BY_NAME[name], value) for name, value in values.items()]


def write(rig: Rig, leave: WriteContext | None = None, **values: Value) -> WriteReport:
    """Write what a person accepted."""
    wanted = changes(**values)
    leave = replace(leave or WriteContext(journal=FakeJournal()), accepted_risks=frozenset(wanted))
    return rig.run(write_all(wanted, leave))


def sets(rig: Rig) -> list[str]:
    return [request.command.name for request in rig.line.requests if request.is_set]


def test_all_are_verified_and_the_baud_rate_comes_last() -> None:
    rig, journal = Rig(), FakeJournal()
    permit = Permit(Act.CHANGE_BAUD, Origin.COMMAND_LINE, rig.clock())
    told: list[Written] = []
    report = write(
        rig, WriteContext(journal=journal, permit=permit, on_written=told.append),
        baud_rate=9600, freefall_time=1.2, attitude_trigger=False, attitude_threshold=70,
    )  # fmt: skip
    assert [written.command.name for written in report.results] == sets(rig)
    assert sets(rig)[-1] == "baud_rate"
    assert [written.verified for written in report.results] == [True, True, None, True]
    assert told == list(report.results)
    assert report.is_fine
    assert rig.line.baud_rate == 9600
    assert [intent[0] for intent in journal.intents] == [Act.WRITE, Act.WRITE, Act.WRITE, Act.CHANGE_BAUD]
    assert journal.outcomes == dict.fromkeys(range(4), Outcome.CONFIRMED)


def test_a_trigger_that_the_module_refuses_is_logged_as_refused_whoever_sets_it() -> None:
    written, enabled = FakeJournal(), FakeJournal()
    report = write(Rig({"refuses": True}), WriteContext(journal=written), attitude_trigger=False)
    assert [result.fault for result in report.results] == [WriteFault.REFUSED]
    checked, rig = Evidence(port="sim"), Rig({"refuses": True})
    rig.bench.module.state.attitude_is_enabled = rig.bench.module.state.freefall_is_enabled = False
    rig.run(run_preflight(checked, is_enabling=True, journal=enabled))
    assert [flag.state for flag in checked.flags.values()] == [FlagState.REFUSED] * 2
    assert (written.outcomes, enabled.outcomes) == ({0: Outcome.REFUSED}, dict.fromkeys(range(2), Outcome.REFUSED))
    assert written.results[0] == enabled.results[0]


def test_one_bad_value_and_nothing_is_sent() -> None:
    rig = Rig()
    with pytest.raises(ValueRefused):
        write(rig, freefall_time=1.2, freefall_acceleration=0.55)
    assert rig.line.sent == b""


@pytest.mark.parametrize("is_unlocked", [False, True])
def test_an_active_module_is_not_changed_unless_unlocked(is_unlocked: bool) -> None:
    rig, journal = Rig({"active": True}), FakeJournal()
    report = write(rig, WriteContext(journal=journal, is_unlocked=is_unlocked), freefall_time=1.2, light_threshold=2.0)
    assert len(journal.intents) == (2 if is_unlocked else 0)
    assert sets(rig) == (["freefall_time", "light_threshold"] if is_unlocked else [])
    if not is_unlocked:
        assert [refusal.condition for refusal in report.refusals] == [Interlock.MAY_WRITE]
        assert {written.fault for written in report.results} == {WriteFault.NOT_ALLOWED}
        assert {written.verified for written in report.results} == {False}


def test_a_module_that_becomes_active_in_between_is_changed_no_further() -> None:
    rig = Rig()

    def activate(request: Request) -> None:
        if request.is_set and request.command.code == 0x22:
            rig.bench.module.activate(is_active=True)
            rig.clock.now_s += 1.5

    at_each_frame(rig.bench, activate)
    report = write(rig, freefall_time=1.2, light_threshold=2.0)
    assert sets(rig) == ["freefall_time"]
    assert report.results[1].fault is WriteFault.NOT_ALLOWED


@pytest.mark.parametrize("what", ["snapshot", "log"])
@pytest.mark.promise("h")
def test_the_module_is_asked_again_after_a_wait_for_the_disk(what: str) -> None:
    """Somebody else activated it meanwhile: its last report is less than a second old, and from before that."""
    rig, journal = Rig(), FakeJournal()
    kept: Future[int] = Future()
    journal.is_held = what == "log"
    leave = WriteContext(journal=journal, store_snapshot=(lambda _snapshot: kept) if what == "snapshot" else None)
    run = rig.started(write_all(changes(freefall_time=1.2), leave))
    rig.session.run_in_background(watch(StreamSwitch(is_wanted=False)))
    rig.step_until(lambda: run.waiting_since() is not None)
    rig.step_for(0.3)
    rig.bench.module.activate(is_active=True)
    kept.set_result(1)
    journal.flush()
    assert [refusal.condition for refusal in rig.end(run).refusals] == [Interlock.MAY_WRITE]
    assert sets(rig) == []


def test_a_report_that_came_unasked_does_not_allow_writing() -> None:
    """On a line that doubles and dawdles, the second answer to a status comes late; found by the stateful test."""
    for seed in range(5):
        rig = Rig({"seed": seed})
        rig.bench.change(double=1.0, direction="both", jitter_ms=500.0)
        rig.run(lock())
        rig.bench.module.activate(is_active=True)
        rig.step_for(1.1)
        report = rig.run(
            write_all([SettingChange(BY_NAME["light_threshold"], 2.0)], WriteContext(journal=FakeJournal()))
        )
        assert BY_NAME["light_threshold"].set(2.0) not in rig.line.requests
        assert report.refusals


def test_nothing_is_written_while_something_is_armed() -> None:
    rig = Rig()
    report = write(rig, WriteContext(journal=FakeJournal(), armed=Armed(Act.DEPLOY)), freefall_time=1.2)
    assert sets(rig) == []
    assert [refusal.sentence for refusal in report.refusals] == ["Already armed: Deploy."]


def test_nothing_is_kept_of_a_module_that_nobody_has_confirmed() -> None:
    rig = Rig(expected=Expected(IdentityEvidence()))
    kept: list[Snapshot] = []
    write(rig, WriteContext(journal=FakeJournal(), store_snapshot=kept.append), freefall_time=1.2)
    assert (kept, sets(rig)) == ([], [])


def test_a_setting_is_written_also_where_nothing_can_be_logged_but_not_the_baud_rate() -> None:
    rig = Rig()
    permit = Permit(Act.CHANGE_BAUD, Origin.COMMAND_LINE, rig.clock())
    report = write(rig, WriteContext(journal=NoJournal(), permit=permit), freefall_time=1.2, baud_rate=9600)
    assert sets(rig) == ["freefall_time"]
    assert [refusal.condition for refusal in report.refusals] == [Interlock.INTENT_DURABLE]


RISKY = [
    (command.name, value)
    for command in SETTINGS
    if command.write is not None
    for value in (command.write.decode(raw) for raw in sorted(command.write.allowed))
    if risks(command, value)
]


def test_some_values_of_each_threshold_and_trigger_are_risky_and_none_of_the_others() -> None:
    names = {name for name, _ in RISKY}
    assert names == {"attitude_threshold", "freefall_acceleration", "freefall_time", "light_threshold",
                     "attitude_trigger", "freefall_trigger"}  # fmt: skip
    assert [value for name, value in RISKY if name.endswith("trigger")] == [False, False]


@pytest.mark.parametrize(("name", "value"), RISKY[::7] + RISKY[-2:])
@pytest.mark.promise("g")
def test_nothing_that_takes_protection_away_is_sent_unless_a_person_accepted_it(name: str, value: Value) -> None:
    """By the engine itself, so that no place where a write begins can leave the question out."""
    rig, journal = Rig(), FakeJournal()
    harmless: dict[str, Value] = {"light_threshold": 2.0} if name != "light_threshold" else {"attitude_threshold": 60}
    wanted = changes(**harmless, **{name: value})
    others = frozenset(changes(attitude_trigger=True, freefall_trigger=True, attitude_threshold=1))
    for accepted in (frozenset(), others - frozenset(wanted)):
        leave = WriteContext(journal=journal, is_unlocked=True, accepted_risks=accepted)
        report = rig.run(write_all(wanted, leave))
        assert [refusal.condition for refusal in report.refusals] == [Interlock.RISK_ACCEPTED]
        assert {written.fault for written in report.results} == {WriteFault.NOT_ALLOWED}
        written, refused = rig.run(write_logged(wanted[1], leave, {}))
        assert (written.heard, [one.condition for one in refused]) == (SetReply.NOT_SENT, [Interlock.RISK_ACCEPTED])
        assert BY_NAME[name].title in refused[0].sentence
    assert (sets(rig), journal.intents) == ([], [])
    leave = WriteContext(journal=journal, accepted_risks=frozenset(wanted))
    assert rig.run(write_all(wanted, leave)).refusals == ()
    assert sets(rig) == [*harmless, name]


def test_the_baud_rate_needs_its_own_permit() -> None:
    rig = Rig()
    report = write(rig, baud_rate=9600)
    assert [refusal.condition for refusal in report.refusals] == [Interlock.CONFIRMED]
    assert report.results[0].fault is WriteFault.NOT_ALLOWED


def test_what_was_written_before_a_restart_is_claimed_no_longer() -> None:
    rig = Rig()
    at_each_frame(
        rig.bench, lambda request: rig.bench.restart() if request == BY_NAME["attitude_threshold"].set(70) else None
    )
    journal = FakeJournal()
    wanted: dict[str, Value] = {"attitude_trigger": False, "freefall_time": 1.2, "attitude_threshold": 70}
    report = write(rig, WriteContext(journal=journal), **wanted, light_threshold=2.0)
    faults = {written.command.name: written.fault for written in report.results}
    assert faults.pop("freefall_time") is faults.pop("attitude_threshold") is WriteFault.RESTARTED
    assert set(faults.values()) == {None}, "set after it"
    assert [*journal.outcomes.values()][1:] == [Outcome.UNKNOWN, Outcome.CONFIRMED, Outcome.CONFIRMED]


def test_a_silent_module_is_asked_no_further() -> None:
    rig, journal = Rig(), FakeJournal()
    rig.bench.change(mute=True)
    report = write(rig, WriteContext(journal=journal, is_unlocked=True), freefall_time=1.2, light_threshold=2.0)
    assert {written.heard for written in report.results} == {SetReply.NOT_SENT}
    assert {refusal.condition for refusal in report.refusals} == {Interlock.ONLINE}
    assert sets(rig) == []
    assert not report.is_fine


@pytest.mark.parametrize(
    ("options", "fault"), [({}, WriteFault.NO_LAST_READING), ({"refuses": True}, WriteFault.REFUSED)]
)
def test_a_module_that_falls_silent_before_the_last_reading_has_nothing_verified(
    options: dict[str, object], fault: WriteFault
) -> None:
    rig = Rig(options)
    leave = WriteContext(journal=FakeJournal(), on_written=lambda _written: rig.bench.change(mute=True))
    (written,) = write(rig, leave, light_threshold=2.0).results
    assert (written.fault, written.verified) == (fault, False)


def test_a_setting_that_is_not_read_at_the_end_is_named_and_may_have_changed() -> None:
    rig = Rig()
    mute = frozenset((BY_NAME["freefall_time"].code,))
    leave = WriteContext(journal=FakeJournal(), on_written=lambda _written: rig.bench.change(mute_codes=mute))
    report = write(rig, leave, light_threshold=2.0)
    assert [written.verified for written in report.results] == [True]
    assert ([command.key for command in report.unread], report.is_fine) == (["freefall_time_s"], False)


def test_without_a_boot_count_at_the_end_nothing_is_verified() -> None:
    """A restart in between could not be excluded."""
    rig = Rig()
    mute = partial(rig.bench.change, mute_codes=frozenset({BY_NAME["boot_count"].code}))
    leave = WriteContext(journal=FakeJournal(), on_written=lambda _written: mute())
    (written,) = write(rig, leave, light_threshold=2.0).results
    assert (written.fault, written.verified) == (WriteFault.NO_LAST_READING, False)
    assert rig.line.requests.count(BY_NAME["attitude_threshold"].query()) == 2 * 3  # before, and twice at the end


def test_what_ends_a_writing_early_is_raised_and_the_intent_is_settled() -> None:
    rig, journal = Rig(), FakeJournal()
    run = rig.started(write_all(changes(freefall_time=1.2, attitude_threshold=70), WriteContext(journal=journal)))
    rig.step_until(lambda: sets(rig))
    run.cancel()
    rig.step_until(lambda: run.is_done)
    assert isinstance(run.error, Cancelled)
    assert list(journal.outcomes.values()) == [Outcome.UNKNOWN]


def test_the_log_says_that_the_module_refused_a_value() -> None:
    rig, journal = Rig({"refuses": True}), FakeJournal()
    (written,) = write(rig, WriteContext(journal=journal), light_threshold=2.0).results
    assert (written.read_back, written.fault) == (1.8, WriteFault.REFUSED)
    assert list(journal.outcomes.values()) == [Outcome.REFUSED]
