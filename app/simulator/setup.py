"""What a simulated module and its line are like: one table for the command line, the query of `sim://` and the panel.

`dps-s simulate --ack one --drop 0.1` and `sim://bench?ack=one&drop=0.1` are the same. The defaults follow the frames in
the vendor's table. Names in brackets (E2 …) are explained in `docs/protocol.md`.
"""

# ruff: noqa: RUF009  an option is a field

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from enum import Enum, StrEnum
from functools import partial
from typing import Any, Final

from app.text.user_error import UserError
from protocol.catalogue import BAUD_RATES, BY_CODE
from protocol.translatable import marked

_MILLISECONDS: Final = ("MS", 0.0, 10_000.0)
_SHARE: Final = ("SHARE", 0.0, 1.0)


class Group(Enum):
    """Heading in the help; the value is its text."""

    MODULE = marked("Module")
    QUIRKS = marked("Protocol differences")
    DEFECTS = marked("Module faults")
    FAULTS = marked("Line faults")
    PHYSICAL = marked("Physics")


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """One option. `name` is the field of `Setup`; on the command line `_` becomes `-`."""

    name: str = ""
    group: Group
    text: str
    """In English; begins with the E-number if there is one."""
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
        numbers = frozenset(int(part, 16) for part in text.replace(",", " ").split())
    except ValueError:
        raise ValueError("CODE,…") from None
    if not numbers <= BY_CODE.keys():
        raise ValueError("|".join(f"{code:02X}" for code in sorted(BY_CODE)))
    return numbers


Kind = tuple[str, float, float] | tuple[str, Callable[[str], Any]] | Mapping[str, object] | None
"""Form of a value: placeholder and range of a number, or what parses it; words with their values. None: yes or no, or a
member of the default's enumeration."""


def _option(group: Group, default: Any, text: str, kind: Kind = None) -> Any:
    make = partial(Option, group=group, text=text, default=default)
    if isinstance(default, Enum):
        kind = {str(member.value): member for member in type(default)}
    match kind:
        case None:
            option = make(parse=_yes_or_no, metavar=YES_OR_NO)
        case (metavar, least, most):
            number = int if isinstance(default, int) else float
            option = make(parse=_between(number, least, most), metavar=metavar)
        case (metavar, parse):
            option = make(parse=parse, metavar=metavar)
        case words:
            option = make(parse=_among(words), metavar=f"{{{','.join(words)}}}")
    return field(default=default, metadata={"option": option})


_module, _quirk, _defect, _fault, _physical = (partial(_option, group) for group in Group)


Acknowledge = StrEnum("Acknowledge", ["ECHO", "ONE"])
Delivery = StrEnum("Delivery", ["TOGETHER", "SPACED", "PIECES"])
EmptySlots = StrEnum("EmptySlots", ["NONE", "ZEROS", "ONES"])
BaudChange = StrEnum("BaudChange", ["OLD", "NEW", "RESTART"])
Streaming = StrEnum("Streaming", ["YES", "ACKNOWLEDGED", "SILENT"])


class FaultDirection(StrEnum):
    """Direction in which drop, lose, corrupt, garbage and double apply."""

    TO_HOST = "to-host"
    TO_MODULE = "to-module"
    BOTH = "both"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Initial state, behaviour and line of one module. Shares are 0 … 1."""

    rate: float = _quirk(50.0, marked("Stream rate"), ("HZ", 1, 1440))
    baud: int = _module(115200, marked("Baud rate"), ("RATE", _among({str(rate): rate for rate in BAUD_RATES})))
    active: bool = _module(False, marked("Active"))
    boots: int = _module(37, marked("Boot count"), ("N", 0, 255))
    uptime: float = _module(60.0, marked("After power-on"), ("S", 0, 65535))
    """With 0 the two heartbeats after power-on are sent."""
    pwm_after: float = _module(0.0, marked("PWM trigger after"), ("S", 0, 86_400))
    """It fires then if it is active; 0 for never."""
    history: int = _module(0, marked("Trigger records"), ("N", 0, 9))
    seed: int = _module(1, marked("Random seed"), ("N", 0, 2**31))
    tilt: float = _physical(0.0, marked("Tilt"), ("DEG", -180, 180))
    cell: float = _physical(3.9, marked("Cell voltage"), ("V", 0, 5))
    drain: float = _physical(0.05, marked("Cell drain per hour"), ("V", 0, 100))
    bay_open: bool = _physical(False, marked("Bay open"))
    charger: bool = _physical(False, marked("External power"))
    noise: float = _physical(0.0, marked("Sensor noise"), ("N", 0, 100))
    """1 is typical."""
    lifelike: bool = _physical(False, marked("Wobbles"))
    ack: Acknowledge = _quirk(Acknowledge.ECHO, marked("E2: acknowledgement"))
    voltage_code: int = _quirk(0x35, marked("E3: voltage code"), {"34": 0x34, "35": 0x35})
    freefall_ack: int = _quirk(0x16, marked("E4: code for 17"), {"16": 0x16, "17": 0x17})
    records: Delivery = _quirk(Delivery.TOGETHER, marked("E6: record delivery"))
    empty_slots: EmptySlots = _quirk(EmptySlots.NONE, marked("E7: empty slots"))
    baud_ack: BaudChange = _quirk(BaudChange.OLD, marked("E9: baud-rate change"))
    light_inverted: bool = _quirk(False, marked("E11: inverted light"))
    odd_voltage: bool = _quirk(False, marked("E12: 4.70 V records"))
    remembers: bool = _quirk(False, marked("E15: keeps state"))
    stream: Streaming = _quirk(Streaming.YES, marked("Serial output"))
    stream_at_boot: bool = _quirk(False, marked("Streams after start"))
    keeps: bool = _quirk(True, marked("Keeps settings"))
    clamps: bool = _quirk(False, marked("Clamps settings"))
    refuses: bool = _quirk(False, marked("Refuses settings"))
    mute_codes: frozenset[int] = _defect(frozenset(), marked("Ignored commands"), ("CODE,…", codes))
    forgets: bool = _defect(False, marked("Restart loses settings"))
    restart_at_s: float = _defect(0.0, marked("Silent restart every"), ("S", 0, 86_400))
    drop: float = _fault(0.0, marked("Lost frames"), _SHARE)
    lose: float = _fault(0.0, marked("Lost bytes"), _SHARE)
    corrupt: float = _fault(0.0, marked("Bit errors"), _SHARE)
    garbage: float = _fault(0.0, marked("Garbage"), _SHARE)
    double: float = _fault(0.0, marked("Duplicate replies"), _SHARE)
    direction: FaultDirection = _fault(FaultDirection.TO_HOST, marked("Direction of faults"))
    delay_ms: float = _fault(0.0, marked("Delay"), _MILLISECONDS)
    jitter_ms: float = _fault(0.0, marked("Jitter"), _MILLISECONDS)
    split_ms: float = _fault(0.0, marked("Split, pause"), _MILLISECONDS)
    echo: bool = _fault(False, marked("Echo"))
    mute: bool = _fault(False, marked("Mute"))
    lag_ms: float = _fault(0.0, marked("Wireless lag"), _MILLISECONDS)


OPTIONS: tuple[Option, ...] = tuple(
    sorted(
        (replace(source.metadata["option"], name=source.name) for source in fields(Setup)),
        key=lambda option: list(Group).index(option.group),
    )
)
BY_NAME: dict[str, Option] = {option.name: option for option in OPTIONS}


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
    """Values by option name, which may have `-` for `_`; raises `UserError` for the first invalid one."""
    values = {}
    for name, text in texts.items() if isinstance(texts, Mapping) else texts:
        option = BY_NAME.get(name.replace("-", "_"))
        if option is None:
            raise UserError(marked("“{name}” is unknown."), name=name)
        try:
            values[option.name] = option.parse(text)
        except ValueError as error:
            refused = marked("{option}={text}: expected {expected}")
            raise UserError(refused, option=option.name, text=text, expected=error) from error
    return values
