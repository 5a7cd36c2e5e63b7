"""Settings are written, proven by reading back, and set back to what they were; LOCK is tried. Nothing is activated."""

import pytest

from tests.hardware.conftest import Run

STEPS = {
    "attitude_threshold_deg": (60, 61),
    "freefall_acceleration_g": (0.5, 0.4),
    "freefall_time_s": (1.6, 1.5),
    "light_threshold_v": (1.8, 1.9),
}
"""Two values within the vendor's advice; the one that it does not hold is written."""

pytestmark = pytest.mark.usefixtures("may_write")


@pytest.mark.parametrize("name", STEPS)
def test_a_setting_is_written_and_set_back(name: str, run: Run) -> None:
    before = run("read", "--json").lines[0]["settings"][name]
    wanted = next(value for value in STEPS[name] if value != before)
    try:
        ran = run("set", f"{name}={wanted}", "--json")
        assert ran.code == 0, ran.err
        assert ran.lines[0]["results"][name]["verified"] is True
        assert run("read", "--json").lines[0]["settings"][name] == wanted
    finally:
        back = run("set", f"{name}={before}", "--json", "--accept-risk")
    assert back.code == 0, f"{name} was {before} and was not set back: {back.err}"


def test_it_locks(run: Run) -> None:
    ran = run("lock", "--json")
    assert ran.code == 0, ran.err
    assert run("read", "--json").lines[0]["status"]["active"] is False
