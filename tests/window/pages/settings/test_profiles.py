"""Profiles on the Settings page: opened, compared, applied as far as they are ticked, saved."""

import tomllib
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QLabel, QPushButton

from app.settings.form import RowState
from tests.support.window import walk
from tests.support.window.settings_bench import Desk, notice, state, type_into
from tests.support.window.steps import choosing

PROFILE = f"{walk.PROFILE}baud_rate = 9600\n"


def profile_file(folder: Path, text: str = PROFILE, name: str = "H6.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def open_by_dialog(one: Desk, path: Path) -> None:
    one.settings.ask_open = choosing(path)
    one.click("profile_open")


def tick(one: Desk, name: str) -> QCheckBox:
    return one.find(QCheckBox, f"profile_tick_{name}")


def match(one: Desk, name: str) -> str:
    return one.find(QLabel, f"profile_match_{name}").text()


def apply(one: Desk) -> None:
    one.click("profile_apply")
    one.until(lambda: not one.settings.work.job.is_running)


def test_compare_tick_apply_verify(tmp_path: Path, one: Desk) -> None:
    open_by_dialog(one, profile_file(tmp_path))
    assert one.find(QLabel, "profile_title").text() == "Survey hexacopter"
    assert match(one, "attitude_threshold") == "different"
    assert match(one, "freefall_time") == "same"
    assert match(one, "attitude_trigger") == "unknown"
    assert match(one, "light_threshold") == "not in the profile"
    names = ("attitude_threshold", "freefall_time", "attitude_trigger", "baud_rate")
    assert [name for name in names if tick(one, name).isChecked()] == ["attitude_threshold", "attitude_trigger"]
    assert not tick(one, "baud_rate").isEnabled()  # it has its own place
    assert one.find(QPushButton, "profile_apply").text() == "Apply 2 ticked"
    apply(one)
    assert state(one, "attitude_threshold_deg") is RowState.VERIFIED
    assert one.held("attitude_threshold") == 65
    assert len(one.changes()) == 2
    assert one.changes("baud_rate", "freefall_time") == []


def test_only_what_is_ticked_is_applied(tmp_path: Path, one: Desk) -> None:
    type_into(one, "light_threshold", "1.9")
    open_by_dialog(one, profile_file(tmp_path))
    one.click(tick(one, "attitude_threshold"))
    one.wait(1.0)
    assert not tick(one, "attitude_threshold").isChecked()  # it stays as the person left it
    apply(one)
    assert one.held("attitude_threshold") == 60
    assert len(one.changes("attitude_trigger")) == len(one.changes()) == 1
    assert one.held("light_threshold") == 1.8
    assert one.settings.work.form.edited == {"light_threshold_v": 1.9}, "what was not shown stays an edit"


def test_ticks_end_with_the_conversation_in_which_they_were_made(tmp_path: Path, one: Desk) -> None:
    open_by_dialog(one, profile_file(tmp_path))
    one.click(tick(one, "attitude_threshold"))
    one.assembly.ports.current.treat_as_another()
    one.until(lambda: one.assembly.ports.module.number > 1 and one.assembly.ports.module.is_read)
    one.settings.refresh()
    assert one.settings.work.comparison is None
    open_by_dialog(one, tmp_path / "H6.toml")
    assert tick(one, "attitude_threshold").isChecked()


def test_what_is_no_profile_is_refused_with_its_faults_and_replaces_nothing(tmp_path: Path, one: Desk) -> None:
    bad = 'name = "x"\nwhat = 1\n[settings]\nattitude_threshold_deg = 300\nfreefall_acceleration_g = 0.55\n'
    open_by_dialog(one, profile_file(tmp_path, bad, "bad.toml"))
    said = notice(one)
    assert said.startswith("bad.toml is not a profile")
    assert "what" in said
    assert one.settings.write.isVisible()
    assert one.settings.work.comparison is None
    assert one.changes() == []


def test_current_settings_are_saved_and_unknown_ones_are_named(tmp_path: Path, one: Desk) -> None:
    path = tmp_path / "as it is.toml"
    one.settings.ask_save = choosing(path)
    one.click("profile_save")
    one.until(lambda: "Saved to" in notice(one))
    saved = tomllib.loads(path.read_text(encoding="utf-8"))
    assert saved["name"] == "as it is"
    assert saved["settings"] == {
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
        "baud_rate": 115200,
    }
    assert notice(one).endswith("Unknown: Attitude trigger, Free-fall trigger.")
    one.settings.ask_save = choosing(tmp_path / "no such folder" / "x.toml")
    one.click("profile_save")
    one.until(lambda: "cannot be written" in notice(one))
