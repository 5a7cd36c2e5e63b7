"""Fields of a trigger record in JSON, CSV and the archive, and the texts of its source."""

from app.text.i18n import tr
from protocol.messages import TriggerRecord
from protocol.translatable import marked

JsonValue = bool | int | float | str | list[str] | None
FIELDS = (
    "boot_count",
    "uptime_s",
    "sources",
    "attitude_threshold_deg",
    "freefall_acceleration_g",
    "freefall_time_s",
    "serial_connected",
    "charging",
    "light_v",
    "cell_voltage_v",
    "implausible",
    "raw",
)
"""The names of the contract: the head of the CSV too, since they carry the units."""

SOURCE_WORDS = {
    "serial": marked("serial"),
    "attitude": marked("attitude"),
    "pwm": "PWM",
    "freefall": marked("free fall"),
}
"""English, marked. A bit that the vendor gives no name stands for itself."""


def record_values(record: TriggerRecord) -> dict[str, JsonValue]:
    """What the record says, by name."""
    return {
        "boot_count": record.boot_count,
        "uptime_s": record.uptime_s,
        "sources": list(record.sources),
        "attitude_threshold_deg": record.attitude_threshold_deg,
        "freefall_acceleration_g": record.freefall_acceleration_g,
        "freefall_time_s": record.freefall_time_s,
        "serial_connected": record.serial_connected,
        "charging": record.charging,
        "light_v": record.light_v,
        "cell_voltage_v": record.cell_voltage_v,
    }


def fields_of(record: TriggerRecord) -> dict[str, JsonValue]:
    """`FIELDS` of a record: what it says, what of that cannot be, and its bytes."""
    return {
        **record_values(record),
        "implausible": list(record.implausible),
        "raw": record.raw.hex(" ").upper(),
    }


def source_word(name: str) -> str:
    """In the language in use."""
    text = SOURCE_WORDS.get(name, name)
    return tr(text)
