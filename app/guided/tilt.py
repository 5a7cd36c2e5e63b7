"""Tilt to the trigger: at which angle an active module fires and rearms, in four directions.

    level  ->  tilted until it reports that it has fired  ->  back until it reports that no longer

The module reports an angle, not a direction: the direction is the one that the person was told. An angle is only known
to lie between two reports. If the module moved so fast that they are too far apart, the direction is repeated.
"""

from enum import Enum
from functools import partial
from typing import NamedTuple

from app.engine.procedure import Procedure, Report, ask_value
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import Measure, PersonSteps, StatusWatch, read_setting, require_locked
from app.text.messages import UserError, UserMessage, message
from protocol.catalogue import BOOT_COUNT, RESET_BELOW_THRESHOLD_DEG
from protocol.translatable import marked

LEVEL_WITHIN_DEG = 10.0
# Our choice: the module reports whole degrees, and a hand moves between two reports.
TOLERANCE_DEG = 3.0
WIDEST_SPAN_DEG = 6.0
# Tilted this far beyond the threshold, or upside down, for so many reports without firing: the trigger failed.
MISSED_BY_DEG = 20.0
MISSED_REPORTS = 5
HIGHEST_DEG = 170.0
# Level for this long and still reported as triggered: it does not rearm.
REARMS_WITHIN_S = 3.0
TRIES = 3
# Activating, the four directions, locking.
STEPS = 6
# Longest time on an active module.
MAX_S = 300.0
TILT_SLOWLY = marked("Tilt it slowly {direction} until it fires")


class TiltDirection(Enum):
    """The value is English, translatable."""

    FORWARD = marked("forward")
    RIGHT = marked("right")
    BACK = marked("back")
    LEFT = marked("left")


class Span:
    """An angle that lies between two reports."""

    def __init__(self, one_deg: float, other_deg: float) -> None:
        self.low_deg, self.high_deg = sorted((one_deg, other_deg))

    @property
    def is_sharp(self) -> bool:
        return self.high_deg - self.low_deg <= WIDEST_SPAN_DEG

    def is_near(self, target_deg: float) -> bool:
        return self.low_deg <= target_deg + TOLERANCE_DEG and self.high_deg >= target_deg - TOLERANCE_DEG

    def message(self) -> UserMessage:
        if self.high_deg - self.low_deg <= 1:
            return message(f"{self.high_deg:.0f}°")
        return message(f"{self.low_deg:.0f}–{self.high_deg:.0f}°")


class Turn(NamedTuple):
    """One direction. `fired` None: it did not fire; `rearmed` None: it stayed triggered."""

    direction: TiltDirection
    reached_deg: float = 0.0
    fired: Span | None = None
    rearmed: Span | None = None

    @property
    def is_sharp(self) -> bool:
        return all(span is None or span.is_sharp for span in (self.fired, self.rearmed))

    @property
    def stays_triggered(self) -> bool:
        return self.fired is not None and self.rearmed is None


def prepare_tilt() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from read_setting("attitude_threshold")
    if threshold <= LEVEL_WITHIN_DEG + RESET_BELOW_THRESHOLD_DEG or threshold + TOLERANCE_DEG > HIGHEST_DEG:
        raise UserError(marked("Not testable by hand at {threshold:.0f}°."), threshold=threshold)
    return partial(_measure, threshold)


def _measure(threshold: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    """Needs an active module. The caller locks it afterwards in any case."""
    watch = StatusWatch(is_active=True, longest_s=MAX_S)
    turns: list[Turn] = []
    for number, direction in enumerate(TiltDirection, 1):
        turns.append((yield from _turn(watch, threshold, number, direction)))
        if turns[-1].stays_triggered:
            break  # the other directions could not be told from this one
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    return _result(turns, threshold)


def _turn(watch: StatusWatch, threshold: float, number: int, direction: TiltDirection) -> Procedure[Turn]:
    """Repeat a direction that was moved too fast; the last try counts."""
    step = Report(number, STEPS, marked("Hold it level."), (("direction", message(direction.value)),))
    turn = Turn(direction)
    for _ in range(TRIES):
        yield from watch.begin(step)
        yield from _until_level(watch)
        yield from watch.begin(step._replace(doing=TILT_SLOWLY))
        turn = yield from _until_fired(watch, threshold, direction)
        if turn.fired is not None:
            yield from watch.begin(step._replace(doing=marked("It fired. Level it slowly.")))
            turn = turn._replace(rearmed=(yield from _until_rearmed(watch)))
        if turn.is_sharp or turn.stays_triggered:
            break
        step = step._replace(doing=marked("Too fast. Hold it level."))
    return turn


def _until_level(watch: StatusWatch) -> Procedure[None]:
    while True:
        report = yield from watch.next()
        if report.tilt_deg <= LEVEL_WITHIN_DEG and not report.triggered:
            return


def _until_fired(watch: StatusWatch, threshold: float, direction: TiltDirection) -> Procedure[Turn]:
    """Between the last report before it fired and the first one after."""
    limit = min(HIGHEST_DEG, threshold + MISSED_BY_DEG)
    before = reached = 0.0
    beyond = 0
    while beyond < MISSED_REPORTS:
        report = yield from watch.next()
        reached = max(reached, report.tilt_deg)
        if report.triggered:
            return Turn(direction, reached, Span(before, report.tilt_deg))
        before = report.tilt_deg
        beyond = beyond + 1 if report.tilt_deg >= limit else 0
    return Turn(direction, reached)


def _until_rearmed(watch: StatusWatch) -> Procedure[Span | None]:
    """As above; None where it stays triggered although it is level."""
    before = HIGHEST_DEG
    level_since: float | None = None
    while True:
        report = yield from watch.next()
        if not report.triggered:
            return Span(before, report.tilt_deg)
        before = report.tilt_deg
        if report.tilt_deg > LEVEL_WITHIN_DEG:
            level_since = None
        elif level_since is None:
            level_since = report.at
        elif report.at - level_since > REARMS_WITHIN_S:
            return None


# The result


def _result(turns: list[Turn], threshold: float) -> GuidedResult:
    by_direction = {turn.direction: turn for turn in turns}
    measured = [row for one in TiltDirection for row in _rows(one, by_direction.get(one), threshold)]
    advice = None
    if any(turn.fired is None for turn in turns):
        advice = message(marked("Enable the attitude trigger."))
    elif any(turn.rearmed is None for turn in turns):
        advice = message(marked("It did not rearm: other directions not tested."))
    return GuidedResult(GuidedKind.TILT, tuple(measured), advice)


def _rows(direction: TiltDirection, turn: Turn | None, threshold: float) -> tuple[MeasuredValue, MeasuredValue]:
    """Where it fired and where it rearmed; without a `turn` neither was tested."""
    side = message(direction.value)
    fires = message(marked("Fires, {direction}"), direction=side)
    rearms = message(marked("Rearms, {direction}"), direction=side)
    reset = threshold - RESET_BELOW_THRESHOLD_DEG
    if turn is None:
        return _row(fires, None, threshold), _row(rearms, None, reset)
    missed = message(marked("not up to {angle:.0f}°"), angle=turn.reached_deg)
    stuck = None if turn.fired is None else message(marked("no"))
    return _row(fires, turn.fired, threshold, missed), _row(rearms, turn.rearmed, reset, stuck)


def _row(name: UserMessage, span: Span | None, target_deg: float, failed: UserMessage | None = None) -> MeasuredValue:
    """`failed`: what is said where there is no angle although it was tested."""
    tolerance = _tolerance(target_deg)
    if span is None:
        shown = failed or message(marked("not tested"))
        return MeasuredValue(name, shown, tolerance, GuidedVerdict.FAILED if failed else GuidedVerdict.UNCLEAR)
    # Moved too fast, the angle tells of the hand, not of the module.
    verdict = passed_if(span.is_near(target_deg)) if span.is_sharp else GuidedVerdict.UNCLEAR
    return MeasuredValue(name, span.message(), tolerance, verdict)


def _tolerance(target_deg: float) -> UserMessage:
    return message(f"{target_deg:.0f}° ± {TOLERANCE_DEG:.0f}°")
