"""Describes what a setting means in flight, in plain words and numbers.

Falls are computed without drag, from rest: h = g t² / 2, v = g t, with standard gravity. Real falls are slower, so both
figures are upper limits.
"""

from collections.abc import Callable, Mapping
from enum import Enum
from typing import NamedTuple

from app.text.messages import UserMessage, message
from protocol.catalogue import BAUD_RATE, BY_NAME, DEFAULT_BAUD_RATE, RESET_BELOW_THRESHOLD_DEG, Command
from protocol.fields import Value
from protocol.translatable import marked

GRAVITY_M_S2 = 9.80665
RESTING_G = 1.0
UPRIGHT_DEG = 90
# The shortest that the pre-flight check advises. Below it a jolt may last as long: a hop of 30 cm has no weight for
# half a second.
SHORT_FALL_S = 0.5
# Largest reading and threshold; all readings are on one side of it, as of 0 V.
LIGHT_MAX_V = 25.5
_JOLT = marked("A jolt may fire it.")


class Weight(Enum):
    """How strongly a consequence is presented."""

    PLAIN = "plain"
    AGAINST_ADVICE = "against advice"  # shown as a warning; written only if a person accepts it
    GRAVE = "grave"  # it fires at once, or never: treated like `AGAINST_ADVICE`, in stronger words


class Consequence(NamedTuple):
    message: UserMessage
    weight: Weight = Weight.PLAIN

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return self.message.translated()


def consequences(command: Command, value: Value) -> tuple[Consequence, ...]:
    """The consequence of `value`, followed by the vendor's advice where it is not followed."""
    explain = _EXPLAINED.get(command)
    explained = () if explain is None else (explain(value),)
    if command is BY_NAME["freefall_time"] and 0 < float(value) < SHORT_FALL_S:
        explained = (*explained, Consequence(message(_JOLT), Weight.AGAINST_ADVICE))
    advice = command.advice
    if advice is None or is_advised(command, value):
        return explained
    text = marked("Vendor advises: {advice}")
    return (*explained, Consequence(message(text, advice=message(advice.text)), Weight.AGAINST_ADVICE))


def risks(command: Command, value: Value) -> tuple[Consequence, ...]:
    """What a person has to accept before `value` is written: less protection, or against the vendor's advice.

    Nothing for the baud rate, which takes no protection away and is never written without a permit.
    """
    if command is BAUD_RATE:
        return ()
    return tuple(consequence for consequence in consequences(command, value) if consequence.weight is not Weight.PLAIN)


def is_advised(command: Command, value: Value) -> bool:
    """Whether `value` follows the vendor's advice; True where the value alone cannot tell."""
    if command is BAUD_RATE:
        return value == DEFAULT_BAUD_RATE
    return command.advice is None or command.advice.is_followed_by(float(value))


def _attitude(value: Value) -> Consequence:
    fires = float(value)
    rearms = fires - RESET_BELOW_THRESHOLD_DEG
    if fires == 0:
        return Consequence(message(marked("Fires as soon as it is activated.")), weight=Weight.GRAVE)
    if rearms <= 0:
        return Consequence(message(marked("Fires at {fires:.0f}° and never rearms."), fires=fires), Weight.GRAVE)
    if fires > 180:
        return Consequence(
            message(marked("No protection: no aircraft tilts by {fires:.0f}°."), fires=fires), Weight.GRAVE
        )
    if fires > UPRIGHT_DEG:
        text = marked("Fires only upside down, at {fires:.0f}°; rearms at {rearms:.0f}°.")
        return Consequence(message(text, fires=fires, rearms=rearms), Weight.GRAVE)
    return Consequence(message(marked("Fires at {fires:.0f}°, rearms at {rearms:.0f}°."), fires=fires, rearms=rearms))


def _acceleration(value: Value) -> Consequence:
    limit = float(value)
    if limit == 0:
        return Consequence(message(marked("Never counts as falling: nothing is below 0 g.")), weight=Weight.GRAVE)
    if limit >= RESTING_G:
        text = marked("Counts as falling at rest (1 g): fires after the free-fall time.")
        return Consequence(message(text), weight=Weight.GRAVE)
    return Consequence(message(marked("Counts as falling below {limit:.1f} g; at rest 1 g."), limit=limit))


def _time(value: Value) -> Consequence:
    seconds = float(value)
    if seconds == 0:
        return Consequence(message(_JOLT), weight=Weight.GRAVE)
    height_m, speed_km_h = GRAVITY_M_S2 * seconds**2 / 2, GRAVITY_M_S2 * seconds * 3.6
    text = marked("{seconds:.2f} s of free fall is {height:.3g} m before it fires, at {speed:.2g} km/h.")
    return Consequence(message(text, seconds=seconds, height=height_m, speed=speed_km_h))


def _light(value: Value) -> Consequence:
    if not 0 < float(value) < LIGHT_MAX_V:
        return Consequence(message(marked("Never tells an open bay from a closed one.")), weight=Weight.GRAVE)
    text = marked("Measure which side of {limit:.1f} V means open.")
    return Consequence(message(text, limit=float(value)))


def _baud_rate(value: Value) -> Consequence:
    text = marked("The flight controller must then use {rate} baud, too.")
    return Consequence(message(text, rate=value))


def _flag(on: str, off: str, off_weight: Weight) -> Callable[[Value], Consequence]:
    return lambda value: Consequence(message(on)) if value else Consequence(message(off), off_weight)


_EXPLAINED: Mapping[Command, Callable[[Value], Consequence]] = {
    BY_NAME["attitude_threshold"]: _attitude,
    BY_NAME["freefall_acceleration"]: _acceleration,
    BY_NAME["freefall_time"]: _time,
    BY_NAME["light_threshold"]: _light,
    BY_NAME["attitude_trigger"]: _flag(
        marked("Fires by itself when it tips over."),
        marked("No protection when it tips over."),
        Weight.AGAINST_ADVICE,
    ),
    BY_NAME["freefall_trigger"]: _flag(
        marked("Fires by itself in free fall."), marked("No protection in free fall."), Weight.AGAINST_ADVICE
    ),
    BY_NAME["serial_output"]: _flag(
        marked("Streams the status unasked."), marked("Sends only when asked."), Weight.PLAIN
    ),
    BAUD_RATE: _baud_rate,
}
