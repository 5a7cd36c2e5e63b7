"""A profile is edited in its panel on the Pre-flight page: nothing typed is changed, refused silently, or lost."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.guided.results import GuidedKind
from app.settings.profiles import ActivatedBy, ManualLine, read_profile
from tests.support.window.preflight_window import OnBench, on_bench
from tests.support.window.steps import choosing, drop, find, given, notice_text

PROFILE = """
format = 1
name = "Survey hexacopter"  # the big one
notes = "measured in the yard"
light_inverted = true
[settings]
attitude_threshold_deg = 60
[limits]
cell_voltage_min_v = 3.875
tilt_max_deg = 3.0
[[manual]]
text = " Bridle free"
required = true
"""


def _type(qtbot: QtBot, field: QLineEdit, text: str) -> None:
    field.selectAll()
    qtbot.keyClick(field, Qt.Key.Key_Delete)
    qtbot.keyClicks(field, text)


def test_a_profile_is_edited_saved_and_used(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / "hexa.toml"
    path.write_text(PROFILE, encoding="utf-8")
    before = read_profile(path)
    with on_bench(qtbot, qapp, tmp_path, "editor", "preflight", is_connected=False) as bench:
        page = bench.preflight
        page.form.use_profile(path)
        page.form.menu.aboutToShow.emit()
        find(page, QAction, "preflight_profile_edit").trigger()
        editor = given(page.editor)
        assert not editor.isWindowModified()  # what is only looked at is not changed
        assert (editor.save.isEnabled(), page.list.isVisible()) == (False, False)
        number = editor.limits["cell_voltage_min_v"]
        assert (number.text(), editor.limits["round_trip_max_ms"].text()) == ("3.875", "")
        _type(qtbot, number, "2.0")  # below the bound that no profile goes beyond
        assert number.text() == "2.0"
        assert "3.5 to 4.2" in notice_text(editor.strip)
        assert (editor.save.isEnabled(), editor.save_as.isEnabled(), editor.isWindowModified()) == (False, False, True)
        _type(qtbot, number, "3.5")
        _type(qtbot, editor.limits["tilt_max_deg"], "")
        _type(qtbot, editor.limits["round_trip_max_ms"], "100")
        _type(qtbot, editor.tests[GuidedKind.BAY], "180")
        editor.activated_by.setCurrentIndex(1)
        editor.service.click()
        qtbot.keyClicks(editor.airframe, "H6")
        qtbot.keyClicks(editor.manual[1][0], "Pack date")
        assert len(editor.manual) == 3  # a line for one more
        assert editor.manual[1][1].nextInFocusChain() is editor.manual[2][0]
        _type(qtbot, editor.manual[0][0], "")
        written = PROFILE.replace("= 60", "= 45")  # by the Settings page
        path.write_text(written, encoding="utf-8")
        bench.click(editor.save)
        assert page.editor is None
        assert 'name = "Survey hexacopter"  # the big one' in path.read_text(encoding="utf-8")
        wanted = before._replace(
            settings={"attitude_threshold_deg": 45},
            limits={"round_trip_max_ms": 100, "cell_voltage_min_v": 3.5},
            tests_within_days={GuidedKind.BAY: 180},
            activated_by=ActivatedBy.AIRCRAFT,
            is_service_required=True,
            airframe="H6",
            manual=(ManualLine("Pack date"),),
        )
        assert read_profile(path) == page.form.profile == wanted
        assert [row.line for row in page.list.manual] == [ManualLine("Pack date")]


@pytest.mark.module(is_connected=False)
def test_edits_are_discarded_only_when_that_is_said(qtbot: QtBot, tmp_path: Path, rig: OnBench) -> None:
    page, window = rig.preflight, rig.assembly.window
    page.edit_profile()
    editor = given(page.editor)
    qtbot.keyClicks(editor.name, "H6")
    assert page.on_escape()
    assert not window.close()
    assert "Profile: Unsaved edits." in notice_text(window.notice_bar)
    rig.click(given(window.notice_bar.button("stay")))
    record = tmp_path / "x.json"
    record.write_text("{}", encoding="utf-8")
    drop(window, record)
    assert notice_text(editor.strip) == "Unsaved edits."
    rig.click(given(editor.strip.button("keep")))
    assert (editor.isVisible(), editor.name.text()) == (True, "H6")
    editor.ask_save = choosing(tmp_path / "none" / "x.toml")
    rig.click(editor.save)
    assert editor.strip.notice is not None  # the folder is not there
    page.edit_profile()
    assert page.editor is editor
    editor.ask_save = choosing(tmp_path / "x.toml")
    rig.click(editor.save)
    assert read_profile(tmp_path / "x.toml").name == "H6"
    assert page.form.path == tmp_path / "x.toml"
    page.edit_profile()
    editor = given(page.editor)
    qtbot.keyClicks(editor.limits["tilt_max_deg"], "99")  # the field was empty, as its number still is
    rig.click(editor.cancel)
    rig.click(given(editor.strip.button("discard")))
    assert page.editor is None
    assert page.list.isVisible()
    assert read_profile(tmp_path / "x.toml").name == "H6"
    assert window.close()
