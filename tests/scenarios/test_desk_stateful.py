"""Form, ritual, engine and simulated module together, in any order of gestures, faults and accidents.

`python -m tests.soak` runs the same for as long as one likes. The broken programs below show that it finds what it
looks for.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from app.engine.procedure import MAX_LOCKS, Procedure
from app.engine.session import Session
from app.procedures import write_all
from app.procedures.write import Written, write_verified
from app.safety import interlocks as safety
from app.safety.acts import Act
from app.safety.interlocks import InterlockInputs
from app.text.messages import UserMessage
from protocol.catalogue import LOCK, Command, Hazard, Request
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


def test_the_links_own_heartbeat_holds_lock_back_neither_in_its_time_nor_beyond_it() -> None:
    """Found by the soak: 27 LOCKs in ten seconds instead of 50, and the last one 0.8 s later."""
    state = DeskMachine()
    quirks = {"ack": "echo", "freefall_ack": "16", "baud_ack": "old", "clamps": False, "refuses": False, "keeps": True,
              "remembers": False, "seed": 2, "uptime": 0, "rate": 2}  # fmt: skip
    faults = {"direction": "to-host", "double": 0.3, "mute": False, "jitter_ms": 50.0}
    try:
        state.sit_down(quirks=quirks, is_watching=False, wait_s=0.0)
        state.write_in_trouble(faults=faults, raws={"attitude_threshold_deg": 0})
        state.lock(wait_s=0.02)
        state.fault(faults={"direction": "to-host", "drop": 0.1, "mute": True})
        state.change_rate(rate=115200, wait_s=15.0)
        state.all_holds()
        locks = [at for at, request in state.desk.ledger.wire if request == LOCK]
        assert len(locks) == MAX_LOCKS
        assert max(later - sooner for sooner, later in pairwise(locks)) < 0.2
    finally:
        state.teardown()


def test_the_soak_counts_its_rounds_and_steps() -> None:
    stretch = run_for(0.0, 1)
    assert not stretch.failure
    assert stretch.rounds == 1
    assert stretch.steps > 0
