"""A simulated module that lies: side effects of a set or a query, doubled and missing replies; and one that does not
hear every request.

    lying_bench({"cross_talk": "21:20=14/2@500", "ack": "one"}, clock)

A rule such as `21:20=14/2@500`: a request to 21 changes 20, with the value 14, the second time only, 500 ms
later. A mark such as `35/2`: that code or record number, the second time.
"""

import math
import re
from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Final, NamedTuple

from app.simulator.bench import Clock, SimulatedBench
from app.simulator.module import ACCEPTED, BITS_PER_BYTE, SimulatedModule
from app.simulator.setup import parse_options
from protocol.catalogue import FLAG, TRIGGER_RECORDS, Hazard, Request
from protocol.frame import encode_reply
from tests.support.line.odd_module import IN_MEMORY, IN_STATE, OddModule, OddSetup, as_text, codes, odd

_RULE: Final = re.compile(r"(\w{2}):(\w{2})(?:=(\w{2}))?(?:/(\d+))?(?:@([\d.]+))?", re.ASCII)
_ACTIVATION: Final = 0x10
_ROUNDING_S: Final = 1e-9
"""Times that differ by less are equal."""


class Rule(NamedTuple):
    cause: int
    effect: int
    value: int | None
    """Byte of the effect; None for the one that was set."""
    time: int
    """The n-th time only; 0 for every time."""
    after_s: float


class Mark(NamedTuple):
    what: int
    time: int
    """0 for every time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lies:
    mute_codes: tuple[Mark, ...] = ()
    """Ignored from that time on."""
    cross_talk: tuple[Rule, ...] = ()
    """Effects of a set."""
    read_changes: tuple[Rule, ...] = ()
    """Effects of a query."""
    drop_records: tuple[Mark, ...] = ()
    double_codes: frozenset[int] = frozenset()
    double_ms: float = 0.0
    silent_restart_ms: float = 0.0
    min_gap_ms: float = 0.0
    """Requests that begin sooner after the last reply or request are ignored."""
    activates: bool = True
    locks: bool = True
    shuts_down: bool = True


def _rule(text: str) -> Rule:
    match = _RULE.fullmatch(text)
    assert match is not None, text
    cause, effect, value, time, after_ms = match.groups()
    return Rule(
        int(cause, 16), int(effect, 16), None if value is None else int(value, 16), int(time or 0),
        float(after_ms or 0) / 1000,
    )  # fmt: skip


def _rules(text: str) -> tuple[Rule, ...]:
    return tuple(map(_rule, text.split(",")))


def _marks(text: str, base: int) -> tuple[Mark, ...]:
    parts = [part.partition("/") for part in text.split(",")]
    return tuple(Mark(int(what, base), int(time or 0)) for what, _, time in parts)


_PARSED: Final[Mapping[str, Callable[[str], Any]]] = {
    "mute_codes": partial(_marks, base=16), "drop_records": partial(_marks, base=10), "double_codes": codes,
    "cross_talk": _rules, "read_changes": _rules,
}  # fmt: skip


def lies_of(options: Mapping[str, Any]) -> Lies:
    """Those of the options, as they are typed, that are lies."""
    found: dict[str, Any] = {}
    for field in fields(Lies):
        if field.name in options:
            parse = _PARSED.get(field.name, "yes".__eq__ if isinstance(field.default, bool) else float)
            found[field.name] = parse(options[field.name])
    return Lies(**found)


def lying_bench(options: Mapping[str, Any], clock: Clock) -> SimulatedBench:
    """A module with these options, as values or as they are typed, of which some may be lies."""
    texts = {name.replace("-", "_"): as_text(value) for name, value in options.items()}
    lies = {
        name: text for name, text in texts.items()
        if name in Lies.__slots__ and not (name == "mute_codes" and "/" not in text)
    }  # fmt: skip
    plain = {name: text for name, text in texts.items() if name not in lies}
    bench = SimulatedBench(OddSetup(**parse_options(plain)), clock=clock, kind=LyingModule)
    lying(bench).lies = lies_of(lies)
    return bench


def lying(bench: SimulatedBench) -> "LyingModule":
    assert isinstance(bench.module, LyingModule)
    return bench.module


def write_raw(module: SimulatedModule, code: int, raw: int) -> None:
    """Change it silently, between two requests."""
    if code in IN_MEMORY:
        setattr(module.memory, IN_MEMORY[code], raw)
    elif code == _ACTIVATION:
        module.activate(is_active=raw == FLAG.true)
    else:
        name, field = IN_STATE[code]
        setattr(module.state, name, raw == field.true)


class LyingModule(OddModule):
    """Lies count from when they were last set."""

    def __init__(self, *args: Any, **more: Any) -> None:
        self._is_obeying = False
        self._is_streamed = False
        self._said: list[bytes] = []
        """What was sent for the request that is carried out."""
        self._ready_s = -math.inf
        """When it next heeds a request."""
        self.lies = Lies()
        super().__init__(*args, **more)

    @property
    def lies(self) -> Lies:
        return self._lies

    @lies.setter
    def lies(self, lies: Lies) -> None:
        self._lies, self._asked = lies, Counter[tuple[int, bool]]()

    def _plan_while_on(self, at_s: float, act: Callable[[], object]) -> None:
        """Do this then, unless the module was switched off in between."""
        booted_s = self._booted_s
        self.plan(at_s, lambda _at_s: act() if self.is_on and self._booted_s == booted_s else None)

    # Requests

    def obey(self, request: Request, now_s: float) -> None:
        lies, code = self.lies, request.command.code
        self._asked[code, request.is_set] += 1
        time = self._asked[code, request.is_set]
        total = self._asked[code, True] + self._asked[code, False]
        if any(mark.what == code and total >= mark.time for mark in lies.mute_codes) or code in odd(self).mute_codes:
            return
        self._answer(request, time, now_s)
        is_query = request.hazard is Hazard.NONE
        for rule in _due_rules(lies.read_changes if is_query else lies.cross_talk, code, time):
            self._change(rule, request.data, now_s)
        if lies.silent_restart_ms and not is_query:
            at_s = now_s + lies.silent_restart_ms / 1000
            self._plan_while_on(at_s, partial(self.restart, at_s, is_silent=True))

    def _answer(self, request: Request, time: int, now_s: float) -> None:
        """The reply of an honest module, as far as it is let."""
        lies, code, memory = self.lies, request.command.code, self.memory
        records = memory.records
        if request.command is TRIGGER_RECORDS:
            dropped = {mark.what for mark in lies.drop_records if mark.time in (0, time)}
            memory.records = deque(data for number, data in enumerate(records, start=1) if number not in dropped)
        self._is_obeying, self._said = True, []
        if code != 0x12 or lies.shuts_down:
            self.carry_out(request, now_s)
        else:
            self.send(encode_reply(code, ACCEPTED), now_s)
        self._is_obeying, said = False, self._said
        if request.command is TRIGGER_RECORDS:
            memory.records = records
        for data in said if code in lies.double_codes else ():
            self.plan(now_s + lies.double_ms / 1000, partial(self.send_while_on, data, self._booted_s))

    def _change(self, rule: Rule, raw: int, now_s: float) -> None:
        act = partial(write_raw, self, rule.effect, raw if rule.value is None else rule.value)
        if rule.after_s:
            self._plan_while_on(now_s + rule.after_s, act)
        else:
            act()

    # What it hears

    def receive(self, data: bytes, now_s: float) -> None:
        self.advance(now_s)
        super().receive(self._heard_part(data, now_s), now_s)

    def _heard_part(self, data: bytes, ends_s: float) -> bytes:
        byte_s = BITS_PER_BYTE / self.baud_rate
        begins_s, gap_s = ends_s - len(data) * byte_s, self.lies.min_gap_ms / 1000
        is_too_soon = begins_s < self._ready_s - _ROUNDING_S
        self._ready_s = max(self._ready_s, ends_s + gap_s)
        return b"" if gap_s and is_too_soon else data

    def send(self, data: bytes, now_s: float) -> None:
        super().send(data, now_s)
        if self._is_obeying:
            self._said.append(data)
        if not self._is_streamed:
            self._ready_s = max(self._ready_s, self._out[-1].ends_s + self.lies.min_gap_ms / 1000)

    # What an honest module does

    def stream(self, now_s: float) -> None:
        self._is_streamed = True
        super().stream(now_s)
        self._is_streamed = False

    def activate(self, *, is_active: bool) -> None:
        if not self._is_obeying or (self.lies.activates if is_active else self.lies.locks):
            super().activate(is_active=is_active)


def _due_rules(rules: tuple[Rule, ...], code: int, time: int) -> list[Rule]:
    return [rule for rule in rules if rule.cause == code and rule.time in (0, time)]
