""" "Would it have fired?" on Live and "Try on recorded data" in Settings: the thresholds are tried on Logs."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.flights.judge import TriggerLimits
from app.flights.thresholds import FlightGroup
from app.settings.form import RowState
from protocol.catalogue import SERIAL_OUTPUT, Hazard, Request
from tests.support.line.frames import at_each_frame
from tests.support.window.fakes_ui import WAIT_MS, connect, page_entries, simulated, window
from tests.support.window.steps import await_child, find, given, notice_text
from ui.pages.live.page import LivePage
from ui.pages.logs.page import LogsPage
from ui.pages.logs.work import LogRow
from ui.pages.settings.page import SettingsPage


def tried(qtbot: QtBot, logs: LogsPage, path: Path) -> LogRow:
    """The row of this recording, once it is read."""
    qtbot.waitUntil(logs.isVisible)
    qtbot.waitUntil(lambda: not logs.work.is_loading and not logs.work.logs[str(path)].is_waiting)
    (row,) = logs.table.chosen()
    assert row.name == str(path)
    return row


def test_the_session_is_tried_with_the_modules_thresholds(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with (
        simulated("session", active=True) as bench,
        window(qapp, tmp_path, entries=page_entries("live", "logs")) as assembly,
    ):
        live = await_child(qtbot, assembly.window, LivePage)
        logs = await_child(qtbot, assembly.window, LogsPage)
        live.refresh()
        assert not live.try_out.isEnabled()
        connect(qtbot, assembly, "sim://session")
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        bench.set_world(tilt_deg=57)
        qtbot.waitUntil(lambda: port.module.view.fresh("tilt_deg", assembly.ports.clock()) == 57, timeout=WAIT_MS)
        qtbot.waitUntil(live.try_out.isEnabled, timeout=WAIT_MS)
        path = given(port.recording.path)
        assembly.window.activateWindow()  # else no key is a shortcut
        qtbot.waitUntil(assembly.window.isActiveWindow)
        qtbot.keyClick(live, Qt.Key.Key_T, Qt.KeyboardModifier.ControlModifier)
        row = tried(qtbot, logs, path)
        assert logs.work.limits == TriggerLimits(60, 0.5, 1.6)
        assert not given(row.outcome).direct.sources
        assert logs.work.kept == ()
        logs.work.move([row.name], FlightGroup.MUST)
        assert logs.work.kept == (f"MUST {path}",)
        bench.set_world(tilt_deg=80)
        qtbot.waitUntil(lambda: port.module.view.fresh("tilt_deg", assembly.ports.clock()) == 80, timeout=WAIT_MS)
        assembly.window.go_to("live")
        live.try_out.click()
        again = tried(qtbot, logs, path)  # it has grown
        assert given(again.outcome).direct.sources
        assert again.group is FlightGroup.MUST
        port.disconnect_port()


def test_what_is_not_known_of_the_module_is_said_until_a_person_chooses(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=page_entries("logs")) as assembly:
        logs = await_child(qtbot, assembly.window, LogsPage)
        assembly.window.go_to("logs")
        values = {"attitude_threshold_deg": 50, "freefall_acceleration_g": 0.4}
        logs._services.exchange.tried.emit(values, None, bool)
        assert logs.work.limits == TriggerLimits(50, 0.4, 1.6)
        assert notice_text(logs.strip) == "Vendor defaults, not of a module: Free-fall time."
        logs.thresholds.tilt.turned.emit(51)
        assert notice_text(logs.strip) == ""  # they are the person's own now


def test_edits_of_settings_are_tried_and_come_back_without_being_sent(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("fired") as bench, window(qapp, tmp_path, entries=page_entries("settings", "logs")) as assembly:
        requests: list[Request] = []
        at_each_frame(bench, requests.append)
        with qtbot.waitSignal(assembly.window.pages_made):
            pass
        connect(qtbot, assembly, "sim://fired")
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        settings, logs = find(assembly.window, SettingsPage), find(assembly.window, LogsPage)
        settings.work.choose("attitude_threshold_deg", 70)
        settings.work.choose("freefall_trigger", False)
        find(settings, QAction, "settings_try").trigger()
        qtbot.waitUntil(logs.isVisible)
        assert logs.work.limits == TriggerLimits(70, 0.5, 1.6)
        qtbot.waitUntil(lambda: notice_text(logs.strip) == "Judged as enabled: Free-fall trigger.")
        logs.work.choose(logs.work.limits._replace(attitude_threshold_deg=71))
        logs.proposal._use()
        qtbot.waitUntil(settings.isVisible)
        rows = {row.command.key: row for row in settings.work.rows}
        row = rows["attitude_threshold_deg"]
        assert (row.state, row.edited) == (RowState.EDITED, 71)
        changes = [one for one in requests if one.hazard is not Hazard.NONE]
        assert {one.command for one in changes} <= {SERIAL_OUTPUT}
        settings.work.revert()
        port.disconnect_port()
