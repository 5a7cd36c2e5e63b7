""" "verified" is never a lie, and what moved without being written is named, whatever the module does."""

import os
from itertools import product
from typing import Any

import pytest

from app.procedures.write import WriteFault
from tests.support.line.write_lies import DIALECTS, WANTED, WRITE_LIES, write_to

STRIDE = 1 if os.environ.get("HYPOTHESIS_PROFILE") == "thorough" else 29
"""All of them are nearly 4,000 runs."""


@pytest.mark.parametrize("lie", WRITE_LIES, ids=str)
def test_no_lie_is_verified(lie: dict[str, Any]) -> None:
    for seed, (quirks, wanted) in list(enumerate(product(DIALECTS, WANTED)))[::STRIDE]:
        assert write_to({**quirks, **lie, "seed": seed}, wanted).faults == [], (quirks, wanted)


@pytest.mark.parametrize("name", ["21", "20", "15"])
def test_cross_talk_between_settings_is_named(name: str) -> None:
    report = write_to({"cross_talk": f"22:{name}=14"}, {"freefall_time": 1.2}).report
    assert report.results[0].verified
    assert [one.command.code for one in report.changed] == [int(name, 16)]
    assert not report.is_fine


@pytest.mark.parametrize(
    ("lie", "fault"),
    [
        ({"revert_ms": 20}, WriteFault.REVERTED),
        ({"revert_ms": 500}, WriteFault.REVERTED),
        ({"clamp_ms": 500}, WriteFault.REVERTED),
        ({"silent_restart_ms": 30}, WriteFault.RESTARTED),
        ({"silent_restart_ms": 500}, WriteFault.RESTARTED),
        ({"mute_codes": "20/6"}, WriteFault.NO_LAST_READING),
    ],
)
def test_what_happens_after_the_acknowledgement_is_found(lie: dict[str, Any], fault: WriteFault) -> None:
    report = write_to(lie, {"attitude_threshold": 130}).report
    assert [(one.fault, one.verified) for one in report.results] == [(fault, False)]


def test_a_flag_is_claimed_no_longer_after_a_silent_restart() -> None:
    report = write_to({"silent_restart_ms": 400}, {"attitude_trigger": False}).report
    assert [(one.fault, one.verified) for one in report.results] == [(WriteFault.RESTARTED, None)]
