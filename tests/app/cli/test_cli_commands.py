"""Every sub-command in this process, on the simulated module: what it prints and how it ends."""

import json
from pathlib import Path

import pytest

import app.__main__ as program
from app.engine.procedure import Inspect, Procedure
from app.procedures.history import History
from app.simulator import bench as benches
from protocol.catalogue import SERIAL_OUTPUT, STATUS
from tests.support.cli_line import Printed, bench_of, falls_after, is_one_sentence, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_read_for_people_and_programs(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    bench_of(port).set_tilt(7)
    printed = run_here(capsys, ["read", "--port", port, "--json"])
    shown = json.loads(printed.out)
    assert printed.err == ""
    assert 0 < shown["link"].pop("round_trip_ms") < 100
    assert shown == {
        "link": {"port": port, "baud_rate": 115200},
        "status": {"tilt_deg": 7, "acceleration_g": 1.0, "triggered": False, "active": False},
        "boot_count": 37,
        "cell_voltage_v": 3.9,
        "charging": False,
        "light_v": 0.3,
        "settings": {
            "attitude_threshold_deg": 60,
            "freefall_acceleration_g": 0.5,
            "freefall_time_s": 1.6,
            "light_threshold_v": 1.8,
            "attitude_trigger": None,
            "freefall_trigger": None,
            "serial_output": None,
            "baud_rate": 115200,
        },
        "errors": {},
    }
    assert "unknown (cannot be read)" in run_here(capsys, ["read", "--port", port]).out


def test_what_is_not_answered_is_null_and_said(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    printed = run_here(capsys, ["read", "--port", f"{port}?mute_codes=34", "--json"], 4)
    shown = json.loads(printed.out)
    assert shown["cell_voltage_v"] is None
    assert shown["errors"] == {"cell_voltage_v": "no reply within 1.0 s, asked 3 times"}
    assert shown["charging"] is False
    assert "cell_voltage_v" in printed.err


def test_a_stream_that_was_on_is_seen(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["read", "--port", f"{port}?stream_at_boot=yes&rate=500", "--json"]) == 0
    assert json.loads(Printed(capsys).out)["settings"]["serial_output"] is True


@pytest.mark.parametrize(("is_unplugged", "error", "said"), [(False, "no reply", ""), (True, "port lost", "unplugged")])
def test_what_ends_in_the_middle_keeps_what_was_read(
    port: str, hasty: None, is_unplugged: bool, error: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_of(port)
    with falls_after(bench, 4, bench.unplug if is_unplugged else lambda: bench.change(mute=True)):
        assert program.main(["read", "--port", port, "--json"]) == 4
    printed = Printed(capsys)
    shown = json.loads(printed.out)
    assert (shown["status"]["tilt_deg"], shown["status"]["acceleration_g"]) == (0, 1.0)
    assert (shown["boot_count"], shown["errors"]["boot_count"]) == (None, error)
    assert said in printed.err
    assert is_one_sentence(printed.err)


def test_a_restart_in_the_middle_reads_again(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    bench = bench_of(port)
    with falls_after(bench, 6, bench.restart):
        assert program.main(["read", "--port", port, "--json"]) == 0
    shown = json.loads(Printed(capsys).out)
    assert shown["boot_count"] == 38
    assert shown["errors"] == {}
    assert wire.count(STATUS.query().encode()) >= 2


def test_history_in_all_its_shapes(port: str, hasty: None, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    quirks = "history=9&records=pieces&record_gap_ms=2&odd_voltage=yes"
    shown = json.loads(run_here(capsys, ["history", "--port", f"{port}?{quirks}", "--json"]).out)
    assert len(shown["records"]) == 9
    assert shown["records"][0]["implausible"] == ["cell_voltage_v"] or shown["records"][0]["charging"]
    assert len(run_here(capsys, ["history", "--port", port]).out.splitlines()) >= 10
    path = tmp_path / "records.csv"
    assert program.main(["history", "--port", port, "--csv", str(path)]) == 0
    assert path.read_bytes().count(b"\r\n") == 10
    assert Printed(capsys).out.endswith(f"{path}: 9.\n")


def test_a_csv_that_cannot_be_written_loses_nothing(port: str, hasty: None, capsys: pytest.CaptureFixture[str]) -> None:
    printed = run_here(capsys, ["history", "--port", f"{port}?history=2", "--csv", "/no/such/folder/records.csv"], 4)
    assert len(printed.out.splitlines()) >= 3
    assert "/no/such/folder/records.csv cannot be written" in printed.err


def test_records_of_a_port_that_was_lost_are_kept(port: str, hasty: None, capsys: pytest.CaptureFixture[str]) -> None:
    bench = benches.module(port.removeprefix("sim://"))
    # The second reading of the records is the third frame: heartbeat, records, records.
    with falls_after(bench, 3, bench.unplug):
        assert program.main(["history", "--port", f"{port}?empty_slots=ones", "--json"]) == 4
    printed = Printed(capsys)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 9, "answered": True, "complete": False}
    assert "unplugged" in printed.err


def test_records_that_never_agree_are_said_to_be_uncertain(
    port: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_history() -> Procedure[History]:
        yield Inspect()
        return History((), 1, is_answered=True)

    monkeypatch.setattr("app.cli.history.read_history", read_history)
    printed = run_here(capsys, ["history", "--port", port, "--json"], 4)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 1, "answered": True, "complete": False}
    assert "may be missing" in printed.err


def test_a_module_that_never_answers_for_its_records_is_unknown(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    printed = run_here(capsys, ["history", "--port", f"{port}?mute_codes=35&history=3", "--json"], 4)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 0, "answered": False, "complete": False}
    assert "no reply" in printed.err


def test_find_says_what_it_tried(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["find", "--port", f"{port}?baud=57600", "--json"]) == 0
    assert json.loads(Printed(capsys).out) == {"baud_rate": 57600, "tried": [115200, 57600]}
    assert "57600 baud" in run_here(capsys, ["find", "--port", port, "--baud", "57600"]).out


def test_find_with_nothing_there(
    port: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.procedures.find.WAITS_S", (0.02,))
    printed = run_here(capsys, ["find", "--port", f"{port}?mute=yes", "--json"], 3)
    assert json.loads(printed.out) == {"baud_rate": None, "tried": [115200, 57600, 38400, 19200, 9600, 4800]}
    assert printed.err == (
        f"No module answers on {port}?mute=yes at any baud rate. Check power, ground and crossed TX and RX.\n"
    ), "it advises to find the rate, which was just tried"


def test_auto_finds_the_rate_first(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    shown = json.loads(run_here(capsys, ["read", "--port", f"{port}?baud=57600", "--baud", "auto", "--json"]).out)
    assert shown["link"]["baud_rate"] == shown["settings"]["baud_rate"] == 57600


def test_a_set_without_an_answer_is_not_said_to_stand(
    port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    assert program.main(["set", "serial_output=true", "--port", f"{port}?stream=silent", "--json"]) == 1
    shown = json.loads(Printed(capsys).out)["results"]["serial_output"]
    assert shown["acknowledged"] is False
    assert shown["error"] == "no reply within 1.0 s; may have been carried out"
    assert wire.count(SERIAL_OUTPUT.set(True).encode()) == 1
