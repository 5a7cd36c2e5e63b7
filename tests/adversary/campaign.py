"""Plans the runs, runs them and counts the results."""

import random
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any, Final, NamedTuple, Self
from unittest import mock

from PySide6.QtWidgets import QApplication

from app.simulator.bench import SimulatedBench
from tests.adversary.commands import BY_COMMAND, NAMES, STREAM, WINDOW
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.adversary.judge import SETTLED_S, Case, Finding, conduct, judge_all
from tests.adversary.program import Ran, Stage, caught_errors, home_variables, write_at_once
from tests.adversary.window import SETTLED_IN_S, Session
from tests.gestures.gesture_bench import GestureBench, gesture_bench
from tests.support.line.lies import lying, lying_bench
from tests.support.line.odd_module import as_text, odd
from tests.support.line.sim_line import FakeClock

STEP_S: Final = 0.06
"""The greatest age of an answer that the program accepts on a perfect line."""
STRIDE: Final = 5
"""Step between the quirks that the same fault and command meet."""
BASIS: Final = {"uptime": "60", "noise": "0", "cell": "4.0", "history": "4"}


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
    _ = DIALECTS[quirks], TROUBLES[trouble], NAMES.index(command)
    return plan


def plans(runs: int, seed: int) -> Iterator[Plan]:
    """Yield every fault with every command, with changing quirks, up to the count."""
    quirk_sets, names = list(DIALECTS), NAMES
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
    sent: Mapping[bytes, int]
    """Every frame that was not a query, and how often it was sent."""


class Desk:
    """Where the runs are made; the window is opened once, and each run hangs another module at its port."""

    def __init__(self, home: Path) -> None:
        self._home, self._opened = home, ExitStack()
        self._bench: GestureBench | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def run(self, plan: Plan) -> Result:
        return self._at_window(plan) if plan.command in WINDOW else self._at_terminal(plan)

    def _at_terminal(self, plan: Plan) -> Result:
        """Run a command; the same plan always gives the same run."""
        command, trouble = BY_COMMAND[plan.command], TROUBLES[plan.trouble]
        clock = FakeClock()
        bench = lying_bench(_options(plan, command.module), clock)
        home = self._home / "home"
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir(parents=True)
        stage = Stage(bench, clock, home)
        if trouble.accident is not None:
            stage.happens_at(clock() + trouble.accident.at_s, trouble.accident.happen)
        ran = stage.run(command.argv)
        stage.wait_until(stage.truth.last_act_at + SETTLED_S)
        case = Case(ran, stage.truth, command.acts, latency_s(bench), trouble.forges, trouble.withholds)
        return Result(plan, ran, judge_all(case, command.judge), stage.truth.acts_sent)

    def _at_window(self, plan: Plan) -> Result:
        gestures, trouble = WINDOW[plan.command], TROUBLES[plan.trouble]
        if self._bench is None:
            application = QApplication.instance()
            assert isinstance(application, QApplication)
            folder = self._home / "window"
            folder.mkdir(parents=True)
            self._opened.enter_context(mock.patch.dict("os.environ", home_variables(folder)))
            self._bench = self._opened.enter_context(gesture_bench(application, folder))
            self._opened.enter_context(mock.patch("app.store.fact_store.Store.write", write_at_once))
        bench, began_s = self._bench, self._bench.clock()
        bench.disconnect()
        bench.exchange(_options(plan, {"rate": 20, **gestures.module}))
        session = Session(bench, latency_s(bench.bench), forges=trouble.forges)
        if trouble.accident is not None:
            session.happens = bench.clock() + SETTLED_IN_S + trouble.accident.at_s, trouble.accident.happen
        with caught_errors() as mishaps:
            try:
                gestures.make(session)
            except Exception as caught:  # noqa: BLE001  the window would tell of it
                mishaps.append(caught)
        out = "\n".join(f'"verdict": "{one}"' for one in session.said)
        ran = Ran(code=0, out=out, took_s=bench.clock() - began_s, mishaps=mishaps)
        restarts = bench.truth.now.boots - bench.truth.moments[0].boots  # each is followed by another "on"
        stream = {frame: count + restarts for frame, count in STREAM.items()}
        findings = [*conduct(replace(session.case, ran=ran, acts={**stream, **gestures.acts})), *session.findings]
        return Result(plan, ran, list(dict.fromkeys(findings)), bench.truth.acts_sent)


def _options(plan: Plan, module: Mapping[str, Any]) -> dict[str, str]:
    own = {name: as_text(value) for name, value in module.items()}
    return {**BASIS, "seed": str(plan.seed), **DIALECTS[plan.quirks], **own, **TROUBLES[plan.trouble].options}


def latency_s(bench: SimulatedBench) -> float:
    """Return the age of an answer that has just arrived."""
    faults = odd(bench.module)
    added_ms = faults.delay_ms + faults.jitter_ms + faults.lag_ms + faults.split_ms + lying(bench).lies.latest_ms
    return STEP_S + added_ms / 1000


@dataclass
class Campaign:
    """Counts of a campaign; `breaches` holds every result with a finding, in order."""

    runs: int = 0
    said: Counter[str] = field(default_factory=Counter)
    """Counts of positive claims; without claims there can be no breach."""
    breaches: list[Result] = field(default_factory=list)


def run_all(planned: Iterable[Plan], home: Path) -> Campaign:
    campaign = Campaign()
    with Desk(home) as desk:
        for plan in planned:
            result = desk.run(plan)
            campaign.runs += 1
            for word in ('"verdict": "GO"', '"verdict": "READY"', '"verified": true'):
                campaign.said[word] += result.ran.out.count(word)
            if result.findings:
                campaign.breaches.append(result)
    return campaign
