"""Recordings are listed, pruned (oldest first, never running ones) and deleted."""

import json
from datetime import timedelta
from pathlib import Path

import pytest

from app.recordings.library import RecordingLibrary, recordings_folder
from app.recordings.session_file import HEAD_BYTES
from app.text.messages import UserError
from tests.support.cli_line import Program
from tests.support.records.recordings_made import (
    LINE_HZ,
    NAME,
    NOON,
    batch,
    recorded,
    recorder_in,
    report,
    write_session,
)

pytest_plugins = ["tests.support.cli_fixtures"]


def write(folder: Path, rows: int, *, days: float = 0.0, number: int = 0) -> Path:
    """A recording that began so many days before noon."""
    folder.mkdir(exist_ok=True)
    started_at = NOON - timedelta(days=days)
    path = folder / f"{started_at:%Y%m%dT%H%M%SZ}-{number:05}.mcap"
    write_session(path, (report(1000.0 + row / LINE_HZ) for row in range(rows)), started_at=started_at)
    return path


def library_of(folder: Path, *days: float) -> RecordingLibrary:
    """Recordings that began so many days before noon."""
    for number, before in enumerate(sorted(days, reverse=True), start=1):
        write(folder, 1000 + number, days=before, number=number)
    return RecordingLibrary(folder, max_bytes=1 << 40)


def damage_heading(path: Path) -> None:
    raw = path.read_bytes()
    path.write_bytes(raw[:20] + raw[20:].replace(b"ttyUSB0", b"ttyUSB8", 1))


def ages(library: RecordingLibrary) -> list[float]:
    """Ages in days."""
    return [(NOON - entry.started_at) / timedelta(days=1) for entry in library.entries()]


def numbers(library: RecordingLibrary) -> list[int]:
    return [int(entry.name.rpartition("-")[2]) for entry in library.entries()]


@pytest.mark.promise("f")
def test_a_session_with_a_clock_far_ahead_prunes_nothing(tmp_path: Path) -> None:
    """Neither it nor the others are pruned, in any order."""
    library = RecordingLibrary(tmp_path)
    for number, days in enumerate((6, 5, 4, -100, 3, 2, 1), 1):
        write(tmp_path, 100 + number, days=days, number=number)
    library.prune()
    assert numbers(library) == [7, 6, 5, 4, 3, 2, 1]
    with recorder_in(tmp_path) as bench:
        bench.clock.wall_offset_s += 100 * 86400
        bench.record(batch(1000.0, report(1000.0)))
        assert numbers(bench.library) == [8, 7, 6, 5, 4, 3, 2, 1]


def test_the_oldest_recordings_beyond_the_size_are_pruned(tmp_path: Path) -> None:
    library = library_of(tmp_path, 1, 2, 3, 4)
    library.max_bytes = sum(entry.size_bytes for entry in library.entries()[:2])
    library.prune()
    assert ages(library) == [1, 2]


def test_what_is_being_written_is_neither_pruned_nor_deleted(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        (entry,) = bench.library.entries()
        assert entry.is_running
        RecordingLibrary(tmp_path, max_bytes=0).prune()  # the recorder's own limit begins a further part
        with pytest.raises(UserError, match="being written"):
            bench.library.delete(entry)
        bench.finish()
        bench.library.delete(entry)
        assert bench.library.entries() == ()
        bench.library.delete(entry)


def test_nothing_outside_of_the_library_is_deleted(tmp_path: Path) -> None:
    library = library_of(tmp_path / "library", 1)
    other = recorded(tmp_path / "other", 0.1)
    (entry,) = library.entries()
    for path in (other, tmp_path / "library", tmp_path, entry.path / ".."):
        with pytest.raises(ValueError):
            library.delete(entry._replace(path=path))
    assert other.is_file()
    assert len(library.entries()) == 1


def test_only_the_head_of_each_file_is_read_for_the_list(tmp_path: Path) -> None:
    """So thousands are listed at once, whatever their length."""
    path = write(tmp_path, 10_000)
    path.write_bytes(path.read_bytes()[:HEAD_BYTES])
    (entry,) = RecordingLibrary(tmp_path).entries()
    assert (entry.sample_count, entry.trouble) == (10_000, None)


def test_a_damaged_recording_is_listed_with_its_error(tmp_path: Path) -> None:
    library = library_of(tmp_path, 1)
    (entry,) = library.entries()
    damage_heading(entry.path)
    (damaged,) = library.entries()
    assert damaged.trouble is not None
    assert damaged.trouble.in_english() == f"{entry.path.name} cannot be read: damaged."
    assert damaged.size_bytes > 0
    library.delete(damaged)
    assert library.entries() == ()


# The command line


@pytest.fixture
def kept_at(user_files: Path) -> Path:
    """The folder of the command line."""
    return recordings_folder()


def test_the_list_for_people_and_for_programs(kept_at: Path, dps_s: Program) -> None:
    assert dps_s(["recordings", "list"]).err == "No recordings yet\n"
    folder = recorded(kept_at, 2.0)
    page = dps_s(["recordings", "list"]).out
    assert folder.stem in page
    assert "0:02" in page
    assert NAME in page
    (listed,) = json.loads(dps_s(["recordings", "list", "--json"]).out)["recordings"]
    assert listed == {
        "name": folder.stem, "started_at": NOON.isoformat(), "duration_s": pytest.approx(2.0, abs=0.01),
        "port": "/dev/ttyUSB0", "baud_rate": 115200, "modules": [NAME], "samples": 2880,
        "size_bytes": folder.stat().st_size, "running": False, "cut_off": False,
        "triggered": False, "simulated": False, "readable": True,
    }  # fmt: skip


def test_what_is_damaged_is_not_exported(kept_at: Path, tmp_path: Path, dps_s: Program) -> None:
    damage_heading(recorded(kept_at, 0.1))
    assert "damaged" in dps_s(["recordings", "export", "latest", str(tmp_path / "x.csv")], 2).err
    assert not (tmp_path / "x.csv").exists()
