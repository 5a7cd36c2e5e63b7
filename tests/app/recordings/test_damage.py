"""A session that is cut off, killed or altered is read as far as it is whole; what is missing is
shown.
"""

import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.records import Metadata
from mcap.writer import Writer

from app.captures.line import LinePart
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.markers import MarkerKind
from app.recordings.recording import RecordedTraffic, Recording
from app.recordings.session_format import END, FORMAT, LINE_ENCODING, RX, Opening, with_checksum
from app.text.user_error import UserError
from tests.support.processes import running
from tests.support.records.recordings_made import (
    HEADING,
    NOON,
    Whole,
    opened,
    received,
    recorder_in,
    report,
    stream,
    whole_of,
)

pytest_plugins = ["tests.support.cli_fixtures"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """Six seconds, with a chunk every half second, as in the field."""
    with recorder_in(tmp_path_factory.mktemp("whole")) as bench:
        bench.recorder.begin(*HEADING)
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
    known = dict(zip(whole.times, whole.tilts, strict=True))
    window = recording.tilt.window(0.0, 1e9)
    assert all(known[at] == tilt for at, tilt in zip(window.time_s.tolist(), window.value.tolist(), strict=True))
    sent = b"".join(entry.raw for entry in RecordedTraffic(recording.entry.path))
    assert len(sent) == 8 * len(window.time_s)
    return recording


def changed_but_read(whole: Whole, folder: Path, raw: bytes) -> Recording:
    recording = changed(whole, folder, raw)
    assert recording is not None
    return recording


Folders = settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def test_an_undamaged_session_is_whole(whole: Whole, tmp_path: Path) -> None:
    recording = changed_but_read(whole, tmp_path, whole.path.read_bytes())
    assert (recording.damage, recording.entry.was_cut_off) == (None, False)
    assert len(recording.tilt) == len(whole.times) == 600


@Folders
@given(share=st.floats(0, 1))
def test_cut_off_anywhere(whole: Whole, tmp_path: Path, share: float) -> None:
    raw = whole.path.read_bytes()
    end = int(share * (len(raw) - 1))
    recording = changed(whole, tmp_path, raw[:end])
    if recording is not None:
        count = len(recording.tilt)
        assert recording.tilt.window(0.0, 1e9).time_s.tolist() == whole.times[:count]
        name = raw.find(b"dps-s end") - 4
        assert recording.entry.was_cut_off == (end < name + int.from_bytes(raw[name - 8 : name], "little"))
        assert recording.entry.sample_count == count
        assert recording.damage is None
        assert count >= 600 * (end / len(raw)) - 120
    else:
        assert end < 1000


@Folders
@given(place=st.floats(0, 1), raw=st.binary(min_size=1, max_size=8))
@pytest.mark.promise("f")
def test_no_changed_byte_passes_unsaid(whole: Whole, tmp_path: Path, place: float, raw: bytes) -> None:
    data = bytearray(whole.path.read_bytes())
    start = int(place * (len(data) - len(raw)))
    data[start : start + len(raw)] = raw
    if data == whole.path.read_bytes():
        return
    recording = changed(whole, tmp_path, bytes(data))
    if recording is None:
        assert start < 1000, "only what is in the heading makes a session unreadable"
    elif len(recording.tilt) < len(whole.times):
        assert recording.damage is not None or recording.entry.was_cut_off
        assert len(recording.tilt) >= len(whole.times) - 150
        assert any(mark.kind is MarkerKind.DAMAGED for mark in recording.markers) or recording.entry.was_cut_off
    else:
        assert recording.tilt.window(0.0, 1e9).value.tolist() == whole.tilts


@pytest.mark.promise("f")
def test_what_is_missing_is_a_gap_and_what_follows_is_read(whole: Whole, tmp_path: Path) -> None:
    data = bytearray(whole.path.read_bytes())
    data[len(data) // 2] ^= 0x10
    recording = changed_but_read(whole, tmp_path, bytes(data))
    assert (len(recording.tilt), recording.entry.was_cut_off) == (550, False)
    ((first, last),) = recording.damaged
    assert 0.4 < last - first < 0.6
    times = recording.tilt.window(0.0, 1e9).time_s
    assert not len(times[(times > first + 0.01) & (times < last)])
    assert recording.damage is not None
    assert recording.damage.in_english().startswith("Damaged or altered")


def chunks_in(data: bytes | bytearray) -> list[tuple[int, int]]:
    """Where each begins and ends."""
    places, place = [], 8
    while data[place] != 0x0F:
        end = place + 9 + int.from_bytes(data[place + 1 : place + 9], "little")
        places += [(place, end)] if data[place] == 6 else []
        place = end
    return places


def test_a_chunk_that_was_cut_out_is_missed(whole: Whole, tmp_path: Path) -> None:
    data = whole.path.read_bytes()
    start, end = chunks_in(data)[5]
    recording = changed_but_read(whole, tmp_path, data[:start] + data[end:])
    assert len(recording.tilt) == 550
    assert recording.damage is not None


def test_a_chunk_whose_length_hides_the_last_ones_is_damaged(whole: Whole, tmp_path: Path) -> None:
    data = bytearray(whole.path.read_bytes())
    (start, _), *_, (_, end) = chunks_in(data)[-3:]
    data[start + 1 : start + 9] = (end - start - 9).to_bytes(8, "little")
    recording = changed_but_read(whole, tmp_path, bytes(data))
    assert len(recording.tilt) < 600
    assert recording.damage is not None


@pytest.mark.parametrize("tail", [b"\x00" * 5000, b"\xff" * 5000, bytes(range(256)) * 20])
def test_zeros_or_garbage_behind_the_last_chunk(whole: Whole, tmp_path: Path, tail: bytes) -> None:
    data = whole.path.read_bytes()
    recording = changed_but_read(whole, tmp_path, data[: len(data) * 2 // 3] + tail)
    assert recording.entry.was_cut_off
    assert len(recording.tilt) > 300


KILLED = """
import sys, time
from pathlib import Path
from tests.support.records.recordings_made import HEADING, WAIT_S, stream
from app.recordings.recorder import Recorder
from app.recordings.library import RecordingLibrary

recorder = Recorder(RecordingLibrary(Path(sys.argv[1])))
recorder.begin(*HEADING)
for one in stream(time.monotonic(), 2.0, rate_hz=100):
    recorder.on_batch(one)
assert recorder.settle(WAIT_S)
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


@pytest.mark.parametrize("end_ns", [-1, 1 << 63, 10**400], ids=["early", "late", "endless"])
def test_an_end_that_no_clock_shows_is_none(whole: Whole, tmp_path: Path, end_ns: int) -> None:
    """Its checksum is right: whoever wrote it was no program of ours. The list shows the other recordings."""
    raw = whole.path.read_bytes()
    end = Metadata(END, with_checksum({"progress": "{}", "end_ns": str(end_ns)}))
    builder = RecordBuilder()
    end.write(builder)
    path = tmp_path / "changed.mcap"
    path.write_bytes(raw[: raw.index(b"dps-s end") - 13] + builder.end())
    (entry,) = RecordingLibrary(tmp_path).entries()
    assert (entry.was_cut_off, entry.sample_count, len(opened(path).tilt)) == (True, 600, 600)


def test_what_came_at_a_time_that_no_clock_shows_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "late.mcap"
    writer = Writer(str(path))
    writer.start()
    writer.add_metadata(FORMAT, Opening(started_at=NOON, start_s=0.0, port="", baud_rate=0).fields())
    writer.register_channel(RX, LINE_ENCODING, 0)
    (line,) = LinePart.of([(0, received(report(0.0)).frame.raw)]).messages()
    for at_ns in (1 << 62, 1 << 63):
        writer.add_message(1, at_ns, line[1], at_ns)
    writer.finish()
    recording = opened(path)
    assert (len(recording.tilt), recording.damage is None) == (1, False)
