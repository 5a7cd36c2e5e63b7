"""A module that changes or restarts while it is checked: the check that stands against it is named."""

from collections.abc import Callable

import pytest

from app.preflight.verdict import Verdict
from tests.support.line.odd_module import restart_silently
from tests.support.line.sim_line import Rig
from tests.support.records.preflight_rig import Arrange, Fault, assert_only_questions, check, on_request


def later(code: int, number: int, after_s: float, act: Callable[[Rig], object]) -> Arrange:
    """Do this so long after the `number`-th frame of this code."""
    return on_request(code, number, lambda rig: rig.bench.module.plan(rig.clock() + after_s, lambda _at_s: act(rig)))


def moves(name: str, raw: int) -> Callable[[Rig], None]:
    return lambda rig: setattr(rig.bench.module.memory, name, raw)


def restarts(rig: Rig) -> None:
    restart_silently(rig.bench, rig.clock())


LIES = {
    "threshold moves 50 ms after it was read": ("read_twice", later(0x20, 1, 0.05, moves("attitude_threshold", 20))),
    "threshold moves 500 ms after it was read": ("read_twice", later(0x20, 1, 0.5, moves("attitude_threshold", 20))),
    "free-fall time moves when the light is read": ("read_twice", later(0x14, 1, 0.0, moves("freefall_time", 5))),
    "enabling a trigger moves the threshold": ("read_twice", later(0x16, 1, 0.0, moves("attitude_threshold", 20))),
    "to a value that the advice allows": ("read_twice", later(0x17, 1, 0.5, moves("attitude_threshold", 80))),
    "restarts silently after a trigger was enabled": ("attitude_trigger", later(0x16, 1, 0.03, restarts)),
    "restarts silently while it is measured": ("connection", later(0x32, 6, 0.0, restarts)),
}


@pytest.mark.parametrize("name", LIES)
@pytest.mark.promise("f")
def test_what_moves_is_named(name: str) -> None:
    named, arrange = LIES[name]
    checked = check(Fault(frozenset((named,)), arrange=arrange))
    assert checked.assessment.verdict is Verdict.NO_GO
    assert named in checked.against
    assert_only_questions(checked)
