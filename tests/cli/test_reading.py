"""`dps-s monitor | record | decode | fired`: what is watched, recorded, explained and judged, and how it ends."""

import csv
import io
import json
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from app.port_urls.protocol_sim import Serial as SimulatedPort
from app.port_urls.protocol_sim import open_bench
from app.recordings.library import RecordingLibrary
from app.recordings.session_file import SessionFile, SessionWriter
from protocol.catalogue import SERIAL_OUTPUT
from protocol.messages import Direction
from tests.support.cli_line import Program
from tests.support.flights import log_bytes as made
from tests.support.line.frames import at_frame
from tests.support.patience import PATIENCE_S, in_time
from tests.support.processes import PROGRAM, running

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "hasty", "user_files")
STATUS = "41 75 32 07 0A 00 01 44"


@pytest.mark.parametrize("was_on", [False, True])
def test_monitor_switches_the_stream_on_and_off_unless_it_was_on(
    was_on: bool, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    module = open_bench(port)
    module.change(rate=200.0)
    if was_on:
        module.module.start_stream(module.clock())
    printed = dps_s(["monitor", "--port", port, "--seconds", "1.2", "--json"])
    lines = [json.loads(line) for line in printed.out.splitlines()]
    assert lines[0] == {"t_s": 0.0, "tilt_deg": 0, "acceleration_g": 1.0, "triggered": False, "active": False}
    assert 50 < len(lines) < 300  # polled there are 12
    times = [line["t_s"] for line in lines]
    assert times == sorted(times)
    assert 0.6 < times[-1] < 1.5
    sets = [frame for frame in wire if frame[2] == SERIAL_OUTPUT.code]
    assert sets == ([] if was_on else [SERIAL_OUTPUT.set(True).encode(), SERIAL_OUTPUT.set(False).encode()])
    assert open_bench(port).module.is_streaming is was_on


def test_monitor_switches_the_stream_off_also_where_that_is_lost_twice(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where it collides with the stream on a half-duplex line."""
    left = [SERIAL_OUTPUT.set(False).encode()] * 2
    send = SimulatedPort.write

    def write(line: SimulatedPort, data: bytes) -> int:
        if left and bytes(data) == left[0]:
            left.pop()
            return len(data)
        return send(line, data)

    monkeypatch.setattr(SimulatedPort, "write", write)
    dps_s(["monitor", "--port", port, "--seconds", "1.2", "--json"])
    assert not left
    assert not open_bench(port).module.is_streaming


# `dps-s record`, and `dps-s decode` of what it wrote.


def record(dps_s: Program, port: str, path: Path, *more: str, code: int = 0, seconds: str = "0.9") -> str:
    """What is said on standard error."""
    words = ["record", "--port", f"{port}?rate=100", "--seconds", seconds, str(path), *more]
    return dps_s(words, code).err


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8-sig"))))


def test_csv_holds_the_stream_and_says_what_is_simulated(port: str, tmp_path: Path, dps_s: Program) -> None:
    path = tmp_path / "a.csv"
    assert "Simulated" in record(dps_s, port, path)
    found = rows(path)
    assert any(row["event"] == f"connected: {port}?rate=100 (simulated)" for row in found)
    assert sum(bool(row["tilt_deg"]) for row in found) > 20
    assert {row["triggered"] for row in found} == {"", "false"}
    (entry,) = RecordingLibrary().entries()
    assert entry.is_simulated
    assert not open_bench(port).module.is_streaming
    assert len(list(csv.DictReader(io.StringIO(dps_s(["recordings", "export", "latest", "-"]).out)))) == len(found)


@pytest.mark.parametrize("text", ["precious", "\n"])
def test_a_file_is_never_replaced_unasked(text: str, port: str, tmp_path: Path, dps_s: Program) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    assert "exists: use --force." in record(dps_s, port, path, code=2)
    assert "has other columns" in record(dps_s, port, path, "--append", code=2)
    assert path.read_text(encoding="utf-8") == text
    record(dps_s, port, path, "--force")
    assert rows(path)


def test_where_the_line_goes_dead_what_came_is_kept(port: str, tmp_path: Path, dps_s: Program) -> None:
    path, bench = tmp_path / "a.mcap", open_bench(port)
    at_frame(bench, 20, bench.unplug, is_lost=True)
    assert "unplugged" in dps_s(["record", "--port", port, str(path)], 3).err
    ways = [entry.direction for entry in SessionFile(path).traffic()]
    assert ways.count(Direction.HOST_TO_MODULE) >= 19 <= ways.count(Direction.MODULE_TO_HOST)


def test_where_the_file_cannot_be_written_the_recording_is_kept(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    def full(*_args: object, **_values: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("app.recordings.recording.whole_file", full)
    said = record(dps_s, port, tmp_path / "a.mcap", code=4)
    (entry,) = RecordingLibrary().entries()
    assert f"kept as recording {entry.name}" in said
    assert entry.sample_count > 20


def test_where_nothing_can_be_recorded_it_ends_at_once(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    monkeypatch.setattr("app.recordings.recorder.RESERVE_BYTES", 2**70)
    with in_time(1.0):
        said = record(dps_s, port, tmp_path / "a.csv", code=4, seconds="60")
    assert "the disk is full." in said
    assert not open_bench(port).module.is_streaming


def test_a_recording_whose_end_is_not_on_the_disk_is_not_called_complete(
    port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    goes_on, close = threading.Event(), SessionWriter.close

    def hang(writer: SessionWriter) -> None:
        goes_on.wait(PATIENCE_S)
        close(writer)

    monkeypatch.setattr(SessionWriter, "close", hang)
    monkeypatch.setattr("app.cli.record.SETTLE_LIMIT_S", 0.1)
    said = record(dps_s, port, tmp_path / "a.csv", code=4)
    goes_on.set()
    assert "The disk is too slow: the end of the recording is not written yet." in said


def test_a_session_is_decoded_from_its_file(port: str, wire: list[bytes], tmp_path: Path, dps_s: Program) -> None:
    path = tmp_path / "a.mcap"
    record(dps_s, port, path)
    lines = [json.loads(line) for line in dps_s(["decode", str(path), "--json"]).out.splitlines()]
    entries = list(SessionFile(path).traffic())
    for direction in Direction:
        raw = b"".join(bytes.fromhex(line["hex"]) for line in lines if line["direction"] == direction.value)
        assert raw == b"".join(entry.raw for entry in entries if entry.direction is direction)
    host = [line["hex"] for line in lines if line["direction"] == "host_to_module"]
    assert host == [frame.hex(" ").upper() for frame in wire[-len(host) :]]
    assert [line["t_s"] for line in lines] == sorted(line["t_s"] for line in lines)
    assert any(line["command"] == "cell_voltage" and "cell_voltage_v" in line for line in lines)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("not-there.hex", None, "not-there.hex cannot be read: "),
        ("b.mcap", b"\x89MCAP0\r\n", "not a recording by this program"),
        ("check.pdf", b"%PDF\xff\xfe", "cannot be read: unknown kind of file"),
        ("-", b"Au\xff\xfe", "cannot be read: unknown kind of file"),
    ],
)
def test_what_is_no_capture_is_said(
    name: str, content: bytes | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path(name).write_bytes(content)
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content), encoding="utf-8"))
    assert said in dps_s(["decode", name], 2).err


def test_lines_come_while_the_input_goes_on_and_a_closed_output_is_no_error() -> None:
    with running(*PROGRAM, "decode", "--json", "-") as decode:
        decode.told.write(f"{STATUS}\n")
        decode.told.flush()
        assert json.loads(decode.out.readline())["hex"] == STATUS  # the input is still open
        decode.out.close()
        decode.told.write(f"{STATUS}\n")
        decode.told.close()
        assert decode.errors.read() == ""
        assert decode.process.wait(timeout=PATIENCE_S) == 4


# `dps-s fired`; docs/flight-logs.md has examples, which are executed.

TIMES = np.arange(500) / 50


@pytest.fixture
def calm(tmp_path: Path) -> Path:
    path = tmp_path / "calm.ulg"
    path.write_bytes(made.ulog_bytes(TIMES, 12.0, 1.0))
    return path


@pytest.fixture
def crash(tmp_path: Path) -> Path:
    """Tips over after 4 s to 61.4°, falls for 2 s after 6 s, and hits the ground from 20 m."""
    path = tmp_path / "crash.bin"
    falls = (TIMES >= 6) & (TIMES < 8)
    force = np.select([falls, (TIMES >= 8) & (TIMES < 8.1)], [0.3, 9.0], 1.0)
    rows = made.dataflash("BARO", TIMES, 20 - 5 * np.clip(TIMES - 6, 0, 2) ** 2)
    path.write_bytes(made.dataflash_bytes(TIMES, np.where(TIMES >= 4, 61.4, 5.0), force, *rows))
    return path


def test_other_thresholds_and_what_the_vendors_do(calm: Path, crash: Path, dps_s: Program) -> None:
    words = ("attitude_threshold_deg=62", "freefall_time_s=1.99")
    printed = dps_s(["fired", str(crash), str(calm), "--thresholds", *words])
    assert "0 of 2 fire." in printed.out
    assert "Vendor defaults, not of a module: freefall_acceleration_g, attitude_trigger" in printed.out
    dps_s(["fired", str(crash), "--thresholds", "attitude_trigger=false", "freefall_trigger=false"])
    dps_s(["fired", str(crash), "--thresholds", "attitude_trigger=false"], 4)
    assert "The vendor's defaults miss 0 of 1" in dps_s(["fired", str(crash), "--must"], 4).out


def test_what_cannot_be_read_is_said_and_the_others_are_judged(crash: Path, tmp_path: Path, dps_s: Program) -> None:
    bad = tmp_path / "bad.bin"
    bad.write_bytes(b"nothing")
    printed = dps_s(["fired", str(tmp_path), "--json"], 4)
    lines = [json.loads(line) for line in printed.out.splitlines()]
    assert [(line["log"], line["answer"]) for line in lines] == [(str(bad), "unreadable"), (str(crash), "fires")]
    assert (lines[0]["fires"], lines[0]["problems"]) == (None, ["no column names in the first line."])
    assert f"\n{bad}: no column names in the first line.\n" in printed.err
    assert "1 of 2 fire. 1 of 2 not judged." in dps_s(["fired", str(tmp_path)], 4).out
    crash.unlink()
    dps_s(["fired", str(tmp_path)], 2)
