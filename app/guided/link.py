"""Plug and cable: what is lost while the plug is shaken. Only questions are asked; the module stays locked.

A port that goes away while it is shaken is a result, not an accident. Nothing that is read tells whether anybody shook
it: before it passes, a person has to say so.
"""

from dataclasses import dataclass
from functools import partial

from app.engine.procedure import Ask, EngineView, Inspect, Pause, PortLost, Procedure, Report
from app.engine.transport import PortError
from app.guided.results import GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, passed_if
from app.guided.status_watch import Measure, PersonSteps, require_locked, wait_for_person
from app.text.messages import UserMessage, message
from protocol.catalogue import BY_NAME
from protocol.events import Answered
from protocol.messages import Reading
from protocol.translatable import marked

REST_S, SHAKEN_S = 3.0, 15.0
ASK_EVERY_S = 0.02
WAITS_S = (0.3,)
"""An answer that takes longer is lost; usually it takes some milliseconds."""
QUESTION = BY_NAME["boot_count"].query()
"""Not the heartbeat: the two unsolicited heartbeats of a restart would be taken for its answers."""
STEPS = 2
REST, SHAKE = marked("Leave the plug alone"), marked("Shake plug and cable gently")


@dataclass(slots=True)
class _Counts:
    asked: int = 0
    lost: int = 0
    rejected: int = 0
    restarts: int = 0
    is_port_lost: bool = False


def prepare_link() -> Procedure[Measure]:
    return partial(measure_link, (yield from require_locked()).restarts)


def measure_link(restarts: int, steps: PersonSteps) -> Procedure[GuidedResult]:
    rest, shaken, boots = _Counts(), _Counts(), list[int]()
    try:
        yield from _count(rest, 0, REST, REST_S, restarts, boots)
        yield from _count(shaken, 1, SHAKE, SHAKEN_S, restarts, boots)
        if _result(rest, shaken).verdict is GuidedVerdict.PASSED:
            yield from wait_for_person(steps)
    except (PortLost, PortError):
        shaken.is_port_lost = True
    else:
        yield from require_locked()
    return _result(rest, shaken)


def _count(counts: _Counts, number: int, text: str, seconds: float, restarts: int, boots: list[int]) -> Procedure[None]:
    """`boots` collects the boot counts that are read, each as often as it changed."""
    view: EngineView = yield Inspect()
    ends_at, rejected = view.now + seconds, view.link.counters.rejected
    while view.now < ends_at:
        yield Report(number, STEPS, text, (("asked", counts.asked), ("lost", counts.lost)))
        outcome = yield Ask(QUESTION, WAITS_S, attempts=1)
        counts.asked += 1
        counts.lost += not isinstance(outcome, Answered)
        if isinstance(outcome, Answered):
            read = [answer.raw for answer in outcome.messages if isinstance(answer, Reading)]
            boots += [] if read == boots[-1:] else read
        view = yield Inspect()
        counts.rejected = view.link.counters.rejected - rejected
        # The device counts a restart twice if the boot count is read between its two heartbeats.
        counts.restarts = max(0, len(boots) - 1) or view.device.restarts - restarts
        yield Pause(ASK_EVERY_S)


def _result(rest: _Counts, shaken: _Counts) -> GuidedResult:
    none = message(marked("none"))
    measured = (
        _lost(message(marked("Lost at rest")), rest),
        _lost(message(marked("Lost while shaken")), shaken),
        _row(message(marked("Invalid bytes")), rest.rejected + shaken.rejected, none),
        _row(message(marked("Restarts")), max(rest.restarts, shaken.restarts), none),
        _row(message(marked("Port lost")), int(shaken.is_port_lost), none),
    )
    is_fine = GuidedResult(GuidedKind.LINK, measured).verdict is GuidedVerdict.PASSED
    advice = None if is_fine else message(marked("Check plugs, ground and cable length."))
    return GuidedResult(GuidedKind.LINK, measured, advice)


def _lost(name: UserMessage, counts: _Counts) -> MeasuredValue:
    shown = message(f"{counts.lost} / {counts.asked}")
    verdict = passed_if(counts.lost == 0) if counts.asked else GuidedVerdict.UNCLEAR
    return MeasuredValue(name, shown, message(marked("none")), verdict, counts.lost)


def _row(name: UserMessage, count: int, tolerance: UserMessage) -> MeasuredValue:
    return MeasuredValue(name, message("{count}", count=count), tolerance, passed_if(count == 0), count)
