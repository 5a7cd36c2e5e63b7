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
from functools import partial
from itertools import takewhile
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
from app.text.messages import UserError, UserMessage, message
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
OUT_OF_TIME = marked("No step within {seconds:.0f} s.")


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
            raise UserError(OUT_OF_TIME, seconds=PERSON_LIMIT_S)

    def confirm(self) -> None:
        """The person has done the step. Does nothing if none is waited for."""
        if self.is_waiting:
            self._asked.set_result(None)


Measure = Callable[[PersonSteps], Procedure[GuidedResult]]


def reports_until(
    step: Report, is_done: Callable[[list[StatusSample]], bool], *, is_active: bool, ends_at: float = inf
) -> Procedure[list[StatusSample]]:
    """Show a step, and return the module's reports up to the one with which it is done. Raises `UserError` when the
    module is not in the state that the test needs, or when the step, or all of it (`ends_at`), takes too long."""
    began_at = yield step
    reports: list[StatusSample] = []
    while not reports or not is_done(reports):
        now = yield Pause(REPORT_EVERY_S)
        if now - began_at > PERSON_LIMIT_S:
            raise UserError(OUT_OF_TIME, seconds=PERSON_LIMIT_S)
        if now > ends_at:
            raise UserError(marked("Ended after {seconds:.0f} s."), seconds=TILT_LONGEST_S)
        report = yield from ask_report()
        if report is not None:
            reports.append(report)
        if len(reports) >= AGREEING and all(one.active is not is_active for one in reports[-AGREEING:]):
            raise UserError(marked("The module was locked.") if is_active else marked("ACTIVE during the test."))
    return reports


def _held_s(reports: list[StatusSample], is_so: Callable[[StatusSample], bool]) -> float:
    """How long it is so by now: from the first to the last of the reports in a row that say it."""
    row = list(takewhile(is_so, reversed(reports)))
    return row[0].at - row[-1].at if row else 0.0


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
DIRECTIONS = (marked("forward"), marked("right"), marked("back"), marked("left"))


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


def measure_tilt(threshold: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    view: EngineView = yield Inspect()
    turns: dict[str, Turn] = {}
    for number, direction in enumerate(DIRECTIONS, 1):
        step = Report(number, TILT_STEPS, marked("Hold it level."), (("direction", message(direction)),))
        turns[direction] = yield from _turn(step, threshold, view.now + TILT_LONGEST_S)
        if turns[direction].stays_triggered:
            break  # the other directions could not be told from this one
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    measured = [row for direction, turn in turns.items() for row in _tilt_rows(direction, turn, threshold)]
    advice = None
    if any(turn.fired_deg is None for turn in turns.values()):
        advice = message(marked("Enable the attitude trigger."))
    elif any(turn.rearmed_deg is None for turn in turns.values()):
        advice = message(marked("It did not rearm: other directions not tested."))
    return GuidedResult(GuidedKind.TILT, tuple(measured), advice)


def _turn(step: Report, threshold: float, ends_at: float) -> Procedure[Turn]:
    """Repeat a direction that was moved too fast; the last try counts."""
    limit_deg = min(HIGHEST_DEG, threshold + MISSED_BY_DEG)

    def is_level(reports: list[StatusSample]) -> bool:
        return reports[-1].tilt_deg <= LEVEL_WITHIN_DEG and not reports[-1].triggered

    def has_fired_or_missed(reports: list[StatusSample]) -> bool:
        last = reports[-MISSED_REPORTS:]
        return last[-1].triggered or (len(last) == MISSED_REPORTS and min(one.tilt_deg for one in last) >= limit_deg)

    def has_rearmed_or_not(reports: list[StatusSample]) -> bool:
        level_s = _held_s(reports, lambda one: one.tilt_deg <= LEVEL_WITHIN_DEG)
        return not reports[-1].triggered or level_s > REARMS_WITHIN_S

    until = partial(reports_until, is_active=True, ends_at=ends_at)
    tilt = TILT_SLOWLY
    turn = Turn()
    for _ in range(TILT_TRIES):
        yield from until(step, is_level)
        out = yield from until(step._replace(doing=tilt), has_fired_or_missed)
        turn = Turn(max(one.tilt_deg for one in out))
        if out[-1].triggered:
            back = yield from until(step._replace(doing=marked("It fired. Level it slowly.")), has_rearmed_or_not)
            fired_deg = out[-1].tilt_deg
            rearmed_deg = None if back[-1].triggered else back[-1].tilt_deg
            is_slow = _is_slow(0, out) and _is_slow(fired_deg, back)
            turn = Turn(turn.reached_deg, fired_deg, rearmed_deg, is_slow)
        if turn.is_slow or turn.stays_triggered:
            break
        step = step._replace(doing=marked("Too fast. Hold it level."))
        tilt = TILT_SLOWER
    return turn


def _is_slow(before_deg: int, reports: list[StatusSample]) -> bool:
    """Whether the last report is so near to the one before that its angle is the module's, and not the hand's."""
    angles = [before_deg, *(one.tilt_deg for one in reports)]
    return abs(angles[-1] - angles[-2]) <= TOLERANCE_DEG


def _tilt_rows(direction: str, turn: Turn, threshold: float) -> Iterator[MeasuredValue]:
    """Yield where it fired and, if it did, where it rearmed."""
    missed = message(marked("not up to {angle:.0f}°"), angle=turn.reached_deg)
    rows = [(marked("Fires, {direction}"), turn.fired_deg, threshold, missed)]
    if turn.fired_deg is not None:
        rearms_deg = threshold - RESET_BELOW_THRESHOLD_DEG
        rows.append((marked("Rearms, {direction}"), turn.rearmed_deg, rearms_deg, message(marked("no"))))
    for name, angle_deg, target_deg, otherwise in rows:
        shown = otherwise if angle_deg is None else message(f"{angle_deg:.0f}°")
        verdict = passed_if(angle_deg is not None and abs(angle_deg - target_deg) <= TOLERANCE_DEG)
        if angle_deg is not None and not turn.is_slow:
            verdict = GuidedVerdict.UNCLEAR
        tolerance = message(f"{target_deg:.0f}° ± {TOLERANCE_DEG:.0f}°")
        yield MeasuredValue(message(name, direction=message(direction)), shown, tolerance, verdict)


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


def measure_free_fall(threshold_g: float, time_s: float, _steps: PersonSteps) -> Procedure[GuidedResult]:
    if not 0 < threshold_g <= STILL_FROM_G:
        text = marked("Not testable at {threshold:.1f} g: rest and fall cannot be told apart.")
        raise UserError(text, threshold=threshold_g)

    def is_still(report: StatusSample) -> bool:
        return STILL_FROM_G <= report.acceleration_g <= STILL_TO_G

    def is_falling(report: StatusSample) -> bool:
        return report.acceleration_g < threshold_g

    def has_fallen(reports: list[StatusSample]) -> bool:
        return not is_falling(reports[-1]) and _held_s(reports[:-1], is_falling) >= JERK_S

    until = partial(reports_until, is_active=False)
    yield from until(Report(0, FALL_STEPS, HOLD), lambda reports: _held_s(reports, is_still) >= STILL_S)
    fall = yield from until(Report(1, FALL_STEPS, DROP), has_fallen)
    lasted_s = _held_s(fall[:-1], is_falling)
    lies_from = fall[-1].at
    after = yield from until(Report(2, FALL_STEPS, WAIT), lambda reports: reports[-1].at - lies_from >= AFTERWARDS_S)
    has_fired = any(report.triggered for report in (*fall, *after))
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
CLOSE, OPEN = marked("Close the bay"), marked("Open the bay fully")
BAY_CLOSED, BAY_OPEN = marked("Bay closed"), marked("Bay open")


def measure_bay(threshold: float, steps: PersonSteps) -> Procedure[GuidedResult]:
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
            passed_if(round(margin, 3) >= MIN_MARGIN_V),
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


def measure_link(steps: PersonSteps) -> Procedure[GuidedResult]:
    """The job expects `LOOSE_ENDS`."""
    asked = lost = rejected = 0
    interrupted: Interrupted | None = None
    step = Report(0, 1, SHAKE)
    try:
        now = yield step
        ends_at = now + SHAKEN_S
        while now < ends_at:
            yield step._replace(values=(("asked", asked), ("lost", lost)))
            outcome = yield Ask(BOOT_COUNT.query())
            asked += 1
            # One that had to be asked again was lost, the question or its answer.
            if not isinstance(outcome, Answered) or outcome.attempts > 1:
                lost += 1
            if isinstance(outcome, Answered):
                rejected += outcome.rejected
            now = yield Pause(PLUG_ASK_EVERY_S)
        if not (lost or rejected):
            yield from steps.wait()
        yield from require_locked()
    except Interrupted as error:
        if error.reason not in LOOSE_ENDS:
            raise
        interrupted = error
    none = message(marked("none"))
    loss = passed_if(lost == 0) if asked else GuidedVerdict.UNCLEAR
    shown = none if interrupted is None else interrupted.message
    measured = (
        MeasuredValue(message(marked("Lost replies")), message(f"{lost} / {asked}"), none, loss),
        MeasuredValue(message(marked("Invalid bytes")), message(str(rejected)), none, passed_if(rejected == 0)),
        MeasuredValue(message(marked("Interruption")), shown, none, passed_if(interrupted is None)),
    )
    is_fine = all(value.verdict is GuidedVerdict.PASSED for value in measured)
    advice = None if is_fine else message(marked("Check plugs, ground and cable length."))
    return GuidedResult(GuidedKind.LINK, measured, advice)


# All of them


class GuidedTest(NamedTuple):
    """Texts are English, translatable. `safety`: what must be made safe; `statement`: what the person states before a
    test with an active module; `confirms`: the text of the button for each step that the person confirms."""

    kind: GuidedKind
    safety: str
    steps: tuple[UserMessage, ...]
    # It is given the thresholds, by name in the catalogue, and the steps of the person.
    measure: Callable[..., Procedure[GuidedResult]]
    thresholds: tuple[str, ...] = ()
    # It needs an active module, which must be locked afterwards in any case.
    is_active: bool = False
    statement: str = ""
    confirms: tuple[str, ...] = ()
    # The ends of its conversation that are a result of the test.
    expects: frozenset[EndReason] = frozenset()

    def prepare(self) -> Procedure[Measure]:
        """Read the thresholds, each twice the same. Raises `UserError`, also as `require_locked`."""
        yield from require_locked()
        read: list[float] = []
        for name in self.thresholds:
            value = yield from read_twice(BY_NAME[name])
            if value is None:
                raise UserError(NOT_READ, what=message(BY_NAME[name].title))
            read.append(float(value))
        return partial(self.measure, *read)


GUIDED_TESTS: tuple[GuidedTest, ...] = (
    GuidedTest(
        GuidedKind.TILT,
        marked("It will FIRE four times: take off the ejector (pyro or spring) and the rotors."),
        (message(ACT_TITLES[Act.ACTIVATE]),
         *(message(TILT_SLOWLY, direction=message(direction)) for direction in DIRECTIONS),
         message(ACT_TITLES[Act.LOCK])),
        measure_tilt, ("attitude_threshold",), is_active=True, statement=marked("Ejector and rotors are off"),
    ),
    GuidedTest(
        GuidedKind.FREE_FALL,
        marked("Even locked, keep clear of its opening. Take the rotors off."),
        (message(HOLD), message(DROP), message(WAIT)),
        measure_free_fall,
        ("freefall_acceleration", "freefall_time"),
    ),
    GuidedTest(
        GuidedKind.BAY,
        marked("Even locked, keep clear of its opening. Secure the loaded spring under the lid."),
        (message(CLOSE), message(OPEN)),
        measure_bay,
        ("light_threshold",),
        confirms=(BAY_CLOSED, BAY_OPEN),
    ),
    GuidedTest(
        GuidedKind.LINK,
        marked("Even locked, keep clear of its opening. Take the rotors off."),
        (message(SHAKE),),
        measure_link,
        confirms=(marked("Shaken for 15 s"),),
        expects=LOOSE_ENDS,
    ),
)  # fmt: skip
GUIDED_BY_KIND = {test.kind: test for test in GUIDED_TESTS}
