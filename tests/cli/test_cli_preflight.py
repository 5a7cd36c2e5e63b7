"""`dps-s preflight` and `dps-s verify`, as the contract says, on the simulated module."""

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

import app.__main__ as program
from app.preflight.checks import CHECKS
from app.safety.journal import Act, Outcome
from app.store.fact_store import FILE_NAME, Store
from app.store.rows import PreflightCheck
from app.system.files import data_folder
from app.terminal.console import Signalled
from protocol.messages import decode_request
from tests.cli.test_schemas import faults
from tests.support.cli_line import Program, bench_of
from tests.support.processes import PROGRAM, ran, run_module
from tests.support.records.stored import audit, checks_of, open_store, records_of

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting")

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


def _assert_only_questions(wire: list[bytes], *, flags: int) -> None:
    requests = [decode_request(raw) for raw in wire]
    sets = [request.command.name for request in requests if not request.is_repeatable]
    assert sets == ["freefall_trigger", "attitude_trigger"][:flags]
    assert not {request.command.code for request in requests} & {0x10, 0x11, 0x12, 0x13, 0x24, 0x25}


def test_go_is_the_contract(port: str, dps_s: Program, wire: list[bytes]) -> None:
    shown = json.loads(dps_s(["preflight", "--port", port, "--enable-triggers", "--json"]).out)
    assert list(shown) == ["verdict", "checks", "read", "simulated", "softer_limits"]
    assert (shown["simulated"], shown["softer_limits"]) == (True, [])
    assert shown["verdict"] == "READY"
    assert [one["id"] for one in shown["checks"]] == [check.id for check in CHECKS]
    assert faults("preflight", shown) == []
    assert {one["result"] for one in shown["checks"]} <= {"pass", "warn"}
    assert all(one["limit"] and one["why"] and one["do"] for one in shown["checks"])
    cell = next(one for one in shown["checks"] if one["id"] == "cell_voltage")
    assert (cell["measured"], cell["limit"]) == (3.9, "≥ 3.80 V")
    assert shown["read"]["settings"]["attitude_trigger"] is True
    assert shown["read"]["settings"]["serial_output"] is None
    assert shown["read"]["settings"]["baud_rate"] == 115200
    _assert_only_questions(wire, flags=2)


def test_the_report_is_written_kept_and_verified(
    port: str, dps_s: Program, tmp_path: Path, qapp: object, kept: Store
) -> None:
    profile, report = tmp_path / "h6.toml", tmp_path / "r.pdf"
    profile.write_text(PROFILE, encoding="utf-8")
    words = ["preflight", "--port", port, "--enable-triggers", "--profile", str(profile), "--module", "M-07",
             "--aircraft", "B-1234", "--who", "Li Wei"]  # fmt: skip
    shown = json.loads(dps_s([*words, "--json"], 1).out)  # a required item was not ticked
    assert [(one["id"], one["result"], one["measured"]) for one in shown["checks"][-2:]] == [
        ("manual_1", "unknown", "skipped"), ("manual_2", "warn", "skipped"),
    ]  # fmt: skip
    assert str(report) in dps_s([*words, "--done", "1", "--report", str(report)]).err
    record = json.loads(report.with_suffix(".json").read_text(encoding="utf-8"))["record"]
    assert (record["module"], record["verdict"]) == ("M-07", "READY")
    assert len(record["frames"]) > 60
    for path in (report, report.with_suffix(".json")):
        out = dps_s(["verify", str(path)]).out
        assert out.startswith("INTACT")
        assert "Signed by this station" in out
        assert "M-07: READY" in out
    altered = tmp_path / "altered.json"
    altered.write_text(
        report.with_suffix(".json").read_text(encoding="utf-8").replace('"measured":3.9', '"measured":4.1', 1),
        encoding="utf-8",
    )
    assert dps_s(["verify", str(altered)], 1).out.startswith("ALTERED")
    of_module = checks_of(kept, "M-07")
    assert [one.verdict for one in of_module] == ["READY", "NO-GO"]
    assert [one.aircraft for one in of_module] == ["B-1234"] * 2
    assert [check.cell_voltage_v for check in of_module] == [3.9, 3.9]
    assert [one.outcome for one in audit(kept, Act.WRITE)] == [Outcome.CONFIRMED] * 4


def test_a_new_trigger_and_another_module_are_noticed(port: str, dps_s: Program, kept: Store) -> None:
    words = ["preflight", "--port", f"{port}?history=2", "--enable-triggers", "--json", "--module", "M-07"]

    def result(id_: str, *more: str, code: int, words: list[str] = words) -> str:
        checks = json.loads(dps_s([*words, *more], code).out)["checks"]
        return str({one["id"]: one["result"] for one in checks}[id_])

    assert result("trigger_records", code=1) == "unknown"
    assert result("trigger_records", "--records-reviewed", code=0) == "pass"
    assert result("trigger_records", code=0) == "pass"
    bench = bench_of(port)
    bench.module.activate(is_active=True)
    assert bench.pulse_pwm()
    bench.module.activate(is_active=False)
    bench.set_world(bay_is_open=False)
    assert result("trigger_records", code=1) == "fail"
    assert len(records_of(kept, "M-07")) == 3
    other = [*words[:2], f"{port}other?boots=12", *words[3:]]
    assert json.loads(dps_s(other, 1).out)["error"]["code"] == "refused"
    assert len(records_of(kept, "M-07")) == 3
    dps_s([*other, "--same-module"])


def test_a_silent_module_is_said_to_be_new_once_and_never_after_it_answered_or_fired(port: str, dps_s: Program) -> None:
    silent = ["preflight", "--port", f"{port}?mute_codes=35", "--enable-triggers", "--json"]
    named = [*silent, "--module", "M-07"]

    def result(words: list[str], code: int) -> tuple[str, str]:
        checks = json.loads(dps_s(words, code).out)["checks"]
        (found,) = (check for check in checks if check["id"] == "trigger_records")
        return found["result"], found["why"]

    assert result(named, 1)[0] == "unknown"
    assert result([*silent, "--records-reviewed"], 0)[0] == "warn"
    assert result(silent, 1)[0] == "unknown"  # without a name it is asked each time
    assert result([*named, "--records-reviewed"], 0)[0] == "warn"
    assert result(named, 0)[0] == "warn"
    bench = bench_of(port)
    bench.module.activate(is_active=True)
    assert bench.pulse_pwm()
    for is_said in (False, True):
        assert result([*named, "--records-reviewed"] if is_said else named, 1)[0] == "fail"
    bench.module.activate(is_active=False)
    bench.set_world(bay_is_open=False)
    assert result(named, 1)[0] == "unknown"  # the word ended with the trigger
    assert result([*named, "--records-reviewed"], 1)[0] == "warn"  # it fired: without a repack there is no READY
    dps_s(["archive", "service", "M-07", "--what", "repack", "--who", "Li Wei"], 0)
    assert result([*named, "--records-reviewed"], 0)[0] == "warn"
    bench.change(mute_codes=frozenset())
    answers = ["preflight", "--port", port, *named[3:], "--records-reviewed"]
    assert result(answers, 0)[0] == "pass"
    bench.change(mute_codes=frozenset({0x35}))
    found, _why = result([*answers], 1)
    assert found == "fail"


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


def test_ctrl_c_while_qt_prints_does_not_end_the_process(
    port: str, dps_s: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An exception in the middle of it would abort it."""

    def interrupted(*_: object) -> bytes:
        signal.raise_signal(signal.SIGINT)
        return b"%PDF"

    monkeypatch.setattr("ui.files.report_printer.print_pages", interrupted)
    dps_s(["preflight", "--port", port, "--report", str(tmp_path / "r.pdf")], 1)
    assert (tmp_path / "r.pdf").read_bytes() == b"%PDF"


def test_without_a_store_it_goes_on(port: str, dps_s: Program) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_bytes(b"")  # a file where the folder should be
    printed = dps_s(["preflight", "--port", port, "--enable-triggers", "--module", "M-07"])
    assert "Not kept." in printed.err
    assert printed.out.startswith("READY")


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_the_installed_program_prints_without_a_screen(tmp_path: Path, user_files: Path) -> None:
    """A process of its own, a pseudo-terminal, no display: the whole way, at its own pace."""
    busy = tmp_path / "busy.toml"  # other processes of the machine delay what this one sends
    busy.write_text('name = "Busy"\n[limits]\nround_trip_max_ms = 500\nheartbeats_lost_max = 2\n', encoding="utf-8")
    with run_module() as module:
        words = ["preflight", "--port", module.port, "--enable-triggers", "--records-reviewed", "--json"]
        words += ["--profile", str(busy)]
        words += ["--report", str(tmp_path / "r.pdf")]
        done = ran(*PROGRAM, *words, QT_QPA_PLATFORM="", DISPLAY="", LC_ALL="zh_CN.UTF-8")
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(done.stdout)["verdict"] == "READY"
    assert (tmp_path / "r.pdf").read_bytes().startswith(b"%PDF")
    assert list(user_files.rglob(FILE_NAME))
    assert "未" not in done.stderr  # nothing was said not to be kept


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


@pytest.mark.usefixtures("qapp")
def test_where_nobody_reads_it_is_kept_and_reported(
    port: str, kept: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `dps-s preflight … --report FILE.pdf | head -0`."""
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w", encoding="utf-8") as out:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdout", out)
        assert program.main(["preflight", "--port", port, "--report", str(tmp_path / "r.pdf")]) == 4
        monkeypatch.undo()
    assert len(kept.read(lambda facts: facts.of_kind(PreflightCheck))) == 1
    assert (tmp_path / "r.pdf").exists()


@pytest.mark.parametrize(("options", "is_said"), [(["--enable-triggers"], True), ([], False)])
def test_interrupted_it_says_that_the_triggers_may_be_enabled(
    options: list[str], is_said: bool, port: str, dps_s: Program, wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def check() -> None:
        if any(frame[3] == 2 for frame in wire) or (not options and len(wire) > 12):
            raise Signalled(2)

    monkeypatch.setattr("app.terminal.connection.check_signals", check)
    printed = dps_s(["preflight", "--port", port, "--json", *options], 130)
    assert json.loads(printed.out)["error"]["code"] == "cancelled"
    assert printed.err.startswith("Interrupted; may have been carried out.\n") == is_said
