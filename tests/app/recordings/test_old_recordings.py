"""What versions before session files wrote is converted sample by sample; made by such a version, zipped."""

import zipfile
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest

import app.__main__ as program
from app.captures.entries import Way
from app.recordings.library import RecordingLibrary, recordings_folder
from app.recordings.markers import MarkerKind
from app.recordings.old_recordings import convert, convert_in, entries_in, old_recordings
from app.recordings.recording import traffic_of
from app.text.user_error import UserError
from protocol.frame import Frame
from tests.support.cli_line import Printed
from tests.support.records.captures import explained
from tests.support.records.recordings_made import batch, opened, recorder_in, report

pytest_plugins = ["tests.support.cli_fixtures"]
MADE = Path(__file__).parents[2] / "support" / "records" / "old_recordings.zip"
COLUMNS = {"status.time_s.f8": "tilt.time_s", "status.tilt_deg.f4": "tilt.value",
           "status.acceleration_g.f4": "acceleration.value", "cell.time_s.f8": "cell.time_s",
           "cell.voltage_v.f4": "cell.value", "light.time_s.f8": "light.time_s",
           "light.voltage_v.f4": "light.value"}  # fmt: skip


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """Holds "whole", which was closed after its trigger, and "cutoff", which was killed."""
    with zipfile.ZipFile(MADE) as file:
        file.extractall(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["whole", "cutoff"])
def test_every_sample_and_every_byte_is_converted(library: Path, name: str) -> None:
    folder = library / name
    columns = {file: np.fromfile(folder / file, f"<{file[-2:]}") for file in COLUMNS}
    flags = np.fromfile(folder / "status.flags.u1", "u1")
    traffic = list(entries_in((folder / "line.dpscap").read_text("utf-8").splitlines()))
    size = {file.name: file.stat().st_size for file in folder.iterdir()}
    with opened(convert_in(library, folder)) as recording:
        excerpt = recording.excerpt(recording.start_s, recording.end_s)
        for file, attribute in COLUMNS.items():
            found = attrgetter(attribute)(excerpt)
            # `record --seconds` kept what came after its end among the bytes, not among the reports.
            assert found[: len(columns[file])].tolist() == columns[file].tolist(), file
        assert len(columns["status.time_s.f8"]) > 30
        assert excerpt.is_active[: len(flags)].tolist() == (flags & 1 != 0).tolist()
        assert excerpt.is_triggered[: len(flags)].tolist() == (flags & 2 != 0).tolist()
        found_traffic = list(traffic_of(recording.entry))
        assert [(entry.way, entry.raw) for entry in found_traffic] == [(entry.way, entry.raw) for entry in traffic]
        assert [entry.at_s for entry in found_traffic] == pytest.approx([entry.at_s for entry in traffic], abs=2e-6)
        assert [mark.kind for mark in recording.markers] == [
            MarkerKind.CONNECTED, *([MarkerKind.TRIGGERED] if name == "whole" else [])
        ]  # fmt: skip
        assert (60.0, 50.0, 0.5, 1.8) in [
            (limits.fires_deg, limits.rearms_deg, limits.free_fall_g, limits.light_v) for _, limits in recording.limits
        ]
        assert recording.entry.was_cut_off == (name == "cutoff")
        assert recording.entry.sequence == (2 if name == "cutoff" else 1)
    assert {file.name: file.stat().st_size for file in (library / ".trash" / name).iterdir()} == size


def test_a_capture_is_converted(library: Path) -> None:
    lines = (library / "session.dpscap").read_text("utf-8").splitlines()
    expected = list(entries_in(lines))
    convert(library / "session.dpscap", library / "session.mcap")
    with opened(library / "session.mcap") as recording:
        assert f"# port: {recording.opening.port}" in lines
        assert f"# started: {recording.opening.started_at.isoformat()}" in lines
        traffic = list(traffic_of(recording.entry))
        assert [(entry.way, entry.raw) for entry in traffic] == [(entry.way, entry.raw) for entry in expected]
        assert [entry.at_s for entry in traffic] == pytest.approx([entry.at_s for entry in expected], abs=2e-6)
        pieces = (row.piece for row in explained(expected) if row.way is Way.IN)
        assert len(recording.tilt) == sum(isinstance(piece, Frame) and len(piece.raw) == 8 for piece in pieces)


def test_an_mcap_export_is_converted_with_all_that_it_holds(library: Path) -> None:
    path, target = library / "export.mcap", library / "export-converted.mcap"
    with pytest.raises(UserError, match="recordings convert FILE"), opened(path):
        pass
    assert program.main(["recordings", "convert", str(path)]) == 0
    with opened(convert_in(library, library / "whole")) as folder, opened(target) as export:
        assert (export.opening.port, export.opening.module) == (folder.opening.port, folder.opening.module)
        assert export.opening.started_at == folder.opening.started_at
        since_s = folder.opening.start_s
        assert export.tilt.last is not None
        first, second = (one.excerpt(one.start_s, one.end_s) for one in (export, folder))
        assert first.tilt.time_s == pytest.approx(second.tilt.time_s - since_s, abs=2e-6)
        for name in ("tilt.value", "acceleration.value", "flags", "cell.value", "light.value"):
            assert attrgetter(name)(first) == pytest.approx(attrgetter(name)(second), abs=2e-6), name
        assert [mark.kind for mark in export.markers] == [mark.kind for mark in folder.markers]
        assert [one.raw for one in traffic_of(export.entry)] == [one.raw for one in traffic_of(folder.entry)]
        assert [limits.fires_deg for _, limits in export.limits] == [limits.fires_deg for _, limits in folder.limits]
        assert not export.entry.was_cut_off
    (library / "broken.mcap").write_bytes(path.read_bytes()[:3000])
    assert program.main(["recordings", "convert", str(library / "broken.mcap")]) == 4


def test_damage_is_left_out_and_shown(library: Path) -> None:
    folder = library / "whole"
    path = folder / "status.tilt_deg.f4"
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 0x40
    path.write_bytes(raw)
    with opened(convert_in(library, folder)) as recording:
        assert 40 < len(recording.tilt) < 83
        assert MarkerKind.DAMAGED in [mark.kind for mark in recording.markers]


def test_new_sessions_sort_behind_what_is_not_converted_yet(library: Path) -> None:
    with recorder_in(library) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        assert bench.library.entries()[0].sequence == 3


def test_the_command_line_converts_everything_once(
    library: Path, user_files: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = recordings_folder()
    place.mkdir(parents=True)
    for name in ("whole", "cutoff"):
        (library / name).rename(place / name)
    (place / "broken").mkdir()
    (place / "broken" / "session.json").write_text("{", encoding="utf-8")
    assert program.main(["recordings", "convert"]) == 4
    assert "broken: damaged heading" in Printed(capsys).err
    assert [entry.name for entry in RecordingLibrary(place).entries()] == ["cutoff", "whole"]
    assert [path.name for path in old_recordings(place)] == ["broken"]
    assert program.main(["recordings", "convert", str(library / "session.dpscap")]) == 0
    assert (library / "session.mcap").is_file()
    assert program.main(["recordings", "convert", str(library / "session.dpscap")]) == 4
