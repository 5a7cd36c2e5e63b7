"""Fall of half a metre onto a cushion, on a locked module: how long it reports to be below the threshold.

The fall lasts 0.32 s, far less than any sensible free-fall time: the test proves that the sensor and the line show a
fall. Its duration is at least the time between the first and the last report below the threshold, and at most the
time between the reports around them.
"""

from dataclasses import dataclass, field
from functools import partial

from app.engine.conversation import StatusSample
from app.engine.procedure import Procedure, Report, ask_value
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import Measure, PersonSteps, StatusWatch, read_setting, require_locked
from app.text.messages import UserError, message
from protocol.catalogue import BOOT_COUNT
from protocol.translatable import marked

# A fall of 0.2 m to 1.8 m.
SHORTEST_S, LONGEST_FALL_S = 0.20, 0.60
# A shorter one is a jerk, not a fall.
JERK_S = 0.10
# If the duration is less exact than this, the result is unclear.
COARSEST_S = 0.15
ENOUGH_REPORTS = 5
STILL_FROM_G, STILL_TO_G = 0.8, 1.2
STILL_S = 1.0
# Time after the fall in which a trigger is waited for.
AFTERWARDS_S = 1.0
STEPS = 3
HOLD, DROP, WAIT = marked("Hold it level, 50 cm above a cushion"), marked("Let it fall"), marked("Leave it there")


@dataclass(slots=True)
class MeasuredFall:
    """The reports below the threshold, and the times of those around them."""

    before_at: float
    below: list[StatusSample] = field(default_factory=list)
    after_at: float = 0.0

    @property
    def shortest_s(self) -> float:
        return self.below[-1].at - self.below[0].at

    @property
    def longest_s(self) -> float:
        return self.after_at - self.before_at


def prepare_free_fall() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from read_setting("freefall_acceleration")
    if not 0 < threshold <= STILL_FROM_G:
        text = marked("Not testable at {threshold:.1f} g: rest and fall cannot be told apart.")
        raise UserError(text, threshold=threshold)
    seconds = yield from read_setting("freefall_time")
    return partial(_measure, threshold, seconds)


def _measure(threshold_g: float, time_s: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    """Against the module's thresholds."""
    watch = StatusWatch(is_active=False)
    yield from watch.begin(Report(0, STEPS, HOLD))
    still_at = yield from _until_still(watch)
    yield from watch.begin(Report(1, STEPS, DROP))
    fall = yield from _fall(watch, threshold_g, still_at)
    yield from watch.begin(Report(2, STEPS, WAIT))
    has_fired = any(report.triggered for report in fall.below)
    at = fall.after_at
    while at < fall.after_at + AFTERWARDS_S:
        report = yield from watch.next()
        at, has_fired = report.at, has_fired or report.triggered
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    return _result(fall, time_s, has_fired=has_fired)


def _until_still(watch: StatusWatch) -> Procedure[float]:
    """When the last report at rest arrived."""
    since: float | None = None
    while True:
        report = yield from watch.next()
        if not STILL_FROM_G <= report.acceleration_g <= STILL_TO_G:
            since = None
        elif since is None:
            since = report.at
        elif report.at - since >= STILL_S:
            return report.at


def _fall(watch: StatusWatch, threshold_g: float, before_at: float) -> Procedure[MeasuredFall]:
    """`before_at`: time of the report before this step; the fall may begin before the first one of the step."""
    fall = MeasuredFall(before_at)
    while True:
        report = yield from watch.next()
        if report.acceleration_g < threshold_g:
            fall.below.append(report)
            continue
        fall.after_at = report.at
        if fall.below and (fall.longest_s >= SHORTEST_S or fall.shortest_s >= JERK_S):
            return fall
        fall = MeasuredFall(report.at)


def _result(fall: MeasuredFall, time_s: float, *, has_fired: bool) -> GuidedResult:
    shortest, longest = fall.shortest_s, fall.longest_s
    verdict = passed_if(shortest <= LONGEST_FALL_S and longest >= SHORTEST_S)
    is_clear = longest - shortest <= COARSEST_S and len(fall.below) >= ENOUGH_REPORTS
    if verdict is GuidedVerdict.PASSED and not is_clear:
        verdict = GuidedVerdict.UNCLEAR
    not_triggered = message(marked("not triggered"))
    measured = (
        MeasuredValue(
            message(marked("Below the threshold")),
            message(f"{shortest:.2f}–{longest:.2f} s"),
            message(f"{SHORTEST_S:.2f}–{LONGEST_FALL_S:.2f} s"),
            verdict,
        ),
        MeasuredValue(
            message(marked("Trigger")),
            message(marked("triggered")) if has_fired else not_triggered,
            not_triggered,
            passed_if(not has_fired),
        ),
    )
    advice = None
    if shortest >= time_s:
        advice = message(marked("Over {seconds:.2f} s: active, it would have fired."), seconds=time_s)
    return GuidedResult(GuidedKind.FREE_FALL, measured, advice)
