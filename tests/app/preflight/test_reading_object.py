"""The settings in the order in which a person reads them, and a reading of which nothing is known."""

from app.preflight.reading_object import SETTING_KEYS, reading_object
from protocol.catalogue import SETTINGS


def test_the_most_important_settings_come_first() -> None:
    assert SETTING_KEYS[:8] == (
        "attitude_threshold_deg",
        "freefall_acceleration_g",
        "freefall_time_s",
        "light_threshold_v",
        "attitude_trigger",
        "freefall_trigger",
        "serial_output",
        "baud_rate",
    )
    assert sorted(SETTING_KEYS) == sorted(command.key for command in SETTINGS)


def test_what_is_unknown_is_null() -> None:
    nothing = reading_object(port="sim", baud_rate=9600, round_trip_s=None, values={}, errors={"light_v": "no reply"})
    assert nothing["link"] == {"port": "sim", "baud_rate": 9600, "round_trip_ms": None}
    assert nothing["light_v"] is None
    assert nothing["errors"] == {"light_v": "no reply"}
    some = reading_object(port="sim", baud_rate=9600, round_trip_s=0.01234, values={"light_v": 1.8}, errors={})
    assert some["link"] == {"port": "sim", "baud_rate": 9600, "round_trip_ms": 12.3}
    assert some["light_v"] == 1.8
