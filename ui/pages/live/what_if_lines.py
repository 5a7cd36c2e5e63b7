"""Draft thresholds as lines in the plots."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from app.samples.step_function import StepFunction, StepPoint
from protocol.translatable import marked
from ui.plots.lanes import Lane, Limit
from ui.style.theme import Meaning


class DraftLine(StepFunction):
    """A constant value over all time; None: no line."""

    def __init__(self) -> None:
        super().__init__()
        self.drafted: float | None = None

    @property
    def value(self) -> float | None:
        return self.drafted

    def between(self, start_s: float, end_s: float) -> list[StepPoint]:  # noqa: ARG002  as of `StepFunction`
        return [] if self.drafted is None else [StepPoint(start_s, self.drafted)]


class DraftLines:
    """The lines, shared by all plots, which have to be drawn again after a change."""

    def __init__(self) -> None:
        self.attitude: Final = DraftLine()
        self.freefall: Final = DraftLine()

    def show(self, attitude_deg: float | None, freefall_g: float | None) -> bool:
        """Sets both lines; returns whether anything changed."""
        is_other = (attitude_deg, freefall_g) != (self.attitude.drafted, self.freefall.drafted)
        self.attitude.drafted, self.freefall.drafted = attitude_deg, freefall_g
        return is_other

    def added_to(self, lanes: Sequence[Lane]) -> tuple[Lane, ...]:
        """`lanes`, of which the first are tilt and acceleration, with these lines added."""
        tilt, acceleration, *others = lanes
        fires = Limit(self.attitude, marked("{value}° draft"), Meaning.ATTENTION, is_draft=True)
        falls = Limit(self.freefall, marked("{value} g draft"), Meaning.ATTENTION, 1, is_draft=True)
        return (
            replace(tilt, limits=(*tilt.limits, fires)),
            replace(acceleration, limits=(*acceleration.limits, falls)),
            *others,
        )
