"""Plug and cable: what is lost while the plug is shaken. Only questions are asked; the module stays locked.

A port that goes away, or a module that restarts or falls silent while it is shaken, is a result, not an accident.
Nothing that is read tells whether anybody shook it: before it passes, a person has to say so.
"""

from dataclasses import dataclass

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure, Report
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import Measure, PersonSteps, require_locked, wait_for_person
from app.text.messages import UserMessage, message
from protocol.catalogue import BOOT_COUNT
from protocol.events import Answered, EndReason
from protocol.translatable import marked

# The ends of a conversation that a bad plug makes.
LOOSE_ENDS = frozenset({EndReason.RESTARTED, EndReason.SILENT, EndReason.CONTRADICTED, EndReason.PORT_LOST})
REST_S, SHAKEN_S = 3.0, 15.0
ASK_EVERY_S = 0.02
STEPS = 2
REST, SHAKE = marked("Leave the plug alone"), marked("Shake plug and cable gently")


@dataclass(slots=True)
class _Counts:
    asked: int = 0
    lost: int = 0
    rejected: int = 0


def prepare_link() -> Procedure[Measure]:
    yield from require_locked()
    return measure_link


def measure_link(steps: PersonSteps) -> Procedure[GuidedResult]:
    """The job expects `LOOSE_ENDS`."""
    rest, shaken = _Counts(), _Counts()
    try:
        yield from _count(rest, Report(0, STEPS, REST), REST_S)
        yield from _count(shaken, Report(1, STEPS, SHAKE), SHAKEN_S)
        if _result(rest, shaken).verdict is GuidedVerdict.PASSED:
            yield from wait_for_person(steps)
        yield from require_locked()
    except Interrupted as error:
        if error.reason not in LOOSE_ENDS:
            raise
        return _result(rest, shaken, error)
    return _result(rest, shaken)


def _count(counts: _Counts, step: Report, seconds: float) -> Procedure[None]:
    view: EngineView = yield Inspect()
    ends_at, rejected_before = view.now + seconds, view.link.counters.rejected
    while view.now < ends_at:
        yield step._replace(values=(("asked", counts.asked), ("lost", counts.lost)))
        outcome = yield Ask(BOOT_COUNT.query())
        counts.asked += 1
        # One that had to be asked again was lost, the question or its answer.
        if not isinstance(outcome, Answered) or outcome.attempts > 1:
            counts.lost += 1
        view = yield Inspect()
        counts.rejected = view.link.counters.rejected - rejected_before
        yield Pause(ASK_EVERY_S)


def _result(rest: _Counts, shaken: _Counts, interrupted: Interrupted | None = None) -> GuidedResult:
    none = message(marked("none"))
    rejected = rest.rejected + shaken.rejected
    shown = none if interrupted is None else interrupted.message
    measured = (
        _lost(message(marked("Lost at rest")), rest),
        _lost(message(marked("Lost while shaken")), shaken),
        MeasuredValue(message(marked("Invalid bytes")), message(str(rejected)), none, passed_if(rejected == 0)),
        MeasuredValue(message(marked("Interruption")), shown, none, passed_if(interrupted is None)),
    )
    is_fine = all(value.verdict is GuidedVerdict.PASSED for value in measured)
    advice = None if is_fine else message(marked("Check plugs, ground and cable length."))
    return GuidedResult(GuidedKind.LINK, measured, advice)


def _lost(name: UserMessage, counts: _Counts) -> MeasuredValue:
    shown = message(f"{counts.lost} / {counts.asked}")
    verdict = passed_if(counts.lost == 0) if counts.asked else GuidedVerdict.UNCLEAR
    return MeasuredValue(name, shown, message(marked("none")), verdict)
