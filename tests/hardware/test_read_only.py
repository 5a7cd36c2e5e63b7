"""What a module is asked without changing it. None of these sends anything but heartbeats and queries, except that
`monitor` switches the serial output on and back off."""

from tests.hardware.conftest import Run

RANGES = {
    "attitude_threshold_deg": (0, 180),
    "freefall_acceleration_g": (0.0, 2.0),
    "freefall_time_s": (0.0, 2.55),
    "light_threshold_v": (0.0, 5.0),
}
"""Wider than the vendor's ranges: a value outside was not understood."""


def test_everything_is_read(run: Run) -> None:
    ran = run("read", "--json")
    assert ran.code == 0, ran.err
    read = ran.lines[0]
    assert read["errors"] == {}
    assert read["status"]["triggered"] is False, "a module that has triggered is reset first"
    for name, (low, high) in RANGES.items():
        assert low <= read["settings"][name] <= high, name


def test_two_readings_agree(run: Run) -> None:
    first, second = (run("read", "--json").lines[0] for _ in range(2))
    assert first["settings"] == second["settings"]
    assert first["boot_count"] == second["boot_count"], "it restarted between them"


def test_the_trigger_records_are_read_the_same_twice(run: Run) -> None:
    first, second = (run("history", "--json") for _ in range(2))
    assert first.code in (0, 4), first.err
    assert [one["raw"] for one in first.lines[0]["records"]] == [one["raw"] for one in second.lines[0]["records"]]


def test_the_status_arrives_for_a_few_seconds(run: Run) -> None:
    ran = run("monitor", "--json", "--seconds", "3")
    assert ran.code == 0, ran.err
    assert len(ran.lines) >= 3
    assert all(0 <= line["tilt_deg"] <= 180 for line in ran.lines)


def test_its_baud_rate_is_found(run: Run) -> None:
    ran = run("find", "--json")
    assert ran.code == 0, ran.err
    assert ran.lines[0]["baud_rate"] in ran.lines[0]["tried"]
