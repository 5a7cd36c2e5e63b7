"""Simulates the person in a guided test: does to the simulated module what the procedure asks, on the fake clock."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from app.engine.procedure import Job, Procedure, Report, Result
from app.guided.guided_tests import GUIDED_BY_KIND, PersonSteps
from app.guided.results import GuidedKind, GuidedResult
from app.simulator.bench import SimulatedBench
from app.text.messages import UserError
from tests.support.line.sim_line import Rig

SLOWLY_DEG_S = 25.0


@dataclass
class Hands:
    """Gets every report of the procedure (`hear`), and the time at every step of the session (`move`)."""

    bench: SimulatedBench
    steps: PersonSteps
    speed_deg_s: float = SLOWLY_DEG_S
    height_m: float = 0.5
    goes_to_deg: float = 0.0
    said: list[str] = field(default_factory=list)
    _at: float | None = None

    def hear(self, report: Report) -> None:
        text = report.doing
        if text in self.said[-1:]:
            return
        self.said.append(text)
        if "ilt it slowly {direction}" in text:
            self.goes_to_deg = 100.0
        elif text.startswith(("It fired", "Hold it level.", "Too fast")):
            self.goes_to_deg = 0.0
        elif text.startswith("Let it fall"):
            self.bench.drop(self.height_m)
        elif text.startswith(("Close the bay", "Open the bay")):
            self.bench.set_world(bay_is_open=text.startswith("Open"))

    def move(self, now: float) -> None:
        """Tilt the module towards its target; confirm the step that waits."""
        passed_s = 0.0 if self._at is None else now - self._at
        self._at = now
        tilt, step = self.bench.world.tilt_deg, self.speed_deg_s * passed_s
        if tilt != self.goes_to_deg:
            way = self.goes_to_deg - tilt
            self.bench.set_world(tilt_deg=self.goes_to_deg if abs(way) <= step else tilt + (step if way > 0 else -step))
        if self.said and self.said[-1].startswith(("Close the bay", "Open the bay", "Shake")):
            self.steps.confirm()


def drive(
    rig: Rig, procedure: Procedure[Result], hands: Hands, each: Callable[[], None] = lambda: None, **more: Any
) -> Result:
    """Run `procedure` to its end while `hands` act; `each` is called after every step. `more`: as of `Job`."""
    job: Job[Result] = rig.job(procedure, hands.hear, **more)
    ends_at = rig.clock.now_s + 900.0
    while not job.has_ended:
        assert rig.clock.now_s < ends_at, "it takes too long"
        rig.session.step()
        hands.move(rig.clock.now_s)
        each()
    return job.outcome()


def guided(
    rig: Rig,
    kind: GuidedKind,
    *,
    each: Callable[[], None] = lambda: None,
    act: Callable[[], None] | None = None,
    speed_deg_s: float = SLOWLY_DEG_S,
    height_m: float = 0.5,
    hands: type[Hands] = Hands,
) -> GuidedResult | UserError:
    """Run a whole guided test in one conversation; `act` replaces the confirmed act between preparing and measuring."""
    test, steps, number = GUIDED_BY_KIND[kind], PersonSteps(), rig.conversation.number
    person = hands(rig.bench, steps, speed_deg_s, height_m)
    try:
        measure = drive(rig, test.prepare(), person, each, conversation=number)
        if act is not None:
            act()
        elif test.is_active:
            rig.bench.module.activate(is_active=True)
            rig.step_for(0.1)
        return drive(rig, measure(steps), person, each, conversation=number, expects=test.expects)
    except UserError as why:
        return why
