"""Options of the simulated module: one table for the command line, the query of `sim://` and the panel.

`dps-s simulate --ack one --drop 0.1` and `sim://bench?ack=one&drop=0.1` are the same.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from app.simulator.defect_texts import changes, codes, listed, marked_codes, marked_records, rules
from app.simulator.quirks import Acknowledge, BaudChange, Delivery, EmptySlots, Quirks, Streaming
from app.simulator.wire import FaultDirection, Faults
from app.text.i18n import tr
from protocol.catalogue import BAUD_RATES
from protocol.translatable import marked


class OptionRefused(ValueError):
    """An option that does not exist, or a value that it does not take; the text says which and what it takes."""


class Group(Enum):
    """Heading in the help; the value is its English, translatable text."""

    MODULE = marked("module")
    DIALECT = marked("dialect: where the vendor's table leaves it open")
    LIES = marked("lies and defects of the module; codes and values in hexadecimal")
    FAULTS = marked("faults of the line")
    PHYSICAL = marked("physical side")


class Target(Enum):
    """What an option is a field of."""

    DIALECT = "dialect"
    FAULTS = "faults"
    SETUP = "setup"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """How a simulated module begins."""

    quirks: Quirks = field(default_factory=Quirks)
    faults: Faults = field(default_factory=Faults)
    rate: float = 50.0
    baud: int = 115200
    active: bool = False
    boots: int = 37
    uptime: float = 60.0
    history: int = 0
    seed: int = 1
    tilt: float = 0.0
    cell: float = 3.9
    drain: float = 0.05
    bay_open: bool = False
    charger: bool = False
    noise: float = 0.0
    lifelike: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """One option. `name` is also the field's name in its target; on the command line `_` becomes `-`."""

    name: str
    group: Group
    target: Target
    text: str
    """English, translatable; begins with the E-number where there is one."""
    parse: Callable[[str], Any]
    default: Any
    metavar: str | None = None
    choices: tuple[str, ...] = ()
    is_flag: bool = False

    @property
    def flag(self) -> str:
        return "--" + self.name.replace("_", "-")


def _yes_or_no(text: str) -> bool:
    known = {"": True, "yes": True, "true": True, "on": True, "1": True}
    known |= {"no": False, "false": False, "off": False, "0": False}
    try:
        return known[text.lower()]
    except KeyError:
        raise ValueError(tr("yes or no is needed")) from None


def _number(minimum: float, maximum: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        with suppress(ValueError):
            value = float(text)
            if math.isfinite(value) and minimum <= value <= maximum:
                return value
        raise ValueError(tr("a number from {least} to {most} is needed", least=f"{minimum:g}", most=f"{maximum:g}"))

    return parse


def _integer(minimum: int, maximum: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        with suppress(ValueError):
            value = int(text)
            if minimum <= value <= maximum:
                return value
        raise ValueError(tr("a whole number from {least} to {most} is needed", least=minimum, most=maximum))

    return parse


def _baud_rate(text: str) -> int:
    if text not in map(str, BAUD_RATES):
        raise ValueError(tr("one of {rates} is needed", rates=", ".join(map(str, BAUD_RATES))))
    return int(text)


def _defaults(target: Target) -> object:
    return {Target.DIALECT: Quirks(), Target.FAULTS: Faults(), Target.SETUP: Setup()}[target]


def _option(name: str, group: Group, target: Target, text: str, parse: Callable[[str], Any], metavar: str) -> Option:
    default = getattr(_defaults(target), name)
    return Option(
        name=name, group=group, target=target, text=text, parse=parse, default=default, metavar=metavar
    )  # fmt: skip


def _setup(name: str, text: str, parse: Callable[[str], Any], metavar: str, group: Group = Group.MODULE) -> Option:
    return _option(name, group, Target.SETUP, text, parse, metavar)


def _fault(name: str, text: str, parse: Callable[[str], Any], metavar: str) -> Option:
    return _option(name, Group.FAULTS, Target.FAULTS, text, parse, metavar)


def _flag(name: str, group: Group, target: Target, text: str) -> Option:
    default = getattr(_defaults(target), name)
    return Option(
        name=name, group=group, target=target, text=text, parse=_yes_or_no, default=default, is_flag=True
    )  # fmt: skip


def _choice(name: str, text: str, kind: type[Enum] | Mapping[str, object], target: Target = Target.DIALECT) -> Option:
    values = {str(one.value): one for one in kind} if isinstance(kind, type) else dict(kind)

    def parse(value: str) -> object:
        if value not in values:
            raise ValueError(tr("one of {values} is needed", values=", ".join(values)))
        return values[value]

    group = Group.DIALECT if target is Target.DIALECT else Group.FAULTS
    default = getattr(_defaults(target), name)
    return Option(
        name=name, group=group, target=target, text=text, parse=parse, default=default, choices=tuple(values)
    )  # fmt: skip


_DIALECT, _FAULTS, _SETUP = Target.DIALECT, Target.FAULTS, Target.SETUP
_SHARE = _number(0.0, 1.0)
_MILLISECONDS = _number(0.0, 10_000.0)
_SECONDS = _number(0.0, 86_400.0)


def _lie(name: str, text: str, parse: Callable[[str], Any], metavar: str) -> Option:
    return _option(name, Group.LIES, Target.DIALECT, text, parse, metavar)


OPTIONS: tuple[Option, ...] = (
    _setup("rate", marked("status frames a second while serial output is on, 1 to 1440"), _number(1, 1440), "HZ"),
    _setup("baud", marked("baud rate of the module"), _baud_rate, "RATE"),
    _flag("active", Group.MODULE, _SETUP, marked("begin active instead of locked: it fires by its own thresholds")),
    _setup("boots", marked("boot count, 0 to 255"), _integer(0, 255), "N"),
    _setup("uptime", marked("seconds since it was switched on; 0 lets the two heartbeats be seen"),
           _number(0, 65535), "S"),
    _setup("history", marked("trigger records of earlier days, 0 to 9"), _integer(0, 9), "N"),
    _setup("seed", marked("seed of faults, noise and history: the same seed, the same run"), _integer(0, 2**31), "N"),
    _choice("ack", marked("E2: a set of 21, 22 or 24 is acknowledged by the value or by 01"), Acknowledge),
    _choice("voltage_code", marked("E3: code of the answer to the cell voltage, 34"), {"34": 0x34, "35": 0x35}),
    _choice("freefall_ack", marked("E4: code of the acknowledgement of 17"), {"16": 0x16, "17": 0x17}),
    _choice("records", marked("E6: records come in one go, one by one, or cut into pieces of seven bytes"), Delivery),
    _option("record_gap_ms", Group.DIALECT, _DIALECT, marked("E6: pause between records or pieces"),
            _MILLISECONDS, "MS"),
    _choice("empty_slots", marked("E7: slots never used are left out, sent as 00, or sent as FF"), EmptySlots),
    _choice("baud_ack", marked("E9: a new rate is acknowledged at the old rate, at the new, or begins at a restart"),
            BaudChange),
    _flag("light_inverted", Group.DIALECT, _DIALECT, marked("E11: more light reads lower")),
    _flag("odd_voltage", Group.DIALECT, _DIALECT, marked("E12: records carry 4.70 V, as the worked example does")),
    _flag("remembers", Group.DIALECT, _DIALECT,
          marked("E15: activation, trigger flags and serial output survive a restart")),
    _choice("stream", marked("serial output streams, is acknowledged without streaming, or is not answered"),
            Streaming),
    _flag("stream_at_boot", Group.DIALECT, _DIALECT, marked("serial output is on after every start")),
    _flag("keeps", Group.DIALECT, _DIALECT, marked("no: acknowledges settings and does not keep them")),
    _flag("clamps", Group.DIALECT, _DIALECT,
          marked("forces settings into the vendor's advice and acknowledges what it kept")),
    _flag("refuses", Group.DIALECT, _DIALECT, marked("keeps the old setting and acknowledges that")),
    _lie("mute_codes", marked("commands that it does not know, such as 14,33; 35/2 from the second time on"),
         marked_codes, "CODES"),
    _lie("cross_talk",
         marked("a set of one changes another: 21:20, with a value 16:17=01, the second time and 500 ms later "
                "21:20=14/2@500"), changes, "RULES"),
    _lie("read_changes", marked("the same after a query: 20:20=14/2@500"), changes, "RULES"),
    _lie("revert_ms", marked("settings go back to what they were, this long after a set"), _MILLISECONDS, "MS"),
    _lie("clamp_ms", marked("settings are forced into the vendor's advice, this long after a set"),
         _MILLISECONDS, "MS"),
    _flag("forgets", Group.LIES, _DIALECT, marked("a restart brings the default settings back")),
    _lie("silent_restart_ms", marked("restarts without heartbeats, this long after it acknowledged a change"),
         _MILLISECONDS, "MS"),
    _lie("restart_at_s", marked("restarts without heartbeats whenever it has run this long"), _SECONDS, "S"),
    _lie("drop_records", marked("records left out, 1 is the oldest: 3 always, 1/2 the second time"),
         marked_records, "RECORDS"),
    _lie("double_codes", marked("commands that are answered twice, such as 01,32"), codes, "CODES"),
    _lie("double_ms", marked("how long after the first the second answer comes"), _MILLISECONDS, "MS"),
    _lie("foreign_replies",
         marked("an answer to another command comes first: 20:22, with a value 20:22=05, or 500 ms later 20:22@500"),
         rules, "RULES"),
    _lie("stream_jitter_ms", marked("streamed status frames come up to this much late"), _MILLISECONDS, "MS"),
    _flag("activates", Group.LIES, _DIALECT, marked("no: acknowledges the activation and stays locked")),
    _flag("locks", Group.LIES, _DIALECT, marked("no: acknowledges locking and stays active")),
    _lie("active_late_ms", marked("reports a new activation state only this long afterwards"), _MILLISECONDS, "MS"),
    _flag("zeroes", Group.LIES, _DIALECT, marked("no: acknowledges zeroing without effect")),
    _flag("shuts_down", Group.LIES, _DIALECT, marked("no: acknowledges the shutdown and stays on")),
    _fault("drop", marked("share of whole requests and answers that vanish, 0 to 1"), _SHARE, "SHARE"),
    _fault("lose", marked("share of single bytes that vanish"), _SHARE, "SHARE"),
    _fault("corrupt", marked("share of bytes with one bit turned"), _SHARE, "SHARE"),
    _fault("garbage", marked("share of answers with random bytes before them"), _SHARE, "SHARE"),
    _fault("double", marked("share of answers that come twice"), _SHARE, "SHARE"),
    _choice("direction", marked("which way the five above apply"), FaultDirection, _FAULTS),
    _fault("delay_ms", marked("delay of every answer"), _MILLISECONDS, "MS"),
    _fault("jitter_ms", marked("up to this much more delay, at random"), _MILLISECONDS, "MS"),
    _fault("split_ms", marked("answers come in up to three pieces with this pause between them"), _MILLISECONDS, "MS"),
    _flag("echo", Group.FAULTS, _FAULTS, marked("the host's own bytes come back")),
    _flag("mute", Group.FAULTS, _FAULTS, marked("nothing that the module sends comes through")),
    _fault("min_gap_ms",
           marked("the module ignores a request that begins sooner than this after its last reply or the last request"),
           _MILLISECONDS, "MS"),
    _flag("half_duplex", Group.FAULTS, _FAULTS, marked("the module does not hear what arrives while it is sending")),
    _fault("lag_ms", marked("a wireless bridge: what the module sends, streamed or not, arrives later by this"),
           _MILLISECONDS, "MS"),
    _flag("paced", Group.FAULTS, _FAULTS, marked("no: bytes take no time on the line")),
    _setup("tilt", marked("angle against the horizontal plane, in degrees"), _number(-180, 180), "DEG", Group.PHYSICAL),
    _setup("cell", marked("cell voltage"), _number(0, 5), "V", Group.PHYSICAL),
    _setup("drain", marked("volts that the cell loses in an hour"), _number(0, 100), "V", Group.PHYSICAL),
    _flag("bay_open", Group.PHYSICAL, _SETUP, marked("the parachute bay is open")),
    _flag("charger", Group.PHYSICAL, _SETUP, marked("external power is connected")),
    _setup("noise", marked("noise of the sensors: 0 none, 1 usual"), _number(0, 100), "N", Group.PHYSICAL),
    _flag("lifelike", Group.PHYSICAL, _SETUP, marked("it wobbles a few degrees, as in the wind")),
)  # fmt: skip

BY_NAME: dict[str, Option] = {option.name: option for option in OPTIONS}


def find_option(name: str) -> Option:
    """By its name, with `-` or `_`; raises `OptionRefused`."""
    option = BY_NAME.get(name.replace("-", "_"))
    if option is None:
        raise OptionRefused(tr("the simulated module has no option {name}", name=name))
    return option


def parse_value(option: Option, text: str) -> Any:
    """The value that `text` stands for; raises `OptionRefused`."""
    try:
        return option.parse(text)
    except ValueError as error:
        raise OptionRefused(tr("{option}={value}: {reason}", option=option.name, value=text, reason=error)) from error


def as_text(value: object) -> str:
    """A value as one would type it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, frozenset | tuple):
        return listed(value)
    if isinstance(value, Enum):
        return str(value.value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def default_text(option: Option) -> str:
    """The default as one would type it: the codes of E3 and E4 are hexadecimal."""
    return f"{option.default:02X}" if option.name in ("voltage_code", "freefall_ack") else as_text(option.default)


def parse_options(texts: Mapping[str, str] | Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Values by option name; raises `OptionRefused` for the first that is wrong."""
    pairs = texts.items() if isinstance(texts, Mapping) else texts
    found = [(find_option(name), text) for name, text in pairs]
    return {option.name: parse_value(option, text) for option, text in found}


def fields_of(values: Mapping[str, Any], target: Target) -> dict[str, Any]:
    """Those of `values` that belong to the dialect, the faults or the setup."""
    return {name: value for name, value in values.items() if BY_NAME[name].target is target}


def setup_from(values: Mapping[str, Any]) -> Setup:
    """A setup with these values (by option name), and the defaults for the rest."""
    return Setup(
        quirks=Quirks(**fields_of(values, Target.DIALECT)),
        faults=Faults(**fields_of(values, Target.FAULTS)),
        **fields_of(values, Target.SETUP),
    )
