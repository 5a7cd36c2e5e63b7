"""Exports are whole and written atomically; a full, forbidden or hanging disk ends the recording with a message
only.
"""

import csv
import errno
import io
import threading
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from app.engine.transport import PortError, PortErrorKind
from app.recordings import recorder, session_file
from app.recordings.excerpt import HEAD
from app.recordings.library import RecordingLibrary
from app.recordings.recording import export
from app.recordings.session_file import SessionWriter
from tests.support.patience import PATIENCE_S
from tests.support.records.recordings_made import (
    CLOSED,
    NOON,
    PORT,
    Bench,
    asked,
    batch,
    opened,
    received,
    recorder_in,
    report,
    stream,
    talk,
    whole_of,
)

if TYPE_CHECKING:
    from typing_extensions import Buffer


class SmallDisk(io.FileIO):
    """A file that cannot become longer than this."""

    def __init__(self, path: Path, longest: int, error: OSError) -> None:
        super().__init__(path, "wb")
        self.longest, self.error = longest, error

    def write(self, raw: "Buffer", /) -> int:
        data = bytes(raw)
        room = max(0, self.longest - self.tell())
        super().write(data[:room])
        if len(data) > room:
            raise self.error
        return len(data)


def failing_after(monkeypatch: pytest.MonkeyPatch, count: int, error: OSError) -> None:
    """The disk fails after this many bytes of a session."""
    monkeypatch.setattr(session_file, "open", lambda path, *_, **__: SmallDisk(path, count, error), raising=False)


@pytest.mark.parametrize("count", [*range(0, 5000, 802), 6000])
def test_a_disk_that_is_full_at_any_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    batches = list(stream(1000.0, 2.0, rate_hz=50))
    with recorder_in(tmp_path) as bench:
        failing_after(monkeypatch, count, OSError(errno.ENOSPC, "No space left on device"))
        bench.begin()
        for one in batches:
            bench.feed(one)
        assert not bench.recorder.is_recording
        assert bench.recorder.started_at is None
        assert bench.recorder.trouble is not None
        assert bench.recorder.trouble.in_english().endswith(": the disk is full.")
        (entry,) = bench.library.entries()
        assert entry.trouble is not None or (entry.was_cut_off, entry.is_running) == (True, False)
        if entry.trouble is None:
            found = whole_of(entry.path)
            assert found.times == [sample.at for one in batches for sample in one.samples][: len(found.times)]
            assert count < 5000 or found.times
        monkeypatch.undo()
        bench.record(batch(1010.0, report(1010.0)))
        assert bench.recorder.trouble is None
        assert bench.library.entries()[0].sample_count == 1


@pytest.mark.parametrize(
    ("folder", "reserve_bytes", "why"), [("", 1 << 70, "the disk is full"), ("file/shelf", 0, "file/shelf: ")]
)
def test_the_last_disk_space_is_left_free_and_a_folder_that_cannot_be_made_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str, reserve_bytes: int, why: str
) -> None:
    monkeypatch.setattr(recorder, "RESERVE_BYTES", reserve_bytes)
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with recorder_in(tmp_path / folder) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        assert not bench.recorder.is_recording
        assert bench.recorder.trouble is not None
        assert why in bench.recorder.trouble.in_english().replace("\\", "/")
        assert bench.library.entries() == ()


def test_where_the_file_system_has_no_locks_it_is_recorded_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_file: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(session_file, "lock", refuse)
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.finish()
        assert [entry.sample_count for entry in bench.library.entries()] == [1]


def test_a_name_that_another_port_takes_meanwhile_costs_no_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Many ports that open at once look for a free name at the same time."""
    new_path, taken = RecordingLibrary.new_path, list[Path]()

    def first_taken(library: RecordingLibrary, started_at: datetime) -> Path:
        path = new_path(library, started_at)
        if not taken:
            path.write_bytes(b"of another port")
            taken.append(path)
        return path

    monkeypatch.setattr(RecordingLibrary, "new_path", first_taken)
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.finish()
        assert bench.recorder.trouble is None
        assert bench.library.entries()[0].sample_count == 1
        assert taken[0].read_bytes() == b"of another port"


def test_an_unexpected_error_ends_the_recording_but_not_the_thread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorder_in(tmp_path) as bench:
        monkeypatch.setattr(SessionWriter, "add", lambda *_: 1 / 0)
        bench.record(batch(1000.0, report(1000.0)))
        assert bench.recorder.trouble is not None
        monkeypatch.undo()
        bench.record(batch(1001.0, report(1001.0)))
        assert bench.recorder.started_at is not None


class Jam:
    """The disk hangs in a flush until it is released."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.hangs, self.goes_on = threading.Event(), threading.Event()
        flush = SessionWriter.flush

        def jammed(writer: SessionWriter, now_s: float, *, is_last: bool = False) -> None:
            self.hangs.set()
            assert self.goes_on.wait(PATIENCE_S)
            flush(writer, now_s, is_last=is_last)

        monkeypatch.setattr(SessionWriter, "flush", jammed)


def fill(bench: Bench, count: int, *, first_s: float) -> None:
    for number in range(count):
        at = first_s + number / 100
        sample = report(at, number, active=number >= count - 1)
        bench.recorder.on_batch(batch(at, sample, events=(received(sample),), view=talk(at)))


def test_a_hanging_disk_delays_nothing_and_ends_the_recording_in_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "MAX_WAITING", 300)
    with recorder_in(tmp_path) as bench:
        jam = Jam(monkeypatch)
        bench.begin()
        bench.recorder.on_batch(batch(1000.0, report(1000.0)))
        assert jam.hangs.wait(PATIENCE_S)
        fill(bench, 1000, first_s=1001.0)
        assert bench.recorder.trouble is not None
        assert not bench.recorder.stop(0.0), "closing the window does not wait for it"
        jam.goes_on.set()
        assert bench.recorder.stop(PATIENCE_S)
        recording = opened(bench.path)
        assert len(recording.tilt) == 301
        assert recording.damage is None, "it is whole up to there"
        assert not recording.entry.was_cut_off


def test_csv_holds_every_value_and_is_appended_to(tmp_path: Path) -> None:
    """Three seconds of stream with a trigger, and a lost port."""
    path = tmp_path / "x.csv"
    with recorder_in(tmp_path / "shelf") as bench:
        bench.begin()
        bench.recorder.on_batch(batch(1000.0, events=(asked(1000.0),)))
        bench.feed(*stream(1000.0, 3.0, rate_hz=400))
        bench.name("Flügel \udc80")  # as of a file name that is no text
        bench.feed(
            batch(1003.4, report(1003.4, 76, active=True)),
            batch(1003.5, report(1003.5, 77, triggered=True, active=True), view=talk(1003.5, light_v=2.5)),
            batch(1004.0, connection=CLOSED._replace(trouble=PortError(PortErrorKind.LOST, PORT, "gone"))),
        )
        bench.finish()
        recording = opened(bench.path)
    counts = [export(recording.entry, path, appends=True)[0] for _ in range(2)]
    text = path.read_bytes().decode("utf-8-sig")
    assert (text.splitlines()[0], text.count(HEAD)) == (HEAD, 1)
    rows = list(csv.DictReader(io.StringIO(text)))
    assert rows[: counts[0]] == rows[counts[0] :]
    reports = [row for row in rows[: counts[0]] if row["tilt_deg"]]
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    assert [float(row["tilt_deg"]) for row in reports] == excerpt.tilt.value.tolist()
    assert [float(row["acceleration_g"]) for row in reports] == pytest.approx(excerpt.acceleration.value.tolist())
    assert [float(row["elapsed_s"]) for row in reports] == pytest.approx(
        (excerpt.tilt.time_s - 1000.0).tolist(), abs=6e-4
    )
    assert [datetime.fromisoformat(row["time_utc"] + "+00:00").timestamp() for row in reports[:3]] == pytest.approx(
        [NOON.timestamp() + n / 400 for n in range(3)], abs=6e-4
    )
    flags = [(row["triggered"], row["active"]) for row in reports[-3:]]
    assert flags == [("false", "false"), ("false", "true"), ("true", "true")]
    others = {
        name: [row[name] for row in rows[: counts[0]] if row[name]] for name in ("event", "cell_voltage_v", "light_v")
    }
    assert others == {
        "event": [f"connected: {PORT}", "named: Flügel ?", "activated", "triggered", f"port lost: {PORT}"],
        "cell_voltage_v": ["3.00", "3.01", "3.02"],
        "light_v": ["1.0", "1.1", "1.2", "2.5"],
    }
