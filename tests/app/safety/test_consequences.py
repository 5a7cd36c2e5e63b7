"""Consequences in plain words and figures."""

import pytest

from app.limits.limits import SETTING_BOUNDS
from app.safety.consequences import Weight, consequences, is_advised
from protocol.catalogue import BY_NAME, SETTINGS
from protocol.fields import Value


@pytest.mark.parametrize(
    ("name", "value", "sentences"),
    [
        ("freefall_time", 1.6,
         ["1.60 s of free fall is 12.6 m before it fires, at 56 km/h."]),
        ("freefall_time", 0, ["A jolt may fire it."]),
        ("freefall_time", 0.1,
         ["0.10 s of free fall is 0.049 m before it fires, at 3.5 km/h.", "A jolt may fire it."]),
        ("freefall_time", 0.01,
         ["0.01 s of free fall is 0.00049 m before it fires, at 0.35 km/h.", "A jolt may fire it."]),
        ("freefall_time", 0.5, ["0.50 s of free fall is 1.23 m before it fires, at 18 km/h."]),
        ("freefall_time", 2.55, ["2.55 s of free fall is 31.9 m before it fires, at 90 km/h."]),
        ("attitude_threshold", 60, ["Fires at 60°, rearms at 50°."]),
        ("attitude_threshold", 54, ["Fires at 54°, rearms at 44°.", "Against the vendor's advice: 55° or more."]),
        ("attitude_threshold", 100, ["Fires only upside down, at 100°; rearms at 90°."]),
        ("attitude_threshold", 200, ["No protection: no aircraft tilts by 200°."]),
        ("attitude_threshold", 10,
         ["Fires at 10° and never rearms.", "Against the vendor's advice: 55° or more."]),
        ("attitude_threshold", 0,
         ["Fires as soon as it is activated.", "Against the vendor's advice: 55° or more."]),
        ("freefall_acceleration", 0.5, ["Counts as falling below 0.5 g; at rest 1 g."]),
        ("freefall_acceleration", 0.7,
         ["Counts as falling below 0.7 g; at rest 1 g.", "Against the vendor's advice: Below 0.7 g."]),
        ("freefall_acceleration", 0, ["Never counts as falling: nothing is below 0 g."]),
        ("freefall_trigger", False, ["No protection in free fall."]),
        ("attitude_trigger", True, ["Fires by itself when it tips over."]),
        ("serial_output", False, ["Sends only when asked."]),
        ("baud_rate", 9600,
         ["The flight controller must then use 9600 baud, too.",
          "Against the vendor's advice: Do not change it."]),
    ],
)  # fmt: skip
def test_sentences(name: str, value: Value, sentences: list[str]) -> None:
    assert [one.sentence for one in consequences(BY_NAME[name], value)] == sentences


def test_a_threshold_that_counts_rest_as_falling_is_grave() -> None:
    said = consequences(BY_NAME["freefall_acceleration"], 1.0)
    assert [one.weight for one in said] == [Weight.GRAVE, Weight.AGAINST_ADVICE]


def test_every_value_of_a_byte_has_a_consequence() -> None:
    for command in SETTINGS:
        assert command.write is not None
        for raw in sorted(command.write.allowed):
            value = command.write.decode(raw)
            said = consequences(command, value)
            assert all(one.sentence for one in said)
            assert said
            is_against = any(one.weight is Weight.AGAINST_ADVICE and "advice" in one.message.text for one in said)
            assert is_against is not is_advised(command, value)


def test_a_free_fall_time_that_a_jolt_outlasts_needs_a_second_click() -> None:
    """Below what the pre-flight check allows."""
    bound = SETTING_BOUNDS["freefall_time_s"].advised_low
    weights = {
        seconds: [one.weight for one in consequences(BY_NAME["freefall_time"], seconds)]
        for seconds in (bound, bound - 0.01)
    }
    assert weights == {bound: [Weight.PLAIN], bound - 0.01: [Weight.PLAIN, Weight.AGAINST_ADVICE]}
