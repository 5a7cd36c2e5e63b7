"""Every command that talks to a module, and everything that is done at the window: what it may send, the state of its
module, and its judge."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from app.engine.procedure import MAX_LOCKS
from app.safety.acts import REQUESTS, Act
from protocol.catalogue import BY_NAME, SETTINGS
from protocol.fields import Value
from tests.adversary import judge, window
from tests.adversary.program import PORT

WANTED: Final[Mapping[str, Value]] = {
    "attitude_threshold_deg": 70,
    "freefall_acceleration_g": 0.4,
    "freefall_time_s": 1.8,
    "light_threshold_v": 2.0,
    "attitude_trigger": True,
    "freefall_trigger": False,
    "serial_output": True,
}
_BY_KEY: Final = {command.key: command for command in SETTINGS}
NEW_RATE: Final = 57600
_SIGNED: Final = ("--who", "A", "--module", "M1", "--aircraft", "B", "--records-reviewed")
STREAM: Final = {BY_NAME["serial_output"].set(value).encode(): 4 for value in (True, False)}
TRIGGERS: Final = {BY_NAME[name].set(True).encode(): 2 for name in ("attitude_trigger", "freefall_trigger")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A command; `words` lacks the port, `acts` holds the frames that change the module and their greatest counts."""

    name: str
    words: tuple[str, ...]
    judge: judge.Judge
    acts: Mapping[bytes, int] = field(default_factory=dict)
    module: Mapping[str, Any] = field(default_factory=dict)
    """Options of the module at the start."""

    @property
    def argv(self) -> list[str]:
        return [self.words[0], "--port", PORT, *self.words[1:]]


def _typed(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def _set(name: str, *keys: str) -> Command:
    wanted = {key: WANTED[key] for key in keys}
    return Command(
        name=name,
        words=("set", "--json", "--accept-risk", *(f"{key}={_typed(value)}" for key, value in wanted.items())),
        judge=judge.judge_set(wanted),
        acts={_BY_KEY[key].set(value).encode(): 1 for key, value in wanted.items()},
    )


def _act(act: Act, judged_by: judge.Judge, **module: Any) -> Command:
    return Command(
        name=act.value,
        words=(act.value, "--yes"),
        judge=judged_by,
        acts={REQUESTS[act].encode(): MAX_LOCKS if act is Act.LOCK else 1},
        module=module,
    )


COMMANDS: Final[tuple[Command, ...]] = (
    Command(name="read", words=("read", "--json"), judge=judge.judge_read),
    Command(name="read active", words=("read", "--json"), judge=judge.judge_read, module={"active": True}),
    *(_set(f"set {key}", key) for key in WANTED),
    _set("set several", "attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "attitude_trigger"),
    _set("set all", *WANTED),
    Command(
        name="set baud_rate",
        words=("set", "--json", f"baud_rate={NEW_RATE}"),
        judge=judge.judge_baud(NEW_RATE),
        acts={BY_NAME["baud_rate"].set(NEW_RATE).encode(): 1},
    ),
    Command(name="history", words=("history", "--json"), judge=judge.judge_history),
    Command(name="history none", words=("history", "--json"), judge=judge.judge_history, module={"history": 0}),
    Command(name="history nine", words=("history", "--json"), judge=judge.judge_history, module={"history": 9}),
    Command(name="find", words=("find", "--json"), judge=judge.judge_find, module={"baud": 19200}),
    Command(name="monitor", words=("monitor", "--json", "--seconds", "2"), judge=judge.judge_monitor, acts=STREAM),
    Command(name="preflight", words=("preflight", "--json", *_SIGNED), judge=judge.judge_preflight),
    Command(
        name="preflight triggers",
        words=("preflight", "--json", "--enable-triggers", *_SIGNED),
        judge=judge.judge_preflight,
        acts=TRIGGERS,
    ),
    Command(
        name="preflight active",
        words=("preflight", "--json", "--enable-triggers", *_SIGNED),
        judge=judge.judge_preflight,
        acts=TRIGGERS,
        module={"active": True},
    ),
    _act(Act.LOCK, judge.judge_activation(is_wanted=False), active=True),
    _act(Act.ACTIVATE, judge.judge_activation(is_wanted=True)),
    _act(Act.ZERO, judge.judge_zero, tilt=4),
    _act(Act.SHUTDOWN, judge.judge_shutdown),
)


@dataclass(frozen=True, slots=True)
class Gestures:
    """What somebody does at the window; the rest as in `Command`."""

    make: Callable[[window.Session], None]
    acts: Mapping[bytes, int] = field(default_factory=dict)
    module: Mapping[str, Any] = field(default_factory=dict)


def _once(act: Act) -> dict[bytes, int]:
    return {REQUESTS[act].encode(): 1}


WINDOW: Final[Mapping[str, Gestures]] = {
    "window: watch": Gestures(window.watch),
    "window: watch active": Gestures(window.watch, module={"active": True}),
    "window: write": Gestures(window.write, {_BY_KEY[key].set(one).encode(): 1 for key, one in window.DRAFTS.items()}),
    "window: lock": Gestures(window.lock, {REQUESTS[Act.LOCK].encode(): MAX_LOCKS}, {"active": True}),
    "window: activate": Gestures(window.act(Act.ACTIVATE), _once(Act.ACTIVATE)),
    "window: zero": Gestures(window.act(Act.ZERO), _once(Act.ZERO), {"tilt": 4.0}),
    "window: preflight": Gestures(window.check, {**TRIGGERS, **_once(Act.ACTIVATE)}),
    "window: shutdown": Gestures(window.act(Act.SHUTDOWN), _once(Act.SHUTDOWN)),
}
BY_COMMAND: Final = {command.name: command for command in COMMANDS}
NAMES: Final = (*BY_COMMAND, *WINDOW)
