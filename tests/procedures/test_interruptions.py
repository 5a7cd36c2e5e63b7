"""What is said of a write and of an act that an end interrupted. Every job and every end: `tests.campaigns.walk`."""

from collections.abc import Callable

import pytest

from app.engine.procedure import Procedure
from app.procedures.act import Performed, perform
from app.procedures.write import SettingChange, WriteContext, WriteFault, WriteReport, write_all
from app.safety.journal import REQUESTS, Act, Outcome
from protocol.catalogue import BY_NAME
from protocol.events import EndReason
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.module_line import ModuleRig
from tests.support.line.sim_line import AnyRig, settled_rig

CHANGES = [SettingChange(BY_NAME[name], value) for name, value in (("freefall_time", 1.2), ("light_threshold", 2.0))]


def act(which: Act, rig: AnyRig, journal: FakeJournal) -> Procedure[Performed]:
    return perform(which, journal, permit=rig.permit(which))


# A write


def test_what_was_verified_was_verified_then_and_the_set_in_flight_is_unknown() -> None:
    rig, journal = settled_rig(), FakeJournal()
    second = BY_NAME["light_threshold"].set(2.0)
    at_each_frame(rig.bench, lambda request: rig.bench.change(mute=True) if request == second else None)
    report: WriteReport = rig.run(write_all(CHANGES, WriteContext(journal=journal)))
    assert report.interrupted is not None
    assert [written.fault for written in report.results] == [WriteFault.VERIFIED_THEN, WriteFault.INTERRUPTED]
    assert [written.verified for written in report.results] == [False, False]
    assert report.results[0].read_back == 1.2
    assert not report.is_fine
    assert [*journal.outcomes.values()] == [Outcome.CONFIRMED, Outcome.UNKNOWN]


def test_a_set_that_waited_for_a_quiet_line_was_not_sent() -> None:
    rig, journal = settled_rig(), FakeJournal()
    job = rig.job(write_all(CHANGES[:1], WriteContext(journal=journal)))
    rig.step_until(lambda: job.pending_ask is not None and job.pending_ask.request == BY_NAME["freefall_time"].set(1.2))
    rig.session.treat_as_another()
    (written,) = rig.end(job).results
    assert (written.is_sent, written.fault) == (False, WriteFault.NOT_SENT)
    assert [*journal.outcomes.values()] == [Outcome.NOT_SENT]
    assert not [request for request in rig.line.requests if request.is_set]


@pytest.mark.parametrize("is_written", [True, False])
@pytest.mark.promise("f")
def test_a_setting_that_reads_otherwise_takes_its_verified_back(is_written: bool) -> None:
    """It changed by itself, or another module answers."""
    rig, journal = settled_rig(), FakeJournal()
    changed = "freefall_time" if is_written else "attitude_threshold"

    job = rig.job(write_all(CHANGES[:1], WriteContext(journal=journal)))
    rig.step_until(lambda: rig.line.requests.count(BY_NAME["freefall_time"].query()) == 3)  # read, and read back twice
    rig.step_for(0.1)
    setattr(rig.bench.module.memory, changed, 99)
    report: WriteReport = rig.end(job)
    assert report.interrupted is not None
    assert report.interrupted.reason is EndReason.CONTRADICTED
    (written,) = report.results
    assert not written.verified
    assert (written.fault is WriteFault.CHANGED) is is_written
    title = BY_NAME[changed].title
    assert title in report.interrupted.sentence
    assert "Two modules on this line?" in report.interrupted.sentence


@pytest.mark.promise("f")
def test_what_was_acknowledged_of_a_trigger_is_unknown_while_a_copy_may_come() -> None:
    rig = ModuleRig().begin()
    job = rig.job(write_all([SettingChange(BY_NAME["freefall_trigger"], True)], WriteContext(journal=FakeJournal())))
    rig.step_until(lambda: rig.module.log.sent(0x17))
    rig.step_for(0.5)
    rig.session.treat_as_another()
    (written,) = job.outcome().results
    assert (written.fault, written.is_acknowledged) == (WriteFault.INTERRUPTED, False)


# An act


@pytest.mark.promise("c")
def test_an_act_that_ends_before_its_frame_is_written_down_as_not_sent() -> None:
    rig, journal = settled_rig(), FakeJournal()
    job = rig.job(act(Act.ACTIVATE, rig, journal))
    rig.step_until(lambda: journal.intents)
    rig.session.treat_as_another()
    assert job.outcome().outcome is Outcome.NOT_SENT
    assert journal.outcomes == {0: Outcome.NOT_SENT}
    assert rig.acts == []


@pytest.mark.parametrize("which", [Act.ACTIVATE, Act.ZERO, Act.FORBID_DEPLOY, Act.DEPLOY])
@pytest.mark.promise("c")
def test_an_act_that_left_is_unknown(which: Act) -> None:
    rig, journal = settled_rig(active=which is Act.DEPLOY), FakeJournal()
    at_each_frame(rig.bench, lambda request: rig.bench.change(mute=True) if request == REQUESTS[which] else None)
    done: Performed = rig.run(act(which, rig, journal))
    assert (done.outcome, journal.outcomes) == (Outcome.UNKNOWN, {0: Outcome.UNKNOWN})
    assert done.sentence.endswith("The module was silent for a moment.")
    assert len(rig.acts) == 1


@pytest.mark.parametrize(
    ("end", "outcome"),
    [
        (lambda rig: rig.module.be_silent(rig.clock(), 60.0), Outcome.CONFIRMED),
        (lambda rig: rig.module.restart(rig.clock(), off_s=0.0), Outcome.UNKNOWN),
        (lambda rig: rig.session.treat_as_another(), Outcome.UNKNOWN),
        (lambda rig: rig.session.close(EndReason.PORT_LOST), Outcome.UNKNOWN),
    ],
    ids=["silent", "restarted", "another", "port lost"],
)
def test_only_silence_after_the_acknowledgement_confirms_a_shutdown(
    end: Callable[[ModuleRig], object], outcome: Outcome
) -> None:
    rig = ModuleRig(Options(ignored_sets={0x12: -1})).begin()
    job = rig.job(act(Act.SHUTDOWN, rig, FakeJournal()))
    rig.step_until(lambda: rig.module.log.sets(0x12))
    rig.step_for(0.1)
    end(rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=3.0)
    assert job.outcome().outcome is outcome


@pytest.mark.promise("c")
def test_a_silence_without_the_acknowledgement_confirms_no_shutdown() -> None:
    """The cable may have been pulled before it arrived."""
    rig = ModuleRig().begin()
    rig.module.at_frame = lambda question: rig.module.be_silent(rig.clock(), 60.0) if question.code == 0x12 else None
    done = rig.run(act(Act.SHUTDOWN, rig, FakeJournal()))
    assert done.outcome is Outcome.UNKNOWN
