"""Calibrates the light threshold by measuring with the bay closed and open (E11).

The proposal is the step in the middle between the two bands of readings, so that both sides have the same margin. The
vendor's advice, "the reading with the bay fully open", leaves none on the open side.
"""

from enum import Enum
from statistics import median
from typing import NamedTuple

from app.engine.procedure import Pause, Procedure, Report, ask_value
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from protocol.catalogue import BOOT_COUNT, BY_NAME, TENTH_VOLT
from protocol.translatable import marked

SAMPLES = 20
EVERY_S = 0.1
ENOUGH_SAMPLES = 10
# Unanswered questions after which a measurement ends.
MAX_LOST = 10


class Band(NamedTuple):
    """Readings at one position of the bay, as bytes in order."""

    raws: tuple[int, ...]

    @property
    def is_enough(self) -> bool:
        return len(self.raws) >= ENOUGH_SAMPLES

    @property
    def low_v(self) -> float:
        return min(self.raws) / TENTH_VOLT.per_unit

    @property
    def high_v(self) -> float:
        return max(self.raws) / TENTH_VOLT.per_unit

    @property
    def median_v(self) -> float:
        return median(self.raws) / TENTH_VOLT.per_unit


def measure_light(*, step_of: tuple[int, int] | None = None) -> Procedure[Band]:
    """Read the light several times at the present position of the bay. `step_of`: the step and the steps of a test."""
    raws: list[int] = []
    lost = 0
    while len(raws) < SAMPLES and lost < MAX_LOST:
        yield Report(*(step_of or (len(raws), SAMPLES)), marked("Measuring the light"))
        light_v = yield from ask_value(BY_NAME["light"])
        if light_v is not None:
            raws.append(TENTH_VOLT.encode(light_v))
        else:
            lost += 1
        yield Pause(EVERY_S)
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    return Band(tuple(raws))


# Why there is no proposal.
TOO_FEW = message(marked("Too few readings: measure again."))
TOO_CLOSE = message(marked("Closed and open bay read too much alike: check the sensor."))


class LightDirection(Enum):
    """The value is a sentence in English, translatable."""

    RISES = marked("More light reads higher.")
    FALLS = marked("More light reads lower.")


class Proposal(NamedTuple):
    threshold_v: float
    direction: LightDirection
    margin_v: float  # from the threshold to the nearest reading

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        text = marked("{threshold:.1f} V: at least {margin:.1f} V from closed and from open.")
        return tr(text, threshold=self.threshold_v, margin=self.margin_v)


def propose(closed: Band, opened: Band) -> Proposal | UserMessage:
    """The threshold in the middle of the gap, or why there is none."""
    if not (closed.is_enough and opened.is_enough):
        return TOO_FEW
    direction = LightDirection.FALLS if min(opened.raws) < min(closed.raws) else LightDirection.RISES
    low, high = (closed, opened) if direction is LightDirection.RISES else (opened, closed)
    below, above = max(low.raws), min(high.raws)
    threshold = (below + above) // 2
    if not below < threshold < above:
        return TOO_CLOSE
    # In the middle, and so nearer to the lower side where the gap is no even number of steps.
    return Proposal(threshold / TENTH_VOLT.per_unit, direction, (threshold - below) / TENTH_VOLT.per_unit)
