"""The command line and an independent module whose answers come twice, differently, or not for a moment."""

import json
import subprocess
import sys
from typing import Any

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options
from tests.support.processes import PROGRAM, ran

ACTIVATION, ATTITUDE_OFF, FREEFALL_OFF = 0x10, 0x16, 0x17
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


def dps_s(line: Line, *words: str) -> "subprocess.CompletedProcess[str]":
    return ran(*PROGRAM, *words, "--port", line.port)


def module(**options: Any) -> Module:
    return Module(Options(**options), now=now())


def test_a_copy_after_seconds_is_not_taken_for_the_acknowledgement_of_a_set_that_was_lost() -> None:
    """E4: 17 is acknowledged under 16, and the line repeats that."""
    one = module(freefall_code=ATTITUDE_OFF, copies={FREEFALL_OFF: [3.5]}, lost_sets={ATTITUDE_OFF: -1})
    one.settings |= {ATTITUDE_OFF: 1, FREEFALL_OFF: 1}
    with Line(one) as line:
        ended = dps_s(line, "preflight", "--enable-triggers", "--activate", "--yes", "--records-reviewed", "--json")
    told = json.loads(ended.stdout)
    assert (ended.returncode, told["verdict"]) == (1, "NO-GO")
    checks = {check["id"]: check["result"] for check in told["checks"]}
    assert checks["attitude_trigger"] == "unknown"
    assert one.log.acts() == []


def test_of_two_modules_none_becomes_active() -> None:
    """The second one stands at 80°, which fires, and is set to 85°."""
    first, second = module(), module(delay_s=0.002)
    second.settings[0x20], second.readings.tilt_deg = 85, 80
    with Line(first, second) as line:
        ended = dps_s(line, "activate", "--yes")
        read = dps_s(line, "read", "--json")
        written = dps_s(line, "set", "freefall_time_s=1.2", "--json")
    # Which it is depends on what arrives first: two copies of an answer, or two answers that differ.
    refused_or_interrupted = {1, 3}
    assert ended.returncode in refused_or_interrupted
    assert "Two modules on this line?" in ended.stderr
    assert [one.settings[ACTIVATION] for one in (first, second)] == [0, 0]
    assert read.returncode == 3
    assert "Two modules on this line?" in json.loads(read.stdout)["errors"]["attitude_threshold_deg"]
    assert json.loads(written.stdout)["results"]["freefall_time_s"]["verified"] is not True
    assert written.returncode in refused_or_interrupted


@pytest.mark.parametrize(
    ("instead", "is_active", "key"),
    [({0x30: "01 01"}, 0, "active"), ({0x30: "01 00"}, 1, "active"), ({0x31: "01 01"}, 0, "triggered")],
)
def test_what_30_or_31_contradicts_is_null_with_both_named(instead: dict[int, str], is_active: int, key: str) -> None:
    one = module(instead=instead)
    one.settings[ACTIVATION] = is_active
    with Line(one) as line:
        told = json.loads(dps_s(line, "read", "--json").stdout)
        written = dps_s(line, "set", "freefall_time_s=1.2")
    assert told["status"][key] is None
    assert told["errors"][key].startswith("30: " if key == "active" else "31: ")
    assert "status: " in told["errors"][key]
    assert written.returncode == 1
    assert one.log.sets() == []


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_after_half_a_second_of_silence_lock_is_confirmed(frames: int) -> None:
    one = module(delay_s=0.001)
    one.settings[ACTIVATION] = 1

    def fall_silent(_question: object) -> None:
        if len(one.log.got()) + 1 == frames:
            one.be_silent(now(), 0.5)

    one.at_frame = fall_silent
    with Line(one) as line:
        ended = dps_s(line, "lock")
    assert ended.returncode == 0, ended.stderr
    assert one.settings[ACTIVATION] == 0
