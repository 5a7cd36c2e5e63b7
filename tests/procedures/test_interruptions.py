"""Each procedure ends with its conversation, whatever ended that: it sends nothing more, says why, leaves nothing."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Procedure
from app.procedures.act import Performed, perform
from app.procedures.find import find_rate
from app.procedures.history import read_history
from app.procedures.light import measure_light
from app.procedures.read import read_everything, read_settings, who_is_there
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import SettingChange, WriteContext, WriteFault, WriteReport, set_each, write_all
from app.safety.journal import REQUESTS, Act, Outcome
from protocol.catalogue import BY_NAME
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import Rig, settled_rig

Begin = Callable[[Rig, FakeJournal], Procedure[Any]]
CHANGES = [SettingChange(BY_NAME[name], value) for name, value in (("freefall_time", 1.2), ("light_threshold", 2.0))]
FLAGS = [SettingChange(BY_NAME["freefall_trigger"], True), SettingChange(BY_NAME["attitude_trigger"], True)]


def act(which: Act) -> Begin:
    return lambda rig, journal: perform(which, journal, permit=rig.permit(which))


PROCEDURES: Mapping[str, Begin] = {
    "read everything": lambda _rig, _journal: read_everything(),
    "read settings": lambda _rig, _journal: read_settings(),
    "who is there": lambda _rig, _journal: who_is_there(),
    "history": lambda _rig, _journal: read_history(),
    "light": lambda _rig, _journal: measure_light(),
    "stream": lambda _rig, _journal: watch(StreamSwitch()),
    "write": lambda _rig, journal: write_all(CHANGES, WriteContext(journal=journal)),
    "triggers": lambda _rig, journal: set_each(FLAGS, WriteContext(journal=journal)),
    "activate": act(Act.ACTIVATE),
    "zero": act(Act.ZERO),
    "shut down": act(Act.SHUTDOWN),
    "forbid": act(Act.FORBID_DEPLOY),
}


def mute(rig: Rig) -> None:
    rig.bench.change(mute=True)


def contradict(rig: Rig) -> None:
    rig.bench.module.memory.boot_count += 1  # as another module in its place, without a silence


REASONS: Mapping[EndReason, Callable[[Rig], object]] = {
    EndReason.RESTARTED: lambda rig: rig.bench.restart(),
    EndReason.SILENT: mute,
    EndReason.CONTRADICTED: contradict,
    EndReason.PORT_LOST: lambda rig: rig.session.close(EndReason.PORT_LOST),
    EndReason.CLOSED: lambda rig: rig.session.close(EndReason.CLOSED),
    EndReason.SLEPT: lambda rig: setattr(rig.clock, "now_s", rig.clock.now_s + 60.0),
    EndReason.ANOTHER: lambda rig: rig.session.treat_as_another(),
    EndReason.RATE_CHANGED: lambda rig: rig.job(find_rate(9600), is_urgent=True, outlives=True),
}


@pytest.mark.parametrize("reason", REASONS, ids=lambda reason: reason.value)
@pytest.mark.parametrize("name", PROCEDURES)
@pytest.mark.promise("a")
def test_each_procedure_ends_with_the_conversation(name: str, reason: EndReason) -> None:
    # Late in the procedure, but before its last frame: the shortest has four.
    for frame in (1, 2, 3):
        rig, journal = settled_rig(), FakeJournal()
        asked = len(rig.line.requests)
        job = rig.job(PROCEDURES[name](rig, journal))
        rig.step_until(lambda rig=rig, asked=asked, frame=frame: len(rig.line.requests) >= asked + frame)
        changed = rig.acts
        REASONS[reason](rig)
        if not rig.line.is_closed:
            rig.step_until(lambda job=job: job.has_ended, limit_s=5.0)
            rig.session.step(0.0)
            assert not rig.session.is_busy or reason is EndReason.RATE_CHANGED
        assert job.has_ended
        result = None if job.error is not None else job.outcome()
        interrupted = job.error if result is None else result.interrupted
        assert isinstance(interrupted, Interrupted), (frame, interrupted, result)
        assert interrupted.reason in (reason, *_ALSO.get(reason, ()))
        assert interrupted.sentence.endswith((".", "?"))
        assert "{" not in interrupted.sentence
        assert changed == rig.acts, "nothing was sent afterwards"
        assert not any(outcome is Outcome.CONFIRMED for outcome in journal.outcomes.values())


# The boot count may tell of a restart before its heartbeats do.
_ALSO = {
    EndReason.CONTRADICTED: (EndReason.RESTARTED,),
    EndReason.RESTARTED: (EndReason.CONTRADICTED,),
}


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


@pytest.mark.parametrize("is_written", [True, False])
@pytest.mark.promise("f")
def test_a_setting_that_reads_otherwise_takes_its_verified_back(is_written: bool) -> None:
    """It changed by itself, or another module answers."""
    rig, journal = settled_rig(), FakeJournal()
    changed = "freefall_time" if is_written else "attitude_threshold"

    def change(_written: object) -> None:
        setattr(rig.bench.module.memory, changed, 99)

    context = WriteContext(journal=journal, on_written=change)
    report: WriteReport = rig.run(write_all(CHANGES[:1], context))
    assert report.interrupted is not None
    assert report.interrupted.reason is EndReason.CONTRADICTED
    (written,) = report.results
    assert not written.verified
    assert (written.fault is WriteFault.CHANGED) is is_written
    other = None if report.changed is None else report.changed.after.command.name
    assert other == (None if is_written else "attitude_threshold")
    assert "Two modules on this line?" in report.interrupted.sentence


# An act


@pytest.mark.parametrize("which", [Act.ACTIVATE, Act.ZERO, Act.FORBID_DEPLOY, Act.DEPLOY])
@pytest.mark.promise("c")
def test_an_act_that_left_is_unknown(which: Act) -> None:
    rig, journal = settled_rig(active=which is Act.DEPLOY), FakeJournal()
    at_each_frame(rig.bench, lambda request: rig.bench.change(mute=True) if request == REQUESTS[which] else None)
    done: Performed = rig.run(act(which)(rig, journal))
    assert (done.outcome, journal.outcomes) == (Outcome.UNKNOWN, {0: Outcome.UNKNOWN})
    assert done.sentence.endswith("The module was silent for a moment.")
    assert len(rig.acts) == 1


@pytest.mark.parametrize(
    ("end", "outcome"),
    [
        (lambda _rig: None, Outcome.CONFIRMED),
        (lambda rig: rig.bench.restart(), Outcome.UNKNOWN),
        (lambda rig: rig.session.treat_as_another(), Outcome.UNKNOWN),
        (lambda rig: rig.session.close(EndReason.PORT_LOST), Outcome.UNKNOWN),
    ],
    ids=["silent", "restarted", "another", "port lost"],
)
def test_only_silence_after_the_acknowledgement_confirms_a_shutdown(
    end: Callable[[Rig], object], outcome: Outcome
) -> None:
    rig = settled_rig(shuts_down=False)
    job = rig.job(act(Act.SHUTDOWN)(rig, FakeJournal()))
    rig.step_until(lambda: REQUESTS[Act.SHUTDOWN].encode() in rig.acts)
    rig.step_for(0.1)
    if outcome is Outcome.CONFIRMED:
        rig.bench.change(mute=True)
    end(rig)
    if not rig.line.is_closed:
        rig.step_until(lambda: job.has_ended, limit_s=3.0)
    assert job.outcome().outcome is outcome
