"""A technician's whole way on the command line, from power on to the verified record; the independent module judges."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.module.line import Line, now
from tests.module.module import Module
from tests.support.processes import PROGRAM, ran

ACTIVE, ATTITUDE, ATTITUDE_OFF, FREEFALL_OFF = 0x10, 0x20, 0x16, 0x17


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
@pytest.mark.promise("f")
def test_from_power_on_to_the_verified_record(user_files: Path, tmp_path: Path) -> None:
    module = Module(now=now())
    module.settings.update({ATTITUDE_OFF: 1, FREEFALL_OFF: 1})
    report = tmp_path / "M-07.pdf"
    busy = tmp_path / "busy.toml"  # other processes of the machine delay what these say
    busy.write_text('name = "Busy"\n[limits]\nround_trip_max_ms = 500\nheartbeats_lost_max = 2\n', encoding="utf-8")

    def dps_s(*words: str, code: int = 0) -> dict[str, Any]:
        """What the command prints as JSON."""
        ended = ran(*PROGRAM, *words, "--json")
        assert ended.returncode == code, ended.stdout + ended.stderr
        found: dict[str, Any] = json.loads(ended.stdout)
        return found

    with Line(module) as line:
        at_port = ("--port", line.port)

        # Powered on: everything is read but the two flags, which nobody can ask for.
        settings = dps_s("read", *at_port)["settings"]
        assert (settings["attitude_threshold_deg"], settings["attitude_trigger"]) == (module.settings[ATTITUDE], None)

        # So there is no READY yet.
        check = ["preflight", *at_port, "--module", "M-07", "--who", "Li Wei", "--records-reviewed"]
        check += ["--profile", str(busy)]
        checked = dps_s(*check, code=1)
        results = {one["id"]: one["result"] for one in checked["checks"]}
        assert (checked["verdict"], results["attitude_trigger"], results["freefall_trigger"]) == (
            *("NO-GO", "unknown", "unknown"),
        )
        assert module.log.acts() == []

        # Set, and read back.
        written = dps_s("set", "attitude_threshold_deg=65", *at_port)["results"]
        assert written["attitude_threshold_deg"]["verified"] is True
        assert module.settings[ATTITUDE] == 65

        # Enabled, READY, ACTIVE and GO in one connection; the record is written.
        checked = dps_s(*check, "--enable-triggers", "--activate", "--yes", "--report", str(report))
        assert checked["verdict"] == "GO"
        assert [module.settings[code] for code in (ATTITUDE_OFF, FREEFALL_OFF, ACTIVE)] == [0, 0, 1]
        assert [entry.value for entry in module.log.acts()] == [1]

        # Back on the ground.
        assert dps_s("lock", *at_port, "--module", "M-07")["outcome"] == "confirmed"
        assert module.settings[ACTIVE] == 0

    # What remains: the record, whole and signed here, and what was done to this module.
    for path in (report, report.with_suffix(".json")):
        verified = dps_s("verify", str(path))
        assert [verified[name] for name in ("state", "verdict", "follows", "module", "who", "signed_by")] == (
            ["intact", "GO", "GO", "M-07", "Li Wei", "this_station"]
        )
    (today,) = dps_s("archive", "report")["modules"]
    assert (today["module"], today["last_check"]["verdict"], today["due"]) == ("M-07", "GO", [])
    told = [event["told"] for event in dps_s("archive", "module", "M-07")["events"]]
    assert [what for what in told if what.startswith("Pre-flight check: ")] == [
        f"Pre-flight check: {verdict}, checked by: Li Wei." for verdict in ("NO-GO", "READY", "GO")
    ]
