"""A closed recording is verified when it is opened and exported; damage is left out and reported."""

import json
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

import app.__main__ as program
from app.recordings.commits import COMMIT, read_extents, verified
from app.recordings.export import export_csv, export_mcap
from app.recordings.file_layout import DATA_FILES, read_opening
from app.recordings.library import RecordingLibrary, recordings_folder
from app.recordings.markers import MarkerKind
from app.recordings.recording import Recording, RecordingUnreadable, open_recording
from app.text.i18n import ENGLISH, set_language
from tests.support.cli_line import Printed
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.records.recordings_made import HEADING, recorded, recorder_in, stream, whole_of
from tests.support.window.fakes_ui import speak_chinese
from ui.pages.live.page import LivePage
from ui.pages.recordings.page import RecordingsPage
from ui.services.recording_jobs import ExportKind
from ui.style.theme import Meaning

pytest_plugins = ["tests.support.cli_fixtures"]
TILT, TIME = "status.tilt_deg.f4", "status.time_s.f8"


def in_pieces(folder: Path, seconds: float) -> Path:
    """A closed recording with a commit every half second, as in the field."""
    with recorder_in(folder) as bench:
        bench.recorder.begin(HEADING)
        for number in range(round(seconds * 2)):
            bench.feed(*stream(1000.0 + number / 2, 0.5))
        bench.finish()
        return bench.folder


def overwrite(path: Path, place: int, raw: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(place)
        file.write(raw)


def seal_again(folder: Path) -> None:
    """Replaces the commits by one with valid checksums, as a forger would."""
    last = bytearray((folder / "commits.bin").read_bytes()[-COMMIT.size :])
    crc = 0
    opening = read_opening(folder)
    extents = read_extents(folder, opening)
    for name in DATA_FILES:
        crc = zlib.crc32((folder / name).read_bytes()[: extents.length(name)], crc)
    last[52:56] = crc.to_bytes(4, "little")
    last[60:] = zlib.crc32(bytes(last[:60])).to_bytes(4, "little")
    (folder / "commits.bin").write_bytes(bytes(last))


def check_whole(folder: Path) -> None:
    with open_recording(folder) as recording:
        assert recording.damaged == ()
        assert recording.damage is None


def test_an_altered_tilt_is_left_out_and_reported(tmp_path: Path) -> None:
    folder = in_pieces(tmp_path, 4.0)
    before = whole_of(folder)
    check_whole(folder)
    row = len(before.times) // 2
    overwrite(folder / TILT, row * 4, struct.pack("<f", 189.0))
    with open_recording(folder) as recording:
        (piece,) = recording.damaged
        assert piece.first.status_rows <= row < piece.last.status_rows
        after = recording.tilt.window(0.0, 1e9)
        assert len(after.time_s) == len(before.times) - (piece.last.status_rows - piece.first.status_rows)
        sound = before.tilts[: piece.first.status_rows] + before.tilts[piece.last.status_rows :]
        assert after.value.tolist() == sound
        assert recording.damage is not None
        assert recording.damage.in_english().startswith("Damaged or altered")
        assert [one.kind for one in recording.markers] == [MarkerKind.CONNECTED, MarkerKind.DAMAGED]
        export_csv(recording, tmp_path / "x.csv")
        export_mcap(recording, tmp_path / "x.mcap")
    text = (tmp_path / "x.csv").read_text("utf-8-sig")
    assert "damaged data left out" in text
    assert ",189," not in text


@pytest.mark.parametrize("name", ["status.flags.u1", "light.voltage_v.f4", "line.dpscap", "journal.jsonl", TIME])
def test_damage_in_any_file_is_found(tmp_path: Path, name: str) -> None:
    folder = in_pieces(tmp_path, 3.0)
    path = folder / name
    place = path.stat().st_size // 2
    overwrite(path, place, bytes((path.read_bytes()[place] ^ 0x10,)))
    with open_recording(folder) as recording:
        assert len(recording.damaged) == 1
        assert recording.damage is not None
        assert sum(1 for _ in recording.traffic()) > 0


def test_a_damaged_commit_costs_only_its_piece(tmp_path: Path) -> None:
    folder = in_pieces(tmp_path, 4.0)
    before = whole_of(folder)
    count = (folder / "commits.bin").stat().st_size // COMMIT.size
    assert count >= 5
    overwrite(folder / "commits.bin", 2 * COMMIT.size + 8, b"\xff" * 8)
    with open_recording(folder) as recording:
        assert len(recording.damaged) == 1
        assert 0 < len(recording.tilt) < len(before.times)


@pytest.mark.parametrize("value", [1e300, -1e300, 1e18, 4e9, float("inf"), float("nan")])
def test_damaged_times_raise_no_error(tmp_path: Path, value: float) -> None:
    """Also with valid checksums."""
    folder = recorded(tmp_path, 2.0)
    rows = len(np.fromfile(folder / TIME))
    overwrite(folder / TIME, (rows - 1) * 8, struct.pack("<d", value))
    seal_again(folder)
    opening = read_opening(folder)
    assert verified(folder, opening, read_extents(folder, opening))[1] == ()
    with (folder / "journal.jsonl").open("ab") as file:
        file.write(b'{"at": 1e300, "what": "happening", "kind": "offline"}\n')
    with open_recording(folder) as recording:
        assert len(recording.tilt) == rows - 1
        assert recording.damage is not None
        export_csv(recording, tmp_path / "x.csv")
        export_mcap(recording, tmp_path / "x.mcap")


@pytest.mark.parametrize(
    "change",
    [{"start_s": 1e300}, {"start_s": 10**400}, {"started_at": "0001-01-01T00:00:00+00:00"},
     {"started_at": "9999-12-31T23:59:59-12:00"}],
)  # fmt: skip
def test_a_heading_with_an_impossible_time_is_damaged(tmp_path: Path, change: dict[str, object]) -> None:
    folder = recorded(tmp_path, 0.2)
    heading = json.loads((folder / "session.json").read_text("utf-8"))
    (folder / "session.json").write_text(json.dumps(heading | change), "utf-8")
    with pytest.raises(RecordingUnreadable, match="damaged heading"):
        open_recording(folder)
    (entry,) = RecordingLibrary(tmp_path).entries()
    assert entry.trouble is not None
    assert entry.started_at.astimezone() is not None


def test_a_commit_with_an_impossible_time_does_not_count(tmp_path: Path) -> None:
    folder = recorded(tmp_path, 2.0)
    raw = bytearray((folder / "commits.bin").read_bytes())
    raw[-64:-56] = struct.pack("<d", 1e300)
    raw[-4:] = zlib.crc32(bytes(raw[-64:-4])).to_bytes(4, "little")
    (folder / "commits.bin").write_bytes(bytes(raw))
    with open_recording(folder) as recording:
        assert recording.end_s < 1e6
        assert recording.entry.was_cut_off
        export_csv(recording, tmp_path / "x.csv")


def test_the_command_line_reports_damage(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = recorded(recordings_folder(), 2.0)
    overwrite(folder / TILT, 400, struct.pack("<f", 189.0))
    assert program.main(["recordings", "export", "latest", str(tmp_path / "x.csv")]) == 4
    printed = Printed(capsys)
    assert "Rows written to" in printed.out
    assert "Damaged or altered" in printed.err


# In the window


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """The list and the Live page, with a recording whose tilt was changed."""
    template = record(tmp_path / "template")
    overwrite(template / TILT, 400, struct.pack("<f", 189.0))
    with made(qtbot, qapp, tmp_path / "data", template, RecordingsPage, LivePage) as one:
        yield one


def test_the_window_reports_damage_at_export_and_playback(desk: Desk, tmp_path: Path) -> None:
    desk.page.work.export(desk.page.work.entries[0], tmp_path / "x.csv", ExportKind.CSV)
    desk.until(lambda: "Saved" in desk.said())
    assert "Damaged or altered" in desk.said()
    assert desk.page.strip.notice is not None
    assert desk.page.strip.notice.meaning is Meaning.ATTENTION
    speak_chinese()
    assert "已损坏或被修改" in desk.said()
    set_language(ENGLISH)
    desk.open()
    shown = desk.live.recording
    assert isinstance(shown, Recording)
    assert shown.damage is not None
    desk.until(lambda: "Damaged or altered" in desk.live._recorded.banner.label.text())
