"""`dps-s preflight`, `activate`, `preflight`: READY, then GO, where the audit log knows how the triggers stand."""

import json

import pytest

import app.__main__ as program
from app.store.database import open_database
from app.store.store import data_folder
from protocol.catalogue import BY_NAME
from tests.support.cli_line import Printed, bench_of, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "hasty", "brief")

TRIGGER = BY_NAME["attitude_trigger"]
NAMED = ("--module", "M-07", "--who", "Li Wei")


def _ready(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_here(capsys, ["preflight", "--enable-triggers", "--port", port, *NAMED]).out.startswith("READY")


def _activated(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    run_here(capsys, ["activate", "--yes", "--port", port])


def _checked(port: str, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[str, dict[str, str]]:
    """The verdict, and the results by check."""
    program.main(["preflight", "--port", port, "--json", *(words or NAMED)])
    shown = json.loads(Printed(capsys).out)
    return shown["verdict"], {one["id"]: one["result"] for one in shown["checks"]}


def test_ready_then_activated_is_go(
    port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes], tmp_path_factory: pytest.TempPathFactory
) -> None:
    _ready(port, capsys)
    _activated(port, capsys)
    wire.clear()
    out = run_here(capsys, ["preflight", "--port", port, *NAMED]).out
    assert out.startswith("GO: fit to fly\n")
    assert out.count("ago (audit log, entry ") == 2
    assert not [raw for raw in wire if raw[2] in (0x16, 0x17)]
    kept = open_database(data_folder()).database
    record = json.loads(kept.read("SELECT record FROM preflight_checks ORDER BY id DESC LIMIT 1")[0][0])
    kept.close()
    assert (record["verdict"], record["read"]["settings"]["attitude_trigger"]) == ("GO", True)
    shown = next(one["shown"] for one in record["checks"] if one["id"] == "attitude_trigger")
    assert shown["values"]["entry"] == "1"
    path = tmp_path_factory.mktemp("record") / "go.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    assert run_here(capsys, ["verify", str(path)]).out.startswith("INTACT")


def test_triggers_that_were_set_by_name_count_too(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["set", "freefall_time_s=1.4", "attitude_trigger=true", "freefall_trigger=true",
                         "--port", port]) == 0  # fmt: skip
    _activated(port, capsys)
    assert _checked(port, capsys)[0] == "GO"
    assert _checked(port, capsys, "--enable-triggers", *NAMED)[0] == "GO"  # which sends nothing to an active module


def test_a_restart_in_between_is_no_go(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    _ready(port, capsys)
    bench_of(port).restart()
    bench_of(port).module.activate(is_active=True)
    verdict, results = _checked(port, capsys)
    assert (verdict, results["attitude_trigger"], results["freefall_trigger"]) == ("NO-GO", "unknown", "unknown")


def test_a_trigger_that_was_disabled_since_is_no_go(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    _ready(port, capsys)
    assert program.main(["set", "attitude_trigger=false", "--accept-risk", "--port", port]) == 0
    _activated(port, capsys)
    verdict, results = _checked(port, capsys)
    assert (verdict, results["attitude_trigger"], results["freefall_trigger"]) == ("NO-GO", "unknown", "pass")


def test_another_port_adapter_or_name_is_another_module(
    port: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    _ready(port, capsys)
    _activated(port, capsys)
    other = f"{port}other"
    bench_of(other).module.activate(is_active=True)
    assert _checked(other, capsys)[1]["attitude_trigger"] == "unknown"
    assert _checked(port, capsys, "--module", "M-08")[1]["attitude_trigger"] == "unknown"
    assert _checked(port, capsys)[0] == "GO"
    monkeypatch.setattr("app.terminal.command_journal.adapter_of", lambda _port: "0403:6001 A1")
    assert _checked(port, capsys)[1]["attitude_trigger"] == "unknown"


def test_a_trigger_is_not_disabled_where_the_log_cannot_take_it(
    port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    """Else a later check would find the set before it."""
    data_folder().parent.mkdir(parents=True)
    data_folder().write_bytes(b"")  # a file where the folder should be
    assert (
        "audit log cannot be written"
        in run_here(capsys, ["set", "attitude_trigger=false", "--accept-risk", "--port", port], 1).out
    )
    assert not [raw for raw in wire if raw[2] == TRIGGER.code]
    assert program.main(["set", "attitude_trigger=true", "--port", port]) == 0
