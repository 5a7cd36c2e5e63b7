"""The support bundle equals its preview and contains no names."""

import json
import zipfile
from pathlib import Path

import pytest

from app.captures.entries import CaptureEntry, Way
from app.captures.text import TimedLines
from app.diagnosis.link_statistics import LinkStatistics
from app.diagnosis.support_bundle import COMPUTER, USER, Contents, Names, SupportBundle, scrub
from app.engine.device import DeviceView, How, Known
from app.engine.transport import PortError, PortHolder, PortTrouble
from app.engine.worker import Connection, PortState
from tests.support.records.recordings_made import NOON

NAMES = Names("wolfgang", "field-laptop.example.org", "/home/wolfgang")
ENTRIES = (CaptureEntry(0.0, Way.OUT, b"\x01"), CaptureEntry(1.0, Way.IN, b"\x02"))
CONTENTS = Contents(
    version="1.2",
    log="2026-11-21 opened /home/wolfgang/x on field-laptop\n",
    connection=Connection(
        PortState.CLOSED,
        "/dev/ttyUSB0",
        115200,
        PortError(PortTrouble.BUSY, "/dev/ttyUSB0", "held by Wolfgang", PortHolder("minicom", 7)),
    ),
    device=DeviceView({"tilt_deg": Known(7, How.STREAMED, 10.0)}),
    now=12.0,
    figures=LinkStatistics(),
    preferences={"language": "zh_CN", "last": "C:\\Users\\wolfgang\\x.toml"},
    capture=ENTRIES,
    capture_started_at=NOON,
)


@pytest.mark.parametrize(
    ("text", "clean"),
    [
        ("/home/anna/project/x", f"/home/{USER}/project/x"),
        ("/Users/anna/x", f"/Users/{USER}/x"),
        ("C:\\Users\\Anna Maria\\x", f"C:\\Users\\{USER}\\x"),
        ('"c:/Users/anna/x"', f'"c:/Users/{USER}/x"'),
        ('{"path": "C:\\\\Users\\\\anna\\\\x"}', f'{{"path": "C:\\\\Users\\\\{USER}\\\\x"}}'),
        ("/home/wolfgang/x.py", f"~{USER}/x.py"),
        ("user wolfgang on field-laptop", f"user {USER} on {COMPUTER}"),
        ("WOLFGANG@Field-Laptop.example.org", f"{USER}@{COMPUTER}"),
        ("wolfgangs_port is another word", "wolfgangs_port is another word"),
        ("/dev/ttyUSB0 at 115200", "/dev/ttyUSB0 at 115200"),
    ],
)
def test_names_are_replaced(text: str, clean: str) -> None:
    assert scrub(text, NAMES) == clean


@pytest.mark.parametrize("name", ["", "a", "ab", "root", "user"])
def test_names_that_identify_nobody_stay(name: str) -> None:
    text = "a root user has about a cab"
    assert scrub(text, Names(name, name, "/")) == text


def test_the_zip_equals_the_preview(tmp_path: Path) -> None:
    bundle = SupportBundle(CONTENTS, names=NAMES)
    path = tmp_path / "support.zip"
    bundle.write(path)
    with zipfile.ZipFile(path) as archive:
        held = {name: archive.read(name).decode() for name in archive.namelist()}
        assert archive.comment == b""
        assert all(entry.extra == b"" and entry.comment == b"" for entry in archive.infolist())
    assert held == {part.name: part.text for part in bundle.preview()}
    assert all(part.size_bytes == len(held[part.name].encode()) for part in bundle.preview())
    assert [path.name for path in tmp_path.iterdir()] == ["support.zip"]


def test_the_same_contents_give_the_same_file(tmp_path: Path) -> None:
    for name in ("a", "b"):
        SupportBundle(CONTENTS, names=NAMES).write(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_bundle_names_nobody() -> None:
    for part in SupportBundle(CONTENTS, names=NAMES).preview():
        lower = part.text.lower()
        assert "wolfgang" not in lower, part.name
        assert "field-laptop" not in lower, part.name


def test_this_computers_names_are_replaced_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", "henriette")
    monkeypatch.setattr("socket.gethostname", lambda: "workbench")
    monkeypatch.setenv("SECRET_OF_THE_ENVIRONMENT", "hush-hush")
    bundle = SupportBundle(Contents(version="1", log="henriette@workbench"))
    text = "".join(part.text for part in bundle.preview())
    assert f"{USER}@{COMPUTER}" in text
    assert "hush-hush" not in text


def test_a_bundle_contains_what_support_needs() -> None:
    parts = {part.name: part.text for part in SupportBundle(CONTENTS, names=NAMES).preview()}
    link = json.loads(parts["link.json"])
    assert link["trouble"] == "busy"
    assert "minicom" in link["what"]
    assert link["sent"] == 0
    assert json.loads(parts["about.json"])["program"] == "DPS-S Configurator 1.2"
    module = json.loads(parts["module.json"])
    assert module["values"]["tilt_deg"] == {"value": 7, "how": "streamed", "age_s": 2.0, "doubt": "aged"}
    assert json.loads(parts["preferences.json"])["language"] == "zh_CN"
    started, *lines = parts["capture.txt"].splitlines()
    assert started == f"# started: {NOON.isoformat()}"
    assert tuple(map(TimedLines().feed, lines)) == ENTRIES


def test_a_bundle_of_a_version_alone_can_be_made() -> None:
    names = [part.name for part in SupportBundle(Contents(version="1"), names=NAMES).preview()]
    assert names == ["about.json", "link.json", "module.json", "preferences.json"]


def test_the_end_of_a_long_log_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.diagnosis.support_bundle.MAX_PART_LENGTH", 100)
    log = "".join(f"line {number}\n" for number in range(100))
    parts = {part.name: part.text for part in SupportBundle(Contents(version="1", log=log), names=NAMES).preview()}
    assert parts["log.txt"].startswith("…\nline ")
    assert parts["log.txt"].endswith("line 99\n")
    assert len(parts["log.txt"]) < 110


def test_a_bundle_that_cannot_be_written_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "support.zip"
    path.write_bytes(b"old")

    class FullDisk(zipfile.ZipFile):
        def writestr(self, *args: object, **values: object) -> None:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr("app.diagnosis.support_bundle.zipfile.ZipFile", FullDisk)
    with pytest.raises(OSError, match="space"):
        SupportBundle(CONTENTS, names=NAMES).write(path)
    assert path.read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["support.zip"]
    with pytest.raises(OSError, match="No such"):
        SupportBundle(CONTENTS, names=NAMES).write(tmp_path / "missing" / "x.zip")
