"""The Live page's memory, without a window: series, limits, marks, and the table of a span."""

import csv
import io
from datetime import UTC, datetime
from typing import Any

import pytest

from app.engine.conversation import ConversationView
from app.engine.worker import Batch
from app.limits.limits import LimitsInUse
from app.recordings.excerpt import ACTIVE, TRIGGERED, csv_parts
from app.samples.samples import Series
from protocol.events import Began, Ended, EndReason
from tests.support.records.recordings_made import batch, report, talk
from ui.pages.live.data import LiveData
from ui.plots.lanes import measured_lanes

NOON = datetime(2026, 3, 1, 12, 0, 0).astimezone().timestamp()
ON: dict[str, Any] = {"attitude_trigger": True, "freefall_trigger": True}
VALUES: dict[str, Any] = {"attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5}


def over(view: ConversationView, reason: EndReason = EndReason.SILENT) -> ConversationView:
    return view._replace(ended=Ended(reason, 9.0))


def take(data: LiveData, *batches: Batch) -> list[tuple[float, str]]:
    """When and what all these batches mark."""
    return [(mark.time_s, mark.word) for one in batches for mark in data.on_batch(one)]


def test_every_sample_is_kept_with_its_flags() -> None:
    data = LiveData()
    samples = tuple(report(n / 1440, n % 90, active=n >= 700, triggered=n % 7 == 0) for n in range(1440))
    for first in range(0, 1440, 24):
        data.on_batch(batch(1.0, *samples[first : first + 24]))
    span = data.excerpt(0.0, 1.0)
    columns = (span.tilt.time_s, span.tilt.value, span.flags & TRIGGERED != 0, span.flags & ACTIVE != 0)
    kept = list(zip(*(column.tolist() for column in columns), strict=True))
    assert kept == [(one.at, one.tilt_deg, one.triggered, one.active) for one in samples]
    assert span.is_whole


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
    assert (data.has_samples, len(data.tilt), len(data.cell), list(data.markers)) == (False, 0, 0, [])
    assert data.unproven.fires.between(0.0, 9.0) == []
    # What was of the old one is no change of the new one, nor is its time a bound.
    assert take(data, batch(0.5, report(0.5, active=False), view=over(view))) == []
    assert (data.excerpt(0.0, 9.0).tilt.time_s.tolist(), len(data.cell)) == ([0.5], 0)


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
    lanes = measured_lanes(data, LimitsInUse(), data.acting, data.unproven)[:2]
    for is_stale, expected in ((False, acting), (True, unproven)):
        drawn = [next(limit for limit in lane.limits if limit.is_stale is is_stale) for lane in lanes]
        assert tuple(limit.steps.value for limit in drawn) == expected


def test_each_change_is_marked_where_it_was_seen_and_the_first_known_state_is_none() -> None:
    data = LiveData()
    marks = take(
        data,
        batch(1.0, report(0.9, triggered=True)),
        batch(2.0, report(1.9, triggered=True), report(2.0, active=True, triggered=True)),
        batch(3.0, report(2.5, active=True), report(3.0, active=True, triggered=True)),
        batch(4.0, report(4.0, triggered=True)),
    )
    assert marks == [(2.0, "activated"), (2.5, "trigger ended"), (3.0, "triggered"), (4.0, "locked")]


@pytest.mark.parametrize(
    ("reason", "word"), [(EndReason.RESTARTED, "restarted"), (EndReason.CONTRADICTED, "two modules?")]
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
    assert (data.acting.fires.value, data.unproven.fires.value) == (None, None)


def test_the_table_holds_exactly_what_is_in_the_span() -> None:
    data = LiveData()
    take(
        data,
        batch(0.5),
        batch(1.0, report(1.0, 3), view=talk(1.1, cell_voltage_v=3.94, light_v=0.3, charging=True)),
        batch(2.0, report(1.5, 61, active=True), report(2.0, 62, triggered=True, active=True)),
    )
    text = b"".join(csv_parts(data.excerpt(1.0, 1.9), wall_offset_s=NOON)).decode()
    noon = f"{datetime.fromtimestamp(NOON, UTC):%Y-%m-%d %H:%M:}"
    assert list(csv.reader(io.StringIO(text, newline="")))[1:] == [
        [f"{noon}01.000", "0.000", "3", "0.3", "false", "false", "", "", "", ""],
        [f"{noon}01.100", "0.100", "", "", "", "", "true", "", "0.3", ""],
        [f"{noon}01.100", "0.100", "", "", "", "", "true", "3.94", "", ""],
        [f"{noon}01.500", "0.500", "61", "0.9", "false", "true", "true", "", "", ""],
        [f"{noon}01.500", "0.500", "", "", "", "", "true", "", "", "activated"],
    ]


def test_a_span_with_dropped_samples_is_marked() -> None:
    data = LiveData()
    data.tilt, data.acceleration, data._flags = (Series(100) for _ in range(3))
    data.on_batch(batch(20.0, *(report(n / 10) for n in range(200))))
    assert not data.excerpt(0.0, 20.0).is_whole
    assert data.excerpt(15.0, 20.0).is_whole
