"""Exports contain every recorded value and are written atomically."""

import base64
import csv
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from app.captures.entries import Way
from app.engine.transport import PortError, PortTrouble
from app.recordings.export import ExportCancelled, export_csv, export_mcap
from app.recordings.recording import Recording, open_recording
from app.recordings.table import HEAD
from protocol.catalogue import BY_NAME
from protocol.events import Sent
from tests.support.records.recordings_made import (
    CLOSED,
    HEADING,
    NOON,
    PORT,
    asked,
    batch,
    device,
    recorder_in,
    report,
    stream,
)


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[Recording]:
    """Three seconds of stream with a trigger, changing limits, a lost port and requests."""
    light = BY_NAME["light"].query()
    with recorder_in(tmp_path / "shelf") as bench:
        bench.recorder.begin(HEADING)
        bench.recorder.on_batch(batch(1000.0, events=(asked(1000.0),)))
        bench.feed(*stream(1000.0, 3.0, rate_hz=400))
        fired = report(1003.5, 77, triggered=True, active=True)
        bench.feed(
            batch(1003.5, fired, view=device(1003.5, attitude_threshold_deg=45, freefall_acceleration_g=0.3)),
            batch(1003.75, events=(Sent(light.encode(), light, 1, 1003.75),), view=device(1003.7, light_v=2.5)),
            batch(1004.0, connection=replace(CLOSED, trouble=PortError(PortTrouble.LOST, PORT, "gone"))),
        )
        bench.finish()
        with open_recording(bench.folder) as opened:
            yield opened


def messages(path: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    """Messages by topic, as read by the mcap library."""
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            values = json.loads(message.data)
            described = json.loads(schema.data)
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert list(values) == list(described["properties"]) == described["required"]
            assert message.log_time == message.publish_time
            found.setdefault(channel.topic, []).append((message.log_time, values))
    return found


def at_ns(recording: Recording, time_s: float) -> int:
    return round(time_s * 1e9) + round(recording.wall_offset_s * 1e9)


def test_mcap_holds_every_value_and_every_byte(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    count = export_mcap(recording, path)
    found = messages(path)
    assert count == sum(map(len, found.values()))
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    assert [at for at, _ in found["/status"]] == [at_ns(recording, one) for one in excerpt.time_s]
    assert [tuple(values.values()) for _, values in found["/status"]] == [
        (tilt, pytest.approx(acceleration, abs=1e-6), triggered, active)
        for tilt, acceleration, triggered, active in zip(
            excerpt.tilt_deg.tolist(),
            excerpt.acceleration_g.tolist(),
            excerpt.is_triggered.tolist(),
            excerpt.is_active.tolist(),
            strict=True,
        )
    ]
    assert found["/status"][13][1]["acceleration_g"] == 1.3, "in steps of a tenth, as the module says it"
    assert found["/cell"] == [(at_ns(recording, 1000.0 + n), {"cell_voltage_v": 3.0 + n / 100}) for n in range(3)]
    assert found["/light"][-1] == (at_ns(recording, 1003.7), {"light_v": 2.5})
    assert [list(values.values()) for _, values in found["/limits"]] == [
        [60.0, 50.0, None, None], [45.0, 35.0, 0.3, None], [None] * 4
    ]  # fmt: skip
    assert [(values["event"], values["port"]) for _, values in found["/events"]] == [
        ("connected", PORT), ("activated", PORT), ("triggered", PORT), ("port lost", PORT)
    ]  # fmt: skip
    for topic, way in (("/line/rx", Way.IN), ("/line/tx", Way.OUT)):
        start_s = recording.opening.start_s
        expected = [(at_ns(recording, start_s + one.at_s), one.raw) for one in recording.traffic() if one.way is way]
        assert [(at, base64.b64decode(values["data"])) for at, values in found[topic]] == expected
        assert expected
    first_ns = found["/events"][0][0]
    assert first_ns == round(NOON.timestamp() * 1e9)


def test_mcap_says_what_it_is_of_and_has_its_summary(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    count = export_mcap(recording, path)
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        (about,) = reader.iter_metadata()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == count
    assert {one.topic for one in summary.channels.values()} == {
        "/status", "/cell", "/light", "/limits", "/events", "/line/rx", "/line/tx"
    }  # fmt: skip
    assert all(one.schema_id in summary.schemas for one in summary.channels.values())
    assert (about.name, about.metadata["module"], about.metadata["port"]) == ("dps-s recording", "Bench 7", PORT)
    assert about.metadata["started_at"] == NOON.isoformat()


def test_mcap_is_in_order_of_time(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    export_mcap(recording, path)
    with path.open("rb") as file:
        times = [one.log_time for _, _, one in make_reader(file).iter_messages(log_time_order=False)]
    assert times == sorted(times)


def test_mcap_of_a_session_in_which_the_module_said_nothing(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, events=(asked(1000.0),)))
        with open_recording(bench.folder) as silent:
            assert export_mcap(silent, tmp_path / "x.mcap") == 2
            assert export_csv(silent, tmp_path / "x.csv") == 1
    assert set(messages(tmp_path / "x.mcap")) == {"/events", "/line/tx"}


def test_csv_holds_every_value(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    count = export_csv(recording, path)
    text = path.read_bytes().decode("utf-8-sig")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert text.splitlines()[0] == HEAD
    assert count == len(rows) == 1201 + 3 + 4 + 4
    reports = [row for row in rows if row["tilt_deg"]]
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    assert [float(row["tilt_deg"]) for row in reports] == excerpt.tilt_deg.tolist()
    assert [float(row["acceleration_g"]) for row in reports] == pytest.approx(excerpt.acceleration_g.tolist())
    assert [float(row["elapsed_s"]) for row in reports] == pytest.approx((excerpt.time_s - 1000.0).tolist(), abs=6e-4)
    assert [datetime.fromisoformat(row["time_utc"] + "+00:00").timestamp() for row in reports[:3]] == pytest.approx(
        [NOON.timestamp() + n / 400 for n in range(3)], abs=6e-4
    )
    assert (reports[-1]["triggered"], reports[-1]["active"]) == ("true", "true")
    assert [row["event"] for row in rows if row["event"]] == [
        f"connected: {PORT}", "activated", "triggered", f"port lost: {PORT}"
    ]  # fmt: skip
    assert [row["cell_voltage_v"] for row in rows if row["cell_voltage_v"]] == ["3.00", "3.01", "3.02"]


@pytest.mark.parametrize("export", [export_csv, export_mcap])
def test_progress_goes_to_the_end(recording: Recording, tmp_path: Path, export: Any) -> None:
    shares: list[float] = []
    export(recording, tmp_path / "x", on_progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("export", [export_csv, export_mcap])
@pytest.mark.parametrize("looks", [0, 1])
def test_a_cancelled_export_leaves_the_file_unchanged(
    recording: Recording, tmp_path: Path, export: Any, looks: int
) -> None:
    path = tmp_path / "out" / "x"
    path.parent.mkdir()
    path.write_text("before", encoding="utf-8")
    left = iter([False] * looks)
    with pytest.raises(ExportCancelled):
        export(recording, path, is_cancelled=lambda: next(left, True))
    assert path.read_text(encoding="utf-8") == "before"
    assert [one.name for one in path.parent.iterdir()] == ["x"]


@pytest.mark.parametrize("export", [export_csv, export_mcap])
def test_a_folder_that_is_not_there(recording: Recording, tmp_path: Path, export: Any) -> None:
    with pytest.raises(OSError):
        export(recording, tmp_path / "nowhere" / "x")
