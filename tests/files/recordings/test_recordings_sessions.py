"""Beginning and end of a recording."""

from pathlib import Path

import numpy as np
import pytest

from app.recordings import session_file
from app.recordings.recorder import MAX_SESSION_S
from app.recordings.recording import RecordedTraffic
from tests.support.records.recordings_made import (
    HEADING,
    LINE_HZ,
    WAIT_S,
    batch,
    opened,
    recorder_in,
    report,
    stream,
    talk,
)


def test_a_session_that_is_too_large_goes_on_in_the_next_recording(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.library.max_bytes = 300_000
        bench.recorder.begin(*HEADING)
        batches = list(stream(1000.0, 60.0, rate_hz=100))
        for first in range(0, len(batches), 60):
            bench.feed(*batches[first : first + 60])
        bench.finish()
        entries = bench.library.entries()[::-1]
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


@pytest.mark.promise("f")
def test_no_recording_is_longer_than_what_is_read_of_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At full line rate that is eight hours, long before the file is as large as the library allows."""
    monkeypatch.setattr(session_file, "MAX_UNPACKED_BYTES", 1_000_000)
    with recorder_in(tmp_path) as bench:
        bench.recorder.begin(*HEADING)
        for second in range(20):
            bench.feed(*stream(1000.0 + second, 1.0))
        bench.finish()
        recordings = [opened(entry.path) for entry in bench.library.entries()]
    assert sum(len(recording.tilt) for recording in recordings) == 20 * LINE_HZ
    assert [recording.damage for recording in recordings] == [None] * len(recordings)


def test_after_a_day_the_next_recording_begins(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.name("Bench 9")
        bench.feed(batch(1001.0 + MAX_SESSION_S, report(1001.0 + MAX_SESSION_S)))
        bench.feed(batch(1002.0 + MAX_SESSION_S, report(1002.0 + MAX_SESSION_S)))
        found = [(entry.is_running, entry.sample_count, entry.module) for entry in bench.library.entries()]
        assert found == [(True, 1, "Bench 9"), (False, 2, "Bench 9")]


def test_a_name_does_not_go_on_with_another_conversation_in_the_next_recording(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.name("Bench 9")
        bench.feed(batch(1001.0 + MAX_SESSION_S, report(1001.0 + MAX_SESSION_S)))
        later_s = 1002.0 + MAX_SESSION_S
        bench.feed(batch(later_s, report(later_s), view=talk(later_s, number=2)))
        assert [entry.module for entry in bench.library.entries()] == ["", "Bench 9"]


def test_what_is_dropped_again_is_counted_once(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        for number in (1, 2):
            bench.recorder._max_waiting = 0
            bench.feed(batch(1000.0 + number, report(1000.0 + number)))
            bench.recorder._max_waiting = 100
            bench.feed(batch(1000.5 + number, report(1000.5 + number)))
        bench.finish()
        assert opened(bench.path).missing_count == bench.recorder.dropped == 4


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
