"""Zeroing the sensor: the tilt before and after. The zeroing itself is `app.procedures.act`."""

from statistics import median

from app.engine.procedure import EngineView, Inspect, Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, MeasuredValue, passed_if
from app.guided.status_watch import GuidedSetup, PersonSteps, StatusWatch, require_in_time, require_locked
from app.procedures.act import ZEROED_WITHIN_DEG
from app.safety.interlocks import LEVEL_WITHIN_DEG
from app.text.messages import message
from protocol.translatable import marked

WATCHED_S = 1.0
STEPS = 3
LAY_LEVEL, MEASURE = marked("Set the aircraft level and do not touch it."), marked("Measuring the tilt")


def prepare_zero() -> Procedure[GuidedSetup]:
    restarts = yield from require_locked()
    began: float = yield Report(0, STEPS, LAY_LEVEL)
    tilt = yield from _tilt(restarts)
    while tilt > LEVEL_WITHIN_DEG:
        tilt = yield from _tilt(restarts)
        view: EngineView = yield Inspect()
        require_in_time(began, view.now)
    return GuidedSetup(restarts=restarts, tilt_deg=tilt)


def measure_zero(setup: GuidedSetup, _steps: PersonSteps) -> Procedure[GuidedResult]:
    yield Report(2, STEPS, MEASURE)
    after = yield from _tilt(setup.restarts)
    yield from require_locked()
    before = setup.tilt_deg
    measured = tuple(
        MeasuredValue(message(name), message(f"{tilt:.0f}°"), message(f"≤ {most:.0f}°"), passed_if(tilt <= most), tilt)
        for name, tilt, most in (
            (marked("Tilt before"), before, LEVEL_WITHIN_DEG),
            (marked("Tilt after"), after, ZEROED_WITHIN_DEG),
        )
    )
    # The reading would be the same if zeroing did nothing, or if the sensor always reported level.
    was_level = before <= ZEROED_WITHIN_DEG
    advice = message(marked("It was level before: this does not show that zeroing works.")) if was_level else None
    return GuidedResult(GuidedKind.ZERO, measured, advice)


def _tilt(restarts: int) -> Procedure[float]:
    """Median of one second."""
    watch = StatusWatch(restarts)
    view: EngineView = yield Inspect()
    ends_at, tilts = view.now + WATCHED_S, list[float]()
    while view.now < ends_at or not tilts:
        tilts += [float(one.tilt_deg) for one in (yield from watch.next_reports())]
        view = yield Inspect()
    return float(median(tilts))
