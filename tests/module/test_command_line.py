"""The command line at independent modules: what the module itself holds and heard is compared with what is said."""

import os
import sys
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from app.engine.ports import PortInfo
from app.integration import opened
from app.safety.last_known import keep_away
from tests.hardware import test_read_only, test_writing
from tests.module.line import Line, now
from tests.module.module import ACTIVATION, ACTIVE, ATTITUDE, ATTITUDE_OFF, FREEFALL_OFF, TRIGGERED, Module
from tests.module.options import Options
from tests.module.wire import Question
from tests.support.cli_line import run_here
from tests.support.virtual_cli import PORT, VirtualCli

TWO = "Two modules on this line?"


# Two modules on one line, and one that contradicts itself


@pytest.mark.parametrize("apart_s", [0.0, 0.01, 0.048])
@pytest.mark.parametrize("words", ["read", "set freefall_time_s=1.20"])
def test_a_second_module_that_tells_the_same_is_said(apart_s: float, words: str) -> None:
    """It answers up to 50 ms after the first one, by which time all has been asked."""
    cli = VirtualCli(Options(), Options(delay_s=apart_s))
    ran = cli.run(*words.split(), "--json")
    assert ran.code == 4, ran.err
    assert ran.err.count(TWO) == 1


def test_of_two_modules_none_becomes_active() -> None:
    """The second one stands at 80°, which fires, and is set to 85°."""
    cli = VirtualCli(Options(), Options(delay_s=0.002))
    second = cli.modules[1]
    second.settings[ATTITUDE], second.readings.tilt_deg = 85, 80
    ended = cli.run("activate", "--yes")
    # Which it is depends on what arrives first: two copies of an answer, or two answers that differ.
    assert ended.code in (1, 3)
    assert TWO in ended.err
    assert [one.settings[ACTIVATION] for one in cli.modules] == [0, 0]
    read = cli.run("read", "--json")
    assert read.code == 3
    # So it does where it is said: with the setting, or with the line.
    assert any(TWO in why for why in read.lines[-1]["errors"].values())
    assert read.lines[-1]["settings"]["attitude_threshold_deg"] is None, "which of the two holds nobody knows"
    written = cli.run("set", "freefall_time_s=1.2", "--json")
    assert written.code in (1, 3)
    assert written.lines[-1]["results"]["freefall_time_s"]["verified"] is not True


@pytest.mark.parametrize(("code", "key"), [(ACTIVE, "active"), (TRIGGERED, "triggered")])
def test_what_30_or_31_contradicts_is_null_and_both_are_named(code: int, key: str) -> None:
    told = VirtualCli(Options(instead={code: "01 01"})).run("read", "--json").lines[-1]
    assert told["status"][key] is None
    assert told["errors"][key].startswith(f"{code:02X}: ")
    assert "status: " in told["errors"][key]


# The whole way


@pytest.mark.promise("f")
@pytest.mark.usefixtures("qapp")  # the report is printed, which otherwise makes an application of its own
def test_from_power_on_to_the_verified_record(tmp_path: Path) -> None:
    cli, report = VirtualCli(), tmp_path / "M-07.pdf"
    module = cli.module
    module.settings |= {ATTITUDE_OFF: 1, FREEFALL_OFF: 1}

    def dps_s(*words: str, code: int = 0, port: str = PORT) -> dict[str, Any]:
        """What the command prints as JSON."""
        ran = cli.run(*words, "--json", port=port)
        assert ran.code == code, ran.out + ran.err
        return ran.lines[-1]

    # Powered on: everything is read but the two flags, which nobody can ask for.
    settings = dps_s("read")["settings"]
    assert (settings["attitude_threshold_deg"], settings["attitude_trigger"]) == (60, None)

    # So there is no READY yet.
    check = ("preflight", "--module", "M-07", "--who", "Li Wei", "--records-reviewed")
    checked = dps_s(*check, code=1)
    results = {one["id"]: one["result"] for one in checked["checks"]}
    assert (results["attitude_trigger"], results["freefall_trigger"]) == ("unknown", "unknown")
    assert checked["verdict"] == "NO-GO"
    assert module.log.acts() == []

    # Set, and read back.
    written = dps_s("set", "attitude_threshold_deg=65")["results"]
    assert written["attitude_threshold_deg"]["verified"] is True
    assert module.settings[ATTITUDE] == 65

    # Enabled, READY, ACTIVE and GO in one connection; the record is written.
    checked = dps_s(*check, "--enable-triggers", "--activate", "--yes", "--report", str(report))
    assert checked["verdict"] == "GO"
    assert [module.settings[code] for code in (ATTITUDE_OFF, FREEFALL_OFF, ACTIVATION)] == [0, 0, 1]
    assert [entry.value for entry in module.log.acts()] == [1]

    # After GO it is the normal end that it was left ACTIVE: a plain line, and no warning.
    left = cli.run("read").err
    assert "M-07 was left ACTIVE on " in left
    assert keep_away() not in left

    # Back on the ground.
    assert dps_s("lock", "--module", "M-07")["outcome"] == "confirmed"
    assert module.settings[ACTIVATION] == 0

    # What remains: the record, whole and signed here, and what was done to this module.
    for path in (report, report.with_suffix(".json")):
        verified = dps_s("verify", str(path), port="")
        assert [verified[name] for name in ("state", "verdict", "follows", "module", "who", "signed_by")] == (
            ["intact", "GO", "GO", "M-07", "Li Wei", "this_station"]
        )
    (today,) = dps_s("archive", "report", port="")["modules"]
    assert (today["module"], today["last_check"]["verdict"], today["due"]) == ("M-07", "GO", [])
    told = [event["told"] for event in dps_s("archive", "module", "M-07", port="")["events"]]
    assert [what for what in told if what.startswith("Pre-flight check: ")] == [
        f"Pre-flight check: {verdict}, checked by: Li Wei." for verdict in ("NO-GO", "READY", "GO")
    ]


# The door for other programs, and the tests of a real module


@pytest.mark.promise("g")
def test_what_takes_protection_away_is_sent_only_where_that_was_accepted() -> None:
    cli = VirtualCli()
    with cli.in_time(), opened(PORT) as module:
        assert not module.write(attitude_threshold_deg=30, freefall_trigger=False).is_fine
        assert cli.module.log.sets() == []
        assert module.write(accepts_risk=True, attitude_threshold_deg=30).is_fine
        assert cli.module.settings[ATTITUDE] == 30
        with pytest.raises(KeyError):
            module.write(baud=9600)
    assert cli.module.log.acts() == []


def test_the_hardware_tests_pass_at_a_module_that_keeps_to_the_table_and_change_nothing() -> None:
    """Else nobody would know that they work before there is one."""
    cli = VirtualCli()
    before = dict(cli.module.settings)
    tests = [value for name, value in vars(test_read_only).items() if name.startswith("test_")]
    tests += [partial(test_writing.test_a_setting_is_written_and_set_back, name) for name in test_writing.STEPS]
    for test in (*tests, test_writing.test_it_locks):
        test(cli.run)
    assert cli.module.settings == before


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
@pytest.mark.parametrize("has_twin", [False, True])
@pytest.mark.promise("l")
def test_an_owed_lock_goes_to_the_same_adapter_and_to_no_other_port(
    has_twin: bool, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In real time: pulled when the activation has left. Where no port has an identity it is in again a moment later,
    behind a link that lasts; of two adapters of one serial number only the other one is left."""
    module, other, link = Module(now=now()), Module(now=now()), str(tmp_path / "link")
    monkeypatch.setattr("app.terminal.connection.OWED_LIMIT_S", 2.0)
    with ExitStack() as lines:
        line = lines.enter_context(Line(module, link=link))
        stranger = lines.enter_context(Line(other))
        listed = [PortInfo(stranger.port)]
        if has_twin:
            listed = [
                PortInfo(port, serial_number="0001", vid=0x10C4, pid=0xEA60, location=location)
                for port, location in ((os.path.realpath(link), "1-1"), (stranger.port, "1-2"))
            ]
        monkeypatch.setattr("app.engine.ports.list_ports", lambda: list(listed))

        def move(question: Question) -> None:
            if question.code == ACTIVATION and question.value == 1:
                listed[:] = listed[-1:]
                line.unplug()
                if not has_twin:
                    lines.enter_context(Line(module, link=link))

        module.at_frame = move
        printed = run_here(capsys, ["activate", "--yes", "--port", link], 1)
    assert module.settings[ACTIVATION] == has_twin
    assert ("ACTIVE, not locked." if has_twin else "LOCK was sent after the interruption.") in printed.err
    assert not other.log.got(), "only the same adapter is opened again"
