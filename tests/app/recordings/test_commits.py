"""A recording cut off at any byte is valid up to its last commit."""

import os
import shutil
import struct
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.recordings.commits import COMMIT
from app.recordings.file_layout import COMMITS, DATA_FILES
from app.recordings.recording import open_recording
from tests.support.records.recordings_made import HEADING, NOON, Whole, recorder_in, stream, whole_of

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """A recording of twenty commits that was not closed."""
    library = tmp_path_factory.mktemp("shelf")
    with recorder_in(library) as bench:
        bench.recorder.begin(HEADING)
        for one in stream(1000.0, 4.0, rate_hz=50):
            bench.feed(replace(one, connection=replace(one.connection, baud_rate=9600)))
        copy = library / "copy"
        shutil.copytree(bench.folder, copy)
    return whole_of(copy)


def assert_begins(found: Whole, whole: Whole) -> None:
    """Checks that all files contain the same beginning."""
    assert found.times == whole.times[: len(found.times)]
    assert found.tilts == whole.tilts[: len(found.tilts)]
    assert whole.raw.startswith(found.raw)
    assert len(found.raw) == 8 * len(found.times), "samples and bytes are of the same moment"


def copied(whole: Whole, folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(whole.folder, folder)
    return folder


@given(data=st.data())
def test_cut_off_anywhere(whole: Whole, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = copied(whole, tmp_path_factory.getbasetemp() / "cut")
    name = data.draw(st.sampled_from((*DATA_FILES, COMMITS)))
    size = (folder / name).stat().st_size
    os.truncate(folder / name, data.draw(st.integers(0, size)))
    assert_begins(whole_of(folder), whole)


@given(data=st.data())
def test_ending_in_zeros_or_garbage(
    whole: Whole, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """As after a power failure with blocks that were never written."""
    folder = copied(whole, tmp_path_factory.getbasetemp() / "garbage")
    name = data.draw(st.sampled_from((*DATA_FILES, COMMITS)))
    raw = bytearray((folder / name).read_bytes())
    first = data.draw(st.integers(0, len(raw)))
    raw[first:] = bytes(len(raw) - first) if data.draw(st.booleans()) else os.urandom(len(raw) - first)
    (folder / name).write_bytes(raw)
    assert_begins(whole_of(folder), whole)


@given(data=st.data())
def test_a_torn_piece_behind_the_last_commit_does_not_count(
    whole: Whole, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = copied(whole, tmp_path_factory.getbasetemp() / "torn")
    for name in data.draw(st.sets(st.sampled_from(DATA_FILES), min_size=1)):
        with (folder / name).open("ab") as file:
            file.write(data.draw(st.binary(min_size=1, max_size=40)))
    with (folder / COMMITS).open("ab") as file:
        file.write(data.draw(st.binary(max_size=COMMIT.size)))
    assert whole_of(folder)[1:] == whole[1:]


def test_every_length_of_the_commits(whole: Whole, tmp_path: Path) -> None:
    """More commits never show less."""
    folder = copied(whole, tmp_path / "commits")
    raw = (folder / COMMITS).read_bytes()
    counts = []
    for length in (*range(0, len(raw), 104), len(raw)):
        (folder / COMMITS).write_bytes(raw[:length])
        found = whole_of(folder)
        assert_begins(found, whole)
        counts.append(len(found.times))
    assert counts == sorted(counts)
    assert (counts[0], counts[-1]) == (0, len(whole.times))


def test_a_missing_file_is_said(whole: Whole, tmp_path: Path) -> None:
    folder = copied(whole, tmp_path / "x")
    (folder / DATA_FILES[1]).unlink()
    with recorder_in(tmp_path) as bench:
        (entry,) = bench.library.entries()
        with pytest.raises(FileNotFoundError) as missing:
            (folder / DATA_FILES[1]).stat()
        assert entry.trouble is not None
        assert entry.trouble.in_english() == f"{entry.folder.name} cannot be read: {missing.value.strerror}."


def test_opening_verifies_each_byte_once(whole: Whole, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = copied(whole, tmp_path / "once")
    verified_bytes = 0

    def counted(data: bytes, start: int = 0) -> int:
        nonlocal verified_bytes
        verified_bytes += len(data)
        return zlib.crc32(data, start)

    monkeypatch.setattr("app.recordings.commits.zlib", Mock(crc32=counted))
    assert whole_of(folder)[1:] == whole[1:]
    assert verified_bytes < 1.1 * sum((folder / name).stat().st_size for name in (*DATA_FILES, COMMITS))


def test_a_cut_off_recording_ends_before_damage_that_was_not_synced(whole: Whole, tmp_path: Path) -> None:
    folder = copied(whole, tmp_path / "damaged")
    path = folder / "status.tilt_deg.f4"
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 0x10
    path.write_bytes(raw)
    with open_recording(folder) as recording:
        assert (recording.damaged, recording.entry.was_cut_off) == ((), True)
        assert 0.4 < len(recording.tilt) / len(whole.times) <= 0.5
    commits = bytearray((folder / COMMITS).read_bytes())
    commits[-COMMIT.size :] = later(bytes(commits[-COMMIT.size :]), 121.0)
    (folder / COMMITS).write_bytes(commits)
    with open_recording(folder) as recording:
        assert (len(recording.damaged), recording.entry.was_cut_off) == (1, True)
        assert recording.tilt.window(0.0, 1e9).time_s[-1] == whole.times[-1]


def later(commit: bytes, seconds: float) -> bytes:
    (at_s,) = struct.unpack("<d", commit[:8])
    head = struct.pack("<d", at_s + seconds) + commit[8:-4]
    return head + zlib.crc32(head).to_bytes(4, "little")


KILLED = """
import os, sys, time
from pathlib import Path
sys.path.insert(0, {root!r})
from app.recordings.recording import open_recording
from tests.support.records.recordings_made import HEADING, WAIT_S, stream
from app.recordings.recorder import Recorder
from app.recordings.library import RecordingLibrary

recorder = Recorder(RecordingLibrary(Path({folder!r})))
recorder.begin(HEADING)
for one in stream(time.monotonic(), 2.0, rate_hz=100):
    recorder.on_batch(one)
assert recorder.settle(WAIT_S)
print("there", flush=True)
sys.stdin.readline()
"""


def test_killed_while_it_records(tmp_path: Path) -> None:
    code = KILLED.format(root=str(ROOT), folder=str(tmp_path))
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "there\n"
        with recorder_in(tmp_path) as bench:
            (running,) = bench.library.entries()
            assert (running.is_running, running.was_cut_off, running.sample_count) == (True, False, 200)
            assert bench.library.prune(NOON.replace(year=2036)) == ()
            process.kill()
            process.wait()
            (entry,) = bench.library.entries()
            assert (entry.is_running, entry.was_cut_off, entry.sample_count) == (False, True, 200)
    assert len(whole_of(entry.folder).times) == 200
