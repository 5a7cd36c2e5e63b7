"""Describes what a setting means in flight, in plain words and numbers.

Falls are computed without drag, from rest: h = g t² / 2, v = g t, with standard gravity. Real falls are slower, so both
figures are upper limits.
"""

from typing import NamedTuple

from app.text.messages import UserMessage, message
from protocol.catalogue import BAUD_RATE, DEFAULT_BAUD_RATE, RESET_BELOW_THRESHOLD_DEG, Command
from protocol.fields import Value
from protocol.translatable import marked

GRAVITY_M_S2 = 9.80665
# The shortest that the pre-flight check advises. Below it a jolt may last as long: a hop of 30 cm has no weight for
# half a second.
SHORT_FALL_S = 0.5
# Largest reading and threshold; all readings are on one side of it, as of 0 V.
LIGHT_MAX_V = 25.5
_JOLT = marked("A jolt may fire it.")


class Consequence(NamedTuple):
    """`is_risk`: it takes protection away, or is against the vendor's advice: shown as a warning, and written only if a
    person accepts it."""

    message: UserMessage
    is_risk: bool = False


def consequences(command: Command, value: Value) -> tuple[Consequence, ...]:
    """The consequence of `value`, followed by the vendor's advice where it is not followed."""
    found = [_explained(command, value)]
    if command.name == "freefall_time" and 0 < float(value) < SHORT_FALL_S:
        found.append(Consequence(message(_JOLT), is_risk=True))
    advice = command.advice
    if advice is not None:
        is_followed = value == DEFAULT_BAUD_RATE if command is BAUD_RATE else advice.is_followed_by(float(value))
        if not is_followed:
            text = marked("Vendor advises: {advice}")
            found.append(Consequence(message(text, advice=message(advice.text)), is_risk=True))
    return tuple(found)


def _explained(command: Command, value: Value) -> Consequence:
    amount = float(value)
    match command.name:
        case "attitude_threshold":
            return _tilt_explained(amount)
        case "freefall_acceleration" if amount == 0:
            return Consequence(message(marked("Never counts as falling: nothing is below 0 g.")), is_risk=True)
        case "freefall_acceleration" if amount >= 1:
            at_rest = marked("Fires at rest (1 g), after the free-fall time.")
            return Consequence(message(at_rest), is_risk=True)
        case "freefall_acceleration":
            return Consequence(message(marked("Free fall: below {limit:.1f} g; at rest 1 g."), limit=amount))
        case "freefall_time" if amount == 0:
            return Consequence(message(_JOLT), is_risk=True)
        case "freefall_time":
            height_m, speed_km_h = GRAVITY_M_S2 * amount**2 / 2, GRAVITY_M_S2 * amount * 3.6
            falls = marked("{seconds:.2f} s of free fall is {height:.1f} m before it fires, at {speed:.0f} km/h.")
            return Consequence(message(falls, seconds=amount, height=height_m, speed=speed_km_h))
        case "light_threshold" if not 0 < amount < LIGHT_MAX_V:
            return Consequence(message(marked("Never tells an open bay from a closed one.")), is_risk=True)
        case "light_threshold":
            return Consequence(message(marked("Measure which side of {limit:.1f} V means open."), limit=amount))
        case "attitude_trigger" if value:
            return Consequence(message(marked("Fires by itself when it tips over.")))
        case "attitude_trigger":
            return Consequence(message(marked("No protection when it tips over.")), is_risk=True)
        case "freefall_trigger" if value:
            return Consequence(message(marked("Fires by itself in free fall.")))
        case "freefall_trigger":
            return Consequence(message(marked("No protection in free fall.")), is_risk=True)
        case "serial_output":
            text = marked("Streams the status unasked.") if value else marked("Sends only when asked.")
            return Consequence(message(text))
        case _:  # the baud rate
            return Consequence(message(marked("The flight controller must then use {rate} baud, too."), rate=value))


def _tilt_explained(fires_deg: float) -> Consequence:
    rearms_deg = fires_deg - RESET_BELOW_THRESHOLD_DEG
    if fires_deg == 0:
        text = marked("Fires as soon as it is activated.")
    elif rearms_deg <= 0:
        text = marked("Fires at {fires:.0f}° and never rearms.")
    elif fires_deg > 180:
        text = marked("No protection: no aircraft tilts by {fires:.0f}°.")
    elif fires_deg > 90:
        text = marked("Fires only upside down, at {fires:.0f}°; rearms at {rearms:.0f}°.")
    else:
        text = marked("Fires at {fires:.0f}°, rearms at {rearms:.0f}°.")
    is_risk = fires_deg > 90 or rearms_deg <= 0
    return Consequence(message(text, fires=fires_deg, rearms=rearms_deg), is_risk)
