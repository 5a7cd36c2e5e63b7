"""A recording that is cut off, killed or altered is read as far as it is whole; what is missing is shown."""

import sys
import tracemalloc
from pathlib import Path

import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk

from app.recordings.library import entry_of, recordings_folder
from app.recordings.markers import MarkerKind
from app.recordings.recording import Recording
from app.recordings.session_file import HEAD_BYTES
from app.text.messages import UserError
from tests.support.cli_line import run_here
from tests.support.processes import running
from tests.support.records.recordings_made import Whole, opened, recorder_in, stream, whole_of


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """Six seconds, with a chunk every half second, as in the field."""
    with recorder_in(tmp_path_factory.mktemp("whole")) as bench:
        bench.begin()
        for number in range(12):
            bench.feed(*stream(1000.0 + number / 2, 0.5, rate_hz=100))
        bench.finish()
        return whole_of(bench.path)


def changed(whole: Whole, folder: Path, raw: bytes) -> Recording | None:
    """The recording with other bytes; None if it is refused."""
    path = folder / "changed.mcap"
    path.write_bytes(raw)
    try:
        recording = opened(path)
    except UserError:
        return None
    found = whole_of(path)
    known = dict(zip(whole.times, whole.tilts, strict=True))
    assert all(known[at] == tilt for at, tilt in zip(found.times, found.tilts, strict=True))
    assert len(found.raw) == 8 * len(found.times)
    return recording


def changed_but_read(whole: Whole, folder: Path, raw: bytes) -> Recording:
    recording = changed(whole, folder, raw)
    assert recording is not None
    return recording


@settings(max_examples=150)
@given(share=st.floats(0, 1))
def test_cut_off_anywhere(whole: Whole, tmp_path: Path, share: float) -> None:
    """As many bytes of the file of a running recording as there were at some moment."""
    raw = whole.path.read_bytes()
    recording = changed(whole, tmp_path, raw[: int(share * (len(raw) - 1))])
    if recording is not None:
        count = len(recording.tilt)
        assert recording.tilt.window(0.0, 1e9).time_s.tolist() == whole.times[:count]
        assert count >= 600 * share - 170
        assert count == 600 or recording.damage is not None or recording.entry.was_cut_off
    else:
        assert share * len(raw) < HEAD_BYTES


@settings(max_examples=150)
@given(place=st.floats(0, 1), raw=st.binary(min_size=1, max_size=8))
@pytest.mark.promise("f")
def test_no_changed_byte_passes_unsaid(whole: Whole, tmp_path: Path, place: float, raw: bytes) -> None:
    data = bytearray(whole.path.read_bytes())
    start = int(place * (len(data) - len(raw)))
    data[start : start + len(raw)] = raw
    recording = changed(whole, tmp_path, bytes(data))
    if recording is None:
        assert start < HEAD_BYTES, "only what is in the head makes a recording unreadable"
    elif len(recording.tilt) < len(whole.times):
        assert recording.damage is not None
        assert recording.markers[-1].kind is MarkerKind.DAMAGED
    else:
        assert recording.tilt.window(0.0, 1e9).value.tolist() == whole.tilts


@pytest.mark.promise("f")
def test_it_is_read_up_to_the_first_damage(whole: Whole, tmp_path: Path) -> None:
    data = bytearray(whole.path.read_bytes())
    start, end = chunks_in(data)[7]
    data[(start + end) // 2] ^= 0x10
    recording = changed_but_read(whole, tmp_path, bytes(data))
    assert recording.tilt.window(0.0, 1e9).time_s.tolist() == whole.times[:350]
    assert recording.end_s == pytest.approx(1006.0, abs=0.1)
    assert recording.markers[-1].time_s == pytest.approx(whole.times[349])
    assert recording.damage is not None
    assert recording.damage.in_english().startswith("Damaged or altered; left out from ")
    assert not recording.entry.was_cut_off


def chunks_in(data: bytes | bytearray) -> list[tuple[int, int]]:
    """Where each begins and ends."""
    places, place = [], 8
    while data[place] != 0x0F:
        end = place + 9 + int.from_bytes(data[place + 1 : place + 9], "little")
        places += [(place, end)] if data[place] == 6 else []
        place = end
    return places


def test_the_command_line_reports_it(whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is whole is written all the same."""
    data = bytearray(whole.path.read_bytes())
    data[chunks_in(data)[7][0] + 99] ^= 0x10
    path, table = recordings_folder() / "damaged.mcap", tmp_path / "x.csv"
    path.parent.mkdir(parents=True)
    path.write_bytes(data)
    assert "Damaged or altered" in run_here(capsys, ["decode", str(path)], 4).err
    assert "Damaged or altered" in run_here(capsys, ["recordings", "export", "latest", str(table)], 4).err
    assert "damaged data left out" in table.read_text("utf-8-sig")


def test_what_was_cut_out_is_missed(whole: Whole, tmp_path: Path) -> None:
    """A chunk, or the end of a file that was closed properly: there may have been bytes without a report."""
    data = whole.path.read_bytes()
    start, end = chunks_in(data)[5]
    for changed in (data[:-20], data[:start] + data[end:]):
        assert changed_but_read(whole, tmp_path, changed).damage is not None


def test_a_state_that_is_damaged_costs_no_report(whole: Whole, tmp_path: Path) -> None:
    """The power failed while it was written."""
    data = bytearray(whole.path.read_bytes())
    data[data.index(b"reports")] ^= 0x01
    recording = changed_but_read(whole, tmp_path, bytes(data))
    assert (len(recording.tilt), recording.damage) == (600, None)
    assert (recording.entry.was_cut_off, recording.entry.sample_count) == (True, 0)


def test_a_few_bytes_that_are_packed_gigabytes_are_not_unpacked(whole: Whole, tmp_path: Path) -> None:
    packed = zstandard.compress(bytes(1 << 27))
    for size in (1 << 27, 1000):
        builder = RecordBuilder()
        Chunk("zstd", packed, 0, 0, 0, size).write(builder)
        data = whole.path.read_bytes()
        tracemalloc.start()
        recording = changed_but_read(whole, tmp_path, data[: chunks_in(data)[2][0]] + builder.end())
        assert tracemalloc.get_traced_memory()[1] < 1 << 26
        tracemalloc.stop()
        assert len(recording.tilt) == 100
        assert recording.damage is not None


KILLED = """
import sys, time
from pathlib import Path
from tests.support.records.recordings_made import settle, stream
from app.recordings.recorder import Recorder
from app.recordings.library import RecordingLibrary

recorder = Recorder(RecordingLibrary(Path(sys.argv[1])), "/dev/ttyUSB0", 115200)
for one in stream(time.monotonic(), 2.0, rate_hz=100):
    recorder.on_batch(one)
settle(recorder)
print("there", flush=True)
sys.stdin.readline()
"""


def test_killed_while_it_records(tmp_path: Path) -> None:
    with running(sys.executable, "-c", KILLED, tmp_path) as program:
        assert program.out.readline() == "there\n"
        (path,) = tmp_path.glob("*.mcap")
        begun = entry_of(path)
        assert (begun.is_running, begun.was_cut_off, begun.sample_count) == (True, False, 200)
    entry = entry_of(path)
    assert (entry.is_running, entry.was_cut_off, entry.sample_count) == (False, True, 200)
    assert len(whole_of(path).times) == 200
    assert opened(path).damage is None, "it is whole up to there"
