"""Parses and formats values of settings, and explains why a value is invalid."""

from decimal import Decimal, InvalidOperation

from app.text.messages import clean
from app.text.user_error import UserError
from protocol.catalogue import Command
from protocol.fields import NUMBER_NEEDED, Choice, Field, Quantity, Value, ValueRefused
from protocol.translatable import marked

_WORDS = {"true": True, "on": True, "yes": True, "false": False, "off": False, "no": False}
MAX_NUMBER_LENGTH = 32
LONGEST_SHOWN = 40
"""Characters of what is refused."""
LARGEST_WHOLE = 10**15
"""Larger integers are not shown; Python refuses to format more than 4,300 digits."""
TOO_LONG = marked("{value} has too many digits")


def field_of(command: Command) -> Field:
    """The field that is written. Raises `LookupError` for a command that cannot be set."""
    if command.write is None:
        raise LookupError(f"{command.name} cannot be set")
    return command.write


def fitting(field: Field, value: object) -> Value:
    """`value` exactly as it will be sent, in the field's unit. Never rounds: raises `UserError`."""
    if not isinstance(value, bool | int | float):
        raise _kind_needed(field)
    if isinstance(value, int) and abs(value) >= LARGEST_WHOLE:
        raise UserError(TOO_LONG, value="≥ 10^15" if value > 0 else "≤ -10^15")
    try:
        return field.decode(field.encode(value))
    except ValueRefused as error:
        raise UserError(error.text, **error.values) from error


def parse_value(field: Field, text: str) -> Value:
    """Parses a text typed by a person. Raises `UserError`."""
    if not isinstance(field, Quantity | Choice):
        if text.lower() not in _WORDS:
            raise _kind_needed(field)
        return fitting(field, _WORDS[text.lower()])
    try:
        number = Decimal(text if len(text) <= MAX_NUMBER_LENGTH else "")
        if not number.is_finite():
            raise InvalidOperation
    except InvalidOperation:
        raise _kind_needed(field) from None
    value = int(number) if number == number.to_integral_value() and abs(number) < 10**9 else float(number)
    if Decimal(str(value)) != number:  # more digits than a float carries: between two steps in any case
        raise UserError(TOO_LONG, value=clean(text, longest=LONGEST_SHOWN))
    return fitting(field, value)


def _kind_needed(field: Field) -> UserError:
    if isinstance(field, Quantity | Choice):
        return UserError(NUMBER_NEEDED)
    return UserError(marked("expected {expected}"), expected="true, false")
