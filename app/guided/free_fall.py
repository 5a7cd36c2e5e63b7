"""Fall of half a metre onto a cushion, on a locked module: how long it reports to be below the threshold.

The fall lasts 0.32 s, far less than any sensible free-fall time: the test proves that the sensor and the line show a
fall. Its duration is at least the time between the first and the last report below the threshold, and at most the
time between the reports around them.
"""

from dataclasses import dataclass, field
from functools import partial

from app.engine.device import DeviceView, StatusSample
from app.engine.procedure import EngineView, Inspect, Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import Measure, PersonSteps, StatusWatch, read_setting, require_in_time, require_locked
from app.text.messages import message
from app.text.user_error import UserError
from protocol.translatable import marked

SHORTEST_S, LONGEST_FALL_S = 0.20, 0.60
"""A fall of 0.2 m to 1.8 m."""
JERK_S = 0.10
"""A shorter one is a jerk, not a fall."""
COARSEST_S = 0.15
"""If the duration is less exact than this, the result is unclear."""
ENOUGH_REPORTS = 5
STILL_FROM_G, STILL_TO_G = 0.8, 1.2
STILL_S = 1.0
AFTERWARDS_S = 1.0
"""Time after the fall in which a trigger is waited for."""
STEPS = 3
HOLD, DROP, WAIT = marked("Hold it level, 50 cm above a cushion"), marked("Let it fall"), marked("Leave it there")


@dataclass(slots=True)
class MeasuredFall:
    """The reports below the threshold, and those around them."""

    before_at: float
    below: list[StatusSample] = field(default_factory=list)
    after_at: float = 0.0

    @property
    def shortest_s(self) -> float:
        return self.below[-1].at - self.below[0].at

    @property
    def longest_s(self) -> float:
        return self.after_at - self.before_at

    @property
    def lowest_g(self) -> float:
        return min(report.acceleration_g for report in self.below)


def prepare_free_fall() -> Procedure[Measure]:
    begin = yield from require_locked()
    threshold = yield from read_setting("freefall_acceleration")
    if not 0 < threshold <= STILL_FROM_G:
        raise UserError(marked("Not testable at {threshold:.1f} g: rest and fall cannot be told apart."),
                       threshold=threshold)  # fmt: skip
    seconds = yield from read_setting("freefall_time")
    return partial(_measure, begin, threshold, seconds)


def _measure(begin: DeviceView, threshold_g: float, time_s: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    """Against the module's thresholds."""
    watch = StatusWatch(begin, may_trigger=True)
    still_at = yield from _until_still(watch)
    fall = yield from _fall(watch, threshold_g, still_at)
    now: float = yield Report(2, STEPS, WAIT)
    has_fired, ends_at = False, now + AFTERWARDS_S
    while now < ends_at:
        reports = yield from watch.next_reports()
        has_fired = has_fired or any(report.triggered for report in reports)
        view: EngineView = yield Inspect()
        now = view.now
    has_fired = has_fired or any(report.triggered for report in fall.below)
    return _result(fall, threshold_g, time_s, has_fired=has_fired)


def _until_still(watch: StatusWatch) -> Procedure[float]:
    """When the last report at rest arrived."""
    began: float = yield Report(0, STEPS, HOLD)
    since: float | None = None
    still_at: float | None = None
    while still_at is None:
        for report in (yield from watch.next_reports()):
            is_still = STILL_FROM_G <= report.acceleration_g <= STILL_TO_G
            since = (since if since is not None else report.at) if is_still else None
            if since is not None and report.at - since >= STILL_S:
                still_at = report.at
            require_in_time(began, report.at)
    return still_at


def _fall(watch: StatusWatch, threshold_g: float, before_at: float) -> Procedure[MeasuredFall]:
    """`before_at`: time of the report before this step; the fall may begin before the first one of the step."""
    began: float = yield Report(1, STEPS, DROP)
    fall: MeasuredFall | None = None
    while True:
        for report in (yield from watch.next_reports()):
            require_in_time(began, report.at)
            if report.acceleration_g < threshold_g:
                fall = fall or MeasuredFall(before_at)
                fall.below.append(report)
                continue
            before_at = report.at
            if fall is not None:
                fall.after_at = report.at
                if fall.longest_s >= SHORTEST_S or fall.shortest_s >= JERK_S:
                    return fall
                fall = None


def _result(fall: MeasuredFall, threshold_g: float, time_s: float, *, has_fired: bool) -> GuidedResult:
    shortest, longest = fall.shortest_s, fall.longest_s
    is_clear = longest - shortest <= COARSEST_S and len(fall.below) >= ENOUGH_REPORTS
    verdict = passed_if(shortest <= LONGEST_FALL_S and longest >= SHORTEST_S)
    if verdict is GuidedVerdict.PASSED and not is_clear:
        verdict = GuidedVerdict.UNCLEAR
    count = len(fall.below)
    tolerance = message(f"{SHORTEST_S:.2f}–{LONGEST_FALL_S:.2f} s")
    measured = (
        MeasuredValue(
            message(marked("Below the threshold")),
            message(f"{shortest:.2f}–{longest:.2f} s"),
            tolerance, verdict, (shortest + longest) / 2,
        ),
        MeasuredValue(
            message(marked("Lowest acceleration")),
            message(f"{fall.lowest_g:.1f} g"),
            message(f"< {threshold_g:.1f} g"),
            GuidedVerdict.PASSED, fall.lowest_g,
        ),
        MeasuredValue(
            message(marked("Reports")),
            message("{count}", count=count),
            message(f"≥ {ENOUGH_REPORTS}"),
            GuidedVerdict.PASSED if count >= ENOUGH_REPORTS else GuidedVerdict.UNCLEAR, count,
        ),
        MeasuredValue(
            message(marked("Trigger")),
            message(marked("triggered")) if has_fired else message(marked("not triggered")),
            message(marked("not triggered")),
            passed_if(not has_fired), float(has_fired),
        ),
    )  # fmt: skip
    advice = None
    if shortest >= time_s:
        advice = message(marked("Over {seconds:.2f} s: active, it would have fired."),
                      seconds=time_s)  # fmt: skip
    return GuidedResult(GuidedKind.FREE_FALL, measured, advice)
