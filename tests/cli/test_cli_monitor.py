"""`dps-s monitor`, and what all read-only commands put onto the wire: nothing that changes it but the stream."""

import csv
import io
import json
from pathlib import Path

import pytest

import app.__main__ as program
from app.captures.traffic import Way
from app.recordings.library import RecordingLibrary
from protocol.catalogue import SERIAL_OUTPUT
from tests.support.cli_line import Printed, Program, bench_of, falls_after, run_here
from tests.support.patience import in_time
from tests.support.records.recordings_made import read_session

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "hasty", "user_files")


def test_monitor_switches_the_stream_on_and_off(port: str, hasty: None, dps_s: Program, wire: list[bytes]) -> None:
    printed = dps_s(["monitor", "--port", f"{port}?rate=200", "--seconds", "1.2", "--json"])
    lines = [json.loads(line) for line in printed.out.splitlines()]
    assert lines[0] == {"t_s": 0.0, "tilt_deg": 0, "acceleration_g": 1.0, "triggered": False, "active": False}
    assert len(lines) > 50
    times = [line["t_s"] for line in lines]
    assert times == sorted(times)
    assert 0.6 < times[-1] <= 1.2
    sets = [frame for frame in wire if frame[2] == SERIAL_OUTPUT.code]
    assert sets == [SERIAL_OUTPUT.set(True).encode(), SERIAL_OUTPUT.set(False).encode()]
    assert not bench_of(port).module.is_streaming


def test_monitor_leaves_a_stream_that_was_on(
    port: str, hasty: None, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    url = f"{port}?stream_at_boot=yes&rate=100"
    assert program.main(["monitor", "--port", url, "--seconds", "0.8", "--json"]) == 0
    assert [frame for frame in wire if frame[2] == SERIAL_OUTPUT.code] == []
    assert bench_of(port).module.is_streaming
    assert 8 < len(Printed(capsys).out.splitlines()) < 160  # of 80 reports, each once; polled there are 8


def test_reading_sends_nothing_that_changes(port: str, wire: list[bytes], dps_s: Program) -> None:
    for command in ("read", "find"):
        dps_s([command, "--port", port, "--json"])
    assert {frame[2] for frame in wire} == {0x14, 0x15, 0x20, 0x21, 0x22, 0x23, *range(0x30, 0x35)}
    assert {frame[3] for frame in wire} == {0x01}


# `dps-s record`, and `dps-s decode` of what it wrote.


def record(port: str, path: Path, *more: str, seconds: str = "0.9") -> int:
    return program.main(["record", "--port", f"{port}?rate=100", "--seconds", seconds, str(path), *more])


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8-sig"))))


def test_csv_holds_the_stream_and_says_what_is_simulated(
    port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.csv"
    assert record(port, path) == 0
    found = rows(path)
    assert any(row["event"] == f"connected: {port}?rate=100 (simulated)" for row in found)
    assert sum(bool(row["tilt_deg"]) for row in found) > 20
    printed = Printed(capsys)
    assert printed.out == f"Saved to {path}. Rows: {len(found)}.\n"
    assert "Simulated" in printed.err
    (entry,) = RecordingLibrary().entries()
    assert entry.is_simulated
    assert not bench_of(port).module.is_streaming


@pytest.mark.parametrize("text", ["precious", "\n"])
def test_a_file_is_never_replaced_unasked(
    text: str, port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    assert record(port, path) == 2
    assert "--append" in Printed(capsys).err
    assert record(port, path, "--append") == 2
    assert "has other columns" in Printed(capsys).err
    assert path.read_text(encoding="utf-8") == text
    assert record(port, path, "--force") == 0
    assert rows(path)


def test_where_the_line_goes_dead_what_came_is_kept(
    port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, bench = tmp_path / "a.mcap", bench_of(port)
    with falls_after(bench, 20, bench.unplug):
        assert program.main(["record", "--port", port, str(path)]) == 3
    ways = [entry.way for entry in read_session(path)]
    assert ways.count(Way.OUT) >= 19 <= ways.count(Way.IN)
    assert "unplugged" in Printed(capsys).err


def test_where_the_file_cannot_be_written_the_recording_is_kept(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_args: object, **_values: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("app.recordings.recording.whole_file", full)
    assert record(port, tmp_path / "a.mcap") == 4
    (entry,) = RecordingLibrary().entries()
    assert f"kept as recording {entry.name}" in Printed(capsys).err
    assert entry.sample_count > 20


def test_where_nothing_can_be_recorded_it_ends_at_once(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It went on until Ctrl-C, and only then said that nothing had been recorded."""
    monkeypatch.setattr("app.recordings.recorder.RESERVE_BYTES", 2**70)
    with in_time(1.0):
        assert record(port, tmp_path / "a.csv", seconds="60") == 4
    assert "Not recording: the disk is full." in Printed(capsys).err
    assert not bench_of(port).module.is_streaming


def test_a_session_is_decoded_from_its_file(
    port: str, wire: list[bytes], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.mcap"
    assert record(port, path) == 0
    Printed(capsys)
    text = run_here(capsys, ["decode", str(path), "--json"]).out
    lines = [json.loads(line) for line in text.splitlines()]
    entries = read_session(path)
    for direction, way in (("host_to_module", ">"), ("module_to_host", "<")):
        raw = b"".join(bytes.fromhex(line["hex"]) for line in lines if line["direction"] == direction)
        assert raw == b"".join(entry.raw for entry in entries if entry.way.value == way)
    host = [line["hex"] for line in lines if line["direction"] == "host_to_module"]
    assert host == [frame.hex(" ").upper() for frame in wire[-len(host) :]]
    assert [line["t_s"] for line in lines] == sorted(line["t_s"] for line in lines)
    assert any(line["command"] == "cell_voltage" and "cell_voltage_v" in line for line in lines)
    (tmp_path / "b.mcap").write_bytes(b"\x89MCAP0\r\n")
    assert "not a recording by this program" in run_here(capsys, ["decode", str(tmp_path / "b.mcap")], 2).err


def test_a_dash_is_the_table_on_standard_output(port: str, dps_s: Program) -> None:
    printed = dps_s(["record", "--port", port, "--seconds", "1.3", "-"])
    table = list(csv.DictReader(io.StringIO(printed.out)))
    assert len([row for row in table if row["tilt_deg"]]) > 10
    assert {row["triggered"] for row in table} == {"", "false"}
    assert "Simulated module" in printed.err
    assert dps_s(["recordings", "export", "latest", "-"]).out == printed.out
