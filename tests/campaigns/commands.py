"""Commands of the real program at random modules: dialects, bad lines, lies, and what happens meanwhile.

Each run starts `dps-s` in a process of its own on a pseudo-terminal, at whose other end is an independent module
(`tests.module`). What the program says is compared with what that module holds and with its log: nothing is shown or
called verified, READY, GO or done that is not so, and no frame changes the module that was not asked for.
"""

import json
import random
import subprocess
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from tests.module.line import Line, now
from tests.module.module import (
    ACTIVATION,
    ATTITUDE,
    ATTITUDE_OFF,
    BAUD,
    BY_SERIAL,
    DEPLOY,
    FREEFALL_OFF,
    LIGHT_THRESHOLD,
    OUTPUT,
    SHUT_DOWN,
    TIME,
    ZERO,
    Module,
)
from tests.module.options import Options
from tests.support.processes import PROGRAM, ROOT, environment

LIMIT_S: Final = 240.0
SEEN_AFTER_S: Final = 1.5
"""What happened so shortly before the end may not have been seen any more."""
NEW_RATE: Final = 57600
LOWEST_CELL: Final = 0xB8
"""3.68 V; any limit that this program knows is above it."""
SETTABLE: Final = (ACTIVATION, ATTITUDE_OFF, FREEFALL_OFF, ATTITUDE, 0x21, TIME, LIGHT_THRESHOLD)
READ: Final[Mapping[str, tuple[int, float]]] = {
    "attitude_threshold_deg": (ATTITUDE, 1),
    "freefall_time_s": (TIME, 100),
    "light_threshold_v": (LIGHT_THRESHOLD, 10),
}
"""By key: the code, and what a unit is worth in D4."""
WANTED: Final[Mapping[str, tuple[str, int, int]]] = {
    "attitude_threshold_deg": ("65", ATTITUDE, 65),
    "freefall_time_s": ("1.8", TIME, 180),
    "light_threshold_v": ("2.0", LIGHT_THRESHOLD, 20),
    "attitude_trigger": ("true", ATTITUDE_OFF, 0),
    "freefall_trigger": ("false", FREEFALL_OFF, 1),
}
"""By key: what is typed, the code, and the byte that it means."""
_CHECK: Final = ("preflight", "--enable-triggers", "--records-reviewed", "--module", "M1")
COMMANDS: Final[Mapping[str, tuple[str, ...]]] = {
    "read": ("read",),
    "history": ("history",),
    "set": ("set", *(f"{key}={WANTED[key][0]}" for key in READ), "--accept-risk"),
    "set triggers": ("set", "attitude_trigger=true", "freefall_trigger=false", "--accept-risk"),
    "set baud": ("set", f"baud_rate={NEW_RATE}"),
    "check": _CHECK,
    "check and activate": (*_CHECK, "--activate", "--yes"),
    "activate": ("activate", "--yes"),
    "lock": ("lock",),
}


@dataclass
class Happening:
    """What is done to the module from outside, so long after the command was started."""

    at_s: float
    name: str
    act: Callable[[Module], None]


@dataclass
class Case:
    """One run as it was planned: the same seed plans the same."""

    seed: int
    command: str
    module: Module
    happening: Happening | None

    def __str__(self) -> str:
        honest = Options()
        odd = {name: value for name, value in vars(self.module.options).items() if value != getattr(honest, name)}
        happens = "" if self.happening is None else f", {self.happening.name} after {self.happening.at_s:.2f} s"
        return f"seed {self.seed}: {self.command}, {odd}{happens}"


@dataclass
class Ran:
    """What came of a run. `held` and `triggered` are the module's when the command had ended."""

    case: Case
    code: int
    out: str
    err: str
    took_s: float
    held: Mapping[int, int]
    is_triggered: bool
    said: Mapping[str, Any] = field(default_factory=dict)
    """The last object on standard output."""

    @property
    def is_late_happening(self) -> bool:
        """Something happened, so late that the program may not know."""
        happening = self.case.happening
        return happening is not None and happening.at_s > self.took_s - SEEN_AFTER_S

    def frames(self, code: int, value: int | None = None) -> int:
        """How many frames of this code changed something."""
        changing = [*self.case.module.log.sets(code), *(one for one in self.case.module.log.got(code) if code == ZERO)]
        return sum(value in (None, entry.value) for entry in changing)


# What is planned


def _happenings(dice: random.Random) -> Iterator[tuple[str, Callable[[Module], None]]]:
    beats, off_s, silent_s = dice.choice((0, 1, 2)), dice.choice((0.1, 0.3, 0.6)), dice.choice((0.2, 0.6, 1.5))
    yield "restart", lambda module: module.restart(now(), heartbeats=beats, off_s=off_s)
    yield "silence", lambda module: module.be_silent(now(), silent_s)
    yield "somebody activates", lambda module: module.settings.update({ACTIVATION: 1})
    yield "somebody locks", lambda module: module.settings.update({ACTIVATION: 0})
    yield "a setting changes", lambda module: module.settings.update({ATTITUDE: 30})
    yield "it fires", lambda module: module.trigger(now(), BY_SERIAL)


def _odd_options(dice: random.Random) -> Options:
    """Half of the modules are nearly honest, so that something is verified, READY and GO; the others have two or three
    oddities each."""
    options = Options()
    share = dice.choice((0.02, 0.12))
    times = (1, 2, -1)
    oddities: tuple[Callable[[], dict[str, Any]], ...] = (
        lambda: {"misprinted_sum": True},
        lambda: {"acknowledged_by_one": set(dice.sample(SETTABLE, 3))},
        lambda: {"voltage_code": 0x34},
        lambda: {"freefall_code": 0x16},
        lambda: {"records_at_once": dice.choice((1, 2, 3)), "record_gap_s": dice.choice((0.02, 0.2, 0.5))},
        lambda: {"empty_slot": dice.choice((None, 0xFF))},
        lambda: {"activation_survives": True},
        lambda: {"flags_survive": False},
        lambda: {"baud_answer": dice.choice(("new", "none"))},
        lambda: {"delay_s": dice.choice((0.02, 0.1, 0.3))},
        lambda: {"jitter_s": dice.choice((0.05, 0.3))},
        lambda: {"lose": dice.choice((0.002, 0.01))},
        lambda: {"lost_answers": {dice.choice(SETTABLE): dice.choice(times)}},
        lambda: {"lost_sets": {dice.choice(SETTABLE): dice.choice(times)}},
        lambda: {"ignored_sets": {dice.choice(SETTABLE): dice.choice(times)}},
        lambda: {"copies": {dice.choice(SETTABLE): [dice.choice((0.05, 0.3, 0.8, 2.0))]}},
        lambda: {"query_copies": {dice.choice((0x20, 0x23, 0x30, 0x31, 0x32, 0x35)): [dice.choice((0.05, 0.4))]}},
        lambda: {"instead": {dice.choice((0x30, 0x31)): dice.choice(("01 00", "01 01"))}},
        lambda: {"second": {dice.choice((0x20, 0x21, 0x30, 0x31)): (dice.choice((0.01, 0.2)), "01 01")}},
        lambda: {"reverts": {dice.choice(SETTABLE): (dice.choice((0.1, 0.5)), None)}},
    )
    for oddity in oddities:
        if dice.random() < share:
            for name, value in oddity().items():
                setattr(options, name, value)
    return options


def planned(seed: int) -> Case:
    """The run of this seed."""
    dice = random.Random(seed)
    module = Module(_odd_options(dice), seed=seed, now=now())
    module.settings |= {
        ACTIVATION: int(dice.random() < 0.2),
        ATTITUDE_OFF: int(dice.random() < 0.2),
        FREEFALL_OFF: int(dice.random() < 0.2),
        ATTITUDE: dice.choice((60, 70)),
    }
    readings = module.readings
    readings.tilt_deg = dice.choice((*[2] * 14, 12, 80))
    readings.cell = dice.choice((*[0xC8] * 14, 0x90))
    for _ in range(dice.choice((0, 0, 1, 3))):
        module.trigger(now(), BY_SERIAL)
    module.triggered = dice.random() < 0.05
    command = dice.choice([*COMMANDS, "check", "check and activate"])
    happening = None
    if dice.random() < 0.3:
        name, act = dice.choice(list(_happenings(dice)))
        happening = Happening(dice.uniform(0.1, 4.0), name, act)
    return Case(seed, command, module, happening)


# The run


def run(case: Case, folder: Path, program: Sequence[str] = PROGRAM) -> Ran:
    """Run the command; `folder` is the home of this run alone."""
    home = folder / f"{case.seed}"
    home.mkdir()
    module = case.module
    words = COMMANDS[case.command]
    with Line(module, link=str(home / "port")) as line:
        began_s = now()
        if case.happening is not None:
            timer = threading.Timer(case.happening.at_s, case.happening.act, [module])
            timer.daemon = True
            timer.start()
        command = [*program, words[0], "--port", line.port, *words[1:], "--json"]
        kept = {f"XDG_{kind}_HOME": str(home / kind) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
        own = environment(HOME=str(home), LC_ALL="C.UTF-8", **kept)
        done = subprocess.run(
            command, cwd=ROOT, env=own, capture_output=True, encoding="utf-8", timeout=LIMIT_S, check=False
        )
        ran = Ran(
            case, done.returncode, done.stdout, done.stderr, now() - began_s, dict(module.settings), module.triggered
        )
        if case.happening is not None:
            timer.cancel()
            timer.join()
    lines = ran.out.splitlines()
    ran.said = json.loads(lines[-1]) if lines else {}
    return ran


# The judge


def judge(ran: Ran) -> list[str]:
    """What was said or done and must not have been."""
    return [*_conduct(ran), *_JUDGES[ran.case.command](ran)]


def _conduct(ran: Ran) -> Iterator[str]:
    """What holds whatever was asked for."""
    command = ran.case.command
    if "Traceback" in ran.out + ran.err or ran.said.get("error", {}).get("code") == "internal":
        yield f"an error of its own: {ran.err[-400:]}"
    if ran.code not in (0, 1, 3, 4):
        yield f"exit code {ran.code}"
    if not ran.said:
        yield "nothing was printed"
    if ran.frames(ACTIVATION, 1) > (command in ("activate", "check and activate")):
        yield "activated unasked, or twice"
    for code in (DEPLOY, SHUT_DOWN, ZERO):
        if ran.frames(code):
            yield f"a dangerous frame {code:02X}"
    asked_for = {
        "set": [WANTED[key][1] for key in READ],
        "set triggers": [ATTITUDE_OFF, FREEFALL_OFF],
        "set baud": [BAUD],
        "check": [ATTITUDE_OFF, FREEFALL_OFF, ACTIVATION],  # an active one is locked first
        "check and activate": [ATTITUDE_OFF, FREEFALL_OFF, ACTIVATION],
        "activate": [ACTIVATION],
        "lock": [ACTIVATION],
    }.get(command, [])
    counts = Counter(entry.code for entry in ran.case.module.log.sets())
    for code, count in counts.items():
        if code not in (*asked_for, OUTPUT):
            yield f"{code:02X} was set unasked"
        elif count > 1 and code not in (OUTPUT, ACTIVATION):  # LOCK is repeated until it is reported
            yield f"{code:02X} was set {count} times"


def _judge_read(ran: Ran) -> Iterator[str]:
    options = ran.case.module.options
    settings = ran.said.get("settings", {})
    for key, (code, per_unit) in READ.items():
        value = settings.get(key)
        # What a lying second answer says may be what is read; what changes meanwhile may be read before.
        is_certain = code not in options.second and ran.case.happening is None
        if value is not None and is_certain and round(value * per_unit) != ran.held[code]:
            yield f"{key} is shown as {value}, and the module holds {ran.held[code]}"
    for key in ("attitude_trigger", "freefall_trigger"):
        if settings.get(key) is not None:
            yield f"{key} is shown, and nobody can know it"
    if ran.code == 0 and (ran.said.get("errors") or None in [settings.get(key) for key in READ]):
        yield "exit code 0 without everything"


def _judge_history(ran: Ran) -> Iterator[str]:
    kept = [body.hex(" ").upper() for body in ran.case.module.records]
    for record in ran.said.get("records", []):
        if record["raw"][6:-3].upper() not in kept:
            yield f"a record that it does not keep: {record['raw']}"
    is_whole = ran.case.happening is None
    if ran.code == 0 and is_whole and len(ran.said["records"]) != len(kept):
        yield f"complete with {len(ran.said['records'])} of {len(kept)}"


def _judge_set(ran: Ran) -> Iterator[str]:
    log = ran.case.module.log
    for key, result in ran.said.get("results", {}).items():
        _, code, byte = WANTED[key]
        if result["verified"] and ran.held[code] != byte and not ran.is_late_happening:
            yield f"{key} is called verified, and the module holds {ran.held[code]}"
        # E4: 17 may be acknowledged under 16.
        answers = [entry for entry in log.sent() if entry.code in (code, ran.case.module.options.freefall_code)]
        if result["acknowledged"] and not answers:
            yield f"{key} is called acknowledged, and nothing was"
        if ran.code == 0 and result["verified"] is False:
            yield f"exit code 0, and {key} is not verified"


def _judge_baud(ran: Ran) -> Iterator[str]:
    result = ran.said.get("results", {}).get("baud_rate", {})
    if result.get("verified") and ran.case.module.rate != NEW_RATE:
        yield f"{NEW_RATE} is called verified, and the module is at {ran.case.module.rate}"


def _judge_check(ran: Ran) -> Iterator[str]:
    verdict = ran.said.get("verdict")
    if (ran.code in (0, 4)) != (verdict in ("GO", "READY")):
        yield f"exit code {ran.code} with {verdict}"
    if verdict not in ("GO", "READY") or ran.is_late_happening:
        return
    module = ran.case.module
    against = [check["id"] for check in ran.said["checks"] if check["result"] not in ("pass", "warn")]
    if against:
        yield f"{verdict} against {', '.join(against)}"
    if ran.held[ACTIVATION] != (verdict == "GO"):
        yield f"{verdict}, and active is {ran.held[ACTIVATION]}"
    # A flag that changes by itself cannot be noticed: none is ever read.
    if any(ran.held[flag] and flag not in module.options.reverts for flag in (ATTITUDE_OFF, FREEFALL_OFF)):
        yield f"{verdict} with a trigger that is off"
    if ran.said["read"]["settings"]["attitude_threshold_deg"] != ran.held[ATTITUDE]:
        yield f"{verdict}, and the attitude threshold is {ran.held[ATTITUDE]}"
    if ran.is_triggered:
        yield f"{verdict} of a module that has triggered"
    if module.readings.tilt_deg > 10 or module.readings.cell < LOWEST_CELL:
        yield f"{verdict} at {module.readings.tilt_deg}° and a cell of {module.readings.cell}"


def _judge_act(ran: Ran) -> Iterator[str]:
    is_wanted = ran.case.command == "activate"
    if ACTIVATION in ran.case.module.options.reverts:
        return  # it was so when the module said it
    if ran.code == 0 and bool(ran.held[ACTIVATION]) is not is_wanted and not ran.is_late_happening:
        yield f"exit code 0, and active is {ran.held[ACTIVATION]}"
    if is_wanted and ran.frames(ACTIVATION, 1) and ran.held[ACTIVATION] and ran.code != 0 and "ACTIVE" not in ran.err:
        yield "it may be left active, and nothing says so"


_JUDGES: Final[Mapping[str, Callable[[Ran], Iterator[str]]]] = {
    "read": _judge_read,
    "history": _judge_history,
    "set": _judge_set,
    "set triggers": _judge_set,
    "set baud": _judge_baud,
    "check": _judge_check,
    "check and activate": _judge_check,
    "activate": _judge_act,
    "lock": _judge_act,
}


# The campaign


def campaign(seeds: Iterable[int], folder: Path, *, at_once: int = 8) -> Iterator[tuple[Ran, list[str]]]:
    """Run all of them, several at once: each waits most of the time."""

    def judged(seed: int) -> tuple[Ran, list[str]]:
        ran = run(planned(seed), folder)
        return ran, judge(ran)

    with ThreadPoolExecutor(at_once) as pool:
        yield from pool.map(judged, seeds)


def told(results: Iterable[tuple[Ran, list[str]]]) -> tuple[list[str], int]:
    """What was said how often, and each finding with the seed that repeats it; how many runs had one."""
    said, findings, broken = Counter[str](), list[str](), 0
    for ran, found in results:
        answer = ran.said.get("verdict") or f"exit {ran.code}"
        said[f"{ran.case.command}: {answer}"] += 1
        broken += bool(found)
        findings += [f"{ran.case}: {one}" for one in found]
    return [*(f"{count:>6}  {what}" for what, count in sorted(said.items())), *findings], broken
