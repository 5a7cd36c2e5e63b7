"""Another module, that runs already, follows behind the open port at any frame of a procedure."""

from collections.abc import Callable

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Procedure
from app.procedures.act import perform
from app.procedures.baud import change_baud
from app.procedures.history import read_history
from app.procedures.read import read_everything
from app.procedures.write import SettingChange, WriteContext, set_each, write_all
from app.safety.acts import Act
from protocol.catalogue import BY_NAME
from tests.support.journals import FakeJournal
from tests.support.line.exchange import ExchangedRig
from tests.support.thorough import some

Begin = Callable[[ExchangedRig], Procedure[object]]
EDITS = {"attitude_threshold": 75, "freefall_acceleration": 0.5, "light_threshold": 1.5}


def act(which: Act) -> Begin:
    return lambda rig: perform(which, FakeJournal(), permit=rig.permit(which))


def write(**values: float) -> Begin:
    changes = [SettingChange(BY_NAME[name], value) for name, value in values.items()]
    return lambda _rig: write_all(changes, WriteContext(journal=FakeJournal()))


def enable(_rig: ExchangedRig) -> Procedure[object]:
    changes = [SettingChange(BY_NAME[name], True) for name in ("freefall_trigger", "attitude_trigger")]
    return set_each(changes, WriteContext(journal=FakeJournal()))


PROCEDURES: dict[str, tuple[Begin, range]] = {
    "activate": (act(Act.ACTIVATE), range(1, 10)),
    "shut down": (act(Act.SHUTDOWN), range(1, 8)),
    "forbid": (act(Act.FORBID_DEPLOY), range(1, 8)),
    "zero": (act(Act.ZERO), range(1, 44, 3)),
    "settings": (write(**EDITS), range(1, 38)),
    "triggers": (enable, range(1, 44, 3)),
}


@pytest.mark.parametrize("boots", [37, 90], ids=["the same boot count", "a higher one"])
@pytest.mark.parametrize("gap_s", [0.5, 0.8, 2.0])
@pytest.mark.parametrize("name", PROCEDURES)
@pytest.mark.promise("a")
def test_nothing_reaches_it_that_was_decided_for_the_one_before(name: str, gap_s: float, boots: int) -> None:
    begin, frames = PROCEDURES[name]
    for frame in some(frames, one_in=3, first=boots + round(gap_s * 10)):
        rig = ExchangedRig(frame, boots=boots, gap_s=gap_s)
        job = rig.job(begin(rig))
        rig.step_until(lambda rig=rig, job=job: rig.is_exchanged or job.has_ended)
        was_exchanged = rig.is_exchanged
        rig.step_for(3.0)
        rig.step_until(lambda job=job: job.has_ended)
        assert rig.to_second == [], frame
        result = None if job.error is not None else job.outcome()
        is_interrupted = isinstance(job.error, Interrupted) or getattr(result, "interrupted", None) is not None
        # A shut down module falls silent, and what ended before the exchange was not interrupted.
        assert is_interrupted or not was_exchanged or name == "shut down", frame


@pytest.mark.parametrize("gap_s", [0.5, 1.5])
def test_the_baud_rate_is_not_changed_at_it_either(gap_s: float) -> None:
    for frame in range(1, 6):
        rig = ExchangedRig(frame, gap_s=gap_s)
        rig.run(change_baud(9600, FakeJournal(), permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)
        assert rig.to_second == [], frame


@pytest.mark.parametrize("procedure", [read_everything, read_history], ids=["everything", "history"])
@pytest.mark.promise("f")
def test_nothing_is_read_of_both(procedure: Callable[[], Procedure[object]]) -> None:
    for frame in range(1, 12):
        rig = ExchangedRig(frame)
        with pytest.raises(Interrupted):
            rig.run(procedure())
        assert rig.is_exchanged, frame
