"""The guided tests: what must be made safe, the steps with the person, and what is measured.

    prepare   refuses unless the module is locked and has not fired; reads the thresholds that the test needs
    measure   what it returns: the steps with the person

Both raise `UserError`: the test is not completed, does not count and is not kept. Both are of one conversation, whose
end breaks the test off, except where it is one of `expects`: then it is its result.

Whatever can be tested on a locked module is tested on a locked one. Where it must be active, a person confirms its
activation between the two: the same steps, conditions and log as on the Commands page. The caller locks it afterwards
in any case.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from enum import Enum
from functools import partial
from math import inf
from typing import NamedTuple

from app.engine.conversation import Interrupted, StatusSample
from app.engine.procedure import (
    TOO_SLOW,
    Ask,
    EngineView,
    Inspect,
    Pause,
    Procedure,
    Report,
    ask_report,
    ask_value,
    wait_for,
)
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.procedures.light import Band, LightDirection, measure_light
from app.procedures.read import read_twice, who_is_there
from app.safety.journal import TITLES as ACT_TITLES
from app.safety.journal import Act
from app.text.i18n import tr
from app.text.messages import UserError, UserMessage, join_sentences, message
from protocol.catalogue import BOOT_COUNT, BY_NAME, RESET_BELOW_THRESHOLD_DEG
from protocol.events import Answered, EndReason
from protocol.translatable import marked

# For one step of the person; then the test is aborted.
PERSON_LIMIT_S = 120.0
# Quick enough for a fall of a third of a second, and the line has room for the rest.
REPORT_EVERY_S = 0.015
# Reports in a row that must agree before they count: a single one may be a damaged frame.
AGREEING = 2
NOT_READ = marked("Unknown: {what}.")


class PersonSteps:
    """Lets a procedure wait for a step of the person, which the window confirms. Thread-safe."""

    def __init__(self) -> None:
        self._asked: Future[None] = Future()
        self._asked.set_result(None)

    @property
    def is_waiting(self) -> bool:
        return not self._asked.done()

    def wait(self) -> Procedure[None]:
        self._asked = Future()
        is_done = yield from wait_for(self._asked, PERSON_LIMIT_S)
        if not is_done:
            raise _out_of_time()

    def confirm(self) -> None:
        """The person has done the step. Does nothing if none is waited for."""
        if self.is_waiting:
            self._asked.set_result(None)


Measure = Callable[[PersonSteps], Procedure[GuidedResult]]


def _out_of_time() -> UserError:
    return UserError(marked("No step within {seconds:.0f} s."), seconds=PERSON_LIMIT_S)


class StatusWatch:
    """Hands out the module's reports one by one. Raises `UserError` when the module is not in the state that the test
    needs, or when a step, or all of it (`longest_s`), takes too long."""

    def __init__(self, *, is_active: bool, longest_s: float = inf) -> None:
        self._is_active, self._longest_s = is_active, longest_s
        self._began_at: float | None = None
        self._step_began_at = 0.0
        self._against = 0

    def begin(self, step: Report) -> Procedure[None]:
        self._step_began_at = yield step
        if self._began_at is None:
            self._began_at = self._step_began_at

    def next(self) -> Procedure[StatusSample]:
        report = None
        while report is None:
            now = yield Pause(REPORT_EVERY_S)
            if now - self._step_began_at > PERSON_LIMIT_S:
                raise _out_of_time()
            if self._began_at is not None and now - self._began_at > self._longest_s:
                raise UserError(marked("Ended after {seconds:.0f} s."), seconds=self._longest_s)
            report = yield from ask_report()
        self._against = 0 if report.active is self._is_active else self._against + 1
        if self._against >= AGREEING:
            raise UserError(marked("The module was locked.") if self._is_active else marked("ACTIVE during the test."))
        return report


def require_locked() -> Procedure[None]:
    """Raise `UserError` unless the module now reports that it is locked and has not fired."""
    view: EngineView = yield Inspect()
    if view.conversation.is_slow:
        raise UserError(TOO_SLOW)
    present = yield from who_is_there()
    if present.contradiction is not None or present.status is None:
        raise UserError(present.contradiction or marked("No current status."))
    if present.status.active:
        raise UserError(marked("The module is ACTIVE: lock it first."))
    if present.status.triggered:
        raise UserError(marked("The module reports that it has fired."))


def _read_setting(name: str) -> Procedure[float]:
    """Read a threshold, twice the same."""
    command = BY_NAME[name]
    reading = yield from read_twice(command)
    if reading is None:
        raise UserError(NOT_READ, what=message(command.title))
    return float(reading.value)


# Tilt to the trigger: at which angle an active module fires and rearms, in four directions.
#
#     level  ->  tilted until it reports that it has fired  ->  back until it reports that no longer
#
# The module reports an angle, not a direction: the direction is the one that the person was told. If it moved further
# than the tolerance from the report before, the angle tells of the hand, and the direction is repeated.

LEVEL_WITHIN_DEG = 10.0
# Our choice: the module reports whole degrees, and a hand moves between two reports.
TOLERANCE_DEG = 3.0
# Tilted this far beyond the threshold, or upside down, for so many reports without firing: the trigger failed.
MISSED_BY_DEG = 20.0
MISSED_REPORTS = 5
HIGHEST_DEG = 170.0
# Level for this long and still reported as triggered: it does not rearm.
REARMS_WITHIN_S = 3.0
TILT_TRIES = 3
# Activating, the four directions, locking.
TILT_STEPS = 6
# Longest time on an active module.
TILT_LONGEST_S = 300.0
TILT_SLOWLY = marked("Tilt it slowly {direction} until it fires")
# After a try that does not count. Said here, too: whoever holds it level again by then would not see that it was said.
TILT_SLOWER = marked("Too fast. Tilt it slowly {direction} until it fires")


class TiltDirection(Enum):
    """The value is English, translatable."""

    FORWARD = marked("forward")
    RIGHT = marked("right")
    BACK = marked("back")
    LEFT = marked("left")


class Turn(NamedTuple):
    """A turn in one direction. `fired_deg` is None where it did not fire, `rearmed_deg` where it stayed triggered."""

    reached_deg: float = 0.0
    fired_deg: float | None = None
    rearmed_deg: float | None = None
    # It never moved so far from one report to the next that the angle is not known.
    is_slow: bool = True

    @property
    def stays_triggered(self) -> bool:
        return self.fired_deg is not None and self.rearmed_deg is None


def prepare_tilt() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from _read_setting("attitude_threshold")
    if threshold <= LEVEL_WITHIN_DEG + RESET_BELOW_THRESHOLD_DEG or threshold + TOLERANCE_DEG > HIGHEST_DEG:
        raise UserError(marked("Not testable by hand at {threshold:.0f}°."), threshold=threshold)
    return partial(measure_tilt, threshold)


def measure_tilt(threshold: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    watch = StatusWatch(is_active=True, longest_s=TILT_LONGEST_S)
    turns: dict[TiltDirection, Turn] = {}
    for number, direction in enumerate(TiltDirection, 1):
        turns[direction] = yield from _turn(watch, threshold, number, direction)
        if turns[direction].stays_triggered:
            break  # the other directions could not be told from this one
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    measured = [row for one in TiltDirection for row in _tilt_rows(one, turns.get(one), threshold)]
    advice = None
    if any(turn.fired_deg is None for turn in turns.values()):
        advice = message(marked("Enable the attitude trigger."))
    elif any(turn.rearmed_deg is None for turn in turns.values()):
        advice = message(marked("It did not rearm: other directions not tested."))
    return GuidedResult(GuidedKind.TILT, tuple(measured), advice)


def _turn(watch: StatusWatch, threshold: float, number: int, direction: TiltDirection) -> Procedure[Turn]:
    """Repeat a direction that was moved too fast; the last try counts."""
    step = Report(number, TILT_STEPS, marked("Hold it level."), (("direction", message(direction.value)),))
    tilt = TILT_SLOWLY
    turn = Turn()
    for _ in range(TILT_TRIES):
        yield from watch.begin(step)
        report = yield from watch.next()
        while report.tilt_deg > LEVEL_WITHIN_DEG or report.triggered:
            report = yield from watch.next()
        yield from watch.begin(step._replace(doing=tilt))
        turn = yield from _until_fired(watch, threshold)
        if turn.fired_deg is not None:
            yield from watch.begin(step._replace(doing=marked("It fired. Level it slowly.")))
            turn = yield from _until_rearmed(watch, turn)
        if turn.is_slow or turn.stays_triggered:
            break
        step = step._replace(doing=marked("Too fast. Hold it level."))
        tilt = TILT_SLOWER
    return turn


def _until_fired(watch: StatusWatch, threshold: float) -> Procedure[Turn]:
    limit = min(HIGHEST_DEG, threshold + MISSED_BY_DEG)
    before = reached = 0.0
    beyond = 0
    while beyond < MISSED_REPORTS:
        report = yield from watch.next()
        reached = max(reached, report.tilt_deg)
        if report.triggered:
            return Turn(reached, report.tilt_deg, is_slow=abs(report.tilt_deg - before) <= TOLERANCE_DEG)
        before = report.tilt_deg
        beyond = beyond + 1 if report.tilt_deg >= limit else 0
    return Turn(reached)


def _until_rearmed(watch: StatusWatch, turn: Turn) -> Procedure[Turn]:
    """Return the turn with the angle at which it rearmed, if it did."""
    before = turn.fired_deg or 0.0
    level_since: float | None = None
    while True:
        report = yield from watch.next()
        if not report.triggered:
            is_slow = turn.is_slow and abs(report.tilt_deg - before) <= TOLERANCE_DEG
            return turn._replace(rearmed_deg=report.tilt_deg, is_slow=is_slow)
        before = report.tilt_deg
        if report.tilt_deg > LEVEL_WITHIN_DEG:
            level_since = None
        elif level_since is None:
            level_since = report.at
        elif report.at - level_since > REARMS_WITHIN_S:
            return turn


def _tilt_rows(direction: TiltDirection, turn: Turn | None, threshold: float) -> Iterator[MeasuredValue]:
    """Yield the rows of where it fired and where it rearmed; without a `turn` neither was tested."""
    side, not_tested = message(direction.value), message(marked("not tested"))
    missed = not_tested if turn is None else message(marked("not up to {angle:.0f}°"), angle=turn.reached_deg)
    stuck = message(marked("no")) if turn is not None and turn.stays_triggered else not_tested
    turn = turn or Turn()
    for name, angle_deg, target_deg, otherwise in (
        (marked("Fires, {direction}"), turn.fired_deg, threshold, missed),
        (marked("Rearms, {direction}"), turn.rearmed_deg, threshold - RESET_BELOW_THRESHOLD_DEG, stuck),
    ):
        shown = otherwise if angle_deg is None else message(f"{angle_deg:.0f}°")
        if shown == not_tested or (angle_deg is not None and not turn.is_slow):
            verdict = GuidedVerdict.UNCLEAR
        else:
            verdict = passed_if(angle_deg is not None and abs(angle_deg - target_deg) <= TOLERANCE_DEG)
        tolerance = message(f"{target_deg:.0f}° ± {TOLERANCE_DEG:.0f}°")
        yield MeasuredValue(message(name, direction=side), shown, tolerance, verdict)


# Fall of half a metre onto a cushion, on a locked module: how long it reports to be below the threshold.
#
# The fall lasts 0.32 s, far less than any sensible free-fall time: the test proves that the sensor and the line show a
# fall. It is measured from the first to the last report below the threshold.

# A fall of 0.2 m to 1.8 m.
SHORTEST_FALL_S, LONGEST_FALL_S = 0.20, 0.60
# A shorter one is a jerk, not a fall.
JERK_S = 0.10
STILL_FROM_G, STILL_TO_G = 0.8, 1.2
STILL_S = 1.0
# Time after the fall in which a trigger is waited for.
AFTERWARDS_S = 1.0
FALL_STEPS = 3
HOLD, DROP, WAIT = marked("Hold it level, 50 cm above a cushion"), marked("Let it fall"), marked("Leave it there")


def prepare_free_fall() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from _read_setting("freefall_acceleration")
    if not 0 < threshold <= STILL_FROM_G:
        text = marked("Not testable at {threshold:.1f} g: rest and fall cannot be told apart.")
        raise UserError(text, threshold=threshold)
    seconds = yield from _read_setting("freefall_time")
    return partial(measure_free_fall, threshold, seconds)


def measure_free_fall(threshold_g: float, time_s: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    watch = StatusWatch(is_active=False)
    yield from watch.begin(Report(0, FALL_STEPS, HOLD))
    still_since: float | None = None
    while True:
        report = yield from watch.next()
        if not STILL_FROM_G <= report.acceleration_g <= STILL_TO_G:
            still_since = None
        elif still_since is None:
            still_since = report.at
        elif report.at - still_since >= STILL_S:
            break

    yield from watch.begin(Report(1, FALL_STEPS, DROP))
    below: list[StatusSample] = []
    lasted_s = 0.0
    while lasted_s < JERK_S:
        below.clear()
        report = yield from watch.next()
        while report.acceleration_g < threshold_g:
            below.append(report)
            report = yield from watch.next()
        lasted_s = below[-1].at - below[0].at if below else 0.0

    yield from watch.begin(Report(2, FALL_STEPS, WAIT))
    has_fired = any(report.triggered for report in below)
    waits_until = report.at + AFTERWARDS_S
    while report.at < waits_until:
        report = yield from watch.next()
        has_fired |= report.triggered
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it

    usual = message(f"{SHORTEST_FALL_S:.2f}–{LONGEST_FALL_S:.2f} s")
    is_usual = SHORTEST_FALL_S <= lasted_s <= LONGEST_FALL_S
    not_triggered = message(marked("not triggered"))
    trigger = message(marked("triggered")) if has_fired else not_triggered
    measured = (
        MeasuredValue(message(marked("Below the threshold")), message(f"{lasted_s:.2f} s"), usual, passed_if(is_usual)),
        MeasuredValue(message(marked("Trigger")), trigger, not_triggered, passed_if(not has_fired)),
    )
    advice = None
    if lasted_s >= time_s:
        advice = message(marked("Over {seconds:.2f} s: active, it would have fired."), seconds=time_s)
    return GuidedResult(GuidedKind.FREE_FALL, measured, advice)


# Parachute bay closed and open: the light of both, and its margin to the threshold.

# One step of the sensor: a threshold on a reading is none.
MIN_MARGIN_V = 0.1
ROUNDING_V = 1e-6
CLOSE, OPEN = marked("Close the bay"), marked("Open the bay fully")
BAY_CLOSED, BAY_OPEN = marked("Bay closed"), marked("Bay open")


def prepare_bay() -> Procedure[Measure]:
    yield from require_locked()
    threshold = yield from _read_setting("light_threshold")
    return partial(_measure_bay, threshold)


def _measure_bay(threshold: float, steps: PersonSteps) -> Procedure[GuidedResult]:
    bands: list[Band] = []
    for number, doing in enumerate((CLOSE, OPEN)):
        yield Report(number, 2, doing)
        yield from steps.wait()
        band = yield from measure_light(step_of=(number, 2))
        if not band.is_enough:
            raise UserError(NOT_READ, what=message(marked("Light")))
        bands.append(band)
    yield from require_locked()
    closed, opened = bands
    return judge_bay(closed, opened, threshold)


def judge_bay(closed: Band, opened: Band, threshold: float) -> GuidedResult:
    rises = opened.median_v > closed.median_v
    if rises:
        margins = threshold - closed.high_v, opened.low_v - threshold
    else:
        margins = closed.low_v - threshold, threshold - opened.high_v
    tolerance = message(marked("≥ {margin:.1f} V from {threshold:.1f} V"), margin=MIN_MARGIN_V, threshold=threshold)
    measured = tuple(
        MeasuredValue(
            message(name),
            message(f"{band.median_v:.1f} V ({margin:+.1f} V)"),
            tolerance,
            passed_if(margin >= MIN_MARGIN_V - ROUNDING_V),
        )
        for name, band, margin in zip((BAY_CLOSED, BAY_OPEN), (closed, opened), margins, strict=True)
    )
    advice = None
    if any(row.verdict is GuidedVerdict.FAILED for row in measured):
        advice = message(marked("Measure the light threshold."))
    elif not rises:
        advice = message(LightDirection.FALLS.value)
    return GuidedResult(GuidedKind.BAY, measured, advice)


def light_direction(result: GuidedResult) -> LightDirection | None:
    """Which way the light was measured to read; None where the result is of another test, or tells nothing of it."""
    if result.kind is not GuidedKind.BAY or result.verdict is not GuidedVerdict.PASSED:
        return None
    return LightDirection.RISES if result.advice is None else LightDirection.FALLS


# Plug and cable: what is lost while the plug is shaken. Only questions are asked; the module stays locked.
#
# A port that goes away, or a module that restarts or falls silent while it is shaken, is a result, not an accident.
# Nothing that is read tells whether anybody shook it: before it passes, a person has to say so.

# The ends of a conversation that a bad plug makes.
LOOSE_ENDS = frozenset({EndReason.RESTARTED, EndReason.SILENT, EndReason.CONTRADICTED, EndReason.PORT_LOST})
SHAKEN_S = 15.0
PLUG_ASK_EVERY_S = 0.02
SHAKE = marked("Shake plug and cable gently")


class _Counts:
    asked = lost = rejected = 0


def prepare_link() -> Procedure[Measure]:
    yield from require_locked()
    return measure_link


def measure_link(steps: PersonSteps) -> Procedure[GuidedResult]:
    """The job expects `LOOSE_ENDS`."""
    counts = _Counts()
    try:
        yield from _count(counts)
        if _judge_link(counts).verdict is GuidedVerdict.PASSED:
            yield from steps.wait()
        yield from require_locked()
    except Interrupted as error:
        if error.reason not in LOOSE_ENDS:
            raise
        return _judge_link(counts, error)
    return _judge_link(counts)


def _count(counts: _Counts) -> Procedure[None]:
    step = Report(0, 1, SHAKE)
    now = yield step
    ends_at = now + SHAKEN_S
    while now < ends_at:
        yield step._replace(values=(("asked", counts.asked), ("lost", counts.lost)))
        outcome = yield Ask(BOOT_COUNT.query())
        counts.asked += 1
        # One that had to be asked again was lost, the question or its answer.
        if not isinstance(outcome, Answered) or outcome.attempts > 1:
            counts.lost += 1
        if isinstance(outcome, Answered):
            counts.rejected += outcome.rejected
        now = yield Pause(PLUG_ASK_EVERY_S)


def _judge_link(counts: _Counts, interrupted: Interrupted | None = None) -> GuidedResult:
    none = message(marked("none"))
    lost = passed_if(counts.lost == 0) if counts.asked else GuidedVerdict.UNCLEAR
    shown = none if interrupted is None else interrupted.message
    measured = (
        MeasuredValue(message(marked("Lost replies")), message(f"{counts.lost} / {counts.asked}"), none, lost),
        MeasuredValue(
            message(marked("Invalid bytes")), message(str(counts.rejected)), none, passed_if(counts.rejected == 0)
        ),
        MeasuredValue(message(marked("Interruption")), shown, none, passed_if(interrupted is None)),
    )
    is_fine = all(value.verdict is GuidedVerdict.PASSED for value in measured)
    advice = None if is_fine else message(marked("Check plugs, ground and cable length."))
    return GuidedResult(GuidedKind.LINK, measured, advice)


# All of them


class GuidedTest(NamedTuple):
    """Texts are English, translatable. `statement`: what the person states before a test with an active module;
    `confirms`: the text of the button for each step that the person confirms."""

    kind: GuidedKind
    safety: str
    steps: tuple[UserMessage, ...]
    prepare: Callable[[], Procedure[Measure]]
    # It needs an active module, which must be locked afterwards in any case.
    is_active: bool = False
    statement: str = ""
    confirms: tuple[str, ...] = ()
    # The ends of its conversation that are a result of the test.
    expects: frozenset[EndReason] = frozenset()

    @property
    def precautions(self) -> str:
        """What must be made safe, translated."""
        common = "" if self.is_active else tr("Even locked, keep clear of its opening.")
        return join_sentences((common, tr(self.safety)))


GUIDED_TESTS: tuple[GuidedTest, ...] = (
    GuidedTest(
        GuidedKind.TILT,
        marked("It will FIRE four times: take off the ejector (pyro or spring) and the rotors."),
        (message(ACT_TITLES[Act.ACTIVATE]),
         *(message(TILT_SLOWLY, direction=message(direction.value)) for direction in TiltDirection),
         message(ACT_TITLES[Act.LOCK])),
        prepare_tilt, is_active=True, statement=marked("Ejector and rotors are off"),
    ),
    GuidedTest(
        GuidedKind.FREE_FALL,
        marked("Take the rotors off."),
        (message(HOLD), message(DROP), message(WAIT)),
        prepare_free_fall,
    ),
    GuidedTest(
        GuidedKind.BAY,
        marked("Secure the loaded spring under the lid."),
        (message(CLOSE), message(OPEN)),
        prepare_bay,
        confirms=(BAY_CLOSED, BAY_OPEN),
    ),
    GuidedTest(
        GuidedKind.LINK,
        marked("Take the rotors off."),
        (message(SHAKE),),
        prepare_link,
        confirms=(marked("Shaken for 15 s"),),
        expects=LOOSE_ENDS,
    ),
)  # fmt: skip
GUIDED_BY_KIND = {test.kind: test for test in GUIDED_TESTS}
