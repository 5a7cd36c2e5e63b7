"""Defects of the simulated module: side effects of a set, wrong or missing replies."""

from functools import partial

from app.simulator.hardware import Hardware
from app.simulator.quirks import Marks, Occasion, Rule
from app.simulator.settings import clamped
from protocol.catalogue import BY_CODE, FLAG, INVERTED, Hazard, Request
from protocol.fields import Flag

_IN_MEMORY = {
    0x15: "light_threshold",
    0x20: "attitude_threshold",
    0x21: "freefall_acceleration",
    0x22: "freefall_time",
}
_IN_STATE: dict[int, tuple[str, Flag]] = {
    0x13: ("serial_output_is_on", FLAG),
    0x16: ("attitude_is_enabled", INVERTED),
    0x17: ("freefall_is_enabled", INVERTED),
}
_ACTIVATION = 0x10
CHANGEABLE_CODES = frozenset((_ACTIVATION, *_IN_MEMORY, *_IN_STATE))
"""Codes of what a rule can change."""
_REVERTING = CHANGEABLE_CODES - {_ACTIVATION, 0x13}


def is_marked_from(marks: Marks, what: int, time: int) -> bool:
    """Whether it is marked for every time, or from an earlier time on."""
    return what in marks or any(isinstance(one, Occasion) and one.what == what and time >= one.time for one in marks)


def is_marked_at(marks: Marks, what: int, time: int) -> bool:
    """Whether it is marked for every time, or for this one."""
    return what in marks or Occasion(what, time) in marks


def read_raw(module: Hardware, code: int) -> int:
    """The present byte of a setting or a state."""
    if code in _IN_MEMORY:
        return int(getattr(module.memory, _IN_MEMORY[code]))
    if code == _ACTIVATION:
        return int(module.state.is_active)
    name, field = _IN_STATE[code]
    return field.encode(getattr(module.state, name))


def write_raw(module: Hardware, code: int, raw: int) -> None:
    """Change it silently."""
    if code in _IN_MEMORY:
        setattr(module.memory, _IN_MEMORY[code], raw)
    elif code == _ACTIVATION:
        module.activate(is_active=raw == FLAG.true)
    else:
        name, field = _IN_STATE[code]
        setattr(module.state, name, raw == field.true)


def rules_for(rules: tuple[Rule, ...], code: int, time: int) -> list[Rule]:
    return [rule for rule in rules if rule.cause == code and rule.time in (0, time)]


def settings_before(module: Hardware) -> dict[int, int]:
    """Settings that may be reverted after the next request."""
    return {code: read_raw(module, code) for code in _REVERTING} if module.quirks.revert_ms else {}


def apply_side_effects(module: Hardware, request: Request, time: int, before: dict[int, int], now_s: float) -> None:
    """Side effects of a request that was answered, now or later."""
    quirks, code = module.quirks, request.command.code
    if request.hazard is Hazard.NONE:
        for rule in rules_for(quirks.read_changes, code, time):
            _change(module, rule, request.data, now_s)
        return
    for rule in rules_for(quirks.cross_talk, code, time):
        _change(module, rule, request.data, now_s)
    if quirks.revert_ms and code in before:
        module.plans.add(now_s + quirks.revert_ms / 1000, partial(write_raw, module, code, before[code]))
    if quirks.clamp_ms and code in _IN_MEMORY:
        module.plans.add(now_s + quirks.clamp_ms / 1000, partial(_clamp, module, code))
    if quirks.silent_restart_ms:
        at_s = now_s + quirks.silent_restart_ms / 1000
        module.plans.add(at_s, partial(module.restart, at_s, is_silent=True))


def _change(module: Hardware, rule: Rule, raw: int, now_s: float) -> None:
    act = partial(write_raw, module, rule.effect, raw if rule.value is None else rule.value)
    if rule.after_ms:
        module.plans.add(now_s + rule.after_ms / 1000, act)
    else:
        act()


def _clamp(module: Hardware, code: int) -> None:
    write_raw(module, code, clamped(BY_CODE[code], read_raw(module, code)))
