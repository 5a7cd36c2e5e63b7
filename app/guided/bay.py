"""Parachute bay closed and open: the light of both, and its margin to the threshold."""

from functools import partial

from app.engine.device import DeviceView
from app.engine.procedure import EngineView, Inspect, Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import (
    NOT_READ,
    Measure,
    PersonSteps,
    read_setting,
    require_locked,
    require_start,
    wait_for_person,
)
from app.procedures.light_calibration import Band, CalibrationFault, LightDirection, measure_light, propose
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked

MIN_MARGIN_V = 0.1
"""One step of the sensor: a threshold on a reading is none."""
ROUNDING_V = 1e-6
STEPS = 2
CLOSE, OPEN = marked("Close the bay"), marked("Open the bay fully")


def prepare_bay() -> Procedure[Measure]:
    begin = yield from require_locked()
    threshold = yield from read_setting("light_threshold")
    return partial(_measure, begin, threshold)


def _measure(begin: DeviceView, threshold: float, steps: PersonSteps) -> Procedure[GuidedResult]:
    yield Report(0, STEPS, CLOSE)
    closed = yield from _measure_light(begin, steps, 0)
    yield Report(1, STEPS, OPEN)
    opened = yield from _measure_light(begin, steps, 1)
    yield from require_locked()
    return _result(closed, opened, threshold)


def _measure_light(begin: DeviceView, steps: PersonSteps, step: int) -> Procedure[Band]:
    yield from wait_for_person(steps)
    view: EngineView = yield Inspect()
    require_start(view, begin)
    band = yield from measure_light(step_of=(step, STEPS))
    if not band.is_enough:
        raise UserError(NOT_READ, what=message(marked("Light")))
    return band


def _result(closed: Band, opened: Band, threshold: float) -> GuidedResult:
    if propose(closed, opened) is CalibrationFault.TOO_CLOSE:
        return _alike(closed, opened)
    rises = opened.median_v > closed.median_v
    margins = (
        (threshold - closed.high_v, opened.low_v - threshold)
        if rises
        else (closed.low_v - threshold, threshold - opened.high_v)
    )
    tolerance = message(marked("≥ {margin:.1f} V from {threshold:.1f} V"), margin=MIN_MARGIN_V, threshold=threshold)
    measured = tuple(
        MeasuredValue(
            message(name),
            message(f"{band.median_v:.1f} V ({margin:+.1f} V)"),
            tolerance,
            passed_if(margin >= MIN_MARGIN_V - ROUNDING_V),
            margin,
        )
        for name, band, margin in (
            (marked("Bay closed"), closed, margins[0]),
            (marked("Bay open"), opened, margins[1]),
        )
    )
    advice = None if rises else message(LightDirection.FALLS.value)
    if any(margin < MIN_MARGIN_V - ROUNDING_V for margin in margins):
        advice = message(marked("Measure the light threshold."))
    return GuidedResult(GuidedKind.BAY, measured, advice)


def _alike(closed: Band, opened: Band) -> GuidedResult:
    """The bay was not opened, or the sensor does not see it: no threshold tells the two apart."""
    tolerance = message(marked("closed and open differ"))
    measured = tuple(
        MeasuredValue(message(name), message(f"{band.median_v:.1f} V"), tolerance, GuidedVerdict.FAILED)
        for name, band in ((marked("Bay closed"), closed), (marked("Bay open"), opened))
    )
    return GuidedResult(GuidedKind.BAY, measured, message(CalibrationFault.TOO_CLOSE.value))


def light_direction(result: GuidedResult) -> LightDirection | None:
    """Which way the light was measured to read; None where the result is of another test, or tells nothing of it."""
    if result.kind is not GuidedKind.BAY or result.verdict is not GuidedVerdict.PASSED:
        return None
    return LightDirection.RISES if result.advice is None else LightDirection.FALLS
