"""Modules that speak, fail and lie in their own way, and what somebody else does to one meanwhile; by a seed."""

import random
from collections.abc import Callable, Mapping
from typing import Any, Final

from tests.module.module import (
    ACCELERATION,
    ACTIVATION,
    ATTITUDE,
    ATTITUDE_OFF,
    BY_SERIAL,
    FREEFALL_OFF,
    LIGHT_THRESHOLD,
    OUTPUT,
    STATUS,
    TIME,
    Module,
)
from tests.module.options import Options

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
