"""The Live page's memory and its files, without a window: series, limits, marks, CSV, writing."""

import csv
import io
from datetime import UTC, datetime
from typing import Any

import pytest

from app.engine.conversation import ConversationView
from app.engine.worker import Batch
from app.limits.limits import LimitsInUse
from app.recordings.excerpt import ACTIVE, HEAD, TRIGGERED, csv_parts
from app.samples.samples import Series
from protocol.events import Began, Ended, EndReason
from tests.support.records.recordings_made import OPEN, batch, report, talk
from tests.support.window.steps import given
from ui.pages.live.data import LiveData
from ui.plots.lanes import Mark, measured_lanes

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
    assert (recording.flags & ACTIVE != 0).tolist() == [sample.active for sample in samples]
    assert (recording.flags & TRIGGERED != 0).tolist() == [sample.triggered for sample in samples]
    assert recording.is_whole


def test_voltage_and_light_are_kept_once_for_each_reading() -> None:
    data = LiveData()
    one, other = talk(1.0, cell_voltage_v=3.9, light_v=0.3), talk(2.0, cell_voltage_v=3.92, light_v=0.3)
    take(data, batch(1.0, view=one), batch(1.02, view=one), batch(2.0, view=other), batch(3.0, view=over(other)))
    assert [round(value, 2) for value in data.cell.window(0, 9).value.tolist()] == [3.9, 3.92]
    assert len(data.light) == 2


def test_another_module_starts_over() -> None:
    data = LiveData()
    view = talk(1.0, attitude_threshold_deg=60, cell_voltage_v=3.9)
    take(data, batch(1.0, report(1.0, active=True), view=view))
    data.reset()
    assert not data.has_samples
    assert (len(data.tilt), len(data.cell), list(data.markers)) == (0, 0, [])
    assert data.acting.fires.between(0.0, 9.0) == []
    # What was of the old one is no change of the new one, nor is its time a bound.
    assert take(data, batch(0.5, report(0.5, active=False), view=over(view))) == []
    assert data.excerpt(0.0, 9.0).tilt.time_s.tolist() == [0.5]
    assert len(data.cell) == 0


# Limits


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
    drawn = measured_lanes(data, LimitsInUse(), data.acting, data.unproven)
    assert tuple(lane.limits[0].steps.value for lane in drawn[:2]) == acting
    assert (
        tuple(given(next(limit for limit in lane.limits if limit.is_stale)).steps.value for lane in drawn[:2])
        == unproven
    )


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
    assert (data.acting.at().fires_deg, data.acting.fires.value) == (None, None)
    rows = rows_of(b"".join(csv_parts(data.excerpt(0.9, 5.0), wall_offset_s=NOON)))
    assert [row["tilt_deg"] or row["event"] for row in rows] == [
        "3",
        f"connected: {OPEN.port}",
        word,
        "40",
        "answers again",
    ]


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


def test_a_span_with_dropped_samples_is_marked() -> None:
    data = LiveData()
    data.tilt, data.acceleration, data._flags = (Series(100) for _ in range(3))
    data.on_batch(batch(20.0, *(report(n / 10) for n in range(200))))
    assert not data.excerpt(0.0, 20.0).is_whole
    assert data.excerpt(15.0, 20.0).is_whole


# Writing
