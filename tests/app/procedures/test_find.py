"""The search for a module's baud rate: "no" is said only after the vendor's second."""

import pytest

from app.procedures.baud import look_for
from app.procedures.find import find_rate
from app.procedures.read import read_everything
from tests.support.line.sim_line import Rig


@pytest.mark.parametrize("delay_ms", [0.0, 400.0, 760.0, 900.0, 980.0])
@pytest.mark.parametrize("rate", [115200, 9600])
def test_a_module_that_uses_the_vendors_second_is_found(rate: int, delay_ms: float) -> None:
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(find_rate()).baud_rate == rate
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(look_for(57600, 38400)) == rate


def test_a_slow_module_that_does_not_know_a_question_is_not_called_dead() -> None:
    rig = Rig({"delay_ms": 900.0, "mute_codes": "14"})
    everything = rig.run(read_everything())
    assert not everything.is_line_dead
    assert set(everything.errors) == {"light_v"}
