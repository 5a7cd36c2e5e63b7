"""The Settings page through real clicks and keys: the frames are counted, and what is called verified is what the
module holds."""

import tomllib
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QLineEdit, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.procedures.act import Armed
from app.settings.form import RowState
from app.simulator.module import LIGHT_BAY_CLOSED_V, LIGHT_BAY_OPEN_V
from app.text.i18n import CHINESE, ENGLISH, set_language, tr
from protocol.catalogue import BY_NAME
from protocol.fields import Quantity
from tests.support.line.frames import lose, refuse
from tests.support.records.stored import kept_settings
from tests.support.window import walk
from tests.support.window.desk import choose, notice, pick, reason, row, say_name, state, type_into, write, written
from tests.support.window.fakes_ui import store_of
from tests.support.window.rig import Rig
from tests.support.window.steps import choosing, given, let_lay_out, notice_text
from ui.style.theme import Meaning

TILT, TIME, LIGHT, FLAG = "attitude_threshold_deg", "freefall_time_s", "light_threshold_v", "attitude_trigger"


def meaning(one: Rig) -> Meaning:
    one.settings.refresh()
    return given(one.settings.strip.notice).meaning


# Writing


def test_edit_write_and_verify(one: Rig) -> None:
    code = one.settings.code.text()
    type_into(one, "freefall_time", "1.16")  # times 100 that is a little less than 116
    type_into(one, "freefall_acceleration", "0.4")
    pick(one, "freefall_trigger", True)
    one.settings.refresh()
    assert one.settings.write.text() == "Write 3 changes"
    assert not one.changes()
    written(one)
    assert state(one, TIME) is state(one, "freefall_acceleration_g") is RowState.VERIFIED
    assert state(one, "freefall_trigger") is RowState.ACKNOWLEDGED  # it cannot be read back: never "verified"
    assert (one.held("freefall_time"), one.held("freefall_acceleration")) == (1.16, 0.4)
    assert len(one.changes()) == 3
    assert notice(one) == "Read back as written: 2. Acknowledged, cannot be read: 1."
    assert meaning(one) is Meaning.GOOD
    assert one.settings.code.text() != code
    assert not one.settings.write.isEnabled()
    pick(one, "freefall_trigger", False)
    pick(one, "freefall_trigger", True)
    pick(one, FLAG, True)
    written(one)
    assert notice(one) == "Acknowledged, cannot be read: 1."
    assert meaning(one) is Meaning.INFORMATION


def test_the_top_bar_says_whether_the_triggers_are_on(one: Rig) -> None:
    chip = one.window.top_bar.triggers
    assert chip.word == "not known"
    for name, is_on, says in (
        (FLAG, True, "not known"),
        ("freefall_trigger", True, "both on"),
        (FLAG, False, "tilt off"),
        ("freefall_trigger", False, "both off"),
        (FLAG, True, "fall off"),
    ):
        pick(one, name, is_on)
        written(one)
        if not is_on:
            choose(one, "write_anyway")
        one.until(lambda says=says: chip.accessibleName() == f"triggers: {says}")  # type: ignore[misc]
        assert (chip.meaning is Meaning.ATTENTION) is says.endswith("off")


def test_a_row_tells_who_wrote_it_last_from_what_and_when(qtbot: QtBot, one: Rig) -> None:
    say_name(one, "M-07")
    type_into(one, "freefall_time", "1.16")
    one.settings.note.setText("Li Wei: heavier battery")
    written(one)
    cell = one.settings.rows[TIME].held

    def is_told() -> bool:
        one.settings.refresh()
        return "Free-fall time 1.60 s → 1.16 s: confirmed. “Li Wei: heavier battery”" in cell.toolTip()

    qtbot.waitUntil(is_told)
    assert "Li Wei" in cell.value.accessibleDescription()
    assert "Li Wei" not in one.settings.rows[TILT].held.toolTip()
    one.settings.module.say_name("")
    one.settings.refresh()
    assert "Li Wei" not in cell.toolTip()


def test_a_row_stays_failed_with_the_reason_until_it_is_written(one: Rig) -> None:
    end = refuse(one.bench)
    type_into(one, "attitude_threshold", "70")
    written(one)
    assert state(one, TILT) is RowState.FAILED
    assert "not set" in reason(one, TILT)
    assert one.settings.rows[TILT].reason.property("role") == "danger"
    assert "Not verified: Attitude threshold." in notice(one)
    assert meaning(one) is Meaning.DANGER
    end()
    written(one)
    assert state(one, TILT) is RowState.VERIFIED
    assert one.held("attitude_threshold") == 70


def test_a_write_that_was_cancelled_shows_what_the_module_holds(one: Rig) -> None:
    for name, text in (("attitude_threshold", "70"), ("freefall_time", "1.2"), ("light_threshold", "1.9")):
        type_into(one, name, text)
    write(one)
    one.until(lambda: one.held("attitude_threshold") == 70 or one.held("light_threshold") == 1.9)
    choose(one, "cancel")
    one.until(lambda: notice(one).startswith("Cancelled."))
    for name in ("attitude_threshold", "freefall_time", "light_threshold"):
        assert given(row(one, BY_NAME[name].key).known).value == one.held(name)
    assert len(one.changes()) < 3
    assert one.settings.work.count_unsent() == 3 - len(one.changes())


def test_what_could_not_be_read_is_said(one: Rig) -> None:
    end = lose(one.bench, BY_NAME["light_threshold"].code)
    one.click("settings_read")
    one.until(lambda: "Could not read: Light threshold." in notice(one))
    end()
    choose(one, "read_again")
    one.until(lambda: notice(one) == "")


def test_against_the_advice_needs_a_second_click_and_is_warned_of_also_once_it_is_written(
    qtbot: QtBot, one: Rig
) -> None:
    type_into(one, "attitude_threshold", "40")
    pick(one, FLAG, False)
    one.settings.note.setText("Li Wei: small bay")
    written(one)
    assert "55° or more" in notice(one)
    written(one)  # the same button again is no second click
    one.qtbot.mouseDClick(one.settings.write, Qt.MouseButton.LeftButton)
    one.wait(1.0)
    assert not one.changes()
    qtbot.keyClick(one.settings, Qt.Key.Key_Escape)
    assert notice(one) == ""
    assert one.settings.note.text() == "Li Wei: small bay"  # nothing was written with it yet
    warning = reason(one, FLAG)
    written(one)
    choose(one, "write_anyway")
    one.until(lambda: state(one, TILT) is RowState.VERIFIED)
    assert one.settings.note.text() == ""
    assert len(one.changes()) == 2
    assert reason(one, FLAG) == warning != ""
    assert one.settings.rows[FLAG].reason.property("role") == "attention"


@pytest.mark.promise("d")
@pytest.mark.module(active=True)
def test_an_active_module_is_written_only_when_unlocked_for_this_once(one: Rig) -> None:
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


def test_edits_are_discarded_one_or_all_and_a_default_is_an_edit(one: Rig) -> None:
    box, line = one.find(QLineEdit, "attitude_threshold_wanted"), one.find(QLineEdit, "freefall_time_wanted")
    type_into(one, "attitude_threshold", "75")
    type_into(one, "freefall_time", "1.1")
    one.settings.refresh()
    one.click("attitude_threshold_discard")
    assert (box.text(), line.text()) == ("60", "1.1")
    one.click("settings_revert")
    assert (box.text(), line.text(), line.property("role")) == ("60", "1.60", "muted")
    type_into(one, "attitude_threshold", "75")
    type_into(one, "freefall_time", "1.1")
    one.click("attitude_threshold_default")
    one.settings.refresh()
    assert (box.text(), one.settings.write.text()) == ("60", "Write 1 change")
    assert not one.find(QWidget, "attitude_threshold_default").isVisible()
    one.find(QAction, "settings_defaults").trigger()
    one.settings.refresh()
    assert (box.text(), line.text()) == ("60", "1.60")
    assert one.settings.write.text() == "Write 2 changes"  # the two flags: nobody knows how they stand
    assert not one.changes()


def test_initial_values_can_be_restored(one: Rig) -> None:
    assert not one.settings.as_found.isEnabled()
    one.bench.module.memory.freefall_time = 150
    one.click("settings_read")
    one.until(lambda: not one.settings.work.job.is_running)
    one.until(lambda: given(row(one, TIME).known).value == 1.5)
    for text in ("1.2", "1.3"):
        type_into(one, "freefall_time", text)
        written(one)
    one.settings.refresh()
    one.find(QAction, "settings_as_found").trigger()
    written(one)
    assert (one.held("freefall_time"), state(one, TIME)) == (1.5, RowState.VERIFIED)
    assert [settings[TIME] for settings in kept_settings(store_of(one.assembly.storage))] == [1.5]


def test_what_cannot_be_sent_stays_as_typed_and_nothing_is_written(qtbot: QtBot, one: Rig) -> None:
    page, box = one.settings, one.find(QLineEdit, "light_threshold_wanted")
    emptied = one.find(QLineEdit, "attitude_threshold_wanted")
    type_into(one, "attitude_threshold", "")
    qtbot.keyClick(emptied, Qt.Key.Key_Delete)
    one.wait(1.0)  # the page refreshes itself
    assert (emptied.text(), page.write.isEnabled()) == ("", False)
    qtbot.keyClicks(emptied, " 75")
    assert (emptied.text(), page.work.wanted) == (" 75", {TILT: 75})
    type_into(one, "light_threshold", "0.55")
    one.wait(1.0)
    assert (box.text(), box.property("role"), state(one, LIGHT)) == ("0.55", "wrong", RowState.IMPOSSIBLE)
    assert "steps of 0.1 V" in reason(one, LIGHT)
    assert tr(BY_NAME["light_threshold"].title) in notice(one)
    assert (page.write.text(), page.write.isEnabled()) == ("Write 1 change", False)
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    page.work.write(Armed())
    one.wait(0.5)
    assert one.changes() == []
    assert page.work.count_unsent() == 2  # leaving the program asks
    one.click("light_threshold_discard")
    assert (state(one, LIGHT), box.property("role")) == (RowState.READ, "muted")
    written(one)
    assert state(one, TILT) is RowState.VERIFIED


# The light and the baud rate


@pytest.mark.parametrize("is_inverted", [False, True])
def test_the_light_threshold_by_measurement(is_inverted: bool, one: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    if is_inverted:
        monkeypatch.setattr("app.simulator.module.LIGHT_BAY_OPEN_V", LIGHT_BAY_CLOSED_V)
        monkeypatch.setattr("app.simulator.module.LIGHT_BAY_CLOSED_V", LIGHT_BAY_OPEN_V)
    one.settings.refresh()
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    one.until(lambda: not one.settings.calibration.job.is_running)
    one.bench.set_world(bay_is_open=True)
    one.click("calibration_open_measure")
    one.until(lambda: one.settings.calibration.proposal is not None)
    one.settings.refresh()
    assert ("reads lower" in one.settings.calibration.detail.text()) is is_inverted
    one.click("calibration_take")
    edited = given(row(one, LIGHT).edited)
    assert one.assembly.ports.module.light_direction is not None
    written(one)
    assert one.held("light_threshold") == edited


def test_the_baud_rate_needs_two_clicks_and_the_port_follows(qtbot: QtBot, one: Rig) -> None:
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
    assert port.connection.baud_rate == one.bench.module.baud_rate == 9600
    said = notice_text(one.assembly.window.notice_bar)
    assert "Baud rate: 9600 baud" in said
    set_language(CHINESE)
    assert given(port.interruptions.remainders[0].text).translated() == "波特率：9600 波特"
    set_language(ENGLISH)
    assert "interrupted" not in said, "it ended as it was meant to"
    one.until(lambda: port.module.is_read)
    one.settings.refresh()
    assert one.find(QLabel, "baud_rate_stands").text() == "9600 baud"
    assert one.find(QComboBox, "baud_rate_wanted").currentIndex() == -1, "it is no edit of the next conversation"


def test_a_question_about_the_baud_rate_ends_with_another_choice_and_with_the_conversation(one: Rig) -> None:
    confirm = one.settings.baud.confirm
    for rate in (19200, 9600):
        pick(one, "baud_rate", rate)
        assert not confirm.is_asking, "the answer would be one to another question"
        one.settings.refresh()
        one.ask(confirm)
    one.bench.restart()
    one.until(lambda: one.assembly.ports.module.number > 1)
    assert not confirm.is_asking
    assert one.find(QComboBox, "baud_rate_wanted").currentIndex() == -1
    assert not one.changes("baud_rate")


# Profiles


def open_profile(one: Rig, path: Path, text: str = f"{walk.PROFILE}baud_rate = 9600\n") -> None:
    path.write_text(text, encoding="utf-8")
    one.settings.ask_open = choosing(path)
    one.click("profile_open")


def tick(one: Rig, name: str) -> QCheckBox:
    return one.find(QCheckBox, f"profile_tick_{name}")


def test_compare_tick_apply_verify(tmp_path: Path, one: Rig) -> None:
    type_into(one, "light_threshold", "1.9")
    open_profile(one, tmp_path / "H6.toml")
    assert one.find(QLabel, "profile_title").text() == "Survey hexacopter"
    matches = {
        "attitude_threshold": "different",
        "freefall_time": "same",
        "attitude_trigger": "unknown",
        "light_threshold": "not in the profile",
    }
    assert {name: one.find(QLabel, f"profile_match_{name}").text() for name in matches} == matches
    names = ("attitude_threshold", "freefall_time", "attitude_trigger", "baud_rate")
    assert [name for name in names if tick(one, name).isChecked()] == ["attitude_threshold", "attitude_trigger"]
    assert not tick(one, "baud_rate").isEnabled()  # it has its own place
    assert one.find(QPushButton, "profile_apply").text() == "Apply 2 ticked"
    one.click(tick(one, "attitude_trigger"))
    one.wait(1.0)
    assert not tick(one, "attitude_trigger").isChecked()  # it stays as the person left it
    one.click("profile_apply")
    one.until(lambda: not one.settings.work.job.is_running)
    assert state(one, TILT) is RowState.VERIFIED
    assert (one.held("attitude_threshold"), one.held("light_threshold")) == (65, 1.8)
    assert len(one.changes("attitude_threshold")) == len(one.changes()) == 1
    assert one.settings.work.wanted == {LIGHT: 1.9}, "what was not shown stays an edit"


@pytest.mark.module(is_connected=False)
def test_a_profile_that_was_opened_first_is_compared_with_the_module_that_answers(tmp_path: Path, one: Rig) -> None:
    """As by `dps-s FILE.toml`; with the next conversation it closes."""
    path = tmp_path / "H6.toml"
    path.write_text(walk.PROFILE, encoding="utf-8")
    one.settings.open_file(path)
    one.connect()
    one.settings.refresh()
    assert one.settings.panel is one.settings.compare
    assert one.find(QLabel, "profile_match_attitude_threshold").text() == "different"
    module = one.port.module
    one.bench.restart()
    one.until(lambda: one.settings.module is not module)
    assert one.settings.panel is None


def test_what_is_no_profile_is_refused_with_its_faults_and_replaces_nothing(tmp_path: Path, one: Rig) -> None:
    open_profile(one, tmp_path / "bad.toml", 'name = "x"\nwhat = 1\n[settings]\nattitude_threshold_deg = 300\n')
    said = notice(one)
    assert said.startswith("bad.toml is not a profile")
    assert "what" in said
    assert one.settings.write.isVisible()
    assert one.settings.panel is None


def test_current_settings_are_saved_and_unknown_ones_are_named(tmp_path: Path, one: Rig) -> None:
    path = tmp_path / "as it is.toml"
    one.settings.ask_save = choosing(path)
    one.click("profile_save")
    one.until(lambda: "Saved to" in notice(one))
    saved = tomllib.loads(path.read_text(encoding="utf-8"))
    assert saved["name"] == "as it is"
    assert saved["settings"] == {
        LIGHT: 1.8, TILT: 60, "freefall_acceleration_g": 0.5, TIME: 1.6, "baud_rate": 115200,
    }  # fmt: skip
    assert notice(one).endswith("Unknown: Attitude trigger, Free-fall trigger.")
    one.settings.ask_save = choosing(tmp_path / "no such folder" / "x.toml")
    one.click("profile_save")
    one.until(lambda: "cannot be written" in notice(one))


# Sizes


def test_editors_stay_where_they_are_whatever_the_rows_say(one: Rig) -> None:
    page = one.settings

    def places() -> list[QPoint]:
        one.assembly.window.resize(1024, 600)
        page.refresh()
        let_lay_out(one.assembly.window)
        page.scroll_area.verticalScrollBar().setValue(0)
        return [row.editor.mapTo(page, QPoint()) for row in page.rows.values()]

    before = places()
    type_into(one, "freefall_time", "9999")
    assert places() == before
    type_into(one, "freefall_time", "1.1")
    type_into(one, "attitude_threshold", "40")
    pick(one, "freefall_trigger", True)
    assert places() == before
    written(one)
    assert places() == before


def test_what_a_value_means_fits_beside_it(one: Rig) -> None:
    """In two lines, like its name, so that no row grows when it is edited."""
    one.assembly.window.resize(1024, 600)
    let_lay_out(one.assembly.window)

    def lines(label: QLabel) -> int:
        return round(label.heightForWidth(label.width()) / label.fontMetrics().height())

    for shown in one.settings.rows.values():
        assert lines(shown.name) <= 2
        if isinstance(field := shown.command.write, Quantity):
            for count in (0, 1, *range(10, 256, 10)):
                one.settings.work.fill({shown.command.key: field.decode(count)})
                one.settings.refresh()
                assert lines(shown.reason) <= 2, shown.reason.text()
