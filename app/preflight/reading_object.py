"""What `dps-s read --json` prints, also part of a pre-flight record."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta, Struct

from app.engine.conversation import STATUS_KEYS
from app.procedures.read import LIVE_KEYS, NO_REPLY, SETTING_KEYS
from app.text.messages import UserMessage, clean, message
from protocol.fields import Value

if TYPE_CHECKING:  # a reading loads nothing of a check
    from app.preflight.evidence import Evidence


class LinkJson(Struct, frozen=True, forbid_unknown_fields=True):
    """`round_trip_ms`: the median time from a question to its answer."""

    port: str
    baud_rate: Annotated[int, Meta(ge=0)]
    round_trip_ms: float | None


class StatusJson(Struct, frozen=True, forbid_unknown_fields=True):
    """The module's last report."""

    tilt_deg: float | None
    acceleration_g: float | None
    triggered: bool | None
    active: bool | None


class SettingsJson(Struct, frozen=True, forbid_unknown_fields=True):
    """All settings, the most important first."""

    attitude_threshold_deg: float | None
    freefall_acceleration_g: float | None
    freefall_time_s: float | None
    light_threshold_v: float | None
    attitude_trigger: bool | None
    freefall_trigger: bool | None
    serial_output: bool | None
    baud_rate: Literal[4800, 9600, 19200, 38400, 57600, 115200] | None


class ReadJson(Struct, frozen=True, forbid_unknown_fields=True):
    """What the module says of itself now. A value that is not known is null; `errors` tells why."""

    link: LinkJson
    status: StatusJson
    boot_count: Annotated[int, Meta(ge=0, le=255)] | None
    cell_voltage_v: float | None
    charging: bool | None
    light_v: float | None
    settings: SettingsJson
    errors: dict[str, str]


def reading_object(
    *,
    port: str,
    baud_rate: int,
    round_trip_s: float | None,
    values: Mapping[str, Value | None],
    errors: Mapping[str, UserMessage],
) -> ReadJson:
    """`values` by key, without the unknown ones; `errors`: why they are unknown."""

    def known(keys: Iterable[str]) -> dict[str, Any]:
        return {key: values.get(key) for key in keys}

    round_trip_ms = None if round_trip_s is None else round(1000 * round_trip_s, 1)
    return ReadJson(
        link=LinkJson(port=port, baud_rate=baud_rate, round_trip_ms=round_trip_ms),
        status=StatusJson(**known(STATUS_KEYS)),
        settings=SettingsJson(**known(SETTING_KEYS)),
        errors={key: why.in_english() for key, why in sorted(errors.items())},
        **known(LIVE_KEYS),
    )


def readings_of(evidence: "Evidence") -> ReadJson:
    """The last readings of a check, for its JSON and its record; null where nothing is known."""
    values: dict[str, Value | None] = {key: readings[-1] for key, readings in evidence.series.items() if readings}
    values |= evidence.values | {"baud_rate": evidence.baud_rate or None}
    if evidence.status is not None:
        values |= {key: getattr(evidence.status, key) for key in STATUS_KEYS}
    values |= {key: flag.is_enabled for key, flag in evidence.flags.items()}
    trips_s = sorted(evidence.round_trips_s)
    return reading_object(
        port=clean(evidence.port),
        baud_rate=evidence.baud_rate,
        round_trip_s=trips_s[len(trips_s) // 2] if trips_s else None,
        values=values,
        errors=dict.fromkeys(evidence.unanswered, message(NO_REPLY)),
    )
