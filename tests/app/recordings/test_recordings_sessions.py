"""Beginning and end of a recording."""

import errno
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from app.engine.device import Sleep
from app.recordings import library as library_module
from app.recordings import writer as writer_module
from app.recordings.library import RecordingLibrary
from app.recordings.markers import MarkerKind
from app.recordings.recorder import CLOCK_JUMP_S, DISK_CHECK_EVERY_S, MAX_SESSION_S, SYNC_EVERY_S, Recorder
from app.recordings.recording import RecordedTraffic
from app.recordings.writer import SessionWriter
from protocol.events import Rejected
from protocol.frame import Fault, Noise, Reason
from tests.support.records.recordings_made import (
    HEADING,
    NOON,
    WAIT_S,
    batch,
    opened,
    received,
    recorder_in,
    report,
    stream,
)


def test_a_session_that_is_too_large_goes_on_in_the_next_recording(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.library.max_bytes = 130_000
        bench.recorder.begin(*HEADING)
        batches = list(stream(1000.0, 60.0, rate_hz=100))
        for first in range(0, len(batches), 60):
            bench.feed(*batches[first : first + 60])
        bench.finish()
        entries = bench.library.entries()[::-1]
        assert [entry.sequence for entry in entries] == list(range(1, len(entries) + 1))
        assert len(entries) > 2
        assert not any(entry.was_cut_off for entry in entries)
        times, polled, sent = list[float](), list[float](), 0
        for entry in entries:
            recording = opened(entry.path)
            times += recording.tilt.window(0, 1e9).time_s.tolist()
            polled += recording.cell.window(0, 1e9).time_s.tolist()
            sent += sum(len(piece.raw) for piece in RecordedTraffic(entry.path))
            assert recording.fires.between(0, 1e9)[0].value == 60.0, "each says what is in force"
        assert times == [sample.at for one in batches for sample in one.samples]
        assert sent == 8 * len(times)
        assert polled == np.arange(1000.0, 1060.0).tolist()


def test_after_a_day_the_next_recording_begins(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.recorder.name_module("Bench 9")
        bench.feed(batch(1001.0 + MAX_SESSION_S, report(1001.0 + MAX_SESSION_S)))
        bench.feed(batch(1002.0 + MAX_SESSION_S, report(1002.0 + MAX_SESSION_S)))
        found = [(entry.is_running, entry.sample_count, entry.module) for entry in bench.library.entries()]
        assert found == [(True, 1, "Bench 9"), (False, 2, "Bench 9")]


def test_a_clock_that_is_set_begins_a_recording_with_the_right_time(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.clock.wall_offset_s += 3600.0
        bench.feed(batch(1000.0 + DISK_CHECK_EVERY_S, report(1000.0 + DISK_CHECK_EVERY_S)))
        bench.feed(batch(1020.0, report(1020.0)))
        newest, oldest = bench.library.entries()
        assert (newest.sequence, oldest.sequence, oldest.started_at) == (2, 1, NOON)
        assert (newest.started_at - NOON).total_seconds() == 3600.0 + DISK_CHECK_EVERY_S


@pytest.mark.skipif(sys.platform == "win32", reason="a file that is open cannot be deleted there")
def test_after_its_file_was_deleted_the_next_recording_begins(tmp_path: Path) -> None:
    """A file manager, or a program that tidies up: the window says that it records."""
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.path.unlink()
        bench.feed(batch(1001.0, report(1001.0)))
        bench.feed(batch(1002.0, report(1002.0)), batch(1003.0, report(1003.0)))
        (entry,) = bench.library.entries()
        assert opened(entry.path).tilt.window(1002.0, 1003.0).time_s.tolist() == [1002.0, 1003.0]


def test_the_next_module_is_not_compared_with_the_one_before(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.record(batch(1001.0, report(1001.0, triggered=True, active=True)))
        bench.finish()
        assert [marker.kind for marker in opened(bench.library.entries()[0].path).markers] == [MarkerKind.CONNECTED]


def test_a_slow_disk_is_no_jump_of_the_clock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with recorder_in(tmp_path) as bench:
        flush = SessionWriter.flush

        def flush_slowly(writer: SessionWriter, now_s: float, *, is_last: bool = False) -> None:
            flush(writer, now_s, is_last=is_last)
            bench.clock.now_s += CLOCK_JUMP_S + 1.0

        monkeypatch.setattr(SessionWriter, "flush", flush_slowly)
        bench.record(batch(1000.0, report(1000.0)))
        bench.feed(batch(1010.0, report(1010.0)))
        bench.finish()
        (entry,) = bench.library.entries()
        assert entry.sample_count == 2


def test_a_sleep_begins_a_new_recording(tmp_path: Path) -> None:
    night_s = 8 * 3600.0
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)), batch(1000.01, report(1000.01)))
        bench.clock.wall_offset_s += night_s  # the monotonic clock stood still
        for at in (1000.03, 1000.05, 1000.07):
            woken = batch(at, report(at))
            bench.feed(woken._replace(device=woken.device._replace(last_sleep=Sleep(1000.02, night_s))))
        newest, oldest = bench.library.entries()
        assert (oldest.sample_count, oldest.started_at) == (2, NOON)
        assert newest.sample_count == 3
        assert (newest.started_at - NOON).total_seconds() == pytest.approx(night_s + 0.02)


def test_data_is_synced_regularly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[float] = []
    with recorder_in(tmp_path) as bench:
        monkeypatch.setattr(SessionWriter, "sync", lambda _self: synced.append(bench.clock.now_s))
        bench.record(batch(1000.0, report(1000.0)))
        bench.feed(batch(1001.0, report(1001.0)))
        assert synced == []
        bench.feed(batch(1000.0 + SYNC_EVERY_S, report(1000.0 + SYNC_EVERY_S)))
        assert synced == [1000.0 + SYNC_EVERY_S]


def test_an_empty_recording_is_not_begun(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.clock.wall_offset_s += 3600.0
        bench.feed(batch(1001.0))
        bench.finish()
        assert [entry.was_cut_off for entry in bench.library.entries()] == [False]


def test_a_file_system_without_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(library_module, "lock", refuse)
    monkeypatch.setattr(writer_module, "lock", refuse)
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.finish()
        (entry,) = bench.library.entries()
        assert not entry.is_running
        bench.library.delete(entry)
        assert bench.library.entries() == ()


# Beginning and ending


def test_without_a_session_nothing_is_recorded(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.feed(batch(1000.0, report(1000.0)))
        bench.recorder.begin(*HEADING)
        assert bench.recorder.is_recording
        bench.feed(batch(1001.0))
        assert bench.recorder.path is None, "nothing went over the line yet"
        bench.recorder.end()
        bench.feed(batch(1002.0, report(1002.0)))
        bench.finish()
        assert bench.library.entries() == ()
        assert bench.recorder.stop(WAIT_S)
        bench.recorder.begin(*HEADING)
        assert not bench.recorder.is_recording
        assert bench.recorder.stop(WAIT_S)


def test_a_recorder_that_never_began_has_no_thread(tmp_path: Path) -> None:
    before = threading.active_count()
    recorder = Recorder(RecordingLibrary(tmp_path))
    assert recorder.settle(0.0)
    assert recorder.stop(0.0)
    assert threading.active_count() == before


def test_bytes_of_equal_times_stay_in_order(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.recorder.begin(*HEADING)
        samples = [report(1000.0 + n // 7 / 100, n) for n in range(100)]
        garbage = Rejected(Noise(b"\0\1", Fault(Reason.NO_HEADER, ""), 0), 1000.0)
        bench.feed(batch(1000.0, events=(garbage,)), *(batch(sample.at, sample) for sample in samples))
        bench.finish()
        recording = opened(bench.path)
        traffic = list(RecordedTraffic(recording.entry.path))
        frames = (received(sample).frame.raw for sample in samples)
        assert b"".join(one.raw for one in traffic) == b"".join((garbage.noise.raw, *frames))
        assert len({one.at_s for one in traffic}) == 15
