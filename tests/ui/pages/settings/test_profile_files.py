"""Profiles in the window; the Settings page when the user leaves, the link is lost or a change of the rate is
interrupted.
"""

import re
import tomllib
from pathlib import Path

import pytest
from app.engine.identity import Trust
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QCheckBox, QLabel, QLineEdit, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.settings.form import RowState
from tests.support.line.odd_module import end_faults
from tests.support.window import walk
from tests.support.window.settings_bench import Desk, choose, desk, notice, state, type_into, write
from tests.support.window.steps import choosing, drop, given, notice_text
from ui.shell.attention import AGAIN_S
from ui.style.painted_widget import Freshness

PROFILE = f"{walk.PROFILE}baud_rate = 9600\n"


def profile_file(folder: Path, text: str = PROFILE, name: str = "H6.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def open_by_dialog(one: Desk, path: Path) -> None:
    one.settings.files.ask_open = choosing(path)
    one.click("profile_open")


def tick(one: Desk, name: str) -> QCheckBox:
    return one.find(QCheckBox, f"profile_tick_{name}")


def match(one: Desk, name: str) -> str:
    return one.settings.compare._rows[name].chip.word


def test_compare_tick_apply_verify(tmp_path: Path, one: Desk) -> None:
    open_by_dialog(one, profile_file(tmp_path))
    assert one.find(QLabel, "profile_title").text() == "Survey hexacopter"
    assert match(one, "attitude_threshold_deg") == "different"
    assert match(one, "freefall_time_s") == "same"
    assert match(one, "attitude_trigger") == "unknown"
    assert match(one, "light_threshold_v") == "not in the profile"
    ticked = {name for name in ("attitude_threshold", "freefall_time", "attitude_trigger", "baud_rate")
              if tick(one, name).isChecked()}  # fmt: skip
    assert ticked == {"attitude_threshold", "attitude_trigger"}
    assert not tick(one, "baud_rate").isEnabled()  # it has its own place
    one.click("profile_apply")
    one.until(lambda: not one.settings.work.job.is_running)
    one.settings.refresh()
    rows = one.settings.rows
    assert given(rows["attitude_threshold_deg"].row).state is RowState.VERIFIED
    assert one.held("attitude_threshold") == 65
    assert len(one.changes()) == 2
    assert one.changes("baud_rate", "freefall_time") == []


def test_only_what_is_ticked_is_applied(tmp_path: Path, one: Desk) -> None:
    type_into(one, "light_threshold", "1.9")
    open_by_dialog(one, profile_file(tmp_path))
    tick(one, "attitude_threshold").click()
    one.settings.refresh()
    assert one.settings.compare.apply.text() == "Apply 1 ticked"
    assert not tick(one, "attitude_threshold").isChecked()  # it stays as the person left it
    one.click("profile_apply")
    one.until(lambda: not one.settings.work.job.is_running)
    assert one.held("attitude_threshold") == 60
    assert len(one.changes("attitude_trigger")) == len(one.changes()) == 1
    assert one.held("light_threshold") == 1.8
    assert one.settings.work.form.edited == {"light_threshold_v": 1.9}, "what was not shown stays an edit"


def test_of_what_is_ticked_a_risk_that_is_accepted_writes_no_other_edit(tmp_path: Path, one: Desk) -> None:
    type_into(one, "light_threshold", "1.9")
    open_by_dialog(one, profile_file(tmp_path, PROFILE.replace("65", "40")))
    one.click("profile_apply")
    choose(one, "write_anyway")
    one.until(lambda: one.held("attitude_threshold") == 40 and not one.settings.work.job.is_running)
    assert one.held("light_threshold") == 1.8
    assert one.settings.work.form.edited == {"light_threshold_v": 1.9}


def test_ticks_are_for_the_module_for_which_they_were_made(tmp_path: Path, one: Desk) -> None:
    open_by_dialog(one, profile_file(tmp_path))
    tick(one, "attitude_threshold").click()
    tick(one, "freefall_time").click()
    one.settings.refresh()
    assert (tick(one, "attitude_threshold").isChecked(), tick(one, "freefall_time").isChecked()) == (False, True)
    one.assembly.ports.current.module.treat_as_new()
    one.until(lambda: match(one, "freefall_time_s") == "same")
    assert (tick(one, "attitude_threshold").isChecked(), tick(one, "freefall_time").isChecked()) == (True, False)


def test_what_is_measured_of_the_light_ends_with_the_panel_and_with_the_module(one: Desk) -> None:
    panel, connector = one.settings.calibration, one.assembly.ports
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    assert one.settings.on_escape()
    one.click("light_threshold_measure")
    one.until(lambda: not connector.is_busy, 1.0)
    assert (panel.sides["closed"].text.text(), panel.detail.text()) == ("not measured yet", "")
    one.click("calibration_closed_measure")
    one.bench.unplug()
    one.until(lambda: panel.detail.text() == "Link lost.")
    one.bench.plug()
    connector.connect_to(Target(one.url, 115200))
    one.until(panel.sides["closed"].button.isEnabled)
    assert panel.detail.text() == ""


def test_a_profile_against_the_advice_is_warned_about(tmp_path: Path, one: Desk) -> None:
    open_by_dialog(one, profile_file(tmp_path, PROFILE.replace("= 65", "= 40")))
    assert tick(one, "attitude_threshold").isVisible()
    assert not one.find(QLabel, "profile_faults").isVisible()
    one.click("profile_apply")
    assert "55° or more" in notice_text(one.settings.strip)
    assert one.changes() == []


def test_a_file_that_is_dropped_on_any_page_is_compared(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "commands", "settings") as one:
        assert not drop(one.assembly.window, profile_file(tmp_path, name="notes.txt"))
        assert drop(one.assembly.window, profile_file(tmp_path))
        one.until(one.settings.compare.isVisible)
        assert one.find(QLabel, "profile_title").text() == "Survey hexacopter"
        assert one.changes() == []


def test_files_are_listed_until_they_are_missing_and_all_their_errors_are_shown_at_once(
    qtbot: QtBot, tmp_path: Path, one: Desk
) -> None:
    files = one.settings.files
    assert not files.recent.isEnabled()
    path = profile_file(tmp_path)
    open_by_dialog(one, path)
    one.click("profile_close")
    files.menu.aboutToShow.emit()
    (action,) = files.menu.actions()
    assert action.text() == "H6.toml"
    action.trigger()
    assert one.settings.compare.isVisible()
    path.unlink()
    action.trigger()
    assert "cannot be read" in one.find(QLabel, "profile_faults").text()
    assert not files.recent.isEnabled()
    one.click("profile_close")
    bad = 'name = "x"\nwhat = 1\n[settings]\nattitude_threshold_deg = 300\nfreefall_acceleration_g = 0.55\n'
    open_by_dialog(one, profile_file(tmp_path, bad))
    assert one.find(QLabel, "profile_faults").isVisible()
    told = one.find(QLabel, "profile_faults").text().splitlines()
    assert [line.split(":")[0] for line in told] == [
        "“what” is unknown.", "settings.attitude_threshold_deg", "settings.freefall_acceleration_g",
    ]  # fmt: skip
    assert not one.find(QPushButton, "profile_apply").isVisible()
    qtbot.keyClick(one.settings, Qt.Key.Key_Escape)
    assert one.settings.write.isVisible()
    assert one.changes() == []


def test_current_settings_are_saved_and_unknown_ones_are_named(tmp_path: Path, one: Desk) -> None:
    path = tmp_path / "as it is.toml"
    one.settings.files.ask_save = choosing(path)
    one.click("profile_save")
    saved = tomllib.loads(path.read_text(encoding="utf-8"))
    assert saved["name"] == "as it is"
    assert saved["settings"] == {
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
        "baud_rate": 115200,
    }
    said = given(one.settings.strip.notice)
    assert said.text.endswith("Unknown: Attitude trigger, Free-fall trigger.")
    one.settings.files.ask_save = choosing(tmp_path / "no such folder" / "x.toml")
    one.click("profile_save")
    said = given(one.settings.strip.notice)
    assert "cannot be written" in said.text


TILT, TIME = "attitude_threshold_deg", "freefall_time_s"


def test_losing_edits_is_confirmed(one: Desk) -> None:
    connector, window, bar = one.assembly.ports, one.assembly.window, one.assembly.window.notice_bar
    type_into(one, "freefall_time", "1.2")
    window.disconnect_port()
    assert "Settings not written: 1" in notice_text(bar)
    choose(one, "stay", bar)
    opening = connector.current.connection.opening
    window._connect_again()
    assert "Settings not written: 1" in notice_text(bar)
    choose(one, "stay", bar)
    assert (connector.current.is_open, connector.current.connection.opening) == (True, opening)
    assert float(one.find(QLineEdit, "freefall_time_wanted").text()) == 1.2
    window.close()
    assert window.isVisible()
    window._connect_again()
    choose(one, "drop_edits", bar)
    one.until(lambda: connector.current.connection.opening > opening and connector.current.is_open)
    type_into(one, "freefall_time", "1.2")
    window.disconnect_port()
    choose(one, "drop_edits", bar)
    one.until(lambda: not connector.current.is_open)
    one.settings.refresh()
    assert one.find(QWidget, "freefall_time_wanted").property("role") == "muted"
    assert not one.changes()


def test_edits_and_an_active_module_are_two_questions(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "settings", active=True) as one:
        window, bar = one.assembly.window, one.assembly.window.notice_bar
        type_into(one, "freefall_time", "1.2")
        window.close()
        assert bar.button("drop_edits") is not None
        one.wait(AGAIN_S)
        window.close()  # a second attempt is an answer to the first question, not to the next
        assert window.isVisible()
        assert bar.button("lock_and_leave") is not None
        choose(one, "stay", bar)
        window.close()
        choose(one, "drop_edits", bar)
        assert window.isVisible()
        choose(one, "leave_active", bar)
        one.until(lambda: not window.isVisible())
        assert one.changes() == []


def test_a_lost_link_keeps_edits_and_makes_values_stale(one: Desk) -> None:
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    shown = one.settings.rows[TILT].value_label
    one.until(lambda: shown.freshness is Freshness.STALE)
    assert re.fullmatch(r"read \S+ s ago \(before link loss\)", shown.note)  # its end may be elided, not its age
    one.settings.refresh()
    assert float(one.find(QLineEdit, "freefall_time_wanted").text()) == 1.2
    assert (one.settings.write.isEnabled(), one.settings.find_rate.isEnabled()) == (False, False)
    one.bench.plug()
    one.until(lambda: shown.freshness is Freshness.FRESH)
    say_same(one)
    write(one)
    one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    assert len(one.changes()) == 1


def say_same(one: Desk) -> None:
    """A person says that what came back is the same module."""
    bar = one.assembly.window.notice_bar
    one.until(lambda: bar.button("identity_same") is not None)
    choose(one, "identity_same", bar)
    one.until(lambda: one.assembly.ports.current.is_open and one.assembly.ports.current.identity.is_settled)


def test_writing_waits_for_the_identity_of_a_returned_module(one: Desk) -> None:
    connector = one.assembly.ports
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.bench.change(delay_ms=100.0)
    one.bench.plug()
    one.until(lambda: connector.current.is_open and connector.current.module.is_going)
    assert connector.current.identity.trust is Trust.OPEN
    one.settings.refresh()
    assert not one.settings.write.isEnabled()
    assert "same module" in notice(one)


def test_leaving_while_it_writes_is_confirmed_until_it_is_written(one: Desk) -> None:
    window, bar = one.assembly.window, one.assembly.window.notice_bar
    one.bench.change(delay_ms=100.0)
    type_into(one, "freefall_time", "1.2")
    write(one)
    one.until(lambda: one.settings.work.form.is_writing)
    window.close()
    assert window.isVisible()
    assert "Settings not written: 1" in notice_text(bar)
    assert (one.settings.write.text(), one.settings.write.isEnabled()) == ("Write 1 change", False)
    end_faults(one.bench)
    one.until(lambda: state(one, TIME) is RowState.VERIFIED)
    one.until(lambda: bar.notice is None)
    assert window.isVisible()
    window.close()
    assert not window.isVisible()


@pytest.mark.parametrize("is_sent", [False, True])
def test_a_change_of_the_baud_rate_that_was_broken_off_is_in_doubt_only_until_the_module_answers(
    is_sent: bool, one: Desk
) -> None:
    panel, connector = one.settings.baud, one.assembly.ports
    panel.editor.box.setCurrentIndex(panel.editor.box.findData(9600))
    panel.refresh()
    one.ask(panel.confirm)
    one.bench.change(**({"mute_codes": frozenset((0x24,))} if is_sent else {"mute": True}))
    one.click(panel.confirm.go)
    one.until(lambda: one.changes("baud_rate") if is_sent else panel.notice_bar.notice is not None)
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    one.until(lambda: ("maybe at 9600" if is_sent else "Nothing was sent") in notice_text(panel.notice_bar))
    one.bench.change(mute=False)
    one.bench.plug()
    say_same(one)
    if is_sent:
        one.until(lambda: notice_text(panel.notice_bar) == "The module answers at 115200 baud.")
    assert len(one.changes("baud_rate")) == is_sent


@pytest.mark.parametrize("is_lost", [False, True])
def test_the_light_of_two_modules_is_no_threshold(is_lost: bool, one: Desk) -> None:
    """The second one took the place of the first between the two measurements."""
    panel, port = one.settings.calibration, one.assembly.ports.current
    one.click("light_threshold_measure")
    one.click("calibration_closed_measure")
    one.until(panel.sides["open"].button.isEnabled)
    one.bench.unplug() if is_lost else one.bench.change(mute=True)
    one.until(lambda: not port.is_open if is_lost else port.device.breaks > 0)
    one.bench.plug() if is_lost else one.bench.change(mute=False)
    one.bench.set_world(bay_is_open=True)
    one.until(
        lambda: port.device.fresh("boot_count", port.clock()) is not None and panel.sides["open"].button.isEnabled()
    )
    one.click("calibration_open_measure")
    one.until(lambda: "open" in panel._bands and panel._bands["open"].is_enough)
    assert not panel.take.isEnabled()


def test_whether_edits_are_dropped_for_a_new_module_is_not_asked_of_the_one_after_it(one: Desk) -> None:
    """The right one was plugged in again meanwhile, and "Discard edits" took its name away."""
    bar, memory = one.assembly.window.notice_bar, one.bench.module.memory
    type_into(one, "freefall_time", "1.2")
    for boots in (20, 37):
        one.bench.unplug()
        one.until(lambda: not one.assembly.ports.current.is_open)
        memory.boot_count = boots
        one.bench.plug()
        one.until(lambda: bar.button("identity_new") is not None)
        if boots == 20:
            choose(one, "identity_new", bar)
            assert bar.button("drop_edits") is not None


@pytest.mark.parametrize("answer", ["identity_same", "identity_new"])
@pytest.mark.promise("a")
def test_edits_wait_until_it_is_known_whether_it_is_the_same_module(answer: str, one: Desk) -> None:
    connector, work = one.assembly.ports, one.settings.work
    bar, box = one.assembly.window.notice_bar, one.find(QLineEdit, "freefall_time_wanted")
    type_into(one, "freefall_time", "1.2")
    one.bench.unplug()
    one.until(lambda: not connector.current.is_open)
    memory = one.bench.module.memory
    memory.boot_count -= 20
    memory.freefall_time, memory.attitude_threshold = 120, 85  # it holds the edited value already
    one.bench.restart()
    one.bench.plug()
    one.until(lambda: connector.current.identity.trust is Trust.REFUTED and bar.button(answer) is not None)
    one.until(lambda: state(one, TILT) is RowState.READ)
    one.until(lambda: connector.current.module.view.known("freefall_time_s", connector.clock()) is not None)
    assert (state(one, TIME), work.count_unsent()) == (RowState.EDITED, 1)
    choose(one, answer, bar)
    if answer == "identity_new":
        assert "Settings not written: 1" in notice_text(bar)
        choose(one, "stay", bar)
        assert (connector.current.identity.trust, float(box.text())) == (Trust.REFUTED, 1.2)
        choose(one, answer, bar)
        choose(one, "drop_edits", bar)
        one.until(lambda: connector.current.identity.is_settled)
        one.until(lambda: state(one, TIME) is RowState.READ)
        assert (one.find(QWidget, "freefall_time_wanted").property("role"), state(one, TILT)) == (
            "muted",
            RowState.READ,
        )
    else:
        one.until(lambda: state(one, TILT) is RowState.CHANGED)
        assert (float(box.text()), work.count_unsent()) == (1.2, 0)
    assert one.changes() == []
