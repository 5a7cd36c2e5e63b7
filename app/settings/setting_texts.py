"""Texts of settings: values with units, vendor's defaults, advice and descriptions."""

from collections.abc import Mapping
from typing import Final

from app.settings.values import field_of, fitting
from app.text.i18n import tr
from app.text.messages import UserMessage, clean, message
from app.text.user_error import UserError
from protocol.catalogue import BY_NAME, SETTINGS, Command
from protocol.fields import Choice, Flag, Quantity, Value
from protocol.translatable import marked

_TRADE_OFFS: Final[Mapping[Command, str]] = {
    BY_NAME["freefall_time"]: marked("longer: fewer false triggers, more height lost"),
}
"""Where the vendor gives no limit but describes a trade-off."""


def value_message(command: Command, value: Value) -> UserMessage:
    """`value` with its unit: "1.60 s", "Enabled"."""
    match field_of(command):
        case Flag():
            return message(marked("Enabled") if value else marked("Disabled"))
        case Choice(unit=unit):
            return message("{value} {unit}", value=value, unit=message(unit))
        case field:
            return UserMessage(field.text(field.encode(value)))


def value_text(command: Command, value: Value) -> str:
    """The same in the language in use."""
    return value_message(command, value).translated()


def setting_message(key: str, value: object) -> UserMessage:
    """A setting with its value and unit, as somebody kept it; one that this version does not know by its key."""
    command = next((command for command in SETTINGS if command.key == key), None)
    if command is None:
        return UserMessage(clean(f"{key} {value}"))
    try:
        shown = value_message(command, fitting(field_of(command), value))
    except UserError:  # another station may have written any number
        shown = UserMessage(clean(str(value)))
    return message("{name} {value}", name=message(command.title), value=shown)


def _default(command: Command) -> Value | None:
    return None if command.default is None or command.write is None else command.write.decode(command.default)


DEFAULTS: Mapping[str, Value] = {command.key: value for command in SETTINGS if (value := _default(command)) is not None}


def advice_text(command: Command) -> str:
    """The vendor's default and advice; empty where there is neither."""
    parts = []
    if command.key in DEFAULTS:
        parts.append(tr("Default {value}", value=value_text(command, DEFAULTS[command.key])))
    if command.advice is not None:
        parts.append(tr("Vendor advises: {advice}", advice=tr(command.advice.text)))
    elif command in _TRADE_OFFS:
        parts.append(tr(_TRADE_OFFS[command]))
    return " · ".join(parts)


def what_is(command: Command) -> str:
    """The "What's this?" text: vendor's term and code, explanation, range, default and advice."""
    title, term = tr(command.title), command.vendor_term
    head = title if title == term else f"{title} {term}"
    lines = [tr("{setting}: command {code}", setting=head, code=f"{command.code:02X}"), tr(command.explanation)]
    match command.write:
        case Quantity(maximum=maximum, per_unit=per_unit) as field:
            lines.append(
                tr(
                    "{least} to {most}, in steps of {step}.",
                    least=field.text(0),
                    most=field.text(round(maximum * per_unit)),
                    step=field.text(1),
                )
            )
        case Choice() as field:
            rates = ", ".join(str(value) for value in field.values.values())
            lines.append(tr("One of {values} {unit}.", values=rates, unit=tr(field.unit)))
        case Flag():
            lines.append(tr("Enabled or disabled."))
    advice = advice_text(command)
    if advice:
        lines.append(advice)
    return "\n".join(lines)
