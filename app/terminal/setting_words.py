"""Settings as words of the command line: NAME=VALUE, and the settings of a profile."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from app.procedures.write import SettingChange
from app.settings.profile_file import read_profile
from app.settings.values import SETTINGS_BY_KEY, parse_value
from app.terminal.console import Refused, did_you_mean
from app.text.i18n import tr
from app.text.messages import UserError
from protocol.fields import Value


def settings_of_profile(path: Path) -> Mapping[str, Value]:
    """The settings of a profile by key. Raises `UserError` where it holds none or is none."""
    settings = read_profile(path).settings
    if not settings:
        raise Refused(tr("{path} holds no settings.", path=path))
    return settings


def parse_settings(words: Sequence[str], names: Collection[str] = SETTINGS_BY_KEY) -> list[SettingChange]:
    """Parse and check all words, of settings with these names. Raises `Refused` with all errors."""
    wishes: dict[str, SettingChange] = {}
    faults: list[str] = []
    for word in words:
        name, equals, text = word.partition("=")
        command = SETTINGS_BY_KEY[name] if name in names else None
        if not equals:
            faults.append(f"{word}: {tr('expected {expected}', expected='NAME=VALUE')}")
        elif command is None or command.write is None:
            hint = did_you_mean(name, names)
            faults.append(f"{name}: {tr('expected {expected}', expected='|'.join(names))}{hint}")
        elif name in wishes:
            faults.append(tr("{name} is given twice.", name=name))
        else:
            try:
                wishes[name] = SettingChange(command, parse_value(command.write, text))
            except UserError as error:
                faults.append(tr("{value}: {why}.", value=name, why=error.sentence))
    if faults:
        raise Refused("\n".join(faults))
    return list(wishes.values())


def typed(value: Value | None) -> str:
    """The value as it is typed."""
    if value is None:
        return tr("unknown")
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"
