"""A session is recorded and read back with every sample and byte."""

import json
import os
import re
import sys
import zlib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.data_stream import RecordBuilder
from mcap.records import Metadata
from mcap.writer import MCAP0_MAGIC

from app.engine.conversation import ConversationView, StatusSample
from app.recordings import session_file
from app.recordings.excerpt import ACTIVE, TRIGGERED
from app.recordings.markers import Marker, MarkerKind
from app.recordings.recorder import MAX_SESSION_S
from app.recordings.session_file import (
    EVENTS,
    OPENING,
    RX,
    STATUS,
    TX,
    Opening,
    SessionFile,
    metadata_record,
    read_head,
)
from app.text.messages import UserError
from protocol.events import Began, Ended, EndReason, Rejected
from protocol.messages import Direction, Noise, Reason
from tests.support.records.recordings_made import (
    LOST,
    NOON,
    PORT,
    asked,
    batch,
    directions,
    opened,
    received,
    recorded,
    recorder_in,
    report,
    stream,
    talk,
)

ROOT = Path(__file__).parents[3]


def test_every_sample_and_every_byte_comes_back(tmp_path: Path) -> None:
    batches = [batch(1000.0, events=(asked(1000.0),)), *stream(1000.0, 3.0)]
    samples = [sample for each in batches for sample in each.samples]
    recording = opened(recorded(tmp_path, 3.0))
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    assert excerpt.tilt.time_s.tolist() == pytest.approx([sample.at for sample in samples], abs=2e-9)
    assert excerpt.tilt.value.tolist() == [sample.tilt_deg for sample in samples]
    assert excerpt.acceleration.value.tolist() == np.array([sample.acceleration_g for sample in samples], "f4").tolist()
    assert not excerpt.flags.any()
    assert excerpt.cell.time_s.tolist() == [1000.0, 1001.0, 1002.0]
    assert excerpt.cell.value.tolist() == pytest.approx([3.0, 3.01, 3.02])
    assert excerpt.light.value.tolist() == pytest.approx([1.0, 1.1, 1.2])
    traffic = list(SessionFile(recording.entry.path).traffic())
    bytes_of = directions([(one.direction, one.raw) for one in traffic])
    assert bytes_of[Direction.HOST_TO_MODULE] == asked(1000.0).raw
    frames = [event.frame.raw for each in batches[1:] for event in each.events]  # type: ignore[union-attr]
    assert bytes_of[Direction.MODULE_TO_HOST] == b"".join(frames)
    assert [recording.opening.start_s + one.at_s for one in traffic] == pytest.approx(
        [1000.0, *(sample.at for sample in samples)], abs=1e-6
    )


# One opening of a port is one file


def began(at: float, *samples: StatusSample, number: int) -> Any:
    return batch(at, *samples, view=talk(at, number=number)._replace(began_at=at), events=(Began(7, at),))


def ended(at: float, reason: EndReason, number: int) -> Any:
    end = Ended(reason, at)
    return batch(at, view=talk(at, number=number)._replace(ended=end), events=(end,))


def test_each_break_is_a_mark_in_the_one_recording(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(
            began(1000.0, report(1000.0), number=1),
            batch(1001.0, report(1001.0, active=True), report(1001.5, active=True, triggered=True)),
            ended(1002.0, EndReason.RESTARTED, 1),
            began(1002.1, report(1002.1), number=2),
            ended(1003.0, EndReason.SILENT, 2),
            began(1010.0, report(1010.0, triggered=True), number=3),
            ended(1011.0, EndReason.ANOTHER, 3),
            batch(1011.5, events=(), connection=LOST),
            began(1013.0, report(1013.0, active=True), number=4),
            batch(1013.5, report(1013.5)),
            ended(1014.0, EndReason.CLOSED, 4),
        )
        bench.finish()
        (entry,) = bench.library.entries()
        assert entry.was_triggered
        reports = opened(entry.path).excerpt(1001.0, 1001.5)
        assert reports.flags.tolist() == [ACTIVE, ACTIVE | TRIGGERED]
        assert [(marker.kind.value, marker.time_s) for marker in opened(entry.path).markers] == [
            ("connected", 1000.0),
            ("activated", 1001.0),
            ("triggered", 1001.5),
            ("restarted", 1002.0),
            ("silent", 1003.0),
            ("triggered", 1010.0),
            ("another module", 1011.0),
            ("port lost", 1011.5),
            ("connected", 1013.0),
            ("activated", 1013.0),
            ("locked", 1013.5),
        ]


def test_a_port_that_is_lost_has_one_mark(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        lost = ended(1001.0, EndReason.PORT_LOST, 1)._replace(connection=LOST)
        bench.record(began(1000.0, report(1000.0), number=1), lost)
        bench.finish()
        marks = [(marker.kind, marker.text) for marker in opened(bench.path).markers]
    assert marks == [(MarkerKind.CONNECTED, PORT), (MarkerKind.PORT_LOST, PORT)]


def test_a_name_holds_from_the_beginning_of_its_conversation_to_its_end(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(began(1000.0, report(1000.0), number=1))
        bench.name("M-07")
        bench.feed(
            batch(1001.0, report(1001.0)),
            ended(1002.0, EndReason.SILENT, 1),
            began(1005.0, report(1005.0), number=2),
            batch(1006.0, report(1006.0)),
        )
        bench.recorder.name_module("M-08", ConversationView(number=2, began_at=1005.0))
        bench.feed(batch(1007.0, report(1007.0)))
        bench.finish()
        recording = opened(bench.path)
    assert recording.entry.modules == ("M-07", "M-08")
    assert Marker(1005.5, MarkerKind.NAMED, "M-08") in recording.excerpt(1005.5, 1007.0).markers
    assert not recording.excerpt(1003.0, 1004.0).markers


def test_limits_hold_until_they_change_or_the_conversation_ends(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(
            batch(1000.0, report(1000.0)),
            batch(1001.0, report(1001.0), view=talk(1001.0, attitude_threshold_deg=60)),
            batch(1002.0, report(1002.0), view=talk(1002.0, attitude_threshold_deg=45, freefall_acceleration_g=0.3)),
            batch(1003.0, report(1003.0), view=talk(1003.0, attitude_threshold_deg=45, attitude_trigger=False)),
            batch(1004.0, report(1004.0), view=talk(1004.0, attitude_threshold_deg=45)),
            ended(1005.0, EndReason.SILENT, 1),
        )
        bench.finish()
        recording = opened(bench.path)
    assert recording.fires.between(1000.5, 1009.0) == [(1001.0, 60.0), (1002.0, 45.0), (1003.0, None), (1004.0, 45.0),
                                                       (1005.0, None)]  # fmt: skip
    assert recording.rearms.between(1002.0, 1002.5) == [(1002.0, 35.0)]
    assert recording.falls.between(1002.5, 1009.0) == [(1002.0, 0.3), (1003.0, None)]
    assert recording.lights.value is None


def test_bytes_of_equal_times_stay_in_order_and_the_rate_is_that_of_the_port(tmp_path: Path) -> None:
    with recorder_in(tmp_path) as bench:
        bench.begin(PORT, 9600)
        samples = [report(1000.0 + n // 7 / 100, n) for n in range(100)]
        garbage = Rejected(Noise(b"\0\1", Reason.NO_HEADER, 0), 1000.0)
        bench.feed(batch(1000.0, events=(garbage,)), *(batch(sample.at, sample) for sample in samples))
        bench.finish()
        file = SessionFile(bench.path)
        traffic = list(file.traffic())
    assert file.opening.baud_rate == 9600
    frames = (received(sample).frame.raw for sample in samples)
    assert b"".join(one.raw for one in traffic) == b"".join((garbage.noise.raw, *frames))
    assert all(before.at_s < after.at_s for before, after in pairwise(traffic))


# Beginning and end


@pytest.mark.parametrize(("max_bytes", "max_unpacked_bytes"), [(300_000, 1 << 32), (1 << 32, 600_000)])
@pytest.mark.promise("f")
def test_a_session_that_is_too_large_goes_on_in_the_next_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, max_bytes: int, max_unpacked_bytes: int
) -> None:
    """For the library, or for what is read of one: at full line rate that is eight hours, which comes first."""
    monkeypatch.setattr(session_file, "MAX_UNPACKED_BYTES", max_unpacked_bytes)
    with recorder_in(tmp_path) as bench:
        bench.library.max_bytes = max_bytes
        bench.begin()
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
            assert recording.damage is None
            times += recording.tilt.window(0, 1e9).time_s.tolist()
            polled += recording.cell.window(0, 1e9).time_s.tolist()
            sent += sum(len(piece.raw) for piece in SessionFile(entry.path).traffic())
            assert recording.fires.between(0, 1e9)[0].value == 60.0, "each says what is in force"
        assert times == [sample.at for one in batches for sample in one.samples]
        assert sent == 8 * len(times)
        assert polled == np.arange(1000.0, 1060.0).tolist()


@pytest.mark.parametrize(("number", "module"), [(1, "Bench 9"), (2, "")])
def test_after_a_day_the_next_recording_begins_with_the_name_of_its_conversation(
    tmp_path: Path, number: int, module: str
) -> None:
    with recorder_in(tmp_path) as bench:
        bench.record(batch(1000.0, report(1000.0)))
        bench.name("Bench 9")
        bench.feed(batch(1001.0 + MAX_SESSION_S, report(1001.0 + MAX_SESSION_S)))
        later_s = 1002.0 + MAX_SESSION_S
        bench.feed(batch(later_s, report(later_s), view=talk(later_s, number=number)))
        found = [(entry.is_running, entry.sample_count, entry.module) for entry in bench.library.entries()]
        assert found == [(True, 1, module), (False, 2, "Bench 9")]


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are not bits on Windows")
def test_only_this_user_can_read_a_recording(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        folder = recorded(tmp_path / "shelf", 0.2)
    finally:
        os.umask(before)
    assert [one.stat().st_mode & 0o777 for one in (folder, folder.parent)] == [0o600, 0o700]


# What is no recording


def head_of(opening: Opening, **change: object) -> bytes:
    """A file with this opening, of which some fields have other values, and with the right checksum."""
    (text,) = re.findall(rb"\{.*\}", metadata_record(OPENING, opening))
    changed = json.dumps(json.loads(text) | change)
    builder = RecordBuilder()
    Metadata(OPENING, {"json": changed, "crc32": f"{zlib.crc32(changed.encode()):08x}"}).write(builder)
    raw: bytes = MCAP0_MAGIC + builder.end()
    return raw


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"version": 1}, "another version"),
        ({"start_s": float("nan")}, "damaged"),
        ({"started_at": "2026-11-21T12:00:00"}, "damaged"),
        ({"started_at": "0001-01-01T00:00:00+00:00"}, "damaged"),
    ],
)
def test_other_heads_are_refused_with_a_reason(tmp_path: Path, change: dict[str, object], why: str) -> None:
    opening = Opening(started_at=NOON, start_s=1000.0, port="/dev/tty\udc80", baud_rate=115200)
    path = tmp_path / "x.mcap"
    path.write_bytes(head_of(opening))
    assert read_head(path)[0] == opening
    path.write_bytes(head_of(opening, **change))
    with pytest.raises(UserError, match=why):
        read_head(path)


@pytest.mark.parametrize("raw", [b"", b"\x00" * 300, b"[1]", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" + b"\x06" * 99])
def test_a_file_of_anything_is_refused(tmp_path: Path, raw: bytes) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(raw)
    with pytest.raises(UserError, match="cannot be read"):
        opened(path)
    with pytest.raises(UserError, match="No such file"):
        opened(tmp_path / "y.mcap")


def test_the_example_for_other_programs_works(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "recording.md").read_text("utf-8")
    code = text.partition("```python\n")[2].partition("```")[0]
    path = recorded(tmp_path, 1.0)
    found: dict[str, object] = {}
    exec(code.replace("20261121T014905Z-00042.mcap", path.as_posix()), found)
    recording = opened(path)
    traffic = list(SessionFile(recording.entry.path).traffic())
    assert found["received"] == [
        (pytest.approx(recording.opening.started_at.timestamp() + one.at_s, abs=1e-6), one.raw)
        for one in traffic if one.direction is Direction.MODULE_TO_HOST
    ]  # fmt: skip
    for topic in (RX, TX, EVENTS, STATUS):
        assert f"`{topic}`" in text
