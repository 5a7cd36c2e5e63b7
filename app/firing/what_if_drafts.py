"""Draft thresholds for the what-if analysis; they are never written to the module."""

from collections.abc import Mapping
from typing import NamedTuple

from app.firing.judge import TriggerLimits
from protocol.catalogue import BY_NAME, Command
from protocol.fields import Value
from protocol.translatable import marked

ATTITUDE_TRIGGER = BY_NAME["attitude_trigger"]
ATTITUDE_THRESHOLD = BY_NAME["attitude_threshold"]
FREEFALL_TRIGGER = BY_NAME["freefall_trigger"]
FREEFALL_ACCELERATION = BY_NAME["freefall_acceleration"]
FREEFALL_TIME = BY_NAME["freefall_time"]
TRIED: tuple[Command, ...] = (
    ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION, FREEFALL_TIME, ATTITUDE_TRIGGER, FREEFALL_TRIGGER,
)  # fmt: skip
"""In the order of display."""
TITLES = {command.key: command.title for command in TRIED} | {FREEFALL_ACCELERATION.key: marked("Free fall below")}
"""In English, marked; short enough for the panel."""
_KEYS = frozenset(command.key for command in TRIED)


class SettingSource(NamedTuple):
    """The module's value, now or when it was recorded."""

    value: Value
    is_stale: bool = False
    """It may have changed since."""


class Question(NamedTuple):
    """What is judged. A trigger without a known threshold is off in `limits`."""

    limits: TriggerLimits
    unknown: tuple[Command, ...] = ()
    """Thresholds without a value; their trigger is not judged."""
    assumed: tuple[Command, ...] = ()
    """Triggers whose state is unknown; they are judged as enabled."""
    stale: tuple[Command, ...] = ()
    """Values of the module that may have changed."""


class WhatIfDrafts:
    """A draft for each setting; without one the module's own value. Not thread-safe."""

    def __init__(self) -> None:
        self.values: dict[str, Value] = {}
        self.standing: Mapping[str, SettingSource] = {}
        """The module's values, by key; without the unknown ones."""

    def choose(self, key: str, value: Value) -> None:
        self.values[key] = value

    def withdraw(self, key: str) -> None:
        self.values.pop(key, None)

    def fill(self, values: Mapping[str, Value]) -> None:
        """Replace all drafts; other keys are ignored."""
        self.values = {key: value for key, value in values.items() if key in _KEYS}

    def value(self, command: Command) -> Value | None:
        """The draft, else the module's value; None if unknown."""
        draft, standing = self.values.get(command.key), self.standing.get(command.key)
        return draft if draft is not None or standing is None else standing.value

    def question(self) -> Question:
        missing = tuple(command for command in (ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION, FREEFALL_TIME)
                        if self.value(command) is None)  # fmt: skip
        usual = TriggerLimits()

        def named(command: Command, usually: float) -> float:
            value = self.value(command)
            return usually if value is None else float(value)

        def is_on(trigger: Command, *needed: Command) -> bool:
            return self.value(trigger) is not False and not set(needed) & set(missing)

        limits = TriggerLimits(
            attitude_threshold_deg=named(ATTITUDE_THRESHOLD, usual.attitude_threshold_deg),
            freefall_acceleration_g=named(FREEFALL_ACCELERATION, usual.freefall_acceleration_g),
            freefall_time_s=named(FREEFALL_TIME, usual.freefall_time_s),
            attitude_is_enabled=is_on(ATTITUDE_TRIGGER, ATTITUDE_THRESHOLD),
            freefall_is_enabled=is_on(FREEFALL_TRIGGER, FREEFALL_ACCELERATION, FREEFALL_TIME),
        )
        held = {command: self.standing[command.key] for command in TRIED if command.key in self.standing}
        return Question(
            limits,
            unknown=missing,
            assumed=tuple(trigger for trigger in (ATTITUDE_TRIGGER, FREEFALL_TRIGGER) if self.value(trigger) is None),
            stale=tuple(command for command in held if held[command].is_stale and command.key not in self.values),
        )
