"""A module that lies or loses is never called READY, verified or locked: what the module itself holds is compared."""

import json
import sys
from collections.abc import Callable

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.module.options import Options
from tests.support.processes import PROGRAM, ran

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
CHECK = ("preflight", "--enable-triggers", "--records-reviewed", "--json")
AND_ACTIVATE = (*CHECK, "--activate", "--yes")


def with_both_disabled(options: Options) -> Module:
    module = Module(options, now=now())
    module.settings.update({0x16: 1, 0x17: 1})
    return module


def verdict(modules: list[Module], words: tuple[str, ...]) -> str:
    with Line(*modules) as line:
        ended = ran(*PROGRAM, *words, "--port", line.port)
    found = str(json.loads(ended.stdout)["verdict"])
    assert ended.returncode == (1 if found == "NO-GO" else 0), ended.stderr
    return found


@pytest.mark.parametrize(
    "make",
    [
        pytest.param(lambda: Options(copies={0x16: [0.25]}, lost_sets={0x17: -1}), id="16 acknowledged twice, 17 lost"),
        pytest.param(
            lambda: Options(copies={0x17: [0.8]}, lost_sets={0x16: -1}, freefall_code=0x16),
            id="17 acknowledged twice as 16, 16 lost",
        ),
        pytest.param(lambda: Options(instead={0x30: "01 01"}), id="30 active, the status locked"),
        pytest.param(lambda: Options(instead={0x30: "01 00"}), id="30 locked, the status active afterwards"),
        pytest.param(lambda: Options(second={0x20: (0.002, "01 55")}), id="two answers to one question"),
    ],
)
def test_a_module_that_lies_is_not_ready(make: Callable[[], Options]) -> None:
    module = with_both_disabled(make())
    words = AND_ACTIVATE if "01 00" in module.options.instead.values() else CHECK
    assert verdict([module], words) == "NO-GO"


def test_a_setting_that_reverts_by_itself_is_not_verified() -> None:
    module = Module(Options(reverts={0x22: (0.8, None)}), now=now())
    with Line(module) as line:
        ended = ran(*PROGRAM, "set", "freefall_time_s=0.90", "--json", "--port", line.port)
    assert ended.returncode == 1
    assert json.loads(ended.stdout)["results"]["freefall_time_s"]["verified"] is False


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_a_line_that_loses_bytes_only_what_the_module_holds_is_verified(seed: int) -> None:
    module = Module(Options(lose=0.02, jitter_s=0.01), seed=seed, now=now())
    with Line(module) as line:
        ended = ran(*PROGRAM, "set", "freefall_time_s=0.90", "attitude_threshold_deg=70", "--json", "--port", line.port)
    if ended.stdout:
        results = json.loads(ended.stdout).get("results", {})
        for name, code, byte in (("freefall_time_s", 0x22, 90), ("attitude_threshold_deg", 0x20, 70)):
            if results.get(name, {}).get("verified"):
                assert module.settings[code] == byte
    assert len(module.log.sets(0x22)) <= 1, "a set is sent once"
    assert len(module.log.sets(0x20)) <= 1


def test_lock_is_not_called_confirmed_by_a_module_that_only_acknowledges_it() -> None:
    module = Module(Options(ignored_sets={0x10: -1}), now=now())
    module.settings[0x10] = 1
    with Line(module) as line:
        ended = ran(*PROGRAM, "lock", "--port", line.port)
    assert ended.returncode == 1, ended.stderr
    assert module.settings[0x10] == 1


def test_of_two_modules_none_becomes_active() -> None:
    """The second one stands at 80°, which fires, and is set to 85°."""
    first, second = Module(now=now()), Module(Options(delay_s=0.002), now=now())
    second.settings[0x20], second.readings.tilt_deg = 85, 80
    with Line(first, second) as line:
        ended = ran(*PROGRAM, "activate", "--yes", "--port", line.port)
        read = ran(*PROGRAM, "read", "--json", "--port", line.port)
        written = ran(*PROGRAM, "set", "freefall_time_s=1.2", "--json", "--port", line.port)
    # Which it is depends on what arrives first: two copies of an answer, or two answers that differ.
    refused_or_interrupted = {1, 3}
    assert ended.returncode in refused_or_interrupted
    assert "Two modules on this line?" in ended.stderr
    assert [one.settings[0x10] for one in (first, second)] == [0, 0]
    assert read.returncode == 3
    # So it does where it is said: with the setting, or with the line.
    assert any("Two modules on this line?" in why for why in json.loads(read.stdout)["errors"].values())
    assert json.loads(written.stdout)["results"]["freefall_time_s"]["verified"] is not True
    assert written.returncode in refused_or_interrupted


def test_of_two_equal_modules_a_set_is_not_done_without_a_word() -> None:
    with Line(Module(now=now()), Module(Options(delay_s=0.002), now=now())) as line:
        written = ran(*PROGRAM, "set", "freefall_time_s=1.2", "--port", line.port)
    assert written.returncode != 0
    assert "Two modules on this line?" in written.stderr


@pytest.mark.parametrize(("code", "key"), [(0x30, "active"), (0x31, "triggered")])
def test_what_30_or_31_contradicts_is_null_and_both_are_named(code: int, key: str) -> None:
    with Line(Module(Options(instead={code: "01 01"}), now=now())) as line:
        told = json.loads(ran(*PROGRAM, "read", "--json", "--port", line.port).stdout)
    assert told["status"][key] is None
    assert told["errors"][key].startswith(f"{code:02X}: ")
    assert "status: " in told["errors"][key]
