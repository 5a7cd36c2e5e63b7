"""The Live page: what is fresh, stale and unknown, the time line, and what it does out of sight."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.procedures.light import LightDirection
from protocol.events import EndReason
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import await_child, given
from ui.pages.live.page import LivePage
from ui.style.theme import Meaning
from ui.widgets.readout import Freshness


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as bench:
        yield bench


def test_without_a_module_it_says_what_to_do(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=page_entries("live")) as assembly:
        panel = assembly.window.panel
        page = await_child(qtbot, assembly.window, LivePage)
        qtbot.waitUntil(panel.isVisible)
        qtbot.waitUntil(lambda: not page.choose.isVisible())  # the ports are at hand already
        panel.hide()
        qtbot.waitUntil(page.choose.isVisible)
        assert (page.is_empty, page.empty.text.text()) == (True, "Choose a port.")
        qtbot.mouseClick(page.choose, Qt.MouseButton.LeftButton)
        assert panel.isVisible()


def test_fresh_then_stale_with_its_age(live: Bench) -> None:
    live.say()
    panel = live.page.panel
    assert live.page.plot.isVisible()
    assert panel.tilt.accessibleName() == "Tilt: 12°, limit 60°, trigger not known"
    assert panel.light.accessibleName() == "Light: 0.3 V, limit 1.8 V, bay closed (assumed)"
    assert panel.cell.accessibleName() == "Cell voltage: 3.94 V, not charging"
    assert panel.stream.accessibleName() == "Reports: 50 /s, streamed"
    live.pass_time(3.0)
    assert panel.tilt.accessibleName() == "Tilt: 12°, limit 60°, 3 s ago"
    assert panel.gauge.freshness is Freshness.STALE
    assert panel.cell.freshness is Freshness.FRESH  # polled once a second
    live.pass_time(5.0)
    assert panel.cell.accessibleName() == "Cell voltage: 3.94 V, 8 s ago"
    assert panel.boot_count.freshness is Freshness.FRESH  # changes only by a restart


@pytest.mark.promise("a")
def test_values_are_greyed_when_the_conversation_ends_and_nowhere_in_the_next(live: Bench) -> None:
    live.say()
    panel = live.page.panel
    live.worker.end(EndReason.RESTARTED)
    live.qtbot.waitUntil(lambda: live.connector.module.end is not None)
    live.page.refresh()
    shown = (panel.tilt, panel.acceleration, panel.light, panel.cell, panel.boot_count)
    assert {readout.freshness for readout in shown} == {Freshness.STALE}
    assert panel.tilt.accessibleName().startswith("Tilt: 12°")
    live.worker.begin(cell_voltage_v=4.1)
    live.qtbot.waitUntil(lambda: live.connector.module.is_going)
    live.page.refresh()
    assert panel.cell.accessibleName().startswith("Cell voltage: 4.10 V")
    assert {readout.freshness for readout in shown if readout is not panel.cell} == {Freshness.UNKNOWN}
    names = [readout.accessibleName() for readout in shown] + [panel.gauge.accessibleName()]
    assert not [name for name in names for old in ("12°", "0.3 V", "3.94", "60°", "1.8 V") if old in name]


@pytest.mark.promise("g")
def test_what_is_never_reported_is_unknown_and_what_is_outside_its_limit_is_marked(live: Bench) -> None:
    panel = live.page.panel
    live.say(leave_out="cell_voltage_v")
    assert (panel.cell.accessibleName(), panel.cell.freshness) == ("Cell voltage: unknown", Freshness.UNKNOWN)
    live.say(leave_out="attitude_threshold_deg", tilt_deg=80)
    assert "fires" not in panel.gauge.accessibleName()
    assert panel.tilt.accessibleName() == "Tilt: 80°, trigger not known"  # 60° is only the vendor's default
    live.say(tilt_deg=80, cell_voltage_v=3.52, light_v=2.1, acceleration_g=0.1)
    assert panel.tilt.accessibleName() == "Tilt: 80°, limit 60°, over 60°"
    assert panel.cell.accessibleName() == "Cell voltage: 3.52 V, limit 3.80 V, low"
    assert panel.acceleration.accessibleName() == "Acceleration: 0.1 g, free fall"
    assert panel.cell.meaning is panel.light.meaning is Meaning.ATTENTION


def test_the_charger_the_triggers_and_the_reports_are_noted(live: Bench) -> None:
    panel = live.page.panel
    live.say(charging=True)
    assert panel.cell.accessibleName().endswith(", charging")
    live.say(leave_out="charging")
    assert panel.cell.accessibleName().endswith(", charger unknown")
    for flag, says in ((None, "trigger not known"), (False, "trigger off"), (True, "limit 60°")):
        live.say() if flag is None else live.say(attitude_trigger=flag, freefall_trigger=flag)
        assert panel.tilt.accessibleName().endswith(says)
        assert ("trigger not known" in panel.gauge.accessibleName()) is (flag is None)
        assert ("trigger" in panel.acceleration.accessibleName()) is (flag is not True)
    live.pass_time(2.5)
    times = [live.now_s - 2 + n / 10 for n in range(1, 21)]
    live.say(*(StatusSample(at, 3, 1.0, False, False) for at in times), is_streaming=False)
    assert panel.stream.accessibleName() == "Reports: 10 /s, polled"
    live.pass_time(5.0)
    assert panel.stream.accessibleName() == "Reports: 0 /s, no stream"


def test_the_bay_is_assumed_until_it_was_measured_closed_and_open(live: Bench) -> None:
    for direction, light_v, says in (
        (None, 2.5, "bay open (assumed)"),
        (LightDirection.RISES, 0.3, "bay closed"),
        (LightDirection.RISES, 2.5, "bay open"),
        (LightDirection.FALLS, 0.3, "bay open"),
        (LightDirection.FALLS, 2.5, "bay closed"),
    ):
        live.say(light_v=light_v)
        live.connector.module.light_direction = direction
        live.say(light_v=light_v)
        assert live.page.panel.light.accessibleName() == f"Light: {light_v} V, limit 1.8 V, {says}"


def test_pause_holds_the_picture_and_nothing_is_lost(live: Bench) -> None:
    live.say()
    live.click("time-plot-pause")
    held = live.page.plot.time_range.span
    live.now_s += 5
    live.say(tilt_deg=44)
    assert live.page.plot.time_range.span == held
    assert given(live.page.data.tilt.last).value == 44
    live.qtbot.keyClick(live.page, Qt.Key.Key_P, Qt.KeyboardModifier.ControlModifier)
    assert live.page.plot.time_range.is_live
    assert live.page.plot.time_range.span.end_s == pytest.approx(live.now_s, abs=0.3)


def test_values_marks_and_pause_go_with_their_module(live: Bench) -> None:
    live.say()
    live.say(triggered=True)
    live.click("time-plot-pause")
    plot = live.page.plot
    assert plot.canvas.marks
    live.connector.choose(live.connector.add(live.ports.make))
    assert (list(plot.canvas.marks), plot.time_range.is_live) == ([], True)
    assert (live.page.is_empty, live.page.data.has_samples) == (True, False)


def test_a_hidden_page_records_but_does_not_draw(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "live", page_entries("live", "diagnosis")) as one:
        assembly, page = one.assembly, await_child(qtbot, one.root, LivePage)
        one.connect()
        one.until(lambda: not page.is_empty)
        assembly.window.go_to("diagnosis")
        qtbot.waitUntil(lambda: not page.isVisible())  # the other page may have to be made first
        span, count = page.plot.time_range.span, len(page.data.tilt)
        asked: list[Path] = []
        page.ask_path = lambda _parent, _title, path, _filter, _then: asked.append(path)
        qtbot.keyClick(assembly.window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
        assert asked == []  # the key belongs to the page in sight
        one.until(lambda: len(page.data.tilt) > count + 5)
        assert page.plot.time_range.span == span
        assembly.window.go_to("live")
        one.until(lambda: page.plot.time_range.span.end_s > span.end_s)
