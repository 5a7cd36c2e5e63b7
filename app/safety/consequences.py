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
    explained = _explained(command, value)
    found = [] if explained is None else [explained]
    if command.name == "freefall_time" and 0 < float(value) < SHORT_FALL_S:
        found.append(Consequence(message(_JOLT), is_risk=True))
    advice = command.advice
    if advice is not None:
        is_followed = value == DEFAULT_BAUD_RATE if command is BAUD_RATE else advice.is_followed_by(float(value))
        if not is_followed:
            text = marked("Vendor advises: {advice}")
            found.append(Consequence(message(text, advice=message(advice.text)), is_risk=True))
    return tuple(found)


def risks(command: Command, value: Value) -> tuple[Consequence, ...]:
    """Return what a person has to accept before `value` is written. The baud rate has none: it takes no protection away
    and is never written without a permit."""
    if command is BAUD_RATE:
        return ()
    return tuple(consequence for consequence in consequences(command, value) if consequence.is_risk)


def _explained(command: Command, value: Value) -> Consequence | None:
    amount, is_risk = float(value), False
    match command.name:
        case "attitude_threshold":
            rearms, is_risk = amount - RESET_BELOW_THRESHOLD_DEG, True
            if amount == 0:
                text = message(marked("Fires as soon as it is activated."))
            elif rearms <= 0:
                text = message(marked("Fires at {fires:.0f}° and never rearms."), fires=amount)
            elif amount > 180:
                text = message(marked("No protection: no aircraft tilts by {fires:.0f}°."), fires=amount)
            elif amount > 90:
                upside_down = marked("Fires only upside down, at {fires:.0f}°; rearms at {rearms:.0f}°.")
                text = message(upside_down, fires=amount, rearms=rearms)
            else:
                is_risk = False
                text = message(marked("Fires at {fires:.0f}°, rearms at {rearms:.0f}°."), fires=amount, rearms=rearms)
        case "freefall_acceleration" if amount == 0:
            text, is_risk = message(marked("Never counts as falling: nothing is below 0 g.")), True
        case "freefall_acceleration" if amount >= 1:
            at_rest = marked("Counts as falling at rest (1 g): fires after the free-fall time.")
            text, is_risk = message(at_rest), True
        case "freefall_acceleration":
            text = message(marked("Counts as falling below {limit:.1f} g; at rest 1 g."), limit=amount)
        case "freefall_time" if amount == 0:
            text, is_risk = message(_JOLT), True
        case "freefall_time":
            height_m, speed_km_h = GRAVITY_M_S2 * amount**2 / 2, GRAVITY_M_S2 * amount * 3.6
            falls = marked("{seconds:.2f} s of free fall is {height:.3g} m before it fires, at {speed:.2g} km/h.")
            text = message(falls, seconds=amount, height=height_m, speed=speed_km_h)
        case "light_threshold" if not 0 < amount < LIGHT_MAX_V:
            text, is_risk = message(marked("Never tells an open bay from a closed one.")), True
        case "light_threshold":
            text = message(marked("Measure which side of {limit:.1f} V means open."), limit=amount)
        case "attitude_trigger" if value:
            text = message(marked("Fires by itself when it tips over."))
        case "attitude_trigger":
            text, is_risk = message(marked("No protection when it tips over.")), True
        case "freefall_trigger" if value:
            text = message(marked("Fires by itself in free fall."))
        case "freefall_trigger":
            text, is_risk = message(marked("No protection in free fall.")), True
        case "serial_output":
            text = message(marked("Streams the status unasked.") if value else marked("Sends only when asked."))
        case "baud_rate":
            text = message(marked("The flight controller must then use {rate} baud, too."), rate=value)
        case _:
            return None
    return Consequence(text, is_risk)
