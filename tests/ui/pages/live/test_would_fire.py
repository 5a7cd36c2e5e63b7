""" "Would it have fired?" on Live and "Try on recorded data" in Settings: the thresholds are tried on Flight logs."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import StatusSample
from app.flights.judge import TriggerLimits
from app.flights.thresholds import FlightGroup
from app.settings.form import RowState
from protocol.catalogue import SERIAL_OUTPUT, Hazard, Request
from tests.support.line.frames import at_each_frame
from tests.support.records.recordings_made import HEADING, batch, opened, recorder_in, talk
from tests.support.window.fakes_ui import WAIT_MS, connect, page_entries, simulated, window
from tests.support.window.steps import await_child, find, given, notice_text
from ui.pages.flights.controller import FlightRow
from ui.pages.flights.page import FlightsPage
from ui.pages.live.page import LivePage
from ui.pages.settings.page import SettingsPage


def tried(qtbot: QtBot, flights: FlightsPage, path: Path) -> FlightRow:
    """The row of this recording, once it is read."""
    qtbot.waitUntil(flights.isVisible)
    qtbot.waitUntil(lambda: not flights.work.task.is_running and not flights.work.flights[str(path)].is_waiting)
    (row,) = (row for part in flights.work.rows().values() for row in part if row.name == str(path))
    (chosen,) = (row for part in flights.lists.of.values() for row in part.table.chosen())
    assert chosen.name == str(path)
    return row


def test_the_session_is_tried_with_the_modules_thresholds(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with (
        simulated("session", active=True) as bench,
        window(qapp, tmp_path, entries=page_entries("live", "flights")) as assembly,
    ):
        live = await_child(qtbot, assembly.window, LivePage)
        flights = await_child(qtbot, assembly.window, FlightsPage)
        live.refresh()
        assert not live.try_out.isEnabled()
        connect(qtbot, assembly, "sim://session")
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        bench.set_world(tilt_deg=57)
        qtbot.waitUntil(lambda: port.module.view.fresh("tilt_deg", assembly.ports.clock()) == 57, timeout=WAIT_MS)
        qtbot.waitUntil(live.try_out.isEnabled, timeout=WAIT_MS)
        path = given(port.recording.path)
        qtbot.keyClick(live, Qt.Key.Key_T, Qt.KeyboardModifier.ControlModifier)
        row = tried(qtbot, flights, path)
        assert flights.work.limits == TriggerLimits(60, 0.5, 1.6)
        assert not given(row.outcome).direct.sources
        assert flights.work.kept_lists == ()
        flights.work.move([row.name], FlightGroup.MUST)
        assert flights.work.kept_lists == (f"MUST {path}",)
        bench.set_world(tilt_deg=80)
        qtbot.waitUntil(lambda: port.module.view.fresh("tilt_deg", assembly.ports.clock()) == 80, timeout=WAIT_MS)
        assembly.window.go_to("live")
        live.try_out.click()
        again = tried(qtbot, flights, path)  # it has grown
        assert given(again.outcome).direct.sources
        assert again.flight.group is FlightGroup.MUST
        port.disconnect_port()


def test_a_recording_is_tried_with_its_own_thresholds(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with recorder_in(tmp_path / "made") as bench:
        bench.recorder.begin(*HEADING)
        had = talk(1000.0, attitude_threshold_deg=50, freefall_acceleration_g=0.4)
        tilts = [0] * 50 + [55] * 10 + [0] * 50
        samples = [StatusSample(1000.0 + n / 50, tilt, 1.0, False, True) for n, tilt in enumerate(tilts)]
        bench.feed(batch(samples[-1].at, *samples, view=had))
        bench.finish()
        path = bench.path
    with window(qapp, tmp_path, entries=page_entries("live", "flights")) as assembly:
        live = await_child(qtbot, assembly.window, LivePage)
        flights = await_child(qtbot, assembly.window, FlightsPage)
        live.show_recording(opened(path))
        live.try_out.click()
        row = tried(qtbot, flights, path)
        assert flights.work.limits == TriggerLimits(50, 0.4, 1.6)  # the time is not in it: the vendor's default
        assert given(row.outcome).direct.sources
        qtbot.waitUntil(lambda: notice_text(flights.strip) == "Vendor defaults, not of a module: Free-fall time.")
        flights.thresholds.tilt.turned.emit(51)
        qtbot.waitUntil(lambda: notice_text(flights.strip) == "")  # they are the person's own now
        live.back_to_live()


def test_edits_of_settings_are_tried_and_come_back_without_being_sent(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("fired") as bench, window(qapp, tmp_path, entries=page_entries("settings", "flights")) as assembly:
        requests: list[Request] = []
        at_each_frame(bench, requests.append)
        with qtbot.waitSignal(assembly.window.pages_made):
            pass
        connect(qtbot, assembly, "sim://fired")
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        settings, flights = find(assembly.window, SettingsPage), find(assembly.window, FlightsPage)
        settings.work.choose("attitude_threshold_deg", 70)
        settings.work.choose("freefall_trigger", False)
        find(settings, QAction, "settings_try").trigger()
        qtbot.waitUntil(flights.isVisible)
        assert flights.work.limits == TriggerLimits(70, 0.5, 1.6)
        qtbot.waitUntil(lambda: notice_text(flights.strip) == "Judged as enabled: Free-fall trigger.")
        flights.work.choose(flights.work.limits._replace(attitude_threshold_deg=71))
        flights.proposal._use()
        qtbot.waitUntil(settings.isVisible)
        rows = {row.command.key: row for row in settings.work.rows}
        row = rows["attitude_threshold_deg"]
        assert (row.state, row.edited) == (RowState.EDITED, 71)
        changes = [one for one in requests if one.hazard is not Hazard.NONE]
        assert {one.command for one in changes} <= {SERIAL_OUTPUT}
        settings.work.revert()
        port.disconnect_port()


def test_how_it_is_judged_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=page_entries("flights")) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            pass
        find(assembly.window, FlightsPage)._explain()
        said = [part for part in qapp.topLevelWidgets() if part.isVisible() and part.inherits("QWhatsThat")]
        assert len(said) == 1
        said[0].close()
