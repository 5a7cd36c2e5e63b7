"""A full, forbidden or hanging disk ends the recording with a message, and nothing else."""

import errno
import io
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from app.recordings import writer
from app.recordings.markers import MarkerKind
from app.recordings.writer import SessionWriter
from tests.support.records.recordings_made import (
    HEADING,
    PORT,
    WAIT_S,
    Bench,
    batch,
    device,
    opened,
    received,
    recorder_in,
    report,
    stream,
    whole_of,
)

if TYPE_CHECKING:
    from typing_extensions import Buffer


class SmallDisk(io.BytesIO):
    """Takes so many bytes of a file, then fails."""

    def __init__(self, path: Path, count: int, error: OSError) -> None:
        super().__init__()
        self.file, self.room, self.error = path.open("wb", buffering=0), count, error

    def write(self, raw: "Buffer", /) -> int:
        data = bytes(raw)
        self.file.write(data[: self.room])
        if len(data) > self.room:
            self.room = 0
            raise self.error
        self.room -= len(data)
        return len(data)

    def fileno(self) -> int:
        return self.file.fileno()

    def tell(self) -> int:
        return self.file.tell()

    def close(self) -> None:
        self.file.close()


def failing_after(monkeypatch: pytest.MonkeyPatch, count: int, error: OSError) -> None:
    """The disk fails after this many bytes of a session."""
    monkeypatch.setattr(writer, "open", lambda path, *_, **__: SmallDisk(path, count, error), raising=False)


@pytest.mark.parametrize("count", [*range(0, 2500, 211), 4000])
def test_a_disk_that_is_full_at_any_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    batches = list(stream(1000.0, 2.0, rate_hz=50))
    with recorder_in(tmp_path) as bench:
        failing_after(monkeypatch, count, OSError(errno.ENOSPC, "No space left on device"))
        bench.recorder.begin(*HEADING)
        for one in batches:
            bench.feed(one)
        assert not bench.recorder.is_recording
        assert bench.recorder.path is None
        assert bench.recorder.trouble is not None
        assert bench.recorder.trouble.text.startswith("Not recording: the disk is full.")
        (entry,) = bench.library.entries()
        assert entry.trouble is not None or (entry.was_cut_off, entry.is_running) == (True, False)
        if entry.trouble is None:
            found = whole_of(entry.path)
            assert found.times == [sample.at for one in batches for sample in one.samples][: len(found.times)]
            assert count < 2000 or found.times
        monkeypatch.undo()
        bench.record(batch(1010.0, report(1010.0)))
        assert bench.recorder.trouble is None
        assert bench.library.entries()[0].sample_count == 1


def test_the_last_disk_space_is_left_free(tmp_path: Path) -> None:
    with recorder_in(tmp_path, free_bytes=1 << 20) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        assert bench.recorder.trouble is not None
        assert bench.library.entries() == ()


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with recorder_in(tmp_path / "file" / "shelf") as bench:
        bench.record(batch(1000.0, report(1000.0)))
        assert bench.recorder.trouble is not None
        assert str(bench.library.folder) in bench.recorder.trouble.in_english()
        assert not bench.recorder.is_recording


def test_an_unexpected_error_ends_the_recording_but_not_the_thread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorder_in(tmp_path) as bench:
        monkeypatch.setattr(SessionWriter, "put", lambda *_: 1 / 0)
        bench.record(batch(1000.0, report(1000.0)))
        assert bench.recorder.trouble is not None
        monkeypatch.undo()
        bench.record(batch(1001.0, report(1001.0)))
        assert bench.recorder.path is not None


def test_a_failure_of_the_previous_session_does_not_end_this_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        sync = SessionWriter.sync
        failures = [OSError(errno.EIO, "Input/output error")]

        def fail_once(self: SessionWriter) -> None:
            if failures:
                raise failures.pop()
            sync(self)

        monkeypatch.setattr(SessionWriter, "sync", fail_once)
        bench.recorder.begin(PORT, 115200, "Bench 8")
        bench.feed(batch(1001.0, report(1001.0)))
        assert (failures, bench.recorder.trouble) == ([], None)
        assert bench.library.entries()[0].module == "Bench 8"


class Jam:
    """The disk hangs in a flush until it is released."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.hangs, self.goes_on = threading.Event(), threading.Event()
        flush = SessionWriter.flush

        def jammed(writer: SessionWriter, now_s: float, *, is_last: bool = False) -> None:
            self.hangs.set()
            assert self.goes_on.wait(WAIT_S)
            flush(writer, now_s, is_last=is_last)

        monkeypatch.setattr(SessionWriter, "flush", jammed)


def fill(bench: Bench, count: int, *, first_s: float) -> None:
    for number in range(count):
        at = first_s + number / 100
        sample = report(at, number, active=number >= count - 1)
        bench.recorder.on_batch(batch(at, sample, events=(received(sample),), view=device(at)))


def test_a_hanging_disk_delays_nothing_and_lost_data_is_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorder_in(tmp_path, max_waiting=300) as bench:
        jam = Jam(monkeypatch)
        bench.recorder.begin(*HEADING)
        bench.recorder.on_batch(batch(1000.0, report(1000.0)))
        assert jam.hangs.wait(WAIT_S)
        fill(bench, 1000, first_s=1001.0)
        # Three items a batch: a report, an event and itself.
        assert bench.recorder.dropped == 1800
        assert not bench.recorder.settle(0.0)
        assert not bench.recorder.stop(0.0), "closing the window does not wait for it"
        jam.goes_on.set()
        assert bench.recorder.stop(WAIT_S)
        with opened(bench.path) as recording:
            assert len(recording.tilt) == 101
            assert recording.missing_count == 1800
            assert [marker.kind for marker in recording.markers].count(MarkerKind.MISSING) == 1
            assert recording.damage is not None
            assert recording.damage.in_english().endswith("the disk was too slow; reports and frames: 1,800.")
            assert not recording.entry.was_cut_off


def test_after_lost_batches_the_last_state_is_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with recorder_in(tmp_path, max_waiting=30) as bench:
        jam = Jam(monkeypatch)
        bench.recorder.begin(*HEADING)
        bench.recorder.on_batch(batch(1000.0, report(1000.0)))
        assert jam.hangs.wait(WAIT_S)
        fill(bench, 50, first_s=1001.0)
        bench.recorder.on_batch(batch(1002.0, view=device(1002.0, cell_voltage_v=3.7)))
        jam.goes_on.set()
        bench.settle()
        bench.feed(batch(1003.0, report(1003.0)))
        with opened(bench.path) as recording:
            assert recording.cell.window(0, 2000).time_s.tolist() == [1002.0]
            assert recording.tilt.last is not None
            assert recording.tilt.last.time_s == 1003.0
            assert recording.missing_count == 80
