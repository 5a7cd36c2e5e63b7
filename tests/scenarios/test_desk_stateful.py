"""Form, ritual, engine and simulated module together, in any order of gestures, faults and accidents.

`python -m tests.soak` runs the same for as long as one likes. The broken programs below show that it finds what it
looks for.
"""

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from app.engine.procedure import Procedure
from app.engine.session import Session
from app.procedures import write_all
from app.procedures.write import Written, write_verified
from app.safety import interlocks as safety
from app.safety.acts import Act
from app.safety.interlocks import InterlockInputs
from app.text.messages import UserMessage
from protocol.catalogue import Command, Hazard, Request
from protocol.fields import Value
from tests.scenarios.desk_machine import DeskMachine
from tests.soak.stateful import run_for

DeskMachine.TestCase.settings = settings(
    max_examples=max(6, settings().max_examples // 8),
    stateful_step_count=30,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
TestDesk = DeskMachine.TestCase

_FIND_ONE = settings(
    max_examples=300,
    stateful_step_count=40,
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
    report_multiple_bugs=False,
)


def send_sets_again(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Request, "is_repeatable", property(lambda request: request.hazard is not Hazard.DANGEROUS))


def believe_acknowledgements(patch: pytest.MonkeyPatch) -> None:
    def write_believed(command: Command, value: Value) -> Procedure[Written]:
        written = yield from write_verified(command, value)
        return replace(written, verified=True, fault=None) if written.is_acknowledged else written

    patch.setattr(write_all, "write_verified", write_believed)


def go_on_after_lock(patch: pytest.MonkeyPatch) -> None:
    permitted = safety._permitted

    def permit_all(act: Act, now_is: InterlockInputs, missing: str) -> UserMessage | None:
        return permitted(act, replace(now_is, overtaken_at=None), missing)

    patch.setattr(safety, "_permitted", permit_all)
    patch.setattr(Session, "_withhold_dangerous", lambda session: None)


@pytest.mark.parametrize("break_it", [send_sets_again, believe_acknowledgements, go_on_after_lock])
def test_a_faulty_program_is_detected(
    break_it: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    break_it(monkeypatch)
    with pytest.raises(AssertionError):
        run_state_machine_as_test(seed(7)(type("BrokenDesk", (DeskMachine,), {})), settings=_FIND_ONE)


def test_the_soak_counts_its_rounds_and_steps() -> None:
    stretch = run_for(0.0, 1)
    assert not stretch.failure
    assert stretch.rounds == 1
    assert stretch.steps > 0
