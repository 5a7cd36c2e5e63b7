"""Tilt to the trigger: at which angle an active module fires and rearms, in four directions.

    level  ->  tilted until it reports that it has fired  ->  back until it reports that no longer

The module reports an angle, not a direction: the direction is the one that the person was told. An angle is only known
to lie between two reports. If the module moved so fast that they are too far apart, the direction is repeated.
"""

from enum import Enum
from functools import partial
from typing import NamedTuple

from app.engine.device import DeviceView, StatusSample
from app.engine.procedure import EngineView, Inspect, Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import (
    AGREEING,
    Measure,
    PersonSteps,
    StatusWatch,
    read_setting,
    require_in_time,
    require_locked,
)
from app.text.messages import UserMessage, message
from app.text.user_error import UserError
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.translatable import marked

LEVEL_WITHIN_DEG = 10.0
TOLERANCE_DEG = 3.0
"""Our choice: the module reports whole degrees, and a hand moves between two reports."""
WIDEST_SPAN_DEG = 6.0
MISSED_BY_DEG = 20.0
"""Tilted this far beyond the threshold, or upside down, without firing: the trigger failed."""
HIGHEST_DEG = 170.0
REARMS_WITHIN_S = 3.0
"""Level for this long and still reported as triggered: it does not rearm."""
TRIES = 3
STEPS = 6
"""Activating, the four directions, locking."""
MAX_S = 300.0
"""Longest time on an active module."""
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


def prepare_tilt() -> Procedure[Measure]:
    begin = yield from require_locked()
    threshold = yield from read_setting("attitude_threshold")
    if threshold <= LEVEL_WITHIN_DEG + RESET_BELOW_THRESHOLD_DEG or threshold + TOLERANCE_DEG > HIGHEST_DEG:
        raise UserError(marked("Not testable by hand at {threshold:.0f}°."), threshold=threshold)
    return partial(_measure, begin, threshold)


def _measure(begin: DeviceView, threshold: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    """Needs an active module. The caller locks it afterwards in any case."""
    watch = _TiltWatch(begin, threshold)
    view: EngineView = yield Inspect()
    watch.ends_at = view.now + MAX_S
    turns: list[Turn] = []
    for number, direction in enumerate(TiltDirection):
        turn = yield from _turn(watch, number, direction)
        turns.append(turn)
        if turn.fired is not None and turn.rearmed is None:
            break  # the other directions could not be told from this one
    return _result(turns, threshold)


def _turn(watch: "_TiltWatch", number: int, direction: TiltDirection) -> Procedure[Turn]:
    """Repeat a direction that was moved too fast; the last try counts."""
    turn = Turn(direction)
    for number_of_try in range(TRIES):
        level = marked("Hold it level.") if number_of_try == 0 else marked("Too fast. Hold it level.")
        yield from watch.level(number, level, direction)
        turn = yield from watch.one_turn(number, direction)
        is_sharp = all(span is None or span.is_sharp for span in (turn.fired, turn.rearmed))
        if is_sharp or (turn.fired is not None and turn.rearmed is None):
            break
    return turn


class _TiltWatch:
    """Hands out the reports one by one, within the time limits."""

    def __init__(self, begin: DeviceView, threshold: float) -> None:
        self._threshold = threshold
        self._watch = StatusWatch(begin, is_active=True, may_trigger=True)
        self._waiting: list[StatusSample] = []
        self.ends_at = 0.0
        self._step_began = 0.0

    def level(self, number: int, text: str, direction: TiltDirection) -> Procedure[None]:
        yield from self._begin(number, text, direction)
        agreeing = 0
        while agreeing < AGREEING:
            report = yield from self._next()
            is_level = report.tilt_deg <= LEVEL_WITHIN_DEG and not report.triggered
            agreeing = agreeing + 1 if is_level else 0

    def one_turn(self, number: int, direction: TiltDirection) -> Procedure[Turn]:
        """From level until it has fired and rearmed."""
        yield from self._begin(number, TILT_SLOWLY, direction)
        limit = min(HIGHEST_DEG, self._threshold + MISSED_BY_DEG)
        before, first, reached = 0.0, 0.0, 0.0
        agreeing = beyond = 0
        while agreeing < AGREEING:
            report = yield from self._next()
            reached = max(reached, report.tilt_deg)
            if not report.triggered:
                before, agreeing = report.tilt_deg, 0
            else:
                first, agreeing = (report.tilt_deg if agreeing == 0 else first), agreeing + 1
            beyond = beyond + 1 if report.tilt_deg >= limit and not report.triggered else 0
            if beyond > 2 * AGREEING:
                return Turn(direction, reached)
        rearmed = yield from self._back(number, direction)
        return Turn(direction, reached, Span(before, first), rearmed)

    def _back(self, number: int, direction: TiltDirection) -> Procedure[Span | None]:
        yield from self._begin(number, marked("It fired. Level it slowly."), direction)
        before, first, agreeing = HIGHEST_DEG, 0.0, 0
        level_since: float | None = None
        while agreeing < AGREEING:
            report = yield from self._next()
            if report.triggered:
                before, agreeing = report.tilt_deg, 0
                is_level = report.tilt_deg <= LEVEL_WITHIN_DEG
                level_since = (level_since or report.at) if is_level else None
                if level_since is not None and report.at - level_since > REARMS_WITHIN_S:
                    return None
            else:
                first, agreeing = (report.tilt_deg if agreeing == 0 else first), agreeing + 1
        return Span(before, first)

    def _begin(self, number: int, text: str, direction: TiltDirection) -> Procedure[None]:
        now: float = yield Report(number + 1, STEPS, text, (("direction", message(direction.value)),))
        self._step_began = now

    def _next(self) -> Procedure[StatusSample]:
        while not self._waiting:
            self._waiting += yield from self._watch.next_reports()
            view: EngineView = yield Inspect()
            if view.now > self.ends_at:
                raise UserError(marked("Ended after {seconds:.0f} s."), seconds=MAX_S)
            require_in_time(self._step_began, view.now)
        return self._waiting.pop(0)


def _result(turns: list[Turn], threshold: float) -> GuidedResult:
    measured: list[MeasuredValue] = []
    for direction in TiltDirection:
        turn = next((turn for turn in turns if turn.direction is direction), None)
        side = message(direction.value)
        measured.append(_fired(side, turn, threshold))
        measured.append(_rearmed(side, turn, threshold - RESET_BELOW_THRESHOLD_DEG))
    advice = None
    if any(turn.fired is None for turn in turns):
        advice = message(marked("Enable the attitude trigger."))
    elif any(turn.rearmed is None for turn in turns):
        advice = message(marked("It did not rearm: other directions not tested."))
    return GuidedResult(GuidedKind.TILT, tuple(measured), advice)


def _fired(side: UserMessage, turn: Turn | None, threshold: float) -> MeasuredValue:
    name = message(marked("Fires, {direction}"), direction=side)
    if turn is None:
        return _not_tested(name, threshold)
    if turn.fired is None:
        shown = message(marked("not up to {angle:.0f}°"), angle=turn.reached_deg)
        return MeasuredValue(name, shown, _tolerance(threshold), GuidedVerdict.FAILED)
    return _judged(name, turn.fired, threshold, turn.fired.high_deg)


def _rearmed(side: UserMessage, turn: Turn | None, reset: float) -> MeasuredValue:
    name = message(marked("Rearms, {direction}"), direction=side)
    if turn is None or turn.fired is None:
        return _not_tested(name, reset)
    if turn.rearmed is None:
        return MeasuredValue(name, message(marked("no")), _tolerance(reset), GuidedVerdict.FAILED)
    return _judged(name, turn.rearmed, reset, turn.rearmed.low_deg)


def _judged(name: UserMessage, span: Span, target_deg: float, first_deg: float) -> MeasuredValue:
    """`first_deg`: angle of the first report after the change."""
    verdict = passed_if(span.is_near(target_deg))
    if verdict is GuidedVerdict.PASSED and not span.is_sharp:
        verdict = GuidedVerdict.UNCLEAR
    return MeasuredValue(name, span.message(), _tolerance(target_deg), verdict, first_deg)


def _not_tested(name: UserMessage, target_deg: float) -> MeasuredValue:
    return MeasuredValue(name, message(marked("not tested")), _tolerance(target_deg), GuidedVerdict.UNCLEAR)


def _tolerance(target_deg: float) -> UserMessage:
    return message(f"{target_deg:.0f}° ± {TOLERANCE_DEG:.0f}°")
