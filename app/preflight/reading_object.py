"""JSON object of `dps-s read`, also part of a pre-flight record."""

from collections.abc import Mapping

from app.engine.device import STATUS_KEYS
from protocol.catalogue import SETTINGS
from protocol.fields import Value

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


def reading_object(
    *,
    port: str,
    baud_rate: int,
    round_trip_s: float | None,
    values: Mapping[str, Value | None],
    errors: Mapping[str, str],
) -> dict[str, object]:
    """`values` by key, without the unknown ones; `errors`: why they are unknown, in English."""
    return {
        "link": {
            "port": port,
            "baud_rate": baud_rate,
            "round_trip_ms": None if round_trip_s is None else round(1000 * round_trip_s, 1),
        },
        "status": {key: values.get(key) for key in STATUS_KEYS},
        **{key: values.get(key) for key in LIVE_KEYS},
        "settings": {key: values.get(key) for key in SETTING_KEYS},
        "errors": dict(errors),
    }
