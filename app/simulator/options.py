"""Options of the simulated module: one table for the command line, the query of `sim://` and the panel.

`dps-s simulate --ack one --drop 0.1` and `sim://bench?ack=one&drop=0.1` are the same.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import Field, dataclass, fields
from enum import Enum
from functools import partial
from typing import Any

from app.simulator.setup import Group, Setup
from app.text.user_error import UserError
from protocol.catalogue import BAUD_RATES, BY_CODE
from protocol.translatable import marked


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """One option. `name` is the field of `Setup`; on the command line `_` becomes `-`."""

    name: str
    group: Group
    text: str
    """In English; begins with the E-number if there is one."""
    parse: Callable[[str], Any]
    """Raises `ValueError` with the expected form."""
    default: Any
    metavar: str | None = None
    choices: tuple[str, ...] = ()
    is_flag: bool = False

    @property
    def flag(self) -> str:
        return "--" + self.name.replace("_", "-")


_YES_NO = {"": True, "yes": True, "true": True, "on": True, "1": True,
           "no": False, "false": False, "off": False, "0": False}  # fmt: skip


def _yes_or_no(text: str) -> bool:
    if text.lower() not in _YES_NO:
        raise ValueError("yes|no")
    return _YES_NO[text.lower()]


def _between(kind: Callable[[str], float], least: float, most: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        with suppress(ValueError):
            value = kind(text)
            if least <= value <= most:  # no NaN is
                return value
        raise ValueError(f"{least:g}…{most:.10g}")

    return parse


def _among(values: Mapping[str, object]) -> Callable[[str], object]:
    def parse(text: str) -> object:
        if text not in values:
            raise ValueError("|".join(values))
        return values[text]

    return parse


def codes(text: str) -> frozenset[int]:
    """Codes of commands, such as 14,33; raises `ValueError`."""
    try:
        found = frozenset(int(part, 16) for part in text.replace(",", " ").split())
    except ValueError:
        raise ValueError("CODE,…") from None
    if not found <= BY_CODE.keys():
        raise ValueError("|".join(f"{code:02X}" for code in sorted(BY_CODE)))
    return found


_TYPED: Mapping[str, Callable[[str], Any]] = {
    "baud": _among({str(rate): rate for rate in BAUD_RATES}),
    "mute_codes": codes,
}


def _option_of(source: "Field[Any]") -> Option:
    kind = source.metadata["kind"]
    make = partial(
        Option,
        name=source.name,
        group=source.metadata["group"],
        text=source.metadata["text"],
        default=source.default,
    )
    if isinstance(source.default, Enum):
        kind = {str(member.value): member for member in type(source.default)}
    match kind:
        case None:
            return make(parse=_yes_or_no, is_flag=True)
        case dict():
            return make(parse=_among(kind), choices=tuple(kind))
        case str():
            return make(parse=_TYPED[source.name], metavar=kind)
    metavar, least, most = kind
    number = int if isinstance(source.default, int) else float
    return make(parse=_between(number, least, most), metavar=metavar)


OPTIONS: tuple[Option, ...] = tuple(
    sorted(map(_option_of, fields(Setup)), key=lambda option: list(Group).index(option.group))
)
BY_NAME: dict[str, Option] = {option.name: option for option in OPTIONS}


def find_option(name: str) -> Option:
    """By its name, with `-` or `_`; raises `UserError`."""
    option = BY_NAME.get(name.replace("-", "_"))
    if option is None:
        raise UserError(marked("No option {name}."), name=name)
    return option


def parse_value(option: Option, text: str) -> Any:
    """Parse the value of an option; raises `UserError`."""
    try:
        return option.parse(text)
    except ValueError as error:
        refused = marked("{option}={text}: expected {expected}")
        raise UserError(refused, option=option.name, text=text, expected=error) from error


def as_text(value: object) -> str:
    """A value in the form in which it is typed."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, frozenset):
        return ",".join(f"{code:02X}" for code in sorted(value))
    if isinstance(value, Enum):
        return str(value.value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def default_text(option: Option) -> str:
    """The default in the form in which it is typed: the codes of E3 and E4 are hexadecimal."""
    return f"{option.default:02X}" if option.name in ("voltage_code", "freefall_ack") else as_text(option.default)


def parse_options(texts: Mapping[str, str] | Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Values by option name; raises `UserError` for the first invalid one."""
    pairs = texts.items() if isinstance(texts, Mapping) else texts
    found = [(find_option(name), text) for name, text in pairs]
    return {option.name: parse_value(option, text) for option, text in found}
