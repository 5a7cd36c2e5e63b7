"""`dps-s preflight` and `dps-s verify`, as the contract says, on the simulated module."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from app.port_urls.protocol_sim import open_bench
from app.preflight.checks import CHECKS
from app.safety.journal import Act, Outcome
from app.simulator.bench import SimulatedBench
from app.store.acts import unnamed_fired
from app.store.fact_store import Store
from protocol.catalogue import ACTIVATION, Request
from tests.files.records.test_record import signed_record
from tests.support.cli_line import Program, faults, sets
from tests.support.line.frames import at_each_frame
from tests.support.processes import PROGRAM, ran, run_module
from tests.support.records.stored import audit, checks_of, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting")
ACTIVATE = ("preflight", "--activate", "--yes", "--module", "M-07")
PROFILE = """
name = "H6"
[settings]
light_threshold_v = 1.8
[limits]
cell_voltage_min_v = 3.7
[[manual]]
text = "Canopy looked at"
required = true
[[manual]]
text = "Hatch free"
"""


@pytest.fixture
def kept() -> Iterator[Store]:
    """The store of this test, after the command."""
    with closing(open_store()) as store:
        yield store


def test_ready_is_the_contract(port: str, dps_s: Program, wire: list[bytes]) -> None:
    shown = json.loads(dps_s(["preflight", "--port", port, "--enable-triggers", "--json"]).out)
    assert faults("preflight", shown) == []
    assert (shown["verdict"], shown["simulated"], shown["softer_limits"]) == ("READY", True, [])
    assert [one["id"] for one in shown["checks"]] == [check.id for check in CHECKS]
    assert {one["result"] for one in shown["checks"]} <= {"pass", "warn"}
    assert all(one["limit"] and one["why"] and one["do"] for one in shown["checks"])
    settings = shown["read"]["settings"]
    assert (settings["attitude_trigger"], settings["serial_output"], settings["baud_rate"]) == (True, None, 115200)
    assert sets(wire) == ["freefall_trigger", "attitude_trigger"]


def test_the_report_is_written_kept_and_verified(
    port: str, dps_s: Program, tmp_path: Path, qapp: object, kept: Store
) -> None:
    profile, report = tmp_path / "h6.toml", tmp_path / "r.pdf"
    profile.write_text(PROFILE, encoding="utf-8")
    words = ["preflight", "--port", port, "--enable-triggers", "--profile", str(profile), "--module", "M-07",
             "--aircraft", "B-1234", "--who", "Li Wei"]  # fmt: skip
    shown = json.loads(dps_s([*words, "--json"], 1).out)  # a required item was not ticked
    assert [(one["id"], one["result"]) for one in shown["checks"][-2:]] == [
        ("manual_1", "unknown"),
        ("manual_2", "warn"),
    ]
    assert str(report) in dps_s([*words, "--done", "1", "--report", str(report)]).err
    record = json.loads(report.with_suffix(".json").read_text(encoding="utf-8"))["record"]
    assert (record["module"], record["verdict"]) == ("M-07", "READY")
    assert "Signed by this station" in dps_s(["verify", str(report)]).out
    checks = checks_of(kept, "M-07")
    assert [(one.verdict, one.aircraft) for one in checks] == [("READY", "B-1234"), ("NO-GO", "B-1234")]
    assert [one.outcome for one in audit(kept, Act.WRITE)] == [Outcome.CONFIRMED] * 4


def test_verify_says_intact_whoever_signed_and_altered(tmp_path: Path, dps_s: Program) -> None:
    path = tmp_path / "record.json"
    text = signed_record("worst").text
    path.write_text(text, encoding="utf-8")
    printed = dps_s(["verify", str(path)], 0).out
    assert printed.startswith("INTACT: NO-GO")
    assert "Signed by an unknown key" in printed
    told = json.loads(dps_s(["verify", str(path), "--json"], 0).out)
    names = ("state", "verdict", "follows", "signed_by")
    assert [told[name] for name in names] == ["intact", "NO-GO", "NO-GO", "unknown_key"]
    path.write_text(text.replace("Li Wei", "Li Bo"), encoding="utf-8")
    told = json.loads(dps_s(["verify", str(path), "--json"], 1).out)
    assert [told[name] for name in ("state", "signed_by", "signer")] == ["altered", "nobody", None]
    path.write_text("{}", encoding="utf-8")
    for file in (str(path), "a\0b"):
        assert json.loads(dps_s(["verify", file, "--json"], 2).out)["error"]["code"] == "unreadable"


def test_a_report_that_cannot_be_written_is_said(
    port: str, dps_s: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_path: Path, _data: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("app.records.report.write_whole", broken)
    words = ["preflight", "--port", port, "--enable-triggers", "--report", str(tmp_path / "r.pdf")]
    printed = dps_s(words, 4)
    assert "No space left" in printed.err
    assert "READY: activate" in printed.out


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_the_installed_program_prints_without_a_screen(tmp_path: Path, user_files: Path) -> None:
    """A process of its own, a pseudo-terminal, no display: the whole way, at its own pace."""
    busy = tmp_path / "busy.toml"  # other processes of the machine delay what this one sends
    busy.write_text('name = "Busy"\n[limits]\nround_trip_max_ms = 500\nheartbeats_lost_max = 2\n', encoding="utf-8")
    with run_module() as module:
        words = ["preflight", "--port", module.port, "--enable-triggers", "--records-reviewed", "--json"]
        words += ["--profile", str(busy), "--report", str(tmp_path / "r.pdf")]
        done = ran(*PROGRAM, *words, QT_QPA_PLATFORM="", DISPLAY="", LC_ALL="zh_CN.UTF-8")
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(done.stdout)["verdict"] == "READY"
    assert (tmp_path / "r.pdf").read_bytes().startswith(b"%PDF")
    assert "未" not in done.stderr  # nothing was said not to be kept


def test_triggered_of_a_module_without_a_name_is_kept_for_the_next_name(port: str, dps_s: Program, kept: Store) -> None:
    open_bench(port).module.activate(is_active=True)
    dps_s(["read", "--port", port])
    assert not kept.read(lambda facts: unnamed_fired(facts, port=port))
    assert open_bench(port).pulse_pwm()
    dps_s(["read", "--port", port])
    assert kept.read(lambda facts: unnamed_fired(facts, port=port))


def test_several_ports_are_checked_one_after_the_other(port: str, dps_s: Program) -> None:
    """One object a line; the worst decides."""
    words = ["preflight", "--enable-triggers", "--records-reviewed", "--json"]
    ports = [f"{port}-a", f"{port}-b?cell=3.5", f"{port}-c?mute=yes"]
    printed = dps_s([*words, *(word for one in ports for word in ("--port", one))], 1)
    found = [json.loads(line) for line in printed.out.splitlines()]
    assert found.pop()["error"]["code"] == "no_link"
    assert [one["read"]["link"]["port"] for one in found] == ports[:2]
    assert [one["verdict"] for one in found] == ["READY", "NO-GO"]
    assert f"No module answers on {ports[2]}" in printed.err
    dps_s([*words, "--port", ports[0], "--port", ports[2]], 3)
    dps_s([*words, "--port", ports[0], "--port", ports[1], "--report", "set.pdf"], 2)


# READY and GO, only in the connection in which the triggers were enabled


@pytest.mark.promise("f")
def test_activate_leads_in_one_connection_to_go(port: str, dps_s: Program, wire: list[bytes], kept: Store) -> None:
    printed = dps_s([*ACTIVATE, "--port", port])
    assert printed.out.startswith("GO: fit to fly\n")
    assert "ACTIVE" in printed.err
    assert sets(wire) == ["freefall_trigger", "attitude_trigger", "activation"]
    assert open_bench(port).module.state.is_active
    assert [check.verdict for check in checks_of(kept, "M-07")] == ["GO", "READY"]
    last = audit(kept)[0]
    assert (last.act, last.outcome) == (Act.ACTIVATE, Outcome.CONFIRMED)


@pytest.mark.parametrize(
    "arrange", [lambda bench: bench.set_world(bay_is_open=True), lambda bench: bench.module.activate(is_active=True)]
)
@pytest.mark.promise("f")
def test_what_is_not_ready_is_not_activated(
    port: str, dps_s: Program, wire: list[bytes], arrange: Callable[[SimulatedBench], None]
) -> None:
    arrange(open_bench(port))
    assert dps_s([*ACTIVATE, "--port", port], 1).out.startswith("NO-GO")
    assert "activation" not in sets(wire)


def _restart(bench: SimulatedBench) -> None:
    bench.module.memory.boot_count -= 1
    bench.restart()
    bench.module.activate(is_active=True)


@pytest.mark.parametrize(
    "act",
    [
        _restart,
        lambda bench: setattr(bench.module.memory, "attitude_threshold", 70),
        lambda bench: bench.module.activate(is_active=False),
    ],
)
@pytest.mark.promise("f")
def test_what_happens_at_the_activation_is_no_go_and_it_is_sent_once(
    port: str, dps_s: Program, wire: list[bytes], act: Callable[[SimulatedBench], None]
) -> None:
    bench, due_s = open_bench(port), list[float]()

    def happen(request: Request) -> None:
        if due_s and bench.clock() >= due_s[0]:
            due_s.clear()
            act(bench)
        if request.command is ACTIVATION:
            due_s.append(bench.clock() + 0.1)

    at_each_frame(bench, happen)
    assert dps_s([*ACTIVATE, "--port", port], 1).out.startswith("NO-GO")
    assert wire.count(ACTIVATION.set(True).encode()) == 1
