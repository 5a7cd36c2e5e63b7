"""Three modules with nothing in common, exchanged at every frame of every job, and what each of their logs says.

From half a second of silence on nothing may be missed: the conversation ends, no job goes on, no set or dangerous frame
reaches another module than the one that was asked, nothing shown is of two modules, and nothing is called verified or
confirmed that is not.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count, product
from typing import Any, Final, NamedTuple

from app.engine.procedure import Job, Procedure
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.act import Performed, perform
from app.procedures.history import read_history
from app.procedures.light import measure_light
from app.procedures.lock import lock
from app.procedures.read import read_everything, read_settings
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import SettingChange, WriteContext, WriteReport, set_each, write_all
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME
from protocol.events import Ended, EndReason
from protocol.fields import Value
from tests.campaigns.plug import PlugRig
from tests.module.module import Module
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import FakeClock

NOTICED_FROM_S: Final = 0.5
SILENCES_S: Final = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0)
FLAGS_FREE_S: Final = 3.2
"""16 and 17 may be set so long after a port was opened (E4)."""
LIMIT_S: Final = 30.0
SETTLED_S: Final = 2.5
OUTPUT, ACTIVATION = 0x13, 0x10


class _Holds(NamedTuple):
    """What a module says of itself, as D4."""

    boots: int
    tilt: int
    acceleration: int
    cell: int
    light: int
    light_threshold: int
    attitude: int
    freefall: int
    time: int


HELD: Final = (
    _Holds(10, 2, 10, 0xC8, 3, 18, 60, 5, 160),
    _Holds(90, 12, 9, 0xC0, 8, 28, 70, 4, 130),
    _Holds(170, 22, 11, 0xD0, 13, 38, 80, 6, 110),
)
CHANGES: Final = [
    SettingChange(BY_NAME["freefall_time"], 1.8),
    SettingChange(BY_NAME["attitude_threshold"], 65),
    SettingChange(BY_NAME["freefall_acceleration"], 0.3),
    SettingChange(BY_NAME["light_threshold"], 2.2),
]
FLAGS: Final = [SettingChange(BY_NAME["freefall_trigger"], True), SettingChange(BY_NAME["attitude_trigger"], True)]


def made_modules(now: float) -> tuple[Module, ...]:
    modules = []
    for number, held in enumerate(HELD):
        module = Module(Options(light_closed=held.light), name="ABC"[number], seed=number + 1, now=now)
        readings = module.readings
        readings.boots, readings.tilt_deg, readings.acceleration = held.boots, held.tilt, held.acceleration
        readings.cell = held.cell
        module.settings |= {0x15: held.light_threshold, 0x20: held.attitude, 0x21: held.freefall, 0x22: held.time}
        for _ in range(3):
            module.trigger(now, 0x01)
        module.triggered = False
        modules.append(module)
    return tuple(modules)


def _owners() -> Mapping[str, Mapping[Value, int]]:
    """By key: whose each value is. A restart adds one to the boot count."""
    owners: dict[str, dict[Value, int]] = {}
    for number, held in enumerate(HELD):
        values = {
            "tilt_deg": held.tilt,
            "acceleration_g": held.acceleration / 10,
            "cell_voltage_v": held.cell / 50,
            "light_v": held.light / 10,
            "light_threshold_v": held.light_threshold / 10,
            "attitude_threshold_deg": held.attitude,
            "freefall_acceleration_g": held.freefall / 10,
            "freefall_time_s": held.time / 100,
        }
        for key, value in values.items():
            owners.setdefault(key, {})[value] = number
        for starts in range(4):
            owners.setdefault("boot_count", {})[held.boots + starts] = number
    for change in CHANGES:
        owners[change.command.key][change.value] = 0  # written to the first one only
    owners["tilt_deg"][0] = 0  # zeroed
    return owners


OWNERS: Final = _owners()


# The jobs


Begin = Callable[[PlugRig, FakeJournal], Job[Any]]


def _simply(make: Callable[[], Procedure[Any]]) -> Begin:
    return lambda rig, _journal: rig.start(make())


def _written(count: int) -> Begin:
    return lambda rig, journal: rig.start(write_all(CHANGES[:count], WriteContext(journal=journal)))


def _acted(act: Act) -> Begin:
    def begin(rig: PlugRig, journal: FakeJournal) -> Job[Any]:
        rig.plug.module.settings[ACTIVATION] = int(act is Act.DEPLOY)
        origin = Origin.RITUAL if act is Act.DEPLOY else Origin.COMMAND_LINE
        permit = Permit(act, origin, rig.clock.now_s, rig.view.number)
        expects = frozenset({EndReason.SILENT}) if act is Act.SHUTDOWN else frozenset[EndReason]()
        return rig.start(perform(act, journal, permit=permit), expects=expects)

    return begin


JOBS: Final[Mapping[str, Begin]] = {
    "read": _simply(read_everything),
    "settings": _simply(read_settings),
    "history": _simply(read_history),
    "light": _simply(measure_light),
    "write one": _written(1),
    "write four": _written(4),
    "triggers": lambda rig, journal: rig.start(set_each(FLAGS, WriteContext(journal=journal))),
    "activate": _acted(Act.ACTIVATE),
    "zero": _acted(Act.ZERO),
    "deploy": _acted(Act.DEPLOY),
    "forbid": _acted(Act.FORBID_DEPLOY),
    "shut down": _acted(Act.SHUTDOWN),
    "check": lambda rig, journal: rig.start(run_preflight(Evidence(), is_enabling=True, journal=journal)),
    "lock": lambda rig, journal: rig.start(lock(journal), outlives=True),
}


class Plan(NamedTuple):
    """One run: the plug is moved at the `frame`-th frame after the job began, and again later."""

    job: str
    frame: int
    silent_s: float
    is_announced: bool
    streams: bool

    @property
    def must_be_noticed(self) -> bool:
        return self.silent_s >= NOTICED_FROM_S


@dataclass
class Result:
    plan: Plan
    is_over: bool = False
    """The job had ended before that frame."""
    is_unnoticed: bool = False
    findings: list[str] = field(default_factory=list)


class _Run:
    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.result = Result(plan)
        clock = FakeClock()
        self.modules = made_modules(clock.now_s)
        switch = StreamSwitch(is_wanted=plan.streams)
        self.rig = PlugRig(self.modules[0], clock, background=lambda: watch(switch, listen_s=0.2))
        self.rig.on_step = self._look
        self.journal = FakeJournal()
        self._job: Job[Any] | None = None
        self._frames = 0
        self._moved = 0

    def go(self) -> Result:
        rig, plan = self.rig, self.plan
        rig.begin()
        needs_flags = plan.job in ("triggers", "check")
        rig.step_for(FLAGS_FREE_S if needs_flags else 0.8)
        rig.plug.on_frame = self._count
        job = self._job = JOBS[plan.job](rig, self.journal)
        end_s = rig.clock.now_s + LIMIT_S
        while not job.has_ended and rig.clock.now_s < end_s:
            rig.step()
        if not self._moved:
            self.result.is_over = True
            return self.result
        if not job.has_ended:
            self._find("the job goes on")
        rig.step_for(plan.silent_s + SETTLED_S)
        self._move()
        rig.step_for(plan.silent_s + SETTLED_S)
        self._judge(job)
        return self.result

    def _find(self, text: str) -> None:
        if text not in self.result.findings:
            self.result.findings.append(text)

    def _count(self, _frame: bytes) -> None:
        is_running = self._job is not None and not self._job.has_ended
        if self._frames == self.plan.frame and is_running:
            self._move()
        self._frames += 1

    def _move(self) -> None:
        self._moved += 1
        self.rig.plug.move(self.modules[self._moved], self.plan.silent_s, is_announced=self.plan.is_announced)

    def _look(self) -> None:
        """Nothing shown in one conversation is of two modules."""
        found = {OWNERS[key].get(known.value) for key, known in self.rig.view.values.items() if key in OWNERS}
        if len(found) > 1:
            self._find(f"values of {sorted(map(str, found))} in one conversation")

    def _judge(self, job: Job[Any]) -> None:
        ends = [event for event in self.rig.events if isinstance(event, Ended)]
        self.result.is_unnoticed = len(ends) < self._moved
        if self.result.is_unnoticed:
            self._find(f"{len(ends)} ends noticed")
        for module in self.modules[1:]:
            for entry in module.log.sets():
                is_lock = entry.code == ACTIVATION and entry.value == 0
                if entry.code != OUTPUT and not (is_lock and self.plan.job == "lock"):
                    self._find(f"a set of {entry.code:02X} to {module.name}")
            if any(entry.code == 0x25 for entry in module.log.acts()):
                self._find(f"zeroed {module.name}")
        if job.has_ended and job.error is None:
            self._judge_result(job.outcome())

    def _judge_result(self, result: object) -> None:
        first = self.modules[0]
        match result:
            case WriteReport():
                for written in result.results:
                    command = written.command
                    is_held = first.settings.get(command.code) == command.set(written.target).data
                    if written.verified and not is_held:
                        self._find(f"{command.name} verified, but not held")
                if result.is_fine:
                    self._find("the report is fine")
            case Performed(outcome=Outcome.CONFIRMED, act=act):
                is_done = {
                    Act.ACTIVATE: first.settings[ACTIVATION] == 1,
                    Act.DEPLOY: first.triggered,
                    Act.SHUTDOWN: not first.is_on,
                }
                if not is_done.get(act, True):
                    self._find(f"{act.value} confirmed, but not done")
            case Evidence() if result.void is None:
                self._find("the check is not void")
            case _:
                pass


def run(plan: Plan) -> Result:
    return _Run(plan).go()


def campaign(
    *, step: int = 1, jobs: Iterable[str] = JOBS, silences_s: Iterable[float] = SILENCES_S
) -> Iterator[Result]:
    """Every `step`-th frame of each job, in which the first one differs from run to run."""
    kinds = list(product(jobs, silences_s, (False, True), (False, True)))
    for number, (job, silent_s, is_announced, streams) in enumerate(kinds):
        for frame in count(number % step, step):
            result = run(Plan(job, frame, silent_s, is_announced, streams))
            if result.is_over:
                break
            yield result


def told(results: Iterable[Result]) -> list[str]:
    """A table by silence, and every finding that must not be."""
    runs, unnoticed, findings = Counter[float](), Counter[float](), Counter[float]()
    texts: list[str] = []
    for result in results:
        silent_s = result.plan.silent_s
        runs[silent_s] += 1
        unnoticed[silent_s] += result.is_unnoticed
        findings[silent_s] += bool(result.findings) and not result.is_unnoticed
        if result.findings and result.plan.must_be_noticed:
            texts.append(f"{result.plan}: {'; '.join(result.findings)}")
    lines = [f"{'silence s':>10}{'runs':>8}{'unnoticed':>11}{'other findings':>16}"]
    lines += [f"{one:>10}{runs[one]:>8}{unnoticed[one]:>11}{findings[one]:>16}" for one in sorted(runs)]
    return [*lines, *texts]
