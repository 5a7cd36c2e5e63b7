"""What `dps-s read --json` prints, also part of a pre-flight record."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

from app.engine.device import STATUS_KEYS
from protocol.catalogue import SETTINGS, Command
from protocol.fields import Choice, Flag, Value

LIVE_KEYS = ("boot_count", "cell_voltage_v", "charging", "light_v")
_MOST_IMPORTANT = (
    "attitude_threshold_deg",
    "freefall_acceleration_g",
    "freefall_time_s",
    "light_threshold_v",
    "attitude_trigger",
    "freefall_trigger",
    "serial_output",
    "baud_rate",
)
SETTING_KEYS = tuple(
    sorted(
        (command.key for command in SETTINGS),
        key=lambda key: _MOST_IMPORTANT.index(key) if key in _MOST_IMPORTANT else len(_MOST_IMPORTANT),
    )
)
"""Keys of all settings, the most important first."""


class PartJson(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part of a reading. null: not known."""


class LinkJson(PartJson, frozen=True, kw_only=True):
    """`round_trip_ms`: the median time from a question to its answer."""

    port: str
    baud_rate: Annotated[int, Meta(ge=0)]
    round_trip_ms: float | None


class StatusJson(PartJson, frozen=True, kw_only=True):
    """The module's last report."""

    tilt_deg: float | None
    acceleration_g: float | None
    triggered: bool | None
    active: bool | None


def _type_of(command: Command) -> Any:
    match command.write:
        case Flag():
            return bool | None
        case Choice(values=rates):
            return Literal[tuple(sorted(rates.values()))] | None
        case _:
            return float | None


_COMMAND_OF = {command.key: command for command in SETTINGS}
SettingsJson = msgspec.defstruct(
    "SettingsJson",
    [(key, _type_of(_COMMAND_OF[key])) for key in SETTING_KEYS],
    bases=(PartJson,),
    frozen=True,
    kw_only=True,
)
"""All settings of the catalogue."""


class ReadJson(PartJson, frozen=True, kw_only=True):
    """What the module says of itself now; `errors` tells why a value is not known."""

    link: LinkJson
    status: StatusJson
    boot_count: Annotated[int, Meta(ge=0, le=255)] | None
    cell_voltage_v: float | None
    charging: bool | None
    light_v: float | None
    settings: SettingsJson  # type: ignore[valid-type]
    errors: dict[str, str]


def reading_object(
    *,
    port: str,
    baud_rate: int,
    round_trip_s: float | None,
    values: Mapping[str, Value | None],
    errors: Mapping[str, str],
) -> ReadJson:
    """`values` by key, without the unknown ones; `errors`: why they are unknown, in English."""
    live: dict[str, Any] = {key: values.get(key) for key in LIVE_KEYS}
    status: dict[str, Any] = {key: values.get(key) for key in STATUS_KEYS}
    return ReadJson(
        link=LinkJson(
            port=port,
            baud_rate=baud_rate,
            round_trip_ms=None if round_trip_s is None else round(1000 * round_trip_s, 1),
        ),
        status=StatusJson(**status),
        settings=SettingsJson(**{key: values.get(key) for key in SETTING_KEYS}),
        errors=dict(errors),
        **live,
    )
