"""The Settings page through real clicks and keys, against modules of every dialect: the frames are counted, and what
is called verified is what the module holds."""

import os
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QDoubleSpinBox, QLineEdit, QToolButton, QWidget
from pytestqt.qtbot import QtBot

from app.settings.form import RowState
from app.simulator.options import parse_options
from app.store.store import Store
from app.text.i18n import CHINESE
from protocol.link_states import Presence
from tests.support.records.kept_facts import kept_settings
from tests.support.window.settings_bench import Desk, choose, desk, notice, reason, state, type_into, write
from tests.support.window.steps import notice_text
from ui.style.theme import Meaning

TILT, TIME, LIGHT, FLAG = "attitude_threshold_deg", "freefall_time_s", "light_threshold_v", "attitude_trigger"


@pytest.mark.parametrize("options", [{}, {"ack": "one"}, {"freefall_ack": "17"}], ids=str)
def test_edit_write_and_verify(qtbot: QtBot, qapp: QApplication, tmp_path: Path, options: dict[str, Any]) -> None:
    query = "?" + "&".join(f"{key}={value}" for key, value in options.items())
    with desk(qtbot, qapp, tmp_path, query=query) as one:
        code = one.settings.code.text()
        type_into(one, "freefall_time", "1.2")
        type_into(one, "freefall_acceleration", "0.4")
        one.click(one.find(QToolButton, "freefall_trigger_on"))
        one.settings.refresh()
        assert one.settings.write.text() == "Write 3 changes"
        assert not one.changes()
        write(one)
        one.until(lambda: state(one, TIME) is RowState.VERIFIED)
        assert state(one, "freefall_acceleration_g") is RowState.VERIFIED
        assert state(one, "freefall_trigger") is RowState.ACKNOWLEDGED  # it cannot be read back: never "verified"
        assert (one.held("freefall_time"), one.held("freefall_acceleration")) == (1.2, 0.4)
        assert len(one.changes()) == 3
        assert notice(one) == "Read back as written: 2. Acknowledged, cannot be read: 1."
        assert one.settings.code.text() != code
        assert not one.settings.write.isEnabled()


@pytest.mark.parametrize(
    ("ways", "name", "key", "text", "stands", "why"),
    [
        ({"clamps": True}, "freefall_time", TIME, "0.3", 0.5, "holds another value"),
        ({"keeps": False}, "freefall_time", TIME, "1.2", 1.6, "not kept"),
        ({"refuses": True}, "attitude_threshold", TILT, "70", 60, "refused"),
    ],
)
def test_a_row_stays_failed_with_the_reason(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, ways: Any, name: str, key: str, text: str, stands: Any, why: str
) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.bench.change(**ways)
        type_into(one, name, text)
        write_anyway(one)
        one.until(lambda: state(one, key) is RowState.FAILED)
        assert why in reason(one, key)
        assert one.held(name) == stands
        assert one.settings.rows[key].state.meaning is Meaning.DANGER
        assert "NOT as set" in notice(one)
        one.click("settings_read")
        one.until(lambda: not one.settings.work.job.is_running)
        assert state(one, key) is RowState.FAILED
        one.bench.change(clamps=False, keeps=True, refuses=False)
        write_anyway(one)
        one.until(lambda: state(one, key) is RowState.VERIFIED)
        assert one.held(name) == float(text)


def write_anyway(one: Desk) -> None:
    """Write, with the second click that a warned value needs."""
    write(one)
    port = one.assembly.connector.current
    if any(change.risks for change in one.settings.work.form.changes(port.device, port.clock())):
        choose(one, "write_anyway")


BAD_LINES: tuple[dict[str, Any], ...] = (
    {"drop": 0.3, "direction": "both"},
    {"corrupt": 0.04, "direction": "both"},
    {"double": 0.5},
    {"delay_ms": 60, "jitter_ms": 120},
)
"""In real time; the writes themselves go through many more, with many seeds, on a fake clock in test_write.py."""
IS_THOROUGH = os.environ.get("HYPOTHESIS_PROFILE") == "thorough"
ON_BAD_LINES = [
    (faults, ack)
    for number, faults in enumerate(BAD_LINES)
    for ack in (("echo", "one") if IS_THOROUGH else (("echo", "one")[number % 2],))
    if IS_THOROUGH or number % 2
]


@pytest.mark.parametrize(("faults", "ack"), ON_BAD_LINES, ids=str)
def test_on_a_bad_line_verified_is_what_the_module_holds(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, faults: dict[str, Any], ack: str
) -> None:
    with desk(qtbot, qapp, tmp_path, query=f"?ack={ack}") as one:
        for number, text in enumerate(("1.2", "1.3", "1.4") if IS_THOROUGH else ("1.2", "1.3")):
            type_into(one, "freefall_time", text)
            one.bench.change(**parse_options({name: str(value) for name, value in faults.items()}))
            write(one)
            one.until(lambda: not one.settings.work.form.is_writing, 30_000)
            said = state(one, TIME)
            one.bench.end_faults()
            one.until(lambda: one.assembly.connector.current.device.presence is Presence.ONLINE)
            assert said in (RowState.VERIFIED, RowState.READ, RowState.FAILED, RowState.EDITED, RowState.STALE)
            if said in (RowState.VERIFIED, RowState.READ):
                assert one.held("freefall_time") == float(text)
                assert "red rows" not in notice(one)
            assert len(one.changes("freefall_time")) <= number + 1


def test_a_restart_in_the_middle_claims_nothing(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        type_into(one, "freefall_time", "1.2")
        one.bench.change(delay_ms=200.0)
        write(one)
        one.until(lambda: len(one.changes("freefall_time")) == 1)
        one.settings.refresh()
        assert (one.settings.write.text(), one.settings.write.isEnabled()) == ("Write 1 change", False)
        one.bench.restart()
        one.bench.end_faults()
        one.until(lambda: not one.settings.work.form.is_writing, 30_000)
        assert state(one, TIME) is not RowState.VERIFIED
        assert len(one.changes("freefall_time")) == 1


def test_invalid_values_cannot_be_written(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        type_into(one, "freefall_acceleration", "0.55")
        one.settings.refresh()
        assert "0.5 g and 0.6 g" in reason(one, "freefall_acceleration_g")
        assert not one.settings.write.isEnabled()
        assert one.settings.write.text() == "Invalid value"
        type_into(one, "freefall_time", "1.2")  # nothing is written while one of the values is invalid
        one.settings.refresh()
        assert (one.settings.write.text(), one.settings.write.isEnabled()) == ("Invalid value", False)
        type_into(one, "freefall_acceleration", "26")
        one.settings.refresh()
        assert "0.0 g to 25.5 g" in reason(one, "freefall_acceleration_g")
        one.qtbot.keyClick(one.settings, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
        assert not one.settings.work.job.is_running


def test_the_advice_begins_with_a_capital(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        said = {}
        for key in one.settings.rows:
            one.settings.choose(key)
            said[key] = one.settings.pane.advice.text()
    assert said[LIGHT].startswith("Advised: ")
    assert said[TILT].startswith("Default 60° · advised: ")


def test_against_the_advice_needs_a_second_click(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        type_into(one, "attitude_threshold", "40")
        write(one)
        assert "55° or more" in notice(one)
        write(one)  # the same button again is no second click
        one.qtbot.mouseDClick(one.settings.write, Qt.MouseButton.LeftButton)
        assert not one.settings.work.job.is_running
        qtbot.keyClick(one.settings, Qt.Key.Key_Escape)
        assert notice(one) == ""
        write(one)
        choose(one, "write_anyway")
        one.until(lambda: state(one, TILT) is RowState.VERIFIED)
        assert len(one.changes()) == 1


def test_an_active_module_is_written_only_when_unlocked_for_this_once(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, active=True) as one:
        type_into(one, "freefall_time", "1.2")
        write(one)
        one.until(lambda: notice(one).startswith("Nothing was written. The module is ACTIVE"))
        assert not one.changes()
        choose(one, "unlock_once")
        one.until(lambda: state(one, TIME) is RowState.VERIFIED)
        type_into(one, "freefall_time", "1.3")
        write(one)  # once is not for ever
        one.until(lambda: notice(one).startswith("Nothing was written. The module is ACTIVE"))
        assert len(one.changes()) == 1


def test_undo_redo_revert_and_defaults(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        box = one.find(QLineEdit, "attitude_threshold_wanted")
        type_into(one, "attitude_threshold", "75")
        type_into(one, "freefall_time", "1.1")
        control, shift = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
        line, focus = one.find(QLineEdit, "freefall_time_wanted"), one.find(QWidget, "freefall_time_number")
        assert focus.hasFocus()
        qtbot.keyClick(focus, Qt.Key.Key_Z, control)
        assert (box.text(), line.text()) == ("75", "")
        qtbot.keyClick(focus, Qt.Key.Key_Z, control)
        assert box.text() == ""
        qtbot.keyClick(focus, Qt.Key.Key_Z, control | shift)
        assert box.text() == "75"
        one.click("settings_revert")
        assert (box.text(), box.placeholderText()) == ("", "60")
        one.choose_rare("settings_defaults")
        assert (box.text(), line.text()) == ("60", "1.60")
        one.settings.refresh()
        assert one.settings.write.text() == "Write 2 changes"  # the two flags: nobody knows how they stand
        assert not one.changes()
        write(one)
        one.until(lambda: state(one, "attitude_trigger") is RowState.ACKNOWLEDGED)
        one.settings.refresh()  # nothing is left enabled that would do nothing
        page = one.settings
        able = [one_.objectName() for one_ in (page.write, page.revert, page.undo, page.redo) if one_.isEnabled()]
        able += [one_.objectName() for one_ in (page.defaults, page.as_found) if one_.isEnabled()]
        assert (able, box.text(), line.text()) == ([], "", "")


@pytest.mark.parametrize("text", ["0", "25.5"])
def test_a_light_threshold_that_tells_nothing_warns_like_every_other(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, text: str
) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        type_into(one, "light_threshold", text)
        write(one)
        assert "Never tells an open bay from a closed one." in notice(one)
        assert not one.changes()


def test_initial_values_can_be_restored(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        assert not one.settings.as_found.isEnabled()
        for text in ("1.2", "1.3"):
            type_into(one, "freefall_time", text)
            write(one)
            one.until(lambda: state(one, TIME) is RowState.VERIFIED)
        one.choose_rare("settings_as_found")
        write(one)
        one.until(lambda: one.held("freefall_time") == 1.6 and state(one, TIME) is RowState.VERIFIED)
        store = one.assembly.storage.store
        assert isinstance(store, Store)
        assert [settings[TIME] for settings in kept_settings(store)] == [1.6]


@pytest.mark.parametrize("remembers", [True, False])
def test_survives_a_power_cycle(qtbot: QtBot, qapp: QApplication, tmp_path: Path, remembers: bool) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        type_into(one, "freefall_time", "1.2")
        write(one)
        one.until(lambda: state(one, TIME) is RowState.VERIFIED)
        choose(one, "survives")
        one.until(lambda: "Switch the module off and on" in notice(one))
        if not remembers:
            one.bench.module.memory.freefall_time = 160  # a module that forgets
        one.bench.restart()
        one.until(lambda: not one.settings.work.job.is_running)
        stamped = reason(one, TIME)
        assert stamped == ("Kept over the power cycle." if remembers else "LOST at the power cycle: it holds 1.60 s.")
        assert ("37 → 38" in notice(one)) is True


def test_the_wheel_edits_only_with_the_focus(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    def wheel(box: QWidget) -> None:
        here = QPointF(box.rect().center())
        qapp.sendEvent(
            box,
            QWheelEvent(here, QPointF(box.mapToGlobal(here)), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
                        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False),
        )  # fmt: skip

    with desk(qtbot, qapp, tmp_path) as one:
        box = one.find(QLineEdit, "attitude_threshold_wanted")
        number = one.find(QDoubleSpinBox, "attitude_threshold_number")
        one.settings.read.setFocus()
        wheel(number)
        assert box.text() == ""
        number.setFocus()
        wheel(number)
        assert (box.text(), number.value(), number.maximum()) == ("61", 61, 255)
        assert number.accessibleDescription() == "0° to 255°"
        qtbot.keyClick(number, Qt.Key.Key_Down)
        qtbot.keyClick(number, Qt.Key.Key_PageDown)
        assert box.text() == "50"
        qtbot.keyClick(number, Qt.Key.Key_Up)
        assert box.text() == "51"


@pytest.mark.parametrize(("behaviour", "says"), [("old", "are at 9600 baud"), ("restart", "Switch it off and on")])
def test_the_baud_rate_needs_two_clicks_and_the_port_follows(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, behaviour: str, says: str
) -> None:
    with desk(qtbot, qapp, tmp_path, query=f"?baud_ack={behaviour}") as one:
        panel = one.settings.baud
        one.settings.scroll_area.ensureWidgetVisible(panel)
        assert not panel.confirm.ask.isEnabled()
        panel.editor.box.setCurrentIndex(panel.editor.box.findData(9600))
        panel.refresh()
        one.ask(panel.confirm)
        one.until(panel.confirm.cancel.hasFocus)
        qtbot.keyClick(panel.confirm.cancel, Qt.Key.Key_Escape)
        assert not panel.confirm.is_asking
        one.ask(panel.confirm)
        one.click(panel.confirm.go)
        one.until(lambda: panel.said.notice is not None and says in panel.said.notice.text, 20_000)
        assert len(one.changes("baud_rate")) == 1
        assert one.assembly.connector.current.connection.baud_rate == one.bench.module.baud_rate
        one.until(lambda: not one.assembly.storage.store.pending_bauds())  # type: ignore[union-attr]


@pytest.mark.parametrize("is_inverted", [False, True])
def test_the_light_threshold_by_measurement(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, is_inverted: bool
) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.bench.change(light_inverted=is_inverted)
        one.click("light_threshold_measure")
        panel = one.settings.calibration
        one.click("calibration_closed_measure")
        one.until(panel.sides["open"].button.isEnabled, 20_000)
        one.bench.set_bay(is_open=True)
        one.click("calibration_open_measure")
        one.until(panel.take.isEnabled, 20_000)
        assert ("reads lower" in panel.detail.text()) is is_inverted
        one.click("calibration_take")
        row = one.settings.rows[LIGHT].row
        assert row is not None
        assert row.edited is not None
        write(one)
        one.until(lambda: state(one, LIGHT) in (RowState.VERIFIED, RowState.READ))
        assert one.held("light_threshold") == row.edited


def test_the_vendors_term_is_in_the_chinese_help(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.assembly.language_switch.use(CHINESE)
        assert one.settings.rows[TILT].command.vendor_term in one.settings.rows[TILT].whatsThis()


def test_a_restart_of_the_module_is_shown_on_every_page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path) as one:
        one.go_to("commands")
        bar = one.assembly.window.notice_bar
        one.bench.restart()
        one.until(lambda: "The module restarted" in notice_text(bar))
        notice_ = bar.notice
        assert notice_ is not None
        assert notice_.dismiss is not None
        notice_.dismiss()
        one.until(lambda: bar.notice is None)
