"""The Live page's memory and its files, without a window: series, limits, marks, CSV, writing."""

import csv
import io
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.engine.conversation import ConversationView
from app.engine.worker import Batch, PortState
from app.limits.out_of_limits import LimitsInUse
from app.recordings.excerpt import HEAD, csv_parts, part_count, time_cells
from app.recordings.export import write_parts
from app.recordings.markers import Marker, MarkerKind
from app.samples.ring_buffers import Series
from protocol.events import Began, Ended, EndReason
from tests.support.records.recordings_made import LOST, OPEN, batch, report, talk
from tests.support.window.steps import given
from ui.pages.live.data import LiveData, live_lanes
from ui.plots.lanes import Mark

NOON = datetime(2026, 3, 1, 12, 0, 0).astimezone().timestamp()


def over(view: ConversationView, reason: EndReason = EndReason.SILENT) -> ConversationView:
    return view._replace(ended=Ended(reason, 9.0))


def take(data: LiveData, *batches: Batch) -> list[tuple[float, str]]:
    """When and what all these batches mark."""
    marks: list[Mark] = [mark for one in batches for mark in data.on_batch(one)]
    return [(mark.time_s, mark.word) for mark in marks]


# Samples


def test_every_sample_is_kept_with_its_flags() -> None:
    data = LiveData()
    samples = tuple(report(n / 1440, n % 90, active=n >= 700, triggered=n % 7 == 0) for n in range(1440))
    for first in range(0, 1440, 24):
        data.on_batch(batch(1.0, *samples[first : first + 24]))
    recording = data.excerpt(0.0, 1.0)
    assert recording.tilt.time_s.tolist() == [sample.at for sample in samples]
    assert recording.tilt.value.tolist() == [sample.tilt_deg for sample in samples]
    assert recording.is_active.tolist() == [sample.active for sample in samples]
    assert recording.is_triggered.tolist() == [sample.triggered for sample in samples]
    assert recording.is_whole


def test_a_recording_does_not_change_with_what_comes_later() -> None:
    data = LiveData()
    take(data, batch(1.0, report(1.0, 3)))
    recording = data.excerpt(0.0, 9.0)
    data.reset()
    take(data, batch(2.0, report(2.0, 50)))
    assert recording.tilt.value.tolist() == [3.0]


def test_voltage_and_light_are_kept_once_for_each_reading() -> None:
    data = LiveData()
    one, other = talk(1.0, cell_voltage_v=3.9, light_v=0.3), talk(2.0, cell_voltage_v=3.92, light_v=0.3)
    take(data, batch(1.0, view=one), batch(1.02, view=one), batch(2.0, view=other), batch(3.0, view=over(other)))
    assert [round(value, 2) for value in data.cell.window(0, 9).value.tolist()] == [3.9, 3.92]
    assert len(data.light) == 2


def test_the_rate_counts_reports_streamed_or_polled() -> None:
    data = LiveData()
    take(data, batch(2.0, *(report(n / 10) for n in range(21))))
    assert data.reports_per_s(2.0) == pytest.approx(10, abs=0.6)
    assert data.reports_per_s(9.0) == 0


def test_another_module_starts_over() -> None:
    data = LiveData()
    view = talk(1.0, attitude_threshold_deg=60, cell_voltage_v=3.9)
    take(data, batch(1.0, report(1.0, active=True), view=view))
    data.reset()
    assert not data.has_samples
    assert (len(data.tilt), len(data.cell), list(data.markers)) == (0, 0, [])
    assert data.fires.between(0.0, 9.0) == []
    # What was of the old one is no change of the new one, nor is its time a bound.
    assert take(data, batch(0.5, report(0.5, active=False), view=over(view))) == []
    assert data.excerpt(0.0, 9.0).tilt.time_s.tolist() == [0.5]
    assert len(data.cell) == 0


# Limits


def test_a_limit_is_never_a_default() -> None:
    data = LiveData()
    take(data, batch(1.0, report(1.0)))
    assert (data.fires.value, data.rearms.value, data.falls.value) == (None, None, None)


def test_limits_follow_the_settings_until_they_are_stale() -> None:
    data = LiveData()
    sixty = talk(0.0, attitude_threshold_deg=60, freefall_acceleration_g=0.5)
    take(data, batch(1.0, view=sixty), batch(2.0, view=talk(0.0, attitude_threshold_deg=70)), batch(3.0, view=sixty))
    assert [change.value for change in data.fires.between(0, 9)] == [60, 70, 60]
    assert [change.value for change in data.rearms.between(0, 9)] == [50, 60, 50]
    assert [change.value for change in data.falls.between(0, 9)] == [0.5, None, 0.5]
    take(data, batch(4.0, view=over(sixty)))
    assert (data.fires.value, data.falls.value) == (None, None)


def test_a_trigger_that_is_switched_off_has_no_limit() -> None:
    data = LiveData()
    off = talk(
        0.0, attitude_threshold_deg=60, attitude_trigger=False, freefall_acceleration_g=0.5, freefall_trigger=True
    )
    take(data, batch(1.0, view=off))
    assert (data.fires.value, data.falls.value) == (None, 0.5)


ON: dict[str, Any] = {"attitude_trigger": True, "freefall_trigger": True}
VALUES: dict[str, Any] = {"attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5}


@pytest.mark.parametrize(
    ("flags", "acting", "unproven"),
    [
        (ON, (60, 0.5), (None, None)),
        ({}, (None, None), (60, 0.5)),
        (ON | {"attitude_trigger": False}, (None, 0.5), (None, None)),
        ({"freefall_trigger": False}, (None, None), (60, None)),
    ],
)
def test_a_limit_acts_only_where_its_trigger_is_known_to_be_on(
    flags: dict[str, Any], acting: tuple[float | None, ...], unproven: tuple[float | None, ...]
) -> None:
    """ "60° fires" was drawn with unknown flags."""
    data = LiveData()
    take(data, batch(1.0, view=talk(0.0, **VALUES, **flags)))
    drawn = live_lanes(data, LimitsInUse())
    assert tuple(lane.limits[0].steps.value for lane in drawn[:2]) == acting
    assert tuple(given(lane.limits[0].stale).value for lane in drawn[:2]) == unproven


def test_when_the_conversation_is_over_no_limit_acts() -> None:
    data = LiveData()
    view = talk(0.0, **VALUES, **ON)
    take(data, batch(1.0, view=view), batch(2.0, view=over(view)))
    tilt = live_lanes(data, LimitsInUse())[0].limits[0]
    assert (tilt.steps.value, given(tilt.stale).value) == (None, 60)


def test_the_lanes_show_these_series() -> None:
    data = LiveData()
    assert [lane.series for lane in live_lanes(data, LimitsInUse())] == [
        data.tilt, data.acceleration, data.light, data.cell,
    ]  # fmt: skip


# Marks


def test_the_first_known_state_makes_no_mark() -> None:
    assert take(LiveData(), batch(1.0, report(1.0, active=True, triggered=True))) == []


def test_each_change_is_marked_where_it_was_seen() -> None:
    data = LiveData()
    marks = take(
        data,
        batch(1.0, report(0.9)),
        batch(2.0, report(1.9), report(2.0, active=True)),
        batch(3.0, report(2.5, active=True, triggered=True), report(3.0, active=True)),
        batch(4.0, report(4.0)),
    )
    assert marks == [(2.0, "activated"), (2.5, "triggered"), (3.0, "trigger ended"), (4.0, "locked")]


@pytest.mark.parametrize(
    ("reason", "word"),
    [
        (EndReason.RESTARTED, "restarted"),
        (EndReason.SILENT, "silent"),
        (EndReason.CONTRADICTED, "two modules?"),
        (EndReason.ANOTHER, "another module"),
    ],
)
def test_the_end_of_a_conversation_is_a_mark_behind_which_nothing_of_it_holds(reason: EndReason, word: str) -> None:
    data = LiveData()
    first, second = talk(0.5, **VALUES), talk(4.0, number=2)
    marks = take(
        data,
        batch(1.0, report(1.0, 3, active=True), view=first),
        batch(2.0, view=first._replace(ended=Ended(reason, 2.0)), events=(Ended(reason, 2.0),)),
        batch(4.0, report(4.0, 40), view=second, events=(Began(8, 4.0),)),
    )
    # The next one may be another module: that it is locked is no news.
    assert marks == [(2.0, word), (4.0, "answers again")]
    assert (data.at().fires_deg, data.acting.fires.value) == (None, None)
    rows = rows_of(b"".join(csv_parts(data.excerpt(0.9, 5.0), wall_offset_s=NOON)))
    assert [row["tilt_deg"] or row["event"] for row in rows] == [
        "3",
        f"connected: {OPEN.port}",
        word,
        "40",
        "answers again",
    ]


@pytest.mark.parametrize("port", [OPEN.port, "/dev/ttyUSB1"])
def test_a_lost_port_and_its_return_are_marked(port: str) -> None:
    data, back = LiveData(), OPEN._replace(port=port)
    marks = take(data, batch(1.0), batch(2.0, connection=LOST, view=over(talk(0.0))), batch(5.0, connection=back))
    assert marks == [(2.0, "port lost"), (5.0, "connected")]


def test_a_port_that_does_not_open_is_not_called_lost() -> None:
    opening = OPEN._replace(state=PortState.OPENING)
    assert take(LiveData(), batch(1.0, connection=opening), batch(2.0, connection=LOST)) == []


def test_the_charger_is_marked_when_it_comes_and_goes() -> None:
    data = LiveData()
    times = (1.0, 1.5, 2.0, 2.5, 3.0)
    assert take(data, *(batch(at, view=talk(at, charging=2.0 <= at < 3.0)) for at in times)) == [
        (2.0, "charger connected"),
        (3.0, "charger removed"),
    ]


# CSV


def rows_of(raw: bytes) -> list[dict[str, str]]:
    assert raw.startswith(HEAD.encode())  # no byte-order mark, which would become part of the first name
    return list(csv.DictReader(io.StringIO(raw.decode(), newline="")))


def filled() -> LiveData:
    data = LiveData()
    take(
        data,
        batch(0.5),
        batch(1.0, report(1.0, 3), view=talk(1.1, cell_voltage_v=3.94, light_v=0.3, charging=True)),
        batch(2.0, report(1.5, 61, active=True), report(2.0, 62, triggered=True, active=True)),
    )
    return data


def test_csv_holds_exactly_what_is_in_the_span() -> None:
    recording = filled().excerpt(1.0, 1.9)
    rows = rows_of(b"".join(csv_parts(recording, wall_offset_s=NOON)))
    noon = f"{datetime.fromtimestamp(NOON, UTC):%Y-%m-%d %H:%M:}"
    assert [tuple(row.values()) for row in rows] == [
        (f"{noon}01.000", "0.000", "3", "0.3", "false", "false", "", "", "", ""),
        (f"{noon}01.100", "0.100", "", "", "", "", "true", "", "0.3", ""),
        (f"{noon}01.100", "0.100", "", "", "", "", "true", "3.94", "", ""),
        (f"{noon}01.500", "0.500", "61", "0.9", "false", "true", "true", "", "", ""),
        (f"{noon}01.500", "0.500", "", "", "", "", "true", "", "", "activated"),
    ]
    assert datetime.fromisoformat(rows[0]["time_utc"] + "+00:00").timestamp() == pytest.approx(NOON + 1)


def test_csv_names_the_port_and_quotes_what_needs_it() -> None:
    data = filled()
    data.markers.append(Marker(1.2, MarkerKind.PORT_LOST, 'socket://a,"b"'))
    rows = rows_of(b"".join(csv_parts(data.excerpt(0.0, 9.0), wall_offset_s=NOON)))
    assert [row["event"] for row in rows if row["event"]] == [
        "connected: /dev/ttyUSB0",
        'port lost: socket://a,"b"',
        "activated",
        "triggered",
    ]
    assert len(rows) == data.excerpt(0.0, 9.0).row_count


def test_csv_of_many_rows_has_the_announced_number_of_parts() -> None:
    data = LiveData()
    data.on_batch(batch(20.0, *(report(n / 1000) for n in range(12_000))))
    recording = data.excerpt(0.0, 20.0)
    parts = list(csv_parts(recording, wall_offset_s=NOON))
    assert len(parts) == part_count(recording)
    rows = rows_of(b"".join(parts))
    assert len(rows) == 12_000 + 1  # the connection is a row
    assert rows[-1]["elapsed_s"] == "20.000"


def test_csv_counts_from_its_first_row() -> None:
    rows = rows_of(b"".join(csv_parts(filled().excerpt(-60.0, 9.0), wall_offset_s=NOON)))
    assert [row["elapsed_s"] for row in rows][:2] == ["0.000", "0.500"]


def test_time_stamps_round_up_to_the_next_second() -> None:
    assert time_cells(np.array([NOON + 0.9996])) == ["2026-03-01 12:00:01.000"]


def test_a_span_with_dropped_samples_is_marked() -> None:
    data = LiveData()
    data.tilt, data.acceleration, data._flags = (Series(100) for _ in range(3))
    data.on_batch(batch(20.0, *(report(n / 10) for n in range(200))))
    assert not data.excerpt(0.0, 20.0).is_whole
    assert data.excerpt(15.0, 20.0).is_whole


# Writing


def test_files_are_replaced_atomically(tmp_path: Path) -> None:
    path = tmp_path / "values.csv"
    path.write_bytes(b"before")

    def broken() -> Iterator[bytes]:
        yield b"half"
        assert path.read_bytes() == b"before"
        raise OSError("the disk is full")

    with pytest.raises(OSError, match="full"):
        write_parts(path, broken(), 2)
    assert (path.read_bytes(), names_in(tmp_path)) == (b"before", ["values.csv"])
    write_parts(path, [b"whole ", b"file"], 2)
    assert (path.read_bytes(), names_in(tmp_path)) == (b"whole file", ["values.csv"])


def test_saving_can_be_cancelled(tmp_path: Path) -> None:
    told: list[float] = []

    def go_on(share: float) -> None:
        if len(told) > 2:
            raise TimeoutError
        told.append(share)

    with pytest.raises(TimeoutError):
        write_parts(tmp_path / "values.csv", repeat(b"x"), 100, go_on)
    assert told == [0.0, 0.01, 0.02]
    assert names_in(tmp_path) == []


def names_in(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()]
