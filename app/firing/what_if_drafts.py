"""Draft thresholds for what-if analysis; without a draft the module's own value. Nothing is written."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from app.firing.judge import TriggerLimits
from app.settings.drafts import Draft, draft_for, draft_of
from protocol.catalogue import BY_NAME, Command
from protocol.fields import Value

ATTITUDE_TRIGGER = BY_NAME["attitude_trigger"]
ATTITUDE_THRESHOLD = BY_NAME["attitude_threshold"]
FREEFALL_TRIGGER = BY_NAME["freefall_trigger"]
FREEFALL_ACCELERATION = BY_NAME["freefall_acceleration"]
FREEFALL_TIME = BY_NAME["freefall_time"]
TRIED: tuple[Command, ...] = (
    ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION, FREEFALL_TIME, ATTITUDE_TRIGGER, FREEFALL_TRIGGER,
)  # fmt: skip
"""In the order in which they are shown."""
_BY_KEY = {command.key: command for command in TRIED}


@dataclass(frozen=True, slots=True)
class SettingSource:
    """What the module has, or had when it was recorded."""

    value: Value
    is_stale: bool = False
    """It was so, and something casts doubt on it."""


@dataclass(frozen=True, slots=True)
class Question:
    """What is to be judged. A trigger of which a threshold is not known is off in `limits`."""

    limits: TriggerLimits
    unknown: tuple[Command, ...] = ()
    """Thresholds that nobody named; their trigger is not judged."""
    invalid: tuple[Command, ...] = ()
    """What was typed is no value; their trigger is not judged."""
    assumed: tuple[Command, ...] = ()
    """Whether these triggers are enabled is not known; they are judged as if they were."""
    stale: tuple[Command, ...] = ()
    """Taken from what the module said once, and may no longer be true."""


class WhatIfDrafts:
    """Belongs to one thread."""

    def __init__(self) -> None:
        self._drafts: dict[str, Draft] = {}
        self.standing: Mapping[str, SettingSource] = {}
        """By the setting's key; what is not in it is not known."""

    def draft(self, key: str) -> Draft | None:
        return self._drafts.get(key)

    @property
    def has_drafts(self) -> bool:
        return bool(self._drafts)

    @property
    def values(self) -> dict[str, Value]:
        """What is wanted, where that is a value."""
        return {key: draft.value for key, draft in self._drafts.items() if draft.value is not None}

    def type_text(self, key: str, text: str) -> None:
        """Take what was typed so far; an empty text wants what the module has."""
        plain = text.strip()
        if plain:
            self._drafts[key] = draft_of(_BY_KEY[key], plain)
        else:
            self.withdraw(key)

    def choose(self, key: str, value: Value) -> None:
        self._drafts[key] = draft_for(_BY_KEY[key], value)

    def withdraw(self, key: str) -> None:
        self._drafts.pop(key, None)

    def fill(self, values: Mapping[str, Value]) -> None:
        """Want these and nothing else; keys that are not tried are left out."""
        self._drafts = {key: draft_for(_BY_KEY[key], value) for key, value in values.items() if key in _BY_KEY}

    def value(self, command: Command) -> Value | None:
        """What is wanted, else what the module has; None where neither is known, or what was typed is no value."""
        draft, standing = self._drafts.get(command.key), self.standing.get(command.key)
        if draft is not None:
            return draft.value
        return None if standing is None else standing.value

    def question(self) -> Question:
        """What is to be judged now."""
        thresholds = {one: self.value(one) for one in (ATTITUDE_THRESHOLD, FREEFALL_ACCELERATION, FREEFALL_TIME)}
        missing = tuple(one for one, value in thresholds.items() if value is None)
        invalid = tuple(one for one in missing if one.key in self._drafts)
        usual = TriggerLimits()

        def named(command: Command, usually: float) -> float:
            value = thresholds[command]
            return usually if value is None else float(value)

        limits = TriggerLimits(
            attitude_threshold_deg=named(ATTITUDE_THRESHOLD, usual.attitude_threshold_deg),
            freefall_acceleration_g=named(FREEFALL_ACCELERATION, usual.freefall_acceleration_g),
            freefall_time_s=named(FREEFALL_TIME, usual.freefall_time_s),
            attitude_is_enabled=self._is_on(ATTITUDE_TRIGGER, missing, needs=(ATTITUDE_THRESHOLD,)),
            freefall_is_enabled=self._is_on(FREEFALL_TRIGGER, missing, needs=(FREEFALL_ACCELERATION, FREEFALL_TIME)),
        )
        return Question(
            limits,
            unknown=tuple(one for one in missing if one not in invalid),
            invalid=invalid,
            assumed=tuple(one for one in (ATTITUDE_TRIGGER, FREEFALL_TRIGGER) if self.value(one) is None),
            stale=tuple(one for one in TRIED if one.key not in self._drafts and self._is_stale(one)),
        )

    def _is_on(self, trigger: Command, missing: Iterable[Command], *, needs: tuple[Command, ...]) -> bool:
        return self.value(trigger) is not False and not set(needs) & set(missing)

    def _is_stale(self, command: Command) -> bool:
        standing = self.standing.get(command.key)
        return standing is not None and standing.is_stale
