"""The Pre-flight page: records that are dropped, past checks, how it looks; the profile edited
in the window: loaded, validated, saved, used."""

from pathlib import Path

from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtWidgets import QApplication, QComboBox, QGraphicsItem, QLineEdit
from pytestqt.qtbot import QtBot

from app.guided.results import GuidedKind
from app.preflight.verdict import Verdict
from app.records.verification import RecordState, verify_file
from app.settings.profiles import ActivatedBy, ManualLine, Profile, read_profile
from app.store.rows import PreflightCheck
from tests.support.window.fakes_ui import store_of
from tests.support.window.preflight_window import NOBODY, OnBench, confirm_name, name_module, on_bench, said
from tests.support.window.steps import choosing, given, notice_text
from ui.session.check import Standing
from ui.style.theme import Meaning


def test_a_dropped_record_is_intact_or_altered(tmp_path: Path, rig: OnBench) -> None:
    page = rig.preflight
    assert rig.check() is Standing.READY
    target = tmp_path / "report.pdf"
    page.ask_path = choosing(target)
    rig.click(page.export)
    rig.until(lambda: not page.result.is_writing)
    rig.assembly.window.go_to("triggers")
    rig.drop(target)
    rig.until(lambda: "INTACT" in said(rig))
    assert rig.assembly.window.navigation.chosen == "preflight"
    record = target.with_suffix(".json")
    record.write_text(record.read_text(encoding="utf-8").replace('"measured":3.9', '"measured":4.1'), "utf-8")
    rig.drop(record)
    rig.until(lambda: "ALTERED" in said(rig))
    assert given(page.strip.notice).meaning is Meaning.DANGER
    nonsense = tmp_path / "x.json"
    nonsense.write_text("[" * 100_000, encoding="utf-8")
    rig.drop(nonsense)
    rig.until(lambda: "No pre-flight record" in said(rig))
    rig.drop(tmp_path / "gone.pdf")
    rig.until(lambda: "cannot be read" in said(rig))
    for path in (target, nonsense):  # the second while the first is still being read
        page.open_file(path)
    rig.until(lambda: "No pre-flight record" in said(rig))


def test_a_simulated_module_of_this_name_passes_for_no_check_of_it(tmp_path: Path, rig: OnBench) -> None:
    history = rig.preflight.past
    store = store_of(rig.assembly.storage)
    for cell_v, is_void, is_simulated in ((4.0, False, False), (1.0, False, True), (2.0, True, False)):
        check = PreflightCheck(
            verdict="GO", is_void=is_void, is_simulated=is_simulated, cell_voltage_v=cell_v, document="{}"
        )
        store.add(check, "M-07").result()
    name_module(rig, "M-07")
    rig.until(lambda: "M-07" in rig.assembly.ports.known_names())
    rig.preflight.show_view("past")
    rig.until(lambda: len(history.checks) == 3)
    shown = [history.table.model().index(row, 1).data() for row in range(3)]
    assert shown == ["GO (void)", "GO (simulated)", "GO"]
    assert history.trend.values == (4.0,)


def test_what_has_no_name_makes_no_curve(rig: OnBench) -> None:
    """It may be of several modules."""
    store, history = store_of(rig.assembly.storage), rig.preflight.past
    for cell_v in (4.0, 3.6):
        check = PreflightCheck(verdict="GO", is_void=False, is_simulated=False, cell_voltage_v=cell_v, document="{}")
        store.add(check).result()
    rig.preflight.show_view("past")
    rig.until(lambda: len(history.checks) == 2)
    assert history.trend.values == ()


def test_what_was_typed_last_is_on_the_report(tmp_path: Path, rig: OnBench) -> None:
    """Also where the field still has the focus: the report waits for the record that says it."""
    page, target = rig.preflight, tmp_path / "report.pdf"
    assert rig.check() is Standing.READY
    page.ask_path = choosing(target)
    rig.find(QLineEdit, "preflight_aircraft").setText("H6-12")
    rig.click(page.export)
    rig.until(lambda: "Saved to" in said(rig))
    record = given(verify_file(target, NOBODY).record)
    assert (record.aircraft, record.verdict) == ("H6-12", Verdict.READY)
    assert page.work.standing is Standing.READY


def test_past_checks_and_what_they_measured(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "past", "preflight", cell=3.6) as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        bench.find(QLineEdit, "preflight_aircraft").setText("H6-12")
        assert bench.check() is Standing.NO_GO
        bench.bench.set_world(cell_v=4.0)
        assert bench.check() is Standing.READY
        page.show_view("past")
        history = page.past
        bench.until(lambda: [check.verdict for check in history.checks] == ["READY", "NO-GO"])
        assert history.trend.values == (3.6, 4.0)
        assert "3.60 V to 4.00 V" in history.trend.accessibleName()
        axes = history.trend.axes.values()  # a kept picture cut off the first figure of the labels
        assert {axis.cacheMode() for axis in axes} == {QGraphicsItem.CacheMode.NoCache}
        target = tmp_path / "again.pdf"
        page.ask_path = choosing(target)
        history.table.selectRow(1)
        bench.click(history.export)
        bench.until(lambda: not page.result.is_writing)
        assert verify_file(target, NOBODY).state is RecordState.INTACT
        page.show_view("past")
        box = bench.find(QComboBox, "past_checks_filter")
        assert box.currentText() == "Module: M-07"
        box.setCurrentText("Unnamed")
        box.activated.emit(box.currentIndex())
        bench.until(lambda: history.checks == ())
        qtbot.keyClick(page, Qt.Key.Key_Escape)
        assert page.view == "checks"


def test_an_aircraft_is_entered_for_its_own_module_only(rig: OnBench) -> None:
    aircraft = rig.find(QLineEdit, "preflight_aircraft")
    aircraft.setText("H6-12")
    name_module(rig, "M-07")
    rig.check()
    assert aircraft.text() == "H6-12"
    name_module(rig, "M-08")
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("", "")
    name_module(rig, "M-07")
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("H6-12", "H6-12")
    rig.bench.unplug()
    rig.until(lambda: not rig.assembly.ports.current.is_open)
    rig.bench.plug()
    rig.until(lambda: not rig.assembly.ports.current.module.name)
    assert aircraft.text() == ""
    confirm_name(rig)
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("H6-12", "H6-12")
    rig.assembly.ports.current.treat_as_another()
    rig.until(lambda: not rig.assembly.ports.module.name)
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("", "")


# Looks


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


def _type(qtbot: QtBot, field: QLineEdit, text: str) -> None:
    field.selectAll()
    qtbot.keyClick(field, Qt.Key.Key_Delete)
    qtbot.keyClicks(field, text)


def test_a_profile_is_edited_saved_and_used(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / "hexa.toml"
    path.write_text(PROFILE, encoding="utf-8")
    before, spaced = read_profile(path), tmp_path / "spaced.toml"
    spaced.write_text(PROFILE.replace('text = "', 'text = " '), encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "editor", "preflight", is_connected=False) as bench:
        page = bench.preflight
        page.editor.edit(read_profile(spaced), spaced)
        assert not page.editor.is_edited
        page.form.use_profile(path)
        page.edit_profile()
        editor = page.editor
        assert editor.isVisible()
        assert editor.profile == before  # what is only looked at is not changed
        assert not editor.save.isEnabled()
        number = editor.limits["cell_voltage_min_v"]
        assert (number.text(), editor.limits["round_trip_max_ms"].text()) == ("3.85", "")
        _type(qtbot, number, "2.0")  # below the bound that no profile goes beyond
        assert number.text() == "2.0"
        assert "3.5 V to 4.2 V" in notice_text(editor.strip)
        assert (editor.save.isEnabled(), editor.save_as.isEnabled(), editor.is_edited) == (False, False, True)
        _type(qtbot, number, "3.5")
        _type(qtbot, editor.limits["tilt_max_deg"], "")
        _type(qtbot, editor.limits["round_trip_max_ms"], "100")
        _type(qtbot, editor.tests[GuidedKind.BAY], "180")
        editor.activated_by.setCurrentIndex(1)
        qtbot.keyClicks(editor.manual[1].text, "Pack date")
        assert len(editor.manual) == 3  # a line for one more
        editor.manual[0].text.selectAll()
        qtbot.keyClick(editor.manual[0].text, Qt.Key.Key_Delete)
        bench.click(editor.save)
        assert 'name = "Survey hexacopter"  # the big one' in path.read_text(encoding="utf-8")
        wanted = before._replace(
            limits={"round_trip_max_ms": 100, "cell_voltage_min_v": 3.5},
            tests_within_days={GuidedKind.BAY: 180},
            activated_by=ActivatedBy.AIRCRAFT,
            manual=(ManualLine("Pack date"),),
        )
        assert read_profile(path) == page.form.profile == wanted
        assert [row.line for row in page.list.manual] == [ManualLine("Pack date")]


def test_edits_are_discarded_only_when_that_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "editor_new", "preflight", is_connected=False) as bench:
        page = bench.preflight
        page.edit_profile()
        editor = page.editor
        editor.name.setFocus()
        qtbot.keyClicks(editor.name, "H6")
        assert page.on_escape()
        assert editor.isVisible()
        window = bench.assembly.window
        assert not window.close()
        assert notice_text(window.notice_bar) == "Profile: Unsaved edits."
        bench.click(window.notice_bar.button("stay"))
        record = tmp_path / "x.json"
        record.write_text("{}", encoding="utf-8")
        bench.drop(record)
        assert editor.isVisible()
        bench.click(editor.strip.button("keep"))
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
        editor.close_editor()
        bench.click(editor.strip.button("discard"))
        assert not editor.isVisible()
        assert read_profile(tmp_path / "x.toml").name == "H6"
        page.edit_profile()  # with other lines for the manual checks than the last time
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        assert editor.manual[0].text.accessibleName() == "Manual checks 1"
