"""The options of a simulated module and its line: `dps-s simulate --tilt 5 --drop 0.1`, `sim://bench?tilt=5&drop=0.1`."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from typing import Any, Final

from app.text.messages import UserError
from protocol.catalogue import BAUD_RATES
from protocol.translatable import marked

YES_OR_NO: Final = "yes|no"
_SWITCH: Final = {"": True, "yes": True, "no": False}
_RATES: Final = {str(rate): rate for rate in BAUD_RATES}


def one_of(default: Any, text: str, expected: str, values: Mapping[str, Any]) -> Any:
    """Return an option with these values; its `parse` raises `ValueError` with the form that it expects."""

    def parse(typed: str) -> Any:
        if typed.lower() not in values:
            raise ValueError(expected)
        return values[typed.lower()]

    return field(default=default, metadata={"text": text, "metavar": expected, "parse": parse})


def switch(text: str) -> Any:
    return one_of(False, text, YES_OR_NO, _SWITCH)


def number(default: float, text: str, metavar: str, least: float, most: float) -> Any:
    """Return an option that is a number of the kind of its default."""

    def parse(typed: str) -> float:
        with suppress(ValueError):
            value = type(default)(typed)
            if least <= value <= most:  # no NaN is
                return value
        raise ValueError(f"{least:g}…{most:.10g}")

    return field(default=default, metadata={"text": text, "metavar": metavar, "parse": parse})


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """How the module and its line begin. Shares are 0 … 1; what happens after 0 s never happens."""

    baud: int = one_of(115200, "baud rate", "|".join(_RATES), _RATES)
    rate: float = number(50.0, "frames a second while it streams", "HZ", 1, 1440)
    active: bool = switch("active from the beginning")
    boots: int = number(37, "boot count", "N", 0, 255)
    uptime: float = number(60.0, "seconds since power-on; 0 sends the two heartbeats", "S", 0, 65535)
    history: int = number(0, "trigger records of earlier boots", "N", 0, 9)
    seed: int = number(1, "of what is random", "N", 0, 2**31)
    mute: bool = switch("silent: says nothing")
    drop: float = number(0.0, "share of the replies that are lost", "SHARE", 0, 1)
    corrupt: float = number(0.0, "share of the bytes of replies with a wrong bit", "SHARE", 0, 1)
    lag_ms: float = number(0.0, "how late replies come", "MS", 0, 10_000)
    tilt: float = number(0.0, "tilt", "DEG", -180, 180)
    bay_open: bool = switch("the bay is open")
    cell: float = number(3.9, "cell voltage", "V", 0, 5)
    charger: bool = switch("external power")
    lifelike: bool = switch("moves a little, as in a hand")
    fall_after: float = number(0.0, "falls after so many seconds", "S", 0, 86_400)
    pwm_after: float = number(0.0, "is triggered by PWM after so many seconds", "S", 0, 86_400)
    restart_after: float = number(0.0, "restarts after so many seconds", "S", 0, 86_400)


def as_text(value: Any) -> str:
    return ("yes" if value else "no") if isinstance(value, bool) else f"{value:.10g}"


def parse_options(texts: Mapping[str, str]) -> dict[str, Any]:
    """Return the values by the name of the option, which may have `-` for `_`. Raises `UserError` for a wrong one."""
    options = {one.name: one for one in fields(Setup)}
    values = {}
    for typed, text in texts.items():
        name = typed.replace("-", "_")
        if name not in options:
            raise UserError(marked("“{name}” is unknown."), name=typed)
        try:
            values[name] = options[name].metadata["parse"](text)
        except ValueError as error:
            raise UserError(
                marked("{option}={text}: expected {expected}"), option=name, text=text, expected=error
            ) from error
    return values
