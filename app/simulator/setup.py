"""What a simulated module and its line are like: one table for the command line, the query of `sim://` and the panel.

`dps-s simulate --tilt 5 --drop 0.1` and `sim://bench?tilt=5&drop=0.1` are the same.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from typing import Any, Final

from app.text.user_error import UserError
from protocol.catalogue import BAUD_RATES
from protocol.translatable import marked


class Group(Enum):
    """Heading in the help; the value is its text."""

    MODULE = marked("Module")
    FAULTS = marked("Faults")
    PHYSICAL = marked("Physics")


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """One option. `name` is the field of `Setup`; on the command line `_` becomes `-`."""

    name: str = ""
    group: Group
    text: str
    """In English."""
    parse: Callable[[str], Any]
    """Raises `ValueError` with the expected form."""
    default: Any
    metavar: str


YES_OR_NO: Final = "yes|no"
_YES_NO = {"": True, "yes": True, "true": True, "on": True, "1": True,
           "no": False, "false": False, "off": False, "0": False}  # fmt: skip


def _yes_or_no(text: str) -> bool:
    if text.lower() not in _YES_NO:
        raise ValueError(YES_OR_NO)
    return _YES_NO[text.lower()]


def _baud_rate(text: str) -> int:
    rates = {str(rate): rate for rate in BAUD_RATES}
    if text not in rates:
        raise ValueError("|".join(rates))
    return rates[text]


def _between(kind: Callable[[str], float], least: float, most: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        with suppress(ValueError):
            value = kind(text)
            if least <= value <= most:  # no NaN is
                return value
        raise ValueError(f"{least:g}…{most:.10g}")

    return parse


def option(group: Group, default: Any, text: str, metavar: str, parse: Callable[[str], Any]) -> Any:
    """Return a field of `Setup` that is an option."""
    made = Option(group=group, text=text, parse=parse, default=default, metavar=metavar)
    return field(default=default, metadata={"option": made})


def number(group: Group, default: float, text: str, metavar: str, least: float, most: float) -> Any:
    """Return an option that is a number of the kind of its default."""
    return option(group, default, text, metavar, _between(type(default), least, most))


def switch(group: Group, text: str, *, default: bool = False) -> Any:
    return option(group, default, text, YES_OR_NO, _yes_or_no)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Initial state, behaviour and line of one module. Shares are 0 … 1."""

    baud: int = option(Group.MODULE, 115200, marked("Baud rate"), "RATE", _baud_rate)
    rate: float = number(Group.MODULE, 50.0, marked("Stream rate"), "HZ", 1, 1440)
    active: bool = switch(Group.MODULE, marked("Active"))
    boots: int = number(Group.MODULE, 37, marked("Boot count"), "N", 0, 255)
    uptime: float = number(Group.MODULE, 60.0, marked("After power-on"), "S", 0, 65535)
    """With 0 the two heartbeats after power-on are sent."""
    pwm_after: float = number(Group.MODULE, 0.0, marked("PWM trigger after"), "S", 0, 86_400)
    """It fires then if it is active; 0 for never."""
    history: int = number(Group.MODULE, 0, marked("Trigger records"), "N", 0, 9)
    seed: int = number(Group.MODULE, 1, marked("Random seed"), "N", 0, 2**31)
    mute: bool = switch(Group.FAULTS, marked("Mute"))
    drop: float = number(Group.FAULTS, 0.0, marked("Lost replies"), "SHARE", 0, 1)
    corrupt: float = number(Group.FAULTS, 0.0, marked("Bit errors"), "SHARE", 0, 1)
    """Of the bytes of its replies."""
    lag_ms: float = number(Group.FAULTS, 0.0, marked("Wireless lag"), "MS", 0, 10_000)
    tilt: float = number(Group.PHYSICAL, 0.0, marked("Tilt"), "DEG", -180, 180)
    cell: float = number(Group.PHYSICAL, 3.9, marked("Cell voltage"), "V", 0, 5)
    bay_open: bool = switch(Group.PHYSICAL, marked("Bay open"))
    charger: bool = switch(Group.PHYSICAL, marked("External power"))
    noise: float = number(Group.PHYSICAL, 0.0, marked("Sensor noise"), "N", 0, 100)
    """1 is typical."""
    lifelike: bool = switch(Group.PHYSICAL, marked("Wobbles"))


def options_of(setup: type[Setup]) -> tuple[Option, ...]:
    return tuple(replace(source.metadata["option"], name=source.name) for source in fields(setup))


OPTIONS: tuple[Option, ...] = options_of(Setup)
BY_NAME: dict[str, Option] = {one.name: one for one in OPTIONS}


def as_text(value: object) -> str:
    """A value in the form in which it is typed."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def parse_options(texts: Mapping[str, str] | Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Values by option name, which may have `-` for `_`; raises `UserError` for the first invalid one."""
    values = {}
    for name, text in texts.items() if isinstance(texts, Mapping) else texts:
        found = BY_NAME.get(name.replace("-", "_"))
        if found is None:
            raise UserError(marked("“{name}” is unknown."), name=name)
        try:
            values[found.name] = found.parse(text)
        except ValueError as error:
            refused = marked("{option}={text}: expected {expected}")
            raise UserError(refused, option=found.name, text=text, expected=error) from error
    return values
