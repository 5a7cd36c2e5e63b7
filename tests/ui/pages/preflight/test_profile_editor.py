"""The profile's expectations, limits and manual checks edited in the window: loaded, validated, saved, used."""

from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.guided.results import GuidedKind
from app.settings.profile_file import read_profile
from app.settings.profiles import ActivatedBy, ManualLine, Profile
from app.text.i18n import CHINESE
from tests.support.window.preflight_window import name_module, on_bench
from tests.support.window.steps import choosing
from ui.pages.preflight.controller import Standing

PROFILE = """
format = 1
name = "Survey hexacopter"  # the big one
notes = "measured in the yard"
light_inverted = true
[settings]
attitude_threshold_deg = 60
[limits]
cell_voltage_min_v = 3.85
tilt_max_deg = 3.0
[[manual]]
text = "Bridle free"
required = true
"""


def test_a_profile_is_edited_saved_and_used(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / "hexa.toml"
    path.write_text(PROFILE, encoding="utf-8")
    before = read_profile(path)
    with on_bench(qtbot, qapp, tmp_path, "editor", is_connected=False) as bench:
        page = bench.preflight
        page.form.use_profile(path)
        page.edit_profile()
        editor = page.editor
        assert editor.isVisible()
        assert editor.profile == before  # what is only looked at is not changed
        assert not editor.save.isEnabled()
        assert editor.limits["cell_voltage_min_v"].box.text() == "3.85 V"
        assert editor.limits["round_trip_max_ms"].value is None
        editor.limits["cell_voltage_min_v"].box.setValue(2.0)  # below the bound that no profile goes beyond
        assert editor.limits["cell_voltage_min_v"].value == 3.5
        editor.limits["tilt_max_deg"].tick.setChecked(False)
        editor.limits["round_trip_max_ms"].tick.setChecked(True)
        editor.tests[GuidedKind.BAY].tick.setChecked(True)
        editor.activated_by.setCurrentIndex(1)
        bench.click(editor.add)
        assert not editor.save.isEnabled()  # a manual check without a text
        assert editor.strip.notice is not None
        qtbot.keyClicks(editor.manual[1].text, "Pack date")
        assert editor.save.isEnabled()
        bench.click(editor.manual[0].remove)
        bench.click(editor.save)
        assert 'name = "Survey hexacopter"  # the big one' in path.read_text(encoding="utf-8")
        wanted = replace(
            before,
            limits={"round_trip_max_ms": 100, "cell_voltage_min_v": 3.5},
            tests_within_days={GuidedKind.BAY: 180},
            activated_by=ActivatedBy.AIRCRAFT,
            manual=(ManualLine("Pack date"),),
        )
        assert read_profile(path) == page.form.profile == wanted
        assert [row.line for row in page.list.manual] == [ManualLine("Pack date")]


def test_edits_are_discarded_only_when_that_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "editor_new", is_connected=False) as bench:
        page = bench.preflight
        page.edit_profile()
        editor = page.editor
        editor.name.setFocus()
        qtbot.keyClicks(editor.name, "H6")
        assert page.on_escape()
        assert editor.isVisible()
        bench.assembly.language_switch.use(CHINESE)
        assert editor.title.text() == "配置文件"
        assert editor.limits["cell_voltage_min_v"].tick.text().endswith(" ≥")
        keep = editor.strip.button("keep")
        assert keep is not None
        bench.click(keep)
        assert editor.profile == Profile(name="H6")
        editor.ask_save = choosing(tmp_path / "none" / "x.toml")
        bench.click(editor.save)
        assert editor.strip.notice is not None  # the folder is not there
        editor.ask_save = choosing(tmp_path / "x.toml")
        bench.click(editor.save)
        assert read_profile(tmp_path / "x.toml").name == "H6"
        assert page.form.path == tmp_path / "x.toml"
        page.edit_profile()
        editor.name.setText("other")
        editor.leave()
        discard = editor.strip.button("discard")
        assert discard is not None
        bench.click(discard)
        assert not editor.isVisible()
        assert read_profile(tmp_path / "x.toml").name == "H6"


def test_three_clicks_from_a_connected_module_to_a_go(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    """The name is typed once, before; the report is the primary button then."""
    with on_bench(qtbot, qapp, tmp_path, "three") as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        bench.click(page.buttons.enable)
        bench.wait_standing(Standing.READY)
        assert page.buttons.print.property("role") == "primary"
        assert page.list.fold.text().endswith("passed")
        assert not page.list.rows["tilt"].isVisible()
        bench.click(page.activation.confirm.ask)
        bench.click(page.activation.confirm.go)
        bench.wait_standing(Standing.GO)
        assert page.work.record is not None
        assert page.work.record["module"] == "M-07"
