"""Commands at random modules: dialects, bad lines, lies, and what happens meanwhile; in virtual time.

What the program says is compared with what an independent module (`tests.module`) holds and with its log: nothing is
shown or called verified, READY, GO or done that is not so, and no frame changes the module that was not asked for.
"""

import json
import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

from protocol.fields import Value
from tests.campaigns.walk import truth
from tests.module.module import (
    ACCELERATION,
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
from tests.support.virtual_cli import Ran, VirtualCli

SEEN_AFTER_S: Final = 1.5  # what happened so shortly before the end may not have been seen any more
LOWEST_CELL: Final = 0xB8  # 3.68 V; any limit that this program knows is above it
SETTABLE: Final = (ACTIVATION, ATTITUDE_OFF, FREEFALL_OFF, ATTITUDE, ACCELERATION, TIME, LIGHT_THRESHOLD)
CODES: Final[Mapping[str, int]] = {
    "attitude_threshold_deg": ATTITUDE, "freefall_acceleration_g": ACCELERATION, "freefall_time_s": TIME,
    "light_threshold_v": LIGHT_THRESHOLD, "attitude_trigger": ATTITUDE_OFF, "freefall_trigger": FREEFALL_OFF,
    "baud_rate": BAUD,
}  # fmt: skip
FLAGS: Final = ("attitude_trigger", "freefall_trigger")
READABLE: Final = [key for key in CODES if key not in (*FLAGS, "baud_rate")]
WANTED: Final[Mapping[str, Value]] = {
    "attitude_threshold_deg": 65, "freefall_time_s": 1.8, "light_threshold_v": 2.0,
    "attitude_trigger": True, "freefall_trigger": False, "baud_rate": 57600,
}  # fmt: skip


class Command(NamedTuple):
    """`sets`: the codes that it may set."""

    words: str
    judge: Callable[["Ran", "Case"], Iterator[str]]
    sets: tuple[int, ...] = ()


class Happening(NamedTuple):
    """What is done to the module from outside, so long after the port was opened."""

    name: str
    act: Callable[[Module, float], object]
    after_s: float = 0.0


@dataclass
class Case:
    """One run as it was planned: the same seed plans the same. `held` and `is_triggered`: when it had ended."""

    seed: int
    command: str
    cli: VirtualCli
    happening: Happening | None = None

    def __post_init__(self) -> None:
        # One that is ACTIVE already may fire by itself.
        self.may_fire = self.module.settings[ACTIVATION] == 1 or self.happening is not None
        self.fired_before = len(self.module.records)

    @property
    def module(self) -> Module:
        return self.cli.module

    def __str__(self) -> str:
        honest = Options()
        odd = {name: value for name, value in vars(self.module.options).items() if value != getattr(honest, name)}
        happens = "" if self.happening is None else f", {self.happening.name} after {self.happening.after_s:.2f} s"
        return f"seed {self.seed}: {self.command}, {odd}{happens}"

    def happens_late(self, ran: Ran) -> bool:
        """Something happened, so late that the program may not know."""
        return self.happening is not None and self.happening.after_s > ran.took_s - SEEN_AFTER_S

    def run(self, home: Path) -> Ran:
        kept = {f"XDG_{kind}_HOME": str(home / kind) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
        happening, module = self.happening, self.module
        meanwhile = None if happening is None else lambda: happening.act(module, self.cli.clock.now_s)
        after_s = 0.0 if happening is None else happening.after_s
        words = COMMANDS[self.command].words.split()
        return self.cli.run(*words, "--json", meanwhile=meanwhile, after_s=after_s, HOME=str(home), **kept)


# What is planned


def _happenings(dice: random.Random) -> tuple[Happening, ...]:
    beats, off_s, silent_s = dice.choice((0, 1, 2)), dice.choice((0.1, 0.3, 0.6)), dice.choice((0.2, 0.6, 1.5))
    return (
        Happening("restart", lambda module, now: module.restart(now, heartbeats=beats, off_s=off_s)),
        Happening("silence", lambda module, now: module.be_silent(now, silent_s)),
        Happening("somebody activates", lambda module, _now: module.settings.update({ACTIVATION: 1})),
        Happening("somebody locks", lambda module, _now: module.settings.update({ACTIVATION: 0})),
        Happening("a setting changes", lambda module, _now: module.settings.update({ATTITUDE: 30})),
        Happening("it fires", lambda module, now: module.trigger(now, BY_SERIAL)),
    )


def _odd_options(dice: random.Random) -> Options:
    """Half of the modules are nearly honest, so that something is verified, READY and GO; the others have two or three
    oddities each."""
    options = Options()
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
                setattr(options, name, value)
    return options


def planned(seed: int) -> Case:
    """The run of this seed."""
    dice = random.Random(seed)
    cli = VirtualCli(_odd_options(dice), seed=seed)
    module = cli.module
    module.settings |= {code: int(dice.random() < 0.2) for code in (ACTIVATION, ATTITUDE_OFF, FREEFALL_OFF)}
    module.settings[ATTITUDE] = dice.choice((60, 70))
    module.readings.tilt_deg = dice.choice((*[2] * 14, 12, 80))
    module.readings.cell = dice.choice((*[0xC8] * 14, 0x90))
    for number in range(dice.choice((0, 0, 1, 3))):
        module.trigger(cli.clock.now_s + 40 * number, BY_SERIAL)  # equal ones cannot be told apart
    module.triggered = dice.random() < 0.05
    command = dice.choice([*COMMANDS, "check", "check and activate"])
    happening = dice.choice(_happenings(dice))._replace(after_s=dice.uniform(0.05, 4.0))
    return Case(seed, command, cli, happening if dice.random() < 0.3 else None)


# The judge


def judge(ran: Ran, case: Case) -> list[str]:
    """What was said or done and must not have been."""
    command = COMMANDS[case.command]
    return [*_judge_conduct(ran, case, command.sets), *command.judge(ran, case)]


def _judge_conduct(ran: Ran, case: Case, may_set: tuple[int, ...]) -> Iterator[str]:
    """What holds whatever was asked for."""
    log = case.module.log
    if "Traceback" in ran.stdout + ran.stderr or ran.said.get("error", {}).get("code") == "internal":
        yield f"an error of its own: {ran.stderr[-400:]}"
    if ran.returncode not in (0, 1, 3, 4):
        yield f"exit code {ran.returncode}"
    if not ran.said:
        yield "nothing was printed"
    activated = sum(entry.value == 1 for entry in log.sets(ACTIVATION))
    if activated > (case.command in ("activate", "check and activate")):
        yield "activated unasked, or twice"
    if any(log.sets(code) for code in (DEPLOY, SHUT_DOWN)) or log.got(ZERO):
        yield "a dangerous frame"
    if len(case.module.records) > case.fired_before and not case.may_fire:
        yield "it fired"
    for code, count in Counter(entry.code for entry in log.sets()).items():
        if code not in (*may_set, OUTPUT):
            yield f"{code:02X} was set unasked"
        elif count > 1 and code not in (OUTPUT, ACTIVATION):  # LOCK is repeated until it is reported
            yield f"{code:02X} was set {count} times"


def _judge_read(ran: Ran, case: Case) -> Iterator[str]:
    settings, holds = ran.said.get("settings", {}), truth(case.module)
    for key in READABLE:
        # What a lying second answer says may be what is read; what changes meanwhile may be read before.
        is_certain = CODES[key] not in case.module.options.second and case.happening is None
        if settings.get(key) not in (None, holds[key]) and is_certain:
            yield f"{key} is shown as {settings[key]}, and the module holds {holds[key]}"
    yield from (f"{key} is shown, and nobody can know it" for key in FLAGS if settings.get(key) is not None)
    if ran.returncode == 0 and (ran.said.get("errors") or None in [settings.get(key) for key in READABLE]):
        yield "exit code 0 without everything"


def _judge_history(ran: Ran, case: Case) -> Iterator[str]:
    kept = [body.hex(" ").upper() for body in case.module.records]
    records = ran.said.get("records", [])
    for record in records:
        if record["raw"][6:-3].upper() not in kept:
            yield f"a record that it does not keep: {record['raw']}"
    if ran.returncode == 0 and case.happening is None and len(records) != len(kept):
        yield f"complete with {len(records)} of {len(kept)}"


def _judge_set(ran: Ran, case: Case) -> Iterator[str]:
    holds, log = truth(case.module), case.module.log
    for key, result in ran.said.get("results", {}).items():
        if result.get("verified") and holds[key] != WANTED[key] and not case.happens_late(ran):
            yield f"{key} is called verified, and the module holds {holds[key]}"
        # E4: 17 may be acknowledged under 16.
        is_answered = log.sent(CODES[key]) or log.sent(case.module.options.freefall_code)
        if result.get("acknowledged") and not is_answered:
            yield f"{key} is called acknowledged, and nothing was"
        if ran.returncode == 0 and result.get("verified") is False:
            yield f"exit code 0, and {key} is not verified"


def _judge_check(ran: Ran, case: Case) -> Iterator[str]:
    verdict, module, held = ran.said.get("verdict"), case.module, case.module.settings
    if (ran.returncode in (0, 4)) != (verdict in ("GO", "READY")):
        yield f"exit code {ran.returncode} with {verdict}"
    if verdict not in ("GO", "READY") or case.happens_late(ran):
        return
    against = [check["id"] for check in ran.said["checks"] if check["result"] not in ("pass", "warn")]
    wrong = {
        f"against {', '.join(against)}": against,
        f"and active is {held[ACTIVATION]}": held[ACTIVATION] != (verdict == "GO"),
        # A flag that changes by itself, or is acknowledged and not set, cannot be noticed: none is ever read.
        "with a trigger that is off": any(
            held[flag] and flag not in (*module.options.reverts, *module.options.ignored_sets)
            for flag in (ATTITUDE_OFF, FREEFALL_OFF)
        ),
        f"and the attitude threshold is {held[ATTITUDE]}": (
            ran.said["read"]["settings"]["attitude_threshold_deg"] != held[ATTITUDE]
        ),
        "of a module that has triggered": module.triggered,
        f"at {module.readings.tilt_deg}° and a cell of {module.readings.cell}": (
            module.readings.tilt_deg > 10 or module.readings.cell < LOWEST_CELL
        ),
    }
    yield from (f"{verdict} {what}" for what, is_wrong in wrong.items() if is_wrong)


def _judge_act(ran: Ran, case: Case) -> Iterator[str]:
    is_wanted, is_active = case.command == "activate", bool(case.module.settings[ACTIVATION])
    if ACTIVATION in case.module.options.reverts:
        return  # it was so when the module said it
    if ran.returncode == 0 and is_active is not is_wanted and not case.happens_late(ran):
        yield f"exit code 0, and active is {is_active}"
    has_left = any(entry.value == 1 for entry in case.module.log.sets(ACTIVATION))
    if is_wanted and has_left and is_active and ran.returncode != 0 and "ACTIVE" not in ran.stderr:
        yield "it may be left active, and nothing says so"


_CHECK: Final = "preflight --enable-triggers --records-reviewed --module M1"
_BY_CHECK: Final = (ATTITUDE_OFF, FREEFALL_OFF, ACTIVATION)  # an active one is locked first


def _set(*keys: str) -> Command:
    words = " ".join(f"{key}={json.dumps(WANTED[key])}" for key in keys)
    return Command(f"set {words} --accept-risk", _judge_set, tuple(CODES[key] for key in keys))


COMMANDS: Final[Mapping[str, Command]] = {
    "read": Command("read", _judge_read),
    "history": Command("history", _judge_history),
    "set": _set("attitude_threshold_deg", "freefall_time_s", "light_threshold_v"),
    "set triggers": _set(*FLAGS),
    "set baud": _set("baud_rate"),
    "check": Command(_CHECK, _judge_check, _BY_CHECK),
    "check and activate": Command(f"{_CHECK} --activate --yes", _judge_check, _BY_CHECK),
    "activate": Command("activate --yes", _judge_act, (ACTIVATION,)),
    "lock": Command("lock", _judge_act, (ACTIVATION,)),
}


# The campaign


def campaign(seeds: Iterable[int], folder: Path) -> tuple[Counter[str], list[str]]:
    """What was said how often, and each finding with the seed that repeats it."""
    said, findings = Counter[str](), list[str]()
    for seed in seeds:
        case = planned(seed)
        ran = case.run(folder / f"{seed}")
        said[f"{case.command}: {ran.said.get('verdict') or f'exit {ran.returncode}'}"] += 1
        findings += [f"{case}: {one}" for one in judge(ran, case)]
    return said, findings
