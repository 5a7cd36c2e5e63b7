"""The machine of `tests.scenarios.desk_machine` for as long as one likes, each round from a seed of its own."""

import time
import traceback
from dataclasses import dataclass
from typing import Final

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.scenarios.desk_machine import DeskMachine

_ROUNDS: Final = settings(
    max_examples=4,
    stateful_step_count=50,
    deadline=None,
    database=None,
    phases=(Phase.generate, Phase.shrink),
    suppress_health_check=tuple(HealthCheck),
    report_multiple_bugs=False,
    print_blob=False,
)


@dataclass(frozen=True, slots=True)
class Stretch:
    """`failure`: the shortest sequence of steps after which something did not hold, or empty."""

    steps: int
    rounds: int
    failure: str = ""


def run_for(seconds: float, first_seed: int) -> Stretch:
    """Round after round until the time is over or something does not hold; the round under way is finished."""
    end_s = time.monotonic() + seconds
    before, rounds = DeskMachine.steps, 0
    while True:
        machine = seed(first_seed + rounds)(type("SoakedDesk", (DeskMachine,), {}))
        rounds += 1
        try:
            run_state_machine_as_test(machine, settings=_ROUNDS)
        except Exception as error:  # noqa: BLE001  whatever it is, it is told with its steps
            told = "".join(traceback.format_exception(error, limit=-4))
            return Stretch(DeskMachine.steps - before, rounds, f"seed {first_seed + rounds - 1}\n{told}")
        if time.monotonic() >= end_s:
            return Stretch(DeskMachine.steps - before, rounds)
