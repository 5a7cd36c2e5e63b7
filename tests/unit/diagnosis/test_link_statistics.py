"""Statistics of the link, and the bundle that carries them."""

import json
import zipfile
from functools import partial
from pathlib import Path

import pytest

from app.diagnosis.link_state import LinkStatistics
from app.diagnosis.support_bundle import COMPUTER, USER, bundle_files, scrub, write_bundle
from app.engine.conversation import ConversationView, How, Known
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from protocol.catalogue import STATUS
from protocol.events import Answered, Counters, Event, Rejected
from protocol.messages import Noise, Reason
from tests.support.records.recordings_made import asked

OPEN = Connection(PortState.OPEN, "x", 115200)
LOST = Connection(PortState.CLOSED, "x", 115200, PortError(PortErrorKind.LOST, "x", ""))
QUERY = STATUS.query()


def batch(at: float, link: Counters | None = None, *events: Event, connection: Connection = OPEN) -> Batch:
    return Batch(at, connection, ConversationView(), link, events=events)


def view(byte_count: int = 0, **counted: int) -> Counters:
    return Counters(bytes_received=byte_count, **counted)


def answered(trip_s: float | None) -> Answered:
    return Answered(QUERY, (), 1, trip_s, 0.0)


def test_round_trips_have_quantiles() -> None:
    figures = LinkStatistics()
    assert figures.quantile_s(0.5) is None
    trips = (0.0005, 0.001, 0.0011, 0.016, 0.0161, 0.9, 1.0, 1.5, None)
    figures.on_batch(batch(1.0, view(), *(answered(trip) for trip in trips)))
    assert figures.quantile_s(0.5) == 0.0161
    assert figures.quantile_s(1.0) == 1.5


def test_its_counts_are_those_of_the_open_port() -> None:
    figures = LinkStatistics()
    figures.on_batch(batch(1.0, view(100, sent=10)))
    figures.on_batch(batch(1.5, None, connection=LOST))
    assert (figures.totals.sent, figures.totals.bytes_received) == (10, 100)
    figures.on_batch(batch(2.1, view(7, sent=3)))
    assert (figures.totals.sent, figures.totals.bytes_received) == (3, 7)


# The support bundle equals its preview and contains no names


NAMES = "wolfgang", "field-laptop.example.org"
TRAFFIC = (asked(1000.0), Rejected(Noise(b"\x02", Reason.NO_HEADER, 0), 1001.0))
CONTENTS = partial(
    bundle_files,
    version="1.2",
    log="2026-11-21 opened /home/wolfgang/x on field-laptop\n",
    connection=Connection(
        PortState.CLOSED,
        "/dev/ttyUSB0",
        115200,
        PortError(PortErrorKind.BUSY, "/dev/ttyUSB0", "held by Wolfgang"),
    ),
    conversation=ConversationView(number=1, values={"tilt_deg": Known(7, How.STREAMED, 10.0)}),
    statistics=LinkStatistics(),
    preferences={"language": "zh_CN", "last": "C:\\Users\\wolfgang\\x.toml"},
    traffic=TRAFFIC,
)


@pytest.mark.parametrize(
    ("text", "clean"),
    [
        ("/home/anna/project/x", f"/home/{USER}/project/x"),
        ("/Users/anna/x", f"/Users/{USER}/x"),
        ("C:\\Users\\Anna Maria\\x", f"C:\\Users\\{USER}\\x"),
        ('"c:/Users/anna/x"', f'"c:/Users/{USER}/x"'),
        ('{"path": "C:\\\\Users\\\\anna\\\\x"}', f'{{"path": "C:\\\\Users\\\\{USER}\\\\x"}}'),
        ("/home/wolfgang/x.py", f"/home/{USER}/x.py"),
        ("user wolfgang on field-laptop", f"user {USER} on {COMPUTER}"),
        ("WOLFGANG@Field-Laptop.example.org", f"{USER}@{COMPUTER}"),
        ("wolfgangs_port is another word", "wolfgangs_port is another word"),
        ("/dev/ttyUSB0 at 115200", "/dev/ttyUSB0 at 115200"),
    ],
)
def test_names_are_replaced(text: str, clean: str) -> None:
    assert scrub(text, *NAMES) == clean


@pytest.mark.parametrize("name", ["", "a", "ab"])
def test_names_that_identify_nobody_stay(name: str) -> None:
    text = "a root user has about a cab"
    assert scrub(text, name, name) == text


def test_the_zip_equals_the_preview_and_names_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("getpass.getuser", lambda: NAMES[0])
    monkeypatch.setattr("socket.gethostname", lambda: NAMES[1])
    files = CONTENTS()
    for name, text in files.items():
        assert "wolfgang" not in text.lower(), name
        assert "field-laptop" not in text.lower(), name
    path = tmp_path / "support.zip"
    write_bundle(path, files)
    with zipfile.ZipFile(path) as archive:
        assert {name: archive.read(name).decode() for name in archive.namelist()} == files
    saved = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "writestr", full)
    with pytest.raises(OSError, match="space"):
        write_bundle(path, {"a": ""})
    assert path.read_bytes() == saved, "the old file stays"
    assert list(tmp_path.iterdir()) == [path]


def test_a_bundle_contains_what_support_needs() -> None:
    files = CONTENTS()
    about = json.loads(files["about.json"])
    assert about["link"]["trouble"] == "busy"
    assert "in use" in about["link"]["what"]
    assert about["link"]["sent"] == 0
    assert about["program"] == "DPS-S Configurator 1.2"
    assert about["last_values"] == {"tilt_deg": 7}
    assert about["preferences"]["language"] == "zh_CN"
    started, *lines = files["capture.txt"].splitlines()
    assert started.startswith("# started: 20")
    assert lines == [f"0.000000 > {TRAFFIC[0].raw.hex(' ').upper()}", "1.000000 < 02"]
    assert CONTENTS(log="", traffic=()).keys() == {"about.json"}
