"""Values of settings as a person reads and types them, and the vendor's defaults."""

from collections.abc import Mapping

from app.i18n import tr
from protocol.catalogue import SETTINGS, Command
from protocol.fields import Flag, Quantity, Value


def plain_text(command: Command, value: Value) -> str:
    """As one would type it into the field: without the unit."""
    field = command.write
    if isinstance(field, Quantity):
        return f"{value:.{field.decimals}f}"
    return str(value).lower() if isinstance(value, bool) else str(value)


def value_text(command: Command, value: Value) -> str:
    """With its unit, in the language in use: "1.60 s", "Enabled"."""
    if isinstance(command.write, Flag):
        return tr("Enabled") if value else tr("Disabled")
    if command.write is None:
        raise LookupError(f"{command.name} cannot be set")
    return command.write.text(command.write.encode(value))


def _default(command: Command) -> Value | None:
    return None if command.default is None or command.write is None else command.write.decode(command.default)


DEFAULTS: Mapping[str, Value] = {
    command.key: value for command in SETTINGS if (value := _default(command)) is not None
}
