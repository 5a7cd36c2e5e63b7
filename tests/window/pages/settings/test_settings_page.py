"""The Settings page through real clicks and keys: the frames are counted, and what is called verified is what the
module holds."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from app.procedures.act import Armed
from app.settings.form import RowState
from app.text.i18n import tr
from protocol.catalogue import BY_NAME
from tests.support.records.stored import kept_settings
from tests.support.window.fakes_ui import store_of
from tests.support.window.settings_bench import (
    Desk,
    choose,
    desk,
    notice,
    pick,
    reason,
    row,
    state,
    type_into,
    write,
    written,
)
from tests.support.window.steps import notice_text
from ui.style.theme import Meaning

TILT, TIME, LIGHT, FLAG = "attitude_threshold_deg", "freefall_time_s", "light_threshold_v", "attitude_trigger"


def meaning(one: Desk) -> Meaning:
    one.settings.refresh()
    assert one.settings.strip.notice is not None
    return one.settings.strip.notice.meaning


# Writing


def test_edit_write_and_verify(one: Desk) -> None:
    code = one.settings.code.text()
    type_into(one, "freefall_time", "1.2")
    type_into(one, "freefall_acceleration", "0.4")
    pick(one, "freefall_trigger", True)
    one.settings.refresh()
    assert one.settings.write.text() == "Write 3 changes"
    assert not one.changes()
    written(one)
    assert state(one, TIME) is state(one, "freefall_acceleration_g") is RowState.VERIFIED
    assert state(one, "freefall_trigger") is RowState.ACKNOWLEDGED  # it cannot be read back: never "verified"
    assert (one.held("freefall_time"), one.held("freefall_acceleration")) == (1.2, 0.4)
    assert len(one.changes()) == 3
    assert notice(one) == "Read back as written: 2. Acknowledged, cannot be read: 1."
    assert meaning(one) is Meaning.GOOD
    assert one.settings.code.text() != code
    assert not one.settings.write.isEnabled()


def test_what_is_only_acknowledged_is_not_shown_as_good(one: Desk) -> None:
    pick(one, FLAG, True)
    written(one)
    assert notice(one) == "Acknowledged, cannot be read: 1."
    assert meaning(one) is Meaning.INFORMATION


def test_a_row_stays_failed_with_the_reason_until_it_is_written(one: Desk) -> None:
    one.bench.change(refuses=True)
    type_into(one, "attitude_threshold", "70")
    written(one)
    assert state(one, TILT) is RowState.FAILED
    assert "refused" in reason(one, TILT)
    assert one.settings.rows[TILT].reason.property("role") == "danger"
    assert "Not verified: Attitude threshold." in notice(one)
    assert meaning(one) is Meaning.DANGER
    one.bench.change(refuses=False)
    written(one)
    assert state(one, TILT) is RowState.VERIFIED
    assert one.held("attitude_threshold") == 70


def test_a_write_that_was_cancelled_shows_what_the_module_holds(one: Desk) -> None:
    for name, text in (("attitude_threshold", "70"), ("freefall_time", "1.2"), ("light_threshold", "1.9")):
        type_into(one, name, text)
    write(one)
    one.until(lambda: one.held("attitude_threshold") == 70 or one.held("light_threshold") == 1.9)
    choose(one, "cancel")
    one.until(lambda: notice(one).startswith("Cancelled."))
    for name in ("attitude_threshold", "freefall_time", "light_threshold"):
        shown = row(one, BY_NAME[name].key).module_value
        assert shown is not None
        assert shown.value == one.held(name)
    assert len(one.changes()) < 3
    assert one.settings.work.count_unsent() == 3 - len(one.changes())


def test_what_could_not_be_read_is_said(one: Desk) -> None:
    one.bench.change(mute_codes=frozenset((BY_NAME["light_threshold"].code,)))
    one.click("settings_read")
    one.until(lambda: "Could not read: Light threshold." in notice(one))
    one.bench.change(mute_codes=frozenset())
    choose(one, "read_again")
    one.until(lambda: notice(one) == "")


def test_against_the_advice_needs_a_second_click(qtbot: QtBot, one: Desk) -> None:
    type_into(one, "attitude_threshold", "40")
    written(one)
    assert "55° or more" in notice(one)
    written(one)  # the same button again is no second click
    one.qtbot.mouseDClick(one.settings.write, Qt.MouseButton.LeftButton)
    one.wait(1.0)
    assert not one.changes()
    qtbot.keyClick(one.settings, Qt.Key.Key_Escape)
    assert notice(one) == ""
    written(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, TILT) is RowState.VERIFIED)
    assert len(one.changes()) == 1


def test_a_trigger_that_is_off_is_warned_of_also_once_it_is_written(one: Desk) -> None:
    pick(one, FLAG, False)
    warning = reason(one, FLAG)
    assert warning
    write(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, FLAG) is RowState.ACKNOWLEDGED)
    assert reason(one, FLAG) == warning
    assert one.settings.rows[FLAG].reason.property("role") == "attention"


@pytest.mark.promise("d")
def test_an_active_module_is_written_only_when_unlocked_for_this_once(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", active=True) as one:
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


# Edits


def test_edits_are_discarded_one_or_all_and_a_default_is_an_edit(one: Desk) -> None:
    box, line = one.find(QLineEdit, "attitude_threshold_wanted"), one.find(QLineEdit, "freefall_time_wanted")
    type_into(one, "attitude_threshold", "75")
    type_into(one, "freefall_time", "1.1")
    one.settings.refresh()
    one.click("attitude_threshold_discard")
    assert (box.text(), line.text()) == ("60", "1.1")
    type_into(one, "attitude_threshold", "75")
    one.click("settings_revert")
    assert (box.text(), line.text(), line.property("role")) == ("60", "1.60", "muted")
    type_into(one, "attitude_threshold", "75")
    type_into(one, "freefall_time", "1.1")
    one.click("attitude_threshold_default")
    assert (box.text(), line.text()) == ("60", "1.1")
    one.settings.refresh()
    assert not one.find(QWidget, "attitude_threshold_default").isVisible()
    assert one.settings.write.text() == "Write 1 change"
    one.choose_rare("settings_defaults")
    assert (box.text(), line.text()) == ("60", "1.60")
    one.settings.refresh()
    assert one.settings.write.text() == "Write 2 changes"  # the two flags: nobody knows how they stand
    assert not one.changes()


def test_initial_values_can_be_restored(one: Desk) -> None:
    assert not one.settings.as_found.isEnabled()
    for text in ("1.2", "1.3"):
        type_into(one, "freefall_time", text)
        written(one)
        assert state(one, TIME) is RowState.VERIFIED
    one.settings.refresh()
    one.choose_rare("settings_as_found")
    written(one)
    assert (one.held("freefall_time"), state(one, TIME)) == (1.6, RowState.VERIFIED)
    store = store_of(one.assembly.storage)
    assert [settings[TIME] for settings in kept_settings(store)] == [1.6]


@pytest.mark.parametrize(
    ("name", "typed", "says"),
    [
        ("attitude_threshold", "650", "0° to 255°"),
        ("light_threshold", "0.55", "steps of 0.1 V"),
    ],
)
def test_what_cannot_be_sent_stays_as_typed_and_nothing_is_written(
    qtbot: QtBot, one: Desk, name: str, typed: str, says: str
) -> None:
    page, box = one.settings, one.find(QLineEdit, f"{name}_wanted")
    key = BY_NAME[name].key
    type_into(one, "freefall_acceleration", "0.4")  # that could be written by itself
    type_into(one, name, typed)
    one.wait(1.0)  # the page refreshes itself
    assert box.text() == typed
    assert box.property("role") == "wrong"
    assert state(one, key) is RowState.IMPOSSIBLE
    assert says in reason(one, key)
    assert tr(BY_NAME[name].title) in notice(one)
    assert not page.write.isEnabled()
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    page.work.write(Armed())
    one.wait(0.5)
    assert one.changes() == []
    assert page.work.count_unsent() == 2  # leaving the program asks
    one.click(f"{name}_discard")
    assert state(one, key) is RowState.READ
    assert box.property("role") == "muted"
    written(one)
    assert state(one, "freefall_acceleration_g") is RowState.VERIFIED


@pytest.mark.parametrize("typed", ["75", " 75"])
def test_an_emptied_field_waits_for_another_number(typed: str, qtbot: QtBot, one: Desk) -> None:
    box = one.find(QLineEdit, "attitude_threshold_wanted")
    one.until(lambda: box.text() == "60")
    box.setFocus()
    box.selectAll()
    qtbot.keyClick(box, Qt.Key.Key_Delete)
    one.wait(1.0)
    assert box.text() == ""
    assert not one.settings.write.isEnabled()
    qtbot.keyClicks(box, typed)
    assert box.text() == typed
    assert one.settings.work.form.edited == {TILT: 75}


# The light and the baud rate


@pytest.mark.parametrize("is_inverted", [False, True])
def test_the_light_threshold_by_measurement(is_inverted: bool, one: Desk) -> None:
    one.bench.change(light_inverted=is_inverted)
    one.settings.refresh()
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    one.until(lambda: not one.settings.work.measure_job.is_running)
    one.bench.set_world(bay_is_open=True)
    one.click("calibration_open_measure")
    one.until(lambda: one.settings.work.proposal is not None)
    one.settings.refresh()
    assert ("reads lower" in one.settings.calibration.detail.text()) is is_inverted
    one.click("calibration_take")
    edited = row(one, LIGHT).edited
    assert edited is not None
    assert one.assembly.ports.module.light_direction is not None
    written(one)
    assert one.held("light_threshold") == edited


def test_a_measurement_ends_with_its_panel(one: Desk) -> None:
    one.settings.refresh()
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    one.wait(0.5)
    assert one.settings.on_escape()
    one.until(lambda: not one.assembly.ports.module.is_busy, 1.0)
    one.settings.refresh()
    one.click("light_threshold_measure")
    one.settings.refresh()
    assert one.find(QLabel, "calibration_closed_text").text() == "not measured yet"


def test_the_baud_rate_needs_two_clicks_and_the_port_follows(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        baud, port = one.settings.baud, one.assembly.ports.current
        one.settings.refresh()
        assert not baud.confirm.ask.isEnabled()
        pick(one, "baud_rate", 9600)
        one.ask(baud.confirm)
        one.until(baud.confirm.cancel.hasFocus)
        qtbot.keyClick(baud.confirm.cancel, Qt.Key.Key_Escape)
        assert not baud.confirm.is_asking
        one.ask(baud.confirm)
        one.click(baud.confirm.go)
        one.until(lambda: port.interruptions.remainders)
        assert len(one.changes("baud_rate")) == 1
        assert port.connection.baud_rate == one.bench.module.baud_rate
        assert "are at 9600 baud" in notice_text(one.assembly.window.notice_bar)
        one.until(lambda: port.module.is_read)
        one.settings.refresh()
        shown = f"{one.bench.module.baud_rate} baud"
        assert one.find(QLabel, "baud_rate_stands").text() == shown


def test_a_question_about_the_baud_rate_ends_with_the_conversation(one: Desk) -> None:
    pick(one, "baud_rate", 9600)
    one.settings.refresh()
    one.ask(one.settings.baud.confirm)
    one.bench.restart()
    one.until(lambda: one.assembly.ports.module.number > 1)
    assert not one.settings.baud.confirm.is_asking
    assert one.find(QComboBox, "baud_rate_wanted").currentIndex() == -1
    assert not one.changes("baud_rate")
