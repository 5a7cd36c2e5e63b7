"""The time of day of what the program's clock says."""

from datetime import UTC, datetime

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.support_bundle import Contents, bundle_files
from app.system.clock import steady_time, wall_offset_s
from tests.support.records.recordings_made import asked
from tests.support.window.live_bench import live_bench
from ui.pages.diagnosis.traffic import Column, TrafficModel
from ui.pages.live import page as live

HOUR_S = 3600.0


def test_what_came_an_hour_ago_came_an_hour_ago(qapp: QApplication) -> None:
    model = TrafficModel()
    event = asked(steady_time() - HOUR_S)
    model.append([event])
    model.show_new()
    capture = bundle_files(Contents(version="1", traffic=[event]))["capture.txt"]
    began = datetime.fromisoformat(capture.splitlines()[0].removeprefix("# started: "))
    assert abs((datetime.now(UTC) - began).total_seconds() - HOUR_S) < 2
    shown = model.index(0, Column.TIME.value).data()
    assert shown[:-4] in {f"{datetime.fromtimestamp(began.timestamp() + late_s):%H:%M:%S}" for late_s in (-1, 0, 1)}  # noqa: DTZ006


def test_the_live_page_follows_a_clock_that_is_set(
    qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    with live_bench(qtbot, qapp) as bench:
        bench.say()
        assert len(bench.page.data.tilt) == 1
        wrong_s = bench.page.plot.canvas.wall_offset_s
        assert abs(wrong_s - wall_offset_s()) < live.CLOCK_SET_S
        monkeypatch.setattr(live, "wall_offset_s", lambda: wrong_s + HOUR_S)
        bench.say()
        assert bench.page.plot.canvas.wall_offset_s == wrong_s + HOUR_S
        assert len(bench.page.data.tilt) == 2, "nothing is lost"
