"""Parachute bay closed and open: the light of both, and its margin to the threshold."""

from functools import partial

from app.engine.procedure import Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import NOT_READ, Measure, PersonSteps, read_setting, require_locked, wait_for_person
from app.procedures.light import Band, CalibrationFault, LightDirection, measure_light, propose
from app.text.messages import UserError, UserMessage, message
from protocol.translatable import marked

# One step of the sensor: a threshold on a reading is none.
MIN_MARGIN_V = 0.1
ROUNDING_V = 1e-6
STEPS = 2
CLOSE, OPEN = marked("Close the bay"), marked("Open the bay fully")
BAY_CLOSED, BAY_OPEN = marked("Bay closed"), marked("Bay open")


def prepare_bay() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from read_setting("light_threshold")
    return partial(_measure, threshold)


def _measure(threshold: float, steps: PersonSteps) -> Procedure[GuidedResult]:
    yield Report(0, STEPS, CLOSE)
    closed = yield from _measure_light(steps, 0)
    yield Report(1, STEPS, OPEN)
    opened = yield from _measure_light(steps, 1)
    yield from require_locked()
    return _result(closed, opened, threshold)


def _measure_light(steps: PersonSteps, step: int) -> Procedure[Band]:
    yield from wait_for_person(steps)
    band = yield from measure_light(step_of=(step, STEPS))
    if not band.is_enough:
        raise UserError(NOT_READ, what=message(marked("Light")))
    return band


def _result(closed: Band, opened: Band, threshold: float) -> GuidedResult:
    if propose(closed, opened) is CalibrationFault.TOO_CLOSE:
        # The bay was not opened, or the sensor does not see it: no threshold tells the two apart.
        differ = message(marked("closed and open differ"))
        alike = [
            MeasuredValue(message(name), message(f"{band.median_v:.1f} V"), differ, GuidedVerdict.FAILED)
            for name, band in ((BAY_CLOSED, closed), (BAY_OPEN, opened))
        ]
        return GuidedResult(GuidedKind.BAY, tuple(alike), message(CalibrationFault.TOO_CLOSE.value))
    rises = opened.median_v > closed.median_v
    if rises:
        closed_margin, open_margin = threshold - closed.high_v, opened.low_v - threshold
    else:
        closed_margin, open_margin = closed.low_v - threshold, threshold - opened.high_v
    tolerance = message(marked("≥ {margin:.1f} V from {threshold:.1f} V"), margin=MIN_MARGIN_V, threshold=threshold)
    measured = (
        _margin_row(BAY_CLOSED, closed, closed_margin, tolerance),
        _margin_row(BAY_OPEN, opened, open_margin, tolerance),
    )
    advice = None
    if any(row.verdict is GuidedVerdict.FAILED for row in measured):
        advice = message(marked("Measure the light threshold."))
    elif not rises:
        advice = message(LightDirection.FALLS.value)
    return GuidedResult(GuidedKind.BAY, measured, advice)


def _margin_row(name: str, band: Band, margin: float, tolerance: UserMessage) -> MeasuredValue:
    shown = message(f"{band.median_v:.1f} V ({margin:+.1f} V)")
    return MeasuredValue(message(name), shown, tolerance, passed_if(margin >= MIN_MARGIN_V - ROUNDING_V))


def light_direction(result: GuidedResult) -> LightDirection | None:
    """Which way the light was measured to read; None where the result is of another test, or tells nothing of it."""
    if result.kind is not GuidedKind.BAY or result.verdict is not GuidedVerdict.PASSED:
        return None
    return LightDirection.RISES if result.advice is None else LightDirection.FALLS
