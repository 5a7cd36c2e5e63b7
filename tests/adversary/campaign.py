"""Plans the runs, runs them and counts the results."""

import random
import shutil
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, Final, NamedTuple
from unittest import mock

from app.simulator.bench import SimulatedBench
from app.simulator.options import as_text
from tests.adversary.commands import BY_COMMAND
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.adversary.gestures import WINDOW
from tests.adversary.judge import SETTLED_S, Breach, Case, Finding, judge_all
from tests.adversary.program import Ran, Stage, home_variables
from tests.adversary.window import SETTLED_IN_S, Session, WindowDesk
from tests.support.line.lies import lying, lying_bench
from tests.support.line.sim_line import FakeClock

STEP_S: Final = 0.06
"""The greatest age of an answer that the program accepts on a perfect line."""
STRIDE: Final = 5
"""Step between the quirks that the same fault and command meet."""
BASIS: Final = {"uptime": "60", "noise": "0", "cell": "4.0", "drain": "0", "history": "4"}


class Plan(NamedTuple):
    """One run; its text is the argument of `--only`."""

    quirks: str
    trouble: str
    command: str
    seed: int

    def __str__(self) -> str:
        return f"{self.quirks} / {self.trouble} / {self.command} / {self.seed}"


def plan_of(text: str) -> Plan:
    """Parse a plan; raise `ValueError` or `KeyError` if the text is not one."""
    quirks, trouble, command, seed = (part.strip() for part in text.split(" / "))
    plan = Plan(quirks, trouble, command, int(seed))
    _ = DIALECTS[quirks], TROUBLES[trouble], {**BY_COMMAND, **WINDOW}[command]
    return plan


def plans(runs: int, seed: int) -> Iterator[Plan]:
    """Yield every fault with every command, with changing quirks, up to the count."""
    quirk_sets, names = list(DIALECTS), [*BY_COMMAND, *WINDOW]
    pairs = list(product(enumerate(TROUBLES), enumerate(names)))
    random.Random(seed).shuffle(pairs)
    for number in range(runs):
        turn, place = divmod(number, len(pairs))
        (at, trouble), (column, command) = pairs[place]
        yield Plan(quirk_sets[(at + column + STRIDE * turn) % len(quirk_sets)], trouble, command, seed + turn)


@dataclass(frozen=True, slots=True)
class Result:
    plan: Plan
    ran: Ran
    findings: Sequence[Finding]


def run_one(plan: Plan, home: Path) -> Result:
    """Run a plan; the same plan always gives the same run."""
    if plan.command in WINDOW:
        return _sit_at_window(plan, home)
    command, trouble = BY_COMMAND[plan.command], TROUBLES[plan.trouble]
    clock = FakeClock()
    bench = lying_bench(_options(plan, command.module), clock)
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir(parents=True)
    stage = Stage(bench, clock, home)
    if trouble.accident is not None:
        stage.happens_at(clock() + trouble.accident.at_s, trouble.accident.happen)
    ran = stage.run(command.argv)
    stage.wait_until(stage.truth.last_act_at + SETTLED_S)
    case = Case(
        ran=ran,
        truth=stage.truth,
        acts=command.acts,
        latency_s=_latency_s(bench),
        forges=trouble.forges,
        withholds=trouble.withholds,
    )
    return Result(plan, ran, judge_all(case, command.judge))


def _sit_at_window(plan: Plan, home: Path) -> Result:
    gestures, trouble = WINDOW[plan.command], TROUBLES[plan.trouble]
    desk = WindowDesk(_options(plan, {"rate": 20, **gestures.module}))
    session = Session(desk, _latency_s(desk.bench), forges=trouble.forges)
    if trouble.accident is not None:
        session.happens = desk.clock() + SETTLED_IN_S + trouble.accident.at_s, trouble.accident.happen
    begun_s, error = desk.clock(), None
    try:
        with mock.patch.dict("os.environ", home_variables(home)):
            gestures.make(session)
    except Exception as caught:  # noqa: BLE001  the window would tell of it
        error = caught
    ran = Ran(code=0, out="\n".join(f'"verdict": "{one}"' for one in session.said), took_s=desk.clock() - begun_s)
    findings = session.end()
    if error is not None:
        findings.append(Finding(Breach.MISHAP, repr(error)))
    return Result(plan, ran, list(dict.fromkeys(findings)))


def _options(plan: Plan, module: Mapping[str, Any]) -> dict[str, str]:
    own = {name: as_text(value) for name, value in module.items()}
    return {**BASIS, "seed": str(plan.seed), **DIALECTS[plan.quirks], **own, **TROUBLES[plan.trouble].options}


def _latency_s(bench: SimulatedBench) -> float:
    """Return the age of an answer that has just arrived."""
    faults = bench.wire.faults
    added_ms = faults.delay_ms + faults.jitter_ms + faults.lag_ms + faults.split_ms + lying(bench).lies.latest_ms
    return STEP_S + added_ms / 1000


@dataclass
class Campaign:
    """Counts of a campaign; `breaches` holds every result with a finding, in order."""

    runs: int = 0
    took_s: float = 0.0
    fake_s: float = 0.0
    by_command: Counter[str] = field(default_factory=Counter)
    by_code: Counter[tuple[str, int]] = field(default_factory=Counter)
    said: Counter[str] = field(default_factory=Counter)
    """Counts of positive claims; without claims there can be no breach."""
    breaches: list[Result] = field(default_factory=list)

    def feed(self, result: Result) -> None:
        self.runs += 1
        self.fake_s += result.ran.took_s
        self.by_command[result.plan.command] += 1
        self.by_code[result.plan.command, result.ran.code] += 1
        for word in ('"verdict": "GO"', '"verdict": "READY"', '"verified": true'):
            self.said[word] += result.ran.out.count(word)
        if result.findings:
            self.breaches.append(result)


def run_all(
    planned: Iterator[Plan], home: Path, on_result: Callable[[Result], None] = lambda _result: None
) -> Campaign:
    campaign, begun = Campaign(), time.perf_counter()
    for plan in planned:
        result = run_one(plan, home)
        campaign.feed(result)
        on_result(result)
    campaign.took_s = time.perf_counter() - begun
    return campaign
