"""Values of settings as typed and as shown, what the vendor says about them, and a code for all of them."""

from collections.abc import Mapping
from decimal import Decimal, InvalidOperation
from typing import Final

from app.text.i18n import tr
from app.text.messages import UserError, UserMessage, clean, message
from protocol.catalogue import READABLE_SETTINGS, SETTINGS, Command
from protocol.fields import NUMBER_NEEDED, Choice, Field, Flag, Quantity, Value, ValueRefused
from protocol.translatable import marked

SETTINGS_BY_KEY: Final[Mapping[str, Command]] = {command.key: command for command in SETTINGS}
_WORDS: Final = {"true": True, "on": True, "yes": True, "false": False, "off": False, "no": False}
MAX_NUMBER_LENGTH: Final = 32
LONGEST_SHOWN: Final = 40  # characters of what is refused
LARGEST_WHOLE: Final = 10**15  # Python refuses to write an integer of more than 4,300 digits as text
TOO_LONG: Final = marked("{value} has too many digits")


def field_of(command: Command) -> Field:
    """Return the field that is written. Raises `LookupError` for a command that cannot be set."""
    if command.write is None:
        raise LookupError(f"{command.name} cannot be set")
    return command.write


def fitting(field: Field, value: object) -> Value:
    """Return `value` exactly as it will be sent, in the field's unit. Never rounds: raises `UserError`."""
    if not isinstance(value, bool | int | float):
        raise _kind_needed(field)
    if isinstance(value, int) and abs(value) >= LARGEST_WHOLE:
        raise UserError(TOO_LONG, value="≥ 10^15" if value > 0 else "≤ -10^15")
    try:
        return field.decode(field.encode(value))
    except ValueRefused as error:
        raise UserError(error.text, **error.values) from error


def parse_value(field: Field, text: str) -> Value:
    """Return the value of what a person typed. Raises `UserError`."""
    if not isinstance(field, Quantity | Choice):
        if text.lower() not in _WORDS:
            raise _kind_needed(field)
        return fitting(field, _WORDS[text.lower()])
    try:
        number = Decimal(text if len(text) <= MAX_NUMBER_LENGTH else "")
    except InvalidOperation:
        raise _kind_needed(field) from None
    if not number.is_finite():
        raise _kind_needed(field)
    value = float(number)
    if Decimal(str(value)) != number:  # more digits than a float carries
        raise UserError(TOO_LONG, value=clean(text, longest=LONGEST_SHOWN))
    return fitting(field, int(value) if value.is_integer() else value)


def _kind_needed(field: Field) -> UserError:
    if isinstance(field, Quantity | Choice):
        return UserError(NUMBER_NEEDED)
    return UserError(marked("expected {expected}"), expected="true, false")


def value_message(command: Command, value: Value) -> UserMessage:
    """Return `value` with its unit: "1.60 s", "Enabled"."""
    match field_of(command):
        case Flag():
            return message(marked("Enabled") if value else marked("Disabled"))
        case Choice(unit=unit):
            return message("{value} {unit}", value=value, unit=message(unit))
        case field:
            return UserMessage(field.text(field.encode(value)))


def value_text(command: Command, value: Value) -> str:
    """Return the same in the language in use."""
    return value_message(command, value).translated()


def setting_message(key: str, value: object) -> UserMessage:
    """Return a setting with its value and unit, as somebody kept it; one that this version does not know by its key."""
    command = SETTINGS_BY_KEY.get(key)
    name = UserMessage(clean(key)) if command is None else message(command.title)
    return message("{name} {value}", name=name, value=kept_value_message(key, value))


def kept_value_message(key: str, value: object) -> UserMessage:
    """Return the value of such a setting with its unit."""
    command = SETTINGS_BY_KEY.get(key)
    try:
        if command is not None:
            return value_message(command, fitting(field_of(command), value))
    except UserError:  # another station may have written any number
        pass
    return UserMessage(clean(str(value)))


# What the vendor's table gives as delivered. Never shown as the module's value.
DEFAULTS: Final[Mapping[str, Value]] = {
    command.key: field_of(command).decode(command.default) for command in SETTINGS if command.default is not None
}


def advice_text(command: Command) -> str:
    """Return the vendor's default and advice; empty where there is neither."""
    parts = []
    if command.key in DEFAULTS:
        parts.append(tr("Default {value}", value=value_text(command, DEFAULTS[command.key])))
    if command.advice is not None:
        parts.append(tr("Vendor advises: {advice}", advice=tr(command.advice.text)))
    elif command.name == "freefall_time":
        # The vendor gives no limit for it, but says what it trades.
        parts.append(tr("longer: fewer false triggers, more height lost"))
    return " · ".join(parts)


def fingerprint(settings: Mapping[str, Value]) -> str | None:
    """Return the code of settings by key, such as "K7QF-3M2X"; None where one that it covers is not known."""
    # It covers only the settings that can be read back: with the others (E8) the code of a module would depend on what
    # was written in this session.
    import base64  # few need these, and the second is slow: it loads OpenSSL
    import hashlib

    if any(command.key not in settings for command in READABLE_SETTINGS):
        return None
    parts = [
        f"{command.code:02X}={field_of(command).encode(settings[command.key]):02X}" for command in READABLE_SETTINGS
    ]
    # Base 32 has neither 0 nor 1, as the code is read out over the radio.
    code = base64.b32encode(hashlib.sha256(";".join(parts).encode()).digest()).decode()
    return f"{code[:4]}-{code[4:8]}"
