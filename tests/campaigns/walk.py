"""Every job at an independent module, and everything that may happen at any of its frames; in virtual time.

The module is as delivered, or speaks, fails and lies in its own way. Whatever happens, a job ends in time
with its result, `Interrupted` or `Cancelled`; nothing is shown, called verified, READY, GO or confirmed that the module
does not hold, or that is of two modules; nothing that changes a module is sent unasked, twice, or to another module
than the one that was asked; and what must end the conversation ends it.
"""

import math
import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from typing import Any, Final, NamedTuple

from app.engine.conversation import Interrupted
from app.engine.procedure import Cancelled, Job, Pause, Procedure
from app.engine.transport import PortError, PortErrorKind
from app.limits.past import Past
from app.preflight.checks import Case, Person
from app.preflight.evidence import Evidence
from app.preflight.run import activate_ready, run_preflight
from app.preflight.verdict import Assessment, Verdict, assess
from app.procedures.act import Performed, perform
from app.procedures.find import RateSearch, find_rate
from app.procedures.history import History, read_history
from app.procedures.light import Band, measure_light
from app.procedures.lock import Locked, lock
from app.procedures.read import Readings as Read
from app.procedures.read import read_everything, read_settings
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import SettingChange, WriteContext, WriteReport, change_baud, set_each, write_all
from app.safety.journal import REQUESTS, Act, Outcome
from app.settings.profiles import NO_PROFILE
from protocol.catalogue import BAUD_RATE, BY_NAME, COMMANDS, LOCK
from protocol.events import Began, Ended, EndReason, Unanswered
from protocol.fields import Value
from tests.module.module import (
    ACCELERATION,
    ACTIVATION,
    ATTITUDE,
    ATTITUDE_OFF,
    BAUD,
    BY_SERIAL,
    CELL,
    CHARGING,
    DEPLOY,
    FREEFALL_OFF,
    LIGHT_THRESHOLD,
    OUTPUT,
    RECORDS,
    SHUT_DOWN,
    STATUS,
    TIME,
    ZERO,
    Module,
    Readings,
)
from tests.module.options import Options
from tests.module.wire import FROM_HOST, answer, with_sum
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig, Wear
from tests.support.line.sim_line import FakeClock

LIMIT_S: Final = 180.0
FLAGS_FREE_S: Final = 3.2  # 16 and 17 may be set so long after a port was opened (E4)
SETTLED_S: Final = 2.5
NEW_RATE: Final = 57600
SEEN_AFTER_S: Final = 1.5  # what happened so shortly before the end may not have been seen any more
STEP_S: Final = 0.05
LEAP: Final = "clock leaps an hour"

# The modules


class _Holds(NamedTuple):
    """What a module says of itself, as D4."""

    boots: int
    tilt: int
    acceleration: int
    cell: int
    light: int
    settings: Mapping[int, int]


# They have nothing in common.
HELD: Final = (
    _Holds(10, 2, 10, 0xC8, 3, {LIGHT_THRESHOLD: 18, ATTITUDE: 60, ACCELERATION: 5, TIME: 160}),
    _Holds(90, 12, 9, 0xC0, 8, {LIGHT_THRESHOLD: 28, ATTITUDE: 70, ACCELERATION: 4, TIME: 130}),
)


def made_module(held: _Holds, name: str, now: float) -> Module:
    module = Module(Options(light_closed=held.light), name=name, now=now)
    module.readings = Readings(held.tilt, held.acceleration, cell=held.cell, boots=held.boots)
    module.settings |= held.settings
    for _ in range(3):
        module.trigger(now, 0x01)
    module.triggered = False
    return module


def truth(module: Module) -> dict[str, Value]:
    """What it holds, by the keys of the program."""
    settings, readings = module.settings, module.readings
    return {
        "light_threshold_v": settings[LIGHT_THRESHOLD] / 10,
        "attitude_threshold_deg": settings[ATTITUDE],
        "freefall_acceleration_g": settings[ACCELERATION] / 10,
        "freefall_time_s": settings[TIME] / 100,
        "attitude_trigger": settings[ATTITUDE_OFF] == 0,
        "freefall_trigger": settings[FREEFALL_OFF] == 0,
        "serial_output": settings[OUTPUT] == 1,
        "baud_rate": module.rate,
        "boot_count": readings.boots,
        "active": settings[ACTIVATION] == 1,
        "triggered": module.triggered,
        "tilt_deg": readings.tilt_deg,
        "acceleration_g": readings.acceleration / 10,
        "charging": readings.charging == 1,
        "cell_voltage_v": readings.cell / 50,
        "light_v": module.options.light_closed / 10,
    }


# Modules that speak, fail and lie in their own way, and what somebody else does to one meanwhile; by a seed

SETTABLE: Final = (ACTIVATION, ATTITUDE_OFF, FREEFALL_OFF, ATTITUDE, ACCELERATION, TIME, LIGHT_THRESHOLD)
FLAGS: Final = (ATTITUDE_OFF, FREEFALL_OFF)
LOWEST_CELL: Final = 0xB8  # 3.68 V; any limit that this program knows is above it
STEEPEST_DEG: Final = 10  # likewise
EMPTY_CELL: Final = 0x90
FALLEN_DEG: Final = 80

MEANWHILE: Final[Mapping[str, Callable[[Module, float], object]]] = {
    "somebody activates": lambda module, _now: module.settings.update({ACTIVATION: 1}),
    "somebody locks": lambda module, _now: module.settings.update({ACTIVATION: 0}),
    "a setting changes": lambda module, _now: module.settings.update({ATTITUDE: 30}),
    "it restarts without a heartbeat": lambda module, now: module.restart(now, heartbeats=0),
    "it fires": lambda module, now: module.trigger(now, BY_SERIAL),
}


def make_odd(module: Module, seed: int) -> None:
    """Half of the modules are nearly honest, so that something is verified, READY and GO; the others have two or three
    oddities each."""
    dice = random.Random(seed)
    share = dice.choice((0.02, 0.12))
    settable, times = dice.choice(SETTABLE), dice.choice((1, 2, -1))
    oddities: tuple[dict[str, Any], ...] = (
        {"misprinted_sum": True},
        {"acknowledged_by_one": set(dice.sample(SETTABLE, 3))},
        {"voltage_code": 0x34},
        {"freefall_code": 0x16},
        {"records_at_once": dice.choice((1, 2, 3)), "record_gap_s": dice.choice((0.02, 0.2, 0.5))},
        {"empty_slot": dice.choice((None, 0xFF))},
        {"activation_survives": True},
        {"flags_survive": False},
        {"baud_answer": dice.choice(("new", "none"))},
        {"delay_s": dice.choice((0.02, 0.1, 0.3))},
        {"jitter_s": dice.choice((0.05, 0.3))},
        {"lose": dice.choice((0.002, 0.01))},
        {"lost_answers": {settable: times}},
        {"lost_sets": {settable: times}},
        {"ignored_sets": {dice.choice(SETTABLE): times}},
        {"copies": {dice.choice(SETTABLE): [dice.choice((0.05, 0.3, 0.8, 2.0))]}},
        {"query_copies": {dice.choice((0x20, 0x23, 0x30, 0x31, 0x32, 0x35)): [dice.choice((0.05, 0.4))]}},
        {"instead": {dice.choice((0x30, 0x31)): dice.choice(("01 00", "01 01"))}},
        {"second": {dice.choice((0x20, 0x21, 0x30, 0x31)): (dice.choice((0.01, 0.2)), "01 01")}},
        {"reverts": {dice.choice(SETTABLE): (dice.choice((0.1, 0.5)), None)}},
    )
    for oddity in oddities:
        if dice.random() < share:
            for name, value in oddity.items():
                setattr(module.options, name, value)
    module.settings |= {code: int(dice.random() < 0.2) for code in (ACTIVATION, *FLAGS)}
    module.readings.tilt_deg = dice.choice((*[module.readings.tilt_deg] * 14, FALLEN_DEG))
    module.readings.cell = dice.choice((*[module.readings.cell] * 14, EMPTY_CELL))
    module.records.clear()
    for number in range(dice.choice((0, 0, 1, 3))):
        module.trigger(module.began_at + 40 * number, BY_SERIAL)  # equal ones cannot be told apart
    module.triggered = dice.random() < 0.05


def unknowable(options: Options) -> set[int]:
    """Codes of which nobody can know what the module holds: it lies about them, changes them by itself, or acknowledges
    and does not do what can never be asked. A status that comes again is taken for the stream."""
    unasked = [code for code in FLAGS if code in options.ignored_sets]
    lies = {*options.instead, *options.second, *options.reverts}
    return {*lies, *unasked, *([OUTPUT] if STATUS in options.query_copies else [])}


# The jobs

CHANGES: Final = [
    SettingChange(BY_NAME["freefall_time"], 1.8),
    SettingChange(BY_NAME["attitude_threshold"], 65),
    SettingChange(BY_NAME["freefall_acceleration"], 0.3),
    SettingChange(BY_NAME["light_threshold"], 2.2),
]
TRIGGERS: Final = [SettingChange(BY_NAME["freefall_trigger"], True), SettingChange(BY_NAME["attitude_trigger"], True)]
Begin = Callable[[ModuleRig, FakeJournal], Job[Any]]


def _idle() -> Procedure[None]:
    yield Pause(3.0)


def _simply(make: Callable[[], Procedure[Any]], *, outlives: bool = False) -> Begin:
    return lambda rig, _journal: rig.job(make(), outlives=outlives)


def _written(count: int) -> Begin:
    return lambda rig, journal: rig.job(write_all(CHANGES[:count], WriteContext(journal=journal)))


def _acted(act: Act) -> Begin:
    def begin(rig: ModuleRig, journal: FakeJournal) -> Job[Any]:
        rig.module.settings[ACTIVATION] = int(act in (Act.DEPLOY, Act.FORBID_DEPLOY))
        expects = frozenset({EndReason.SILENT}) if act is Act.SHUTDOWN else frozenset[EndReason]()
        return rig.job(perform(act, journal, permit=rig.permit(act)), expects=expects)

    return begin


def _baud(rig: ModuleRig, journal: FakeJournal) -> Job[Any]:
    return rig.job(change_baud(NEW_RATE, journal, permit=rig.permit(Act.CHANGE_BAUD)), outlives=True)


def _lock(rig: ModuleRig, journal: FakeJournal) -> Job[Any]:
    rig.module.settings[ACTIVATION] = 1
    return rig.job(lock(journal), is_urgent=True, outlives=True)


def _assessed(evidence: Evidence) -> Assessment:
    person = Person(are_records_reviewed=True, are_settings_approved=True)
    return assess(Case(evidence=evidence, profile=NO_PROFILE, past=Past(), person=person))


def _check(journal: FakeJournal) -> Procedure[Evidence]:
    evidence = Evidence()
    yield from run_preflight(evidence, is_enabling=True, journal=journal)
    return evidence


def _checked_and_activated(rig: ModuleRig, journal: FakeJournal) -> Job[Any]:
    def check() -> Procedure[Evidence]:
        evidence = yield from _check(journal)
        ready = _assessed(evidence)
        if ready.verdict is Verdict.READY:
            _, evidence = yield from activate_ready(ready, journal, rig.permit(Act.ACTIVATE))
        return evidence

    return rig.job(check())


JOBS: Final[Mapping[str, Begin]] = {
    "nothing": _simply(_idle),
    "read": _simply(read_everything),
    "settings": _simply(read_settings),
    "history": _simply(read_history),
    "light": _simply(measure_light),
    "find": _simply(lambda: find_rate(115200), outlives=True),
    "write one": _written(1),
    "write four": _written(4),
    "triggers": lambda rig, journal: rig.job(set_each(TRIGGERS, WriteContext(journal=journal))),
    "baud": _baud,
    "activate": _acted(Act.ACTIVATE),
    "zero": _acted(Act.ZERO),
    "deploy": _acted(Act.DEPLOY),
    "forbid": _acted(Act.FORBID_DEPLOY),
    "shut down": _acted(Act.SHUTDOWN),
    "check": lambda rig, journal: rig.job(_check(journal)),
    "check and activate": _checked_and_activated,
    "lock": _lock,
}
FREE_FLAGS: Final = ("triggers", "check", "check and activate")
ACTIVATES: Final = ("activate", "check and activate")
# What each may send but questions; the stream is switched in the background.
MAY_SEND: Final[Mapping[str, tuple[int, ...]]] = {
    "write one": (TIME,),
    "write four": (TIME, ATTITUDE, ACCELERATION, LIGHT_THRESHOLD),
    "triggers": FLAGS,
    "check": FLAGS,
    "check and activate": (*FLAGS, ACTIVATION),
    "activate": (ACTIVATION,),
    "baud": (BAUD,),
    "zero": (ZERO,),
    "deploy": (DEPLOY,),
    "forbid": (DEPLOY,),
    "shut down": (SHUT_DOWN,),
}


# What happens


@dataclass(frozen=True)
class Happening:
    begin: Callable[["Run"], object]
    must_end: bool = False
    """The conversation; and what runs in it does not go on."""
    hides: frozenset[str] = frozenset()
    """Keys of what it changes without a sign."""


def _worn(**wear: Any) -> Happening:
    return Happening(lambda run: setattr(run.rig.line, "wear", replace(run.rig.line.wear, **wear)))


def _next_frame(change: Callable[[bytes], bytes]) -> Happening:
    return Happening(lambda run: setattr(run.rig.line, "change_next", change))


def _silent(seconds: float, **more: Any) -> Happening:
    return Happening(lambda run: run.module.be_silent(run.now_s, seconds), **more)


def _comes(data: bytes, **more: Any) -> Happening:
    """Bytes that are no answers, three times."""

    def begin(run: "Run") -> None:
        for number in range(3):
            run.rig.line.inject(data, 0.3 * number)

    return Happening(begin, **more)


def _asks_too(run: "Run") -> None:
    """Another program asks, and the answers arrive here."""
    for code in (STATUS, CELL, ATTITUDE):
        run.module.hear(with_sum(FROM_HOST + bytes((code, 1, 0))), run.now_s)


def _streams(run: "Run") -> None:
    run.module.options.stream_hz = 400.0
    run.module.settings[OUTPUT] = 1


SILENCES_S: Final = (0.5, 1.5)  # a shorter one is the blind spot
EXCHANGES: Final[Mapping[str, Happening]] = {
    f"another module after {silent_s} s{', announced' * is_announced}": Happening(
        lambda run, silent_s=silent_s, is_announced=is_announced: run.rig.line.move(  # type: ignore[misc]
            run.modules[1], silent_s, is_announced=is_announced
        ),
        must_end=True,
    )
    for silent_s, is_announced in product(SILENCES_S, (False, True))
}
FAULTS: Final[Mapping[str, Happening]] = {
    "port lost": Happening(lambda run: run.fail(PortErrorKind.LOST)),
    "cancelled": Happening(lambda run: run.job.cancel()),
    "module silent": _silent(1000.0, must_end=True),
    "module silent for 0.3 s": _silent(0.3),
    "module silent for 0.6 s": _silent(0.6, must_end=True),
    "module restarts": Happening(lambda run: run.module.restart(run.now_s), must_end=True),
    "module switched off": Happening(lambda run: setattr(run.module, "is_on", False), must_end=True),
    LEAP: Happening(lambda run: setattr(run.rig.clock, "now_s", run.now_s + 3600.0), must_end=True),
    "request lost": Happening(lambda run: setattr(run.rig.line, "loses_requests", 1)),
    "reply lost": _next_frame(lambda _frame: b""),
    "reply corrupted": _next_frame(lambda frame: frame[:-1] + bytes((frame[-1] ^ 0x10,))),
    "reply cut off": _next_frame(lambda frame: frame[: len(frame) // 2]),
    "replies in pieces": _worn(byte_pause_s=0.02),
    "replies in bursts": _worn(blocks_s=0.2),
    "adapter holds bytes for 16 ms": _worn(blocks_s=0.016),
    "replies 700 ms late": _worn(lag_s=0.7),
    "replies 1.4 s late": _worn(lag_s=1.4),
    "replies doubled": _worn(repeats=1.0, repeats_after_s=(0.0, 0.0)),
    # A status that was not asked for is taken for the stream.
    "replies come again later": replace(_worn(repeats=0.2), hides=frozenset({"serial_output"})),
    "echo of its own bytes": _worn(is_echoing=True),
    "half duplex": _worn(is_half_duplex=True),
    "wrong rate": Happening(lambda run: setattr(run.module, "rate", 19200), hides=frozenset({"baud_rate"})),
    "login prompt": _comes(b"\r\nDebian GNU/Linux 12 raspberrypi ttyS0\r\n\r\nraspberrypi login: "),
    "modem prober": _comes(b"AT\r" * 3 + b"ATE0\r" + b"\x7e\x00\x78\xf0\x7e"),
    "half a frame": _comes(bytes.fromhex("41 75 32 41 75")),
    # Asked in that very moment, it cannot be told apart.
    "frames of another conversation": _comes(answer(CHARGING, b"\x01\x01"), hides=frozenset({"charging"})),
    "a stream that does not stop": Happening(_streams),
    "garbage that does not stop": _worn(noise_every_s=0.01),
    "a second program reads": _worn(has_second_reader=True),
    "a second program asks": Happening(_asks_too),
    "5 % of all frames lost": _worn(loss=0.05),
    "5 % of all bytes lost": _worn(lost_bytes=0.05),
    "2 % of all bytes corrupted": _worn(turned_bytes=0.02),
}


def _meanwhile(act: Callable[[Module, float], object]) -> Happening:
    # A setting is not asked for again by itself.
    return Happening(lambda run: act(run.module, run.now_s), hides=frozenset({"attitude_threshold_deg"}))


OTHERS: Final = {name: _meanwhile(act) for name, act in MEANWHILE.items()}
HAPPENINGS: Final = {**FAULTS, **EXCHANGES, **OTHERS}


# One run


class Plan(NamedTuple):
    """It happens at the `frame`-th frame after the job began: before it leaves, or when the module has heard it.
    `odd_seed`: makes the module odd."""

    job: str
    happening: str
    frame: int
    is_heard: bool = False
    streams: bool = False
    odd_seed: int | None = None


@dataclass
class Result:
    plan: Plan
    has_happened: bool = False
    verdict: Verdict | None = None
    is_unnoticed: bool = False
    """The conversation went on."""
    findings: list[str] = field(default_factory=list)


class Run:
    """One job on a line, what happens to it, and the judge of both."""

    rig: ModuleRig

    def __init__(self, plan: Plan) -> None:
        self.plan, self.result, self.frames = plan, Result(plan), 0
        self.happening = HAPPENINGS.get(plan.happening, Happening(lambda _run: None))
        self._frames_before = 0
        clock = FakeClock()
        self.modules = tuple(made_module(held, name, clock.now_s) for held, name in zip(HELD, "AB", strict=True))
        if plan.odd_seed is not None:
            make_odd(self.modules[0], plan.odd_seed)
        self.hides = self.happening.hides | {KEYS[code] for code in unknowable(self.modules[0].options) & KEYS.keys()}
        self._happened_at = self._ended_at = math.inf
        switch = StreamSwitch(is_wanted=plan.streams)
        self.rig = ModuleRig(modules=self.modules[:1], clock=clock, background=lambda: watch(switch, listen_s=0.2))
        self.rig.max_step_s = STEP_S
        self.rig.begin()
        self.rig.step_for(FLAGS_FREE_S if plan.job in FREE_FLAGS else 0.8)
        self._sent_before = len(self.rig.line.sent)
        self.job: Job[Any] = JOBS[plan.job](self.rig, FakeJournal())
        self.rig.line.on_frame = self._before
        self.rig.line.on_heard = self._heard
        self._fired_before = len(self.module.records)
        # One that is ACTIVE already may fire by itself.
        self._may_fire = self.module.settings[ACTIVATION] == 1 or plan.happening in OTHERS

    @property
    def module(self) -> Module:
        return self.rig.line.modules[0]

    @property
    def now_s(self) -> float:
        return self.rig.clock.now_s

    @property
    def sent(self) -> list[bytes]:
        return self.rig.line.sent[self._sent_before :]

    def go(self) -> Result:
        rig = self.rig
        reason = EndReason.CLOSED
        try:
            ends_s = self.now_s + LIMIT_S + 3600.0 * (self.plan.happening == LEAP)
            while not self.job.has_ended and self.now_s < ends_s:
                self._step()
            self._ended_at = self.now_s
            if not self.job.has_ended:
                self._find("the job goes on")
            settled_s = self.now_s + SETTLED_S
            while self.now_s < settled_s:
                self._step()
            if rig.conversation.is_going:
                self._judge_values({key: rig.conversation.fresh(key, self.now_s) for key in rig.conversation.values})
        except PortError:
            reason = EndReason.PORT_LOST
        self.result.is_unnoticed = not any(isinstance(one, Ended) for one in rig.events)
        rig.session.close(reason)
        if rig.line.error is not None and reason is EndReason.CLOSED:
            self._find("the port's error was not seen")
        self._judge()
        return self.result

    def _is_lasting(self, code: int) -> bool:
        """What the module was set to it still is, as far as it is for this program."""
        return code not in self.modules[0].options.reverts and self.plan.happening not in OTHERS

    @property
    def _is_news(self) -> bool:
        """Somebody did something to the module so late that the job may not know."""
        is_late = self._ended_at - SEEN_AFTER_S < self._happened_at < math.inf
        return self.plan.happening in OTHERS and is_late

    def _step(self) -> None:
        """Nothing shown in one conversation is of two modules."""
        self.rig.step(STEP_S)
        owners = {OWNERS.get((key, known.value)) for key, known in self.rig.conversation.values.items()} - {None}
        if len(owners) > 1:
            self._find("values of two modules in one conversation")

    def _find(self, text: str) -> None:
        if text not in self.result.findings:
            self.result.findings.append(text)

    # It happens

    def fail(self, trouble: PortErrorKind) -> None:
        self.rig.line.error = PortError(trouble, "line", "failed")

    def _before(self, _frame: bytes) -> None:
        if not self.plan.is_heard:
            self._happen()
        self.frames += not self.job.has_ended

    def _heard(self, _frame: bytes) -> None:
        if self.plan.is_heard:
            self._happen()

    def _happen(self) -> None:
        is_now = self.frames == self.plan.frame + self.plan.is_heard and not self.job.has_ended
        if is_now and not self.result.has_happened:
            self.result.has_happened = True
            self._happened_at = self.now_s
            self._frames_before = self.frames
            self.happening.begin(self)

    # The judge

    def _judge_values(self, values: Mapping[str, Value | None], *, may_be_before: bool = False) -> None:
        """`may_be_before`: what was read may have been changed since by a restart, whose count then is another one."""
        holds = truth(self.module)
        for key, value in values.items():
            if value is None or key in self.hides or value == holds[key]:
                continue
            if may_be_before and (key, value) == ("boot_count", HELD[0].boots):
                continue
            self._find(f"{key} is {value}, and the module holds {holds[key]}")

    def _judge(self) -> None:
        view, job = self.rig.conversation, self.job
        must_end = self.happening.must_end and self.result.has_happened
        if must_end and self.result.is_unnoticed:
            self._find("the conversation goes on")
        must_end = must_end and (self.frames > self._frames_before or not self.plan.is_heard)
        if any(view.fresh(key, self.now_s) is not None for key in view.values):
            self._find("shown as certain although the port is closed")
        self._judge_sent()
        if not job.has_ended:
            self._find("the job goes on although the port is closed")
        elif job.error is None:
            self._judge_result(job.outcome(), must_end=must_end)
        elif not isinstance(job.error, Interrupted | Cancelled):
            self._find(f"ended with {job.error!r}")

    def _judge_sent(self) -> None:
        sets = Counter(frame for frame in self.sent if frame[3] == 2 or frame[2] == ZERO)
        for frame, count in sets.items():
            is_lock = frame[2] == ACTIVATION and frame[4] == 0
            if count > 1 and frame[2] != OUTPUT and not is_lock:  # LOCK is repeated until it is reported
                self._find(f"{frame.hex(' ')} was sent {count} times")
            may_lock = self.plan.job == "lock" or self.plan.job in ACTIVATES  # where that is interrupted
            if frame[2] not in (*MAY_SEND.get(self.plan.job, ()), OUTPUT) and not (may_lock and frame == LOCK.encode()):
                self._find(f"{frame.hex(' ')} was sent unasked")
        if len(self.modules[0].records) > self._fired_before and not self._may_fire and self.plan.job not in ACTIVATES:
            self._find("it fired")
        for entry in [*self.modules[1].log.sets(), *self.modules[1].log.acts()]:
            is_lock = entry.code == ACTIVATION and entry.value == 0
            if entry.code != OUTPUT and not (is_lock and self.plan.job == "lock"):
                self._find(f"{entry.frame.hex(' ')} to another module")

    def _judge_result(self, result: object, *, must_end: bool) -> None:
        first = self.modules[0]
        match result:
            case WriteReport():
                self._judge_report(result)
                if must_end and result.is_fine and result.results[0].command is not BAUD_RATE:  # a job of the port
                    self._find("the report is fine")
            case Performed():
                self._judge_act(result)
            case Evidence():
                if must_end and result.void is None:
                    self._find("the check is not void")
                self._judge_check(_assessed(result))
            case Read():
                if self.module is first:
                    self._judge_values(result.values, may_be_before=True)
            case History():
                kept = [with_sum(b"\x41\x75" + record) for record in first.records]
                if any(record.raw not in kept for record in result.records):
                    self._find("a record that it does not keep")
                if result.is_confirmed and len(result.records) != len(kept) and self._is_lasting(RECORDS):
                    self._find("complete, and not all that it keeps")
            case Locked(is_locked=True) if self.module.settings[ACTIVATION] and self._is_lasting(ACTIVATION):
                self._find("called locked")
            case RateSearch():
                self._judge_rate(result.baud_rate)
            case Band():
                if set(result.raws) - {first.options.light_closed}:
                    self._find(f"light {result.raws}")

    def _judge_rate(self, found: Value | None) -> None:
        if found not in (None, self.module.rate) and "baud_rate" not in self.hides:
            self._find(f"found at {found}, and the module is at {self.module.rate}")

    def _judge_report(self, report: WriteReport) -> None:
        first = self.modules[0]
        for written in report.results:
            request = written.command.set(written.target)
            is_held = first.settings.get(written.command.code) == request.data
            if written.command is BAUD_RATE:
                self._judge_rate(written.read_back)
                is_held = first.rate == written.target
            if written.verified and not is_held and not self._is_news:
                self._find(f"{written.command.name} verified, but not held")
            if not written.is_sent and request.encode() in self.sent:
                self._find(f"{written.command.name} called not sent")
            if written.is_acknowledged and not first.log.sets(written.command.code):
                self._find(f"{written.command.name} called acknowledged")

    def _judge_check(self, assessment: Assessment) -> None:
        first, verdict = self.modules[0], assessment.verdict
        self.result.verdict = verdict
        if verdict is Verdict.NO_GO or self._is_news:
            return
        held, readings = first.settings, first.readings
        wrong = {
            f"with active {held[ACTIVATION]}": held[ACTIVATION] != (verdict is Verdict.GO),
            "with a trigger that is off": any(held[flag] for flag in FLAGS if flag not in unknowable(first.options)),
            f"with {held[ATTITUDE]}°": assessment.case.evidence.values["attitude_threshold_deg"] != held[ATTITUDE],
            "of a module that has triggered": first.triggered,
            f"at {readings.tilt_deg}°": readings.tilt_deg > STEEPEST_DEG,
            f"with a cell of {readings.cell}": readings.cell < LOWEST_CELL,
        }
        for what in (what for what, is_so in wrong.items() if is_so):
            self._find(f"{verdict.value} {what}")

    def _judge_act(self, done: Performed) -> None:
        first, frame = self.modules[0], REQUESTS[done.act].encode()
        is_done = any(entry.frame == frame and entry.note in ("", "unanswered") for entry in first.log.got())
        if done.act is Act.DEPLOY:
            is_done = len(first.records) > self._fired_before
        is_certain = self._is_lasting(frame[2])
        if done.outcome is Outcome.CONFIRMED and not is_done and is_certain:
            self._find(f"{done.act.value} confirmed, but not done")
        if done.outcome is Outcome.REFUSED and is_done and is_certain:
            self._find(f"{done.act.value} called refused, and done")
        if done.outcome is Outcome.NOT_SENT and frame in self.sent:
            self._find(f"{done.act.value} called not sent")


def _owners() -> Mapping[tuple[str, Value], int]:
    """Whose each value is, where it tells. A restart adds one to the boot count."""
    owners: dict[tuple[str, Value], int] = {}
    for number, held in enumerate(HELD):
        module = made_module(held, "", 0.0)
        values = truth(module).items()
        owners |= {item: number for item in values if not isinstance(item[1], bool) and item[0] != "baud_rate"}
        owners |= {("boot_count", held.boots + starts): number for starts in range(4)}
    owners |= {(change.command.key, change.value): 0 for change in CHANGES}  # written to the first one only
    return owners


OWNERS: Final = _owners()
KEYS: Final = {command.code: command.key for command in COMMANDS if command.key in truth(made_module(HELD[0], "", 0.0))}


# The walk


@cache
def frames_of(job: str, *, streams: bool) -> int:
    """How many frames it sends when nothing happens."""
    run = Run(Plan(job, "", -1, streams=streams))
    assert run.go().findings == [], job
    return run.frames


def cells(job: str, happenings: Iterable[str], seed: int) -> Iterator[Plan]:
    """The job with each happening, at a frame that the seed chooses."""
    for happening in happenings:
        dice = random.Random(f"{seed} {job} {happening}")
        streams = dice.random() < 0.5
        frame = dice.randrange(frames_of(job, streams=streams))
        yield Plan(job, happening, frame, dice.random() < 0.5, streams)


def odd_cells(job: str, seeds: Iterable[int]) -> Iterator[Plan]:
    """The job at an odd module of each seed, to which somebody does something now and then."""
    for seed in seeds:
        dice = random.Random(f"{seed} {job}")
        happening, streams = dice.choice(("", "", "", *OTHERS)), dice.random() < 0.5
        frame = dice.randrange(frames_of(job, streams=streams))
        yield Plan(job, happening, frame, dice.random() < 0.5, streams, dice.randrange(10**9))


def walk(plans: Iterable[Plan]) -> Iterator[Result]:
    return (Run(plan).go() for plan in plans)


# Lines that do nothing worse than what is common

LINES: Final[Mapping[str, tuple[Wear, float]]] = {
    "good": (Wear(), 0.002),
    "loses 5 %": (Wear(loss=0.05), 0.002),
    "loses 10 %": (Wear(loss=0.10), 0.002),
    "repeats a fifth, 0.25 to 0.8 s later": (Wear(repeats=0.2), 0.002),
    "0.7 s late": (Wear(lag_s=0.7), 0.002),
    "up to 0.7 s late": (Wear(jitter_s=0.7), 0.002),
    "half duplex": (Wear(is_half_duplex=True), 0.002),
    "half duplex, loses 5 %": (Wear(is_half_duplex=True, loss=0.05), 0.002),
    "answers take 50 ms, loses 5 %": (Wear(loss=0.05), 0.05),
    "answers take 100 ms": (Wear(), 0.1),
    "answers take 100 ms, loses 5 %": (Wear(loss=0.05), 0.1),
    "answers take 250 ms": (Wear(), 0.25),
    "answers take 250 ms, loses 5 %": (Wear(loss=0.05), 0.25),
}
"""And in how many seconds the module answers."""


class Found(NamedTuple):
    begins: int
    ends: Counter[str]  # by reason
    unanswered: int


def watched(wear: Wear, answer_s: float, seconds: float, *, streams: bool, seed: int = 1) -> Found:
    """Watch one module that answers all the time, streamed or polled, as the window does: how often does a conversation
    end without reason?"""
    switch = StreamSwitch(is_wanted=streams)
    rig = ModuleRig(Options(delay_s=answer_s), wear=wear, background=lambda: watch(switch), seed=seed)
    rig.max_step_s = STEP_S
    begins, unanswered, ends = 0, 0, Counter[str]()
    end_s = rig.clock.now_s + seconds
    while rig.clock.now_s < end_s:
        rig.step_for(min(60.0, end_s - rig.clock.now_s))
        begins += sum(isinstance(event, Began) for event in rig.events)
        unanswered += sum(isinstance(event, Unanswered) and not event.may_be_done for event in rig.events)
        ends.update(event.reason.name for event in rig.events if isinstance(event, Ended))
        for kept in rig.events, rig.module.log, rig.line.sent:
            kept.clear()
    return Found(begins, ends, unanswered)
