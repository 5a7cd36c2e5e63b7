"""Exports contain every recorded value and are written atomically."""

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from app.engine.transport import PortError, PortTrouble
from app.recordings.excerpt import HEAD
from app.recordings.export import ExportCancelled, export
from app.recordings.recording import Recording
from app.recordings.session_format import CHANNELS
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
    opened,
    recorder_in,
    report,
    stream,
)


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[Recording]:
    """Three seconds of stream with a trigger, changing limits, a lost port and requests."""
    light = BY_NAME["light"].query()
    with recorder_in(tmp_path / "shelf") as bench:
        bench.recorder.begin(*HEADING)
        bench.recorder.on_batch(batch(1000.0, events=(asked(1000.0),)))
        bench.feed(*stream(1000.0, 3.0, rate_hz=400))
        fired = report(1003.5, 77, triggered=True, active=True)
        bench.feed(
            batch(
                1003.5,
                fired,
                view=device(1003.5, attitude_threshold_deg=45, freefall_acceleration_g=0.3, freefall_time_s=1.6),
            ),
            batch(1003.75, events=(Sent(light.encode(), light, 1, 1003.75),), view=device(1003.7, light_v=2.5)),
            batch(1004.0, connection=replace(CLOSED, trouble=PortError(PortTrouble.LOST, PORT, "gone"))),
        )
        bench.finish()
        with opened(bench.path) as made:
            yield made


def messages(path: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    """JSON messages by topic, as read by the mcap library."""
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert message.log_time == message.publish_time
            if schema is None:
                found.setdefault(channel.topic, [])
                continue
            values = json.loads(message.data)
            described = json.loads(schema.data)
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert described["required"] == list(described["properties"])
            assert set(described["required"]) <= set(values)
            found.setdefault(channel.topic, []).append((message.log_time, values))
    return found


def at_ns(recording: Recording, time_s: float) -> int:
    return round(time_s * 1e9) + round(recording.wall_offset_s * 1e9)


def test_another_program_reads_the_session(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    export(recording.entry, path, is_table=False)
    assert path.read_bytes() == recording.entry.path.read_bytes()
    found = messages(path)
    assert set(found) == {"/status", "/events", "/progress", "/line/rx", "/line/tx"}
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    at = [time_ns for time_ns, _ in found["/status"]]
    assert np.diff(at).min() >= 0.9e8 or found["/status"][-1][1]["triggered"]
    assert 30 <= len(at) <= 33, "three seconds, ten a second, and the trigger"
    for time_ns, values in found["/status"]:
        row = int(np.argmin(np.abs(excerpt.tilt.time_s - (time_ns / 1e9 - recording.wall_offset_s))))
        assert (values["tilt_deg"], values["triggered"]) == (excerpt.tilt.value[row], bool(excerpt.is_triggered[row]))
    assert found["/events"][0] == (round(NOON.timestamp() * 1e9), {"event": "connected", "port": PORT})
    events = [values for _, values in found["/events"]]
    assert [one["event"] for one in events if "port" in one] == ["connected", "activated", "triggered", "port lost"]
    assert {"event": "reading", "cell_voltage_v": 3.01} in events
    assert (at_ns(recording, 1003.7), {"event": "reading", "light_v": 2.5}) in found["/events"]
    assert [(one["fires_deg"], one["rearms_deg"], one["free_fall_g"], one["free_fall_s"])
            for one in events if one["event"] == "limits"] == [
        (60.0, 50.0, None, None), (45.0, 35.0, 0.3, 1.6), (None,) * 4
    ]  # fmt: skip
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        about, end = reader.iter_metadata()
    assert summary is not None
    assert summary.statistics is not None
    assert {one.topic for one in summary.channels.values()} == set(CHANNELS.values())
    assert (about.metadata["module"], about.metadata["port"]) == ("Bench 7", PORT)
    assert end.name == "dps-s end"


def test_what_changes_the_module_is_an_event(tmp_path: Path) -> None:
    request = BY_NAME["freefall_time"].set(1.2)
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, events=(asked(1000.0), Sent(request.encode(), request, 1, 1000.0))))
        bench.finish()
        events = [values for _, values in messages(bench.path)["/events"]]
    assert {"event": "sent", "command": "freefall_time", "set_s": 1.2} in events
    assert not [one for one in events if one.get("command") == "status"]


def test_csv_holds_every_value(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    count = export(recording.entry, path, is_table=True).rows
    text = path.read_bytes().decode("utf-8-sig")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert text.splitlines()[0] == HEAD
    assert count == len(rows) == 1201 + 3 + 4 + 4
    reports = [row for row in rows if row["tilt_deg"]]
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    assert [float(row["tilt_deg"]) for row in reports] == excerpt.tilt.value.tolist()
    assert [float(row["acceleration_g"]) for row in reports] == pytest.approx(excerpt.acceleration.value.tolist())
    assert [float(row["elapsed_s"]) for row in reports] == pytest.approx(
        (excerpt.tilt.time_s - 1000.0).tolist(), abs=6e-4
    )
    assert [datetime.fromisoformat(row["time_utc"] + "+00:00").timestamp() for row in reports[:3]] == pytest.approx(
        [NOON.timestamp() + n / 400 for n in range(3)], abs=6e-4
    )
    assert (reports[-1]["triggered"], reports[-1]["active"]) == ("true", "true")
    assert [row["event"] for row in rows if row["event"]] == [
        f"connected: {PORT}", "activated", "triggered", f"port lost: {PORT}"
    ]  # fmt: skip
    assert [row["cell_voltage_v"] for row in rows if row["cell_voltage_v"]] == ["3.00", "3.01", "3.02"]


@pytest.mark.parametrize("is_table", [True, False])
def test_progress_goes_to_the_end(recording: Recording, tmp_path: Path, is_table: bool) -> None:
    shares: list[float] = []
    export(recording.entry, tmp_path / "x", is_table=is_table, on_progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(("is_table", "looks"), [(True, 0), (True, 1), (False, 0), (False, 1)])
def test_a_cancelled_export_leaves_the_file_unchanged(
    recording: Recording, tmp_path: Path, is_table: bool, looks: int
) -> None:
    path = tmp_path / "out" / "x"
    path.parent.mkdir()
    path.write_text("before", encoding="utf-8")
    shares: list[float] = []

    def go_on(share: float) -> None:
        if len(shares) == looks:
            raise ExportCancelled
        shares.append(share)

    with pytest.raises(ExportCancelled):
        export(recording.entry, path, is_table=is_table, on_progress=go_on)
    assert path.read_text(encoding="utf-8") == "before"
    assert [one.name for one in path.parent.iterdir()] == ["x"]


@pytest.mark.parametrize("is_table", [True, False])
def test_a_folder_that_is_not_there(recording: Recording, tmp_path: Path, is_table: bool) -> None:
    with pytest.raises(OSError):
        export(recording.entry, tmp_path / "nowhere" / "x", is_table=is_table)
